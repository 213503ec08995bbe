//! Colour spaces: layers keep theirs, displays get sRGB, data are never touched.

use super::inputs::write_bumps;
use crate::common::exr::{Part, channel};
use crate::common::program::{fixture, relievo};
use relievo::frame::Plane;
use relievo::io::exr::ExrFile;
use relievo::io::photo::Photo;
use std::path::Path;

/// A wall of one colour.
fn write_wall(path: &Path, color: [f32; 3], chromaticities: Option<[f32; 8]>) {
    let flat = |value| Plane::filled(8, 8, value);
    let planes = [color, [0.0, 0.0, 1.0]].concat();
    let planes: Vec<_> = planes.into_iter().map(flat).collect();
    let names = ["R", "G", "B", "N.X", "N.Y", "N.Z"];
    let part = Part::of(names.into_iter().zip(&planes));
    match chromaticities {
        Some(chromaticities) => part.chromaticities(chromaticities).write(path),
        None => part.write(path),
    }
}

fn pixel(path: &Path, name: &str) -> f32 {
    channel(path, name).at(3, 3)
}

fn shown(path: &Path) -> [f32; 3] {
    let photo = Photo::read(path).unwrap().to_linear();
    [0, 1, 2].map(|c| photo[c].at(3, 3))
}

#[test]
fn acescg_is_shown_in_srgb_and_kept_in_layers() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_wall(&here.join("given.exr"), [0.5, 0.4, 0.2], None);
    // The file itself states AP1.
    let ap1 = relievo::io::colorspace::ColorSpace::AP1;
    write_wall(&here.join("tagged.exr"), [0.5, 0.4, 0.2], Some(ap1));
    // 1.70505 * 0.5 - 0.62179 * 0.4 - 0.08326 * 0.2, and so on, of the published matrix.
    let expected = [0.5872, 0.3891, 0.1670];
    for (name, flags) in [("given", "--colorspace acescg"), ("tagged", "")] {
        for format in ["hdr", "png"] {
            let words = format!("enhance {name}.exr -o {name}.{format} --scaling 0 {flags}");
            relievo(here, &words).ended(0);
            let found = shown(&here.join(format!("{name}.{format}")));
            for (found, expected) in found.into_iter().zip(expected) {
                // A step of RGBE, or of 8 bits at these brightnesses.
                assert!(
                    (found - expected).abs() < 0.006,
                    "{name}.{format}: {found} for {expected}"
                );
            }
        }
        let words =
            format!("enhance {name}.exr -o {name}.out.exr --scaling 0 --layers results {flags}");
        relievo(here, &words).ended(0);
        let out = here.join(format!("{name}.out.exr"));
        assert_eq!(
            [pixel(&out, "R"), pixel(&out, "G"), pixel(&out, "B")],
            [0.5, 0.4, 0.2]
        );
        let file = ExrFile::open(&out, &Default::default()).unwrap();
        assert_eq!(file.chromaticities, Some(ap1));
    }
}

#[test]
fn encoded_colours_are_made_linear_and_data_are_not() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_wall(&here.join("in.exr"), [0.5, 0.25, 1.0], None);
    relievo(
        here,
        "enhance in.exr -o out.exr --scaling 0 --layers results --colorspace srgb",
    )
    .ended(0);
    // ((0.5 + 0.055) / 1.055)^2.4 and ((0.25 + 0.055) / 1.055)^2.4.
    for (name, expected) in [("R", 0.214_041), ("G", 0.050_876), ("B", 1.0)] {
        let found = pixel(&here.join("out.exr"), name);
        assert!((found - expected).abs() < 1e-5, "{name}: {found}");
    }
    relievo(
        here,
        "shape in.exr -o shape.exr --layers results --colorspace srgb",
    )
    .ended(0);
    assert_eq!(pixel(&here.join("shape.exr"), "normal.z"), 1.0);
    // AgX, as Blender has it, keeps middle grey: by the sRGB curve 0.4614; Filmic makes it half of the display's code. `srgb` is the standard.
    write_wall(&here.join("grey.exr"), [0.18; 3], None);
    for (view, expected) in [
        ("agx", 0.4614),
        ("filmic", 0.5002),
        ("standard", 0.4614),
        ("srgb", 0.4614),
        ("none", 0.18),
    ] {
        let shown = format!("enhance grey.exr -o {view}.png --scaling 0 --view-transform {view}");
        relievo(here, &shown).ended(0);
        let photo = Photo::read(&here.join(format!("{view}.png"))).unwrap();
        assert!(
            (photo.channels[0].at(0, 0) - expected).abs() < 0.003,
            "{view}"
        );
    }
    // A photo of linear numbers: the stored values count.
    relievo(
        here,
        "enhance in.exr -o linear.png --scaling 0 --view-transform none",
    )
    .ended(0);
    relievo(
        here,
        "enhance linear.png --normal in.exr -o again.exr --scaling 0 --colorspace linear",
    )
    .ended(0);
    let found = pixel(&here.join("again.exr"), "R");
    assert!((found - 0.5).abs() < 0.003, "{found}");
}

#[test]
fn new_light_does_not_burn() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_bumps(&here.join("in.exr"), 1, [64, 64], 0.5, |_| false);
    let light = "relight in.exr --light 90,60,4,4,4 --albedo-from white --method plain";
    let said = relievo(here, &format!("{light} -o auto.png")).ended(0);
    assert!(said.contains("exposure -1."), "{said}");
    assert!(
        !said.contains("warning") && !said.contains("white"),
        "{said}"
    );
    // The most that arrives is 4 * 0.9 and a tenth of ambient light: 1.9 stops over 1. Brought to 1 it is 0.9 in the
    // shoulder, 0.95 by the curve; brought to 1.85 it is cut off.
    let brightest = |name: &str| {
        let [r, _, _] = &Photo::read(&here.join(name)).unwrap().channels[..] else {
            panic!("{name} is not in colour");
        };
        r.samples().iter().fold(0.0, |most: f32, &v| most.max(v))
    };
    let dimmed = brightest("auto.png");
    assert!((0.85..254.5 / 255.0).contains(&dimmed), "{dimmed}");
    let clipped = format!("{light} -o clipped.png --exposure -1 --highlights clip");
    let said = relievo(here, &clipped).ended(0);
    let advice = "more than 1 % of the surface turned white, without any shape: try --exposure -1 or lower, or \
                  --highlights compress";
    assert!(said.contains(advice), "{said}");
    assert!(said.contains(" % white, "), "{said}");
    assert_eq!(brightest("clipped.png"), 1.0);
    // An EXR stores light unchanged.
    for (name, more) in [("a.exr", ""), ("b.exr", "--exposure -1 --highlights clip")] {
        relievo(here, &format!("{light} -o {name} --layers results {more}")).ended(0);
    }
    let [a, b] = ["a.exr", "b.exr"].map(|name| pixel(&here.join(name), "R"));
    assert_eq!(a, b);
}

/// The mean level of a photo, 0..1.
fn mean_level(path: &Path) -> f64 {
    let photo = Photo::read(path).unwrap();
    let samples = photo.channels[..3].iter().flat_map(|c| c.samples());
    let levels: Vec<f64> = samples.map(|&v| v.into()).collect();
    levels.iter().sum::<f64>() / levels.len() as f64
}

#[test]
fn photos_stay_as_bright_in_new_light() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let [photo, normal] = ["tablet.color.jpg", "tablet.normal.png"].map(fixture);
    let before = mean_level(&photo);
    let relit = |light: &str, name: &str| {
        let [photo, normal] = [&photo, &normal].map(|path| path.display().to_string());
        let words = format!("relight {photo} --normal {normal} {light} -o {name}");
        relievo(here, &words).ended(0)
    };
    // A sixteenth of a stop is 1.5 % of a level, and the curve of a display is no square root: 4 levels of 255.
    for light in ["--light 135,40", "--light 135,15", "--light 135,40,5,5,5"] {
        // Shadows spread tones, and no more than 2 % of a picture are to burn out: it stays darker then.
        let light = &format!("{light} --shadows off");
        relit(light, "out.png");
        let after = mean_level(&here.join("out.png"));
        assert!(
            (after - before).abs() < 4.0 / 255.0,
            "{light}: {before}, {after}"
        );
    }
    let said = relit("--light 135,40,5,5,5", "out.png");
    assert!(said.contains("exposure -"), "{said}");
    // Linear numbers stay, and so does what is asked for.
    relit("--light 135,40 --exposure 0", "out.png");
    assert!((mean_level(&here.join("out.png")) - before).abs() > 8.0 / 255.0);
}

#[test]
fn enhancement_burns_nothing_that_did_not() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    // Up to 0.95: bumps would be brighter than white.
    write_bumps(&here.join("in.exr"), 1, [64, 64], 0.95, |_| false);
    let picture = |name: &str, more: &str| {
        relievo(here, &format!("enhance in.exr -o {name} {more}")).ended(0);
        let photo = Photo::read(&here.join(name)).unwrap();
        photo.channels[0].samples().to_vec()
    };
    let plain = picture("plain.png", "--scaling 0");
    let clipped = picture("clipped.png", "--highlights clip");
    let said = relievo(here, "enhance in.exr -o c.png --highlights clip").ended(0);
    assert!(said.contains("more than 1 % of the surface"), "{said}");
    // Of a picture that is too bright, all is white before: none is made white.
    write_bumps(&here.join("bright.exr"), 1, [64, 64], 4.0, |_| false);
    for more in ["--scaling 0", "", "--highlights clip"] {
        let said = relievo(here, &format!("enhance bright.exr -o b.png {more}")).ended(0);
        assert!(
            !said.contains("warning") && said.contains("100.0 % before"),
            "{said}"
        );
    }
    let shown = picture("shown.png", "");
    let white = |samples: &[f32]| samples.iter().filter(|&&v| v == 1.0).count();
    assert_eq!([white(&plain), white(&shown)], [0, 0]);
    assert!(white(&clipped) > 100);
    for ((plain, clipped), shown) in plain.iter().zip(clipped).zip(shown) {
        // Brighter still, and not darker than before; darker values have unchanged bytes.
        let is_kept = clipped <= *plain && shown == clipped;
        assert!(is_kept || (clipped > *plain && shown >= *plain && shown <= clipped));
    }
}
