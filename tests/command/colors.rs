//! Colour spaces: layers keep theirs, displays get sRGB, data are never touched.

use crate::common::exr::Part;
use crate::common::program::{Desk, tells};
use relievo::frame::Plane;
use relievo::io::colorspace::ColorSpace;

/// Writes a wall of one colour.
fn write_wall(desk: &Desk, name: &str, color: [f32; 3], chromaticities: Option<[f32; 8]>) {
    let planes = [color, [0.0, 0.0, 1.0]].concat();
    let planes: Vec<_> = planes.iter().map(|&v| Plane::filled(8, 8, v)).collect();
    let names = ["R", "G", "B", "N.X", "N.Y", "N.Z"];
    let part = Part::of(names.into_iter().zip(&planes));
    let part = match chromaticities {
        Some(chromaticities) => part.chromaticities(chromaticities),
        None => part,
    };
    part.write(&desk.at(name));
}

fn pixel(desk: &Desk, file: &str, layer: &str) -> f32 {
    desk.channel(file, layer).at(3, 3)
}

#[test]
fn acescg_is_shown_in_srgb_and_kept_in_layers() {
    let desk = Desk::new();
    let color = [0.5, 0.4, 0.2];
    write_wall(&desk, "given.exr", color, None);
    // The file itself states AP1.
    write_wall(&desk, "tagged.exr", color, Some(ColorSpace::AP1));
    for words in ["given.exr --colorspace acescg", "tagged.exr"] {
        let words = format!("enhance {words} --scaling 0");
        // 1.70505 * 0.5 - 0.62179 * 0.4 - 0.08326 * 0.2, and so on, of the published matrix.
        for output in ["out.hdr", "out.png"] {
            desk.make(format!("{words} -o {output}"));
            let light = desk.photo(output).to_linear();
            for (plane, expected) in light.iter().zip([0.5872, 0.3891, 0.1670]) {
                let found = plane.at(3, 3);
                // A step of RGBE, or of 8 bits at these brightnesses.
                let is_near = (found - expected).abs() < 0.006;
                assert!(is_near, "{words} {output}: {found} for {expected}");
            }
        }
        desk.make(format!("{words} -o out.exr --layers results"));
        assert_eq!(
            ["R", "G", "B"].map(|name| pixel(&desk, "out.exr", name)),
            color
        );
        assert_eq!(desk.exr("out.exr").chromaticities, Some(ColorSpace::AP1));
    }
}

#[test]
fn encoded_colours_are_made_linear_and_data_are_not() {
    let desk = Desk::new();
    write_wall(&desk, "in.exr", [0.5, 0.25, 1.0], None);
    let srgb = "in.exr --layers results --colorspace srgb";
    desk.make(format!("enhance {srgb} -o out.exr --scaling 0"));
    // ((0.5 + 0.055) / 1.055)^2.4 and ((0.25 + 0.055) / 1.055)^2.4.
    for (name, expected) in [("R", 0.214_041), ("G", 0.050_876), ("B", 1.0)] {
        let found = pixel(&desk, "out.exr", name);
        assert!((found - expected).abs() < 1e-5, "{name}: {found}");
    }
    desk.make(format!("shape {srgb} -o shape.exr"));
    assert_eq!(pixel(&desk, "shape.exr", "normal.z"), 1.0);
    // AgX, as Blender has it, keeps middle grey: by the sRGB curve 0.4614; Filmic makes it half of the display's code. `srgb` is the standard.
    write_wall(&desk, "grey.exr", [0.18; 3], None);
    for (view, expected) in [
        ("agx", 0.4614),
        ("filmic", 0.5002),
        ("standard", 0.4614),
        ("srgb", 0.4614),
        ("none", 0.18),
    ] {
        let shown = desk.picture(format!(
            "enhance grey.exr --scaling 0 --view-transform {view}"
        ));
        let found = shown.channels[0].at(0, 0);
        assert!((found - expected).abs() < 0.003, "{view}");
    }
    // A photo of linear numbers: the stored values count.
    desk.make("enhance in.exr -o linear.png --scaling 0 --view-transform none");
    desk.make("enhance linear.png --normal in.exr -o again.exr --scaling 0 --colorspace linear");
    let found = pixel(&desk, "again.exr", "R");
    assert!((found - 0.5).abs() < 0.003, "{found}");
}

#[test]
fn new_light_does_not_burn() {
    let desk = Desk::new();
    desk.write_bumps("in.exr", 1, [64, 64], 0.5, |_| false);
    let light = "relight in.exr --light 90,60,4,4,4 --albedo-from white --method plain";
    let rows = "
        -o auto.png => 0: exposure -1. ... !warning ... !white
        -o clipped.png --exposure -1 --highlights clip => 0:  % white,  ... more than 1 % of the surface turned white, without any shape: try --exposure -1 or lower, or --highlights compress
        -o a.exr --layers results => 0
        -o b.exr --layers results --exposure -1 --highlights clip => 0
    ";
    desk.check(&format!("{light} {{}}"), rows);
    // The most that arrives is 4 * 0.9 and a tenth of ambient light: 1.9 stops over 1. Brought to 1 it is 0.9 in the
    // shoulder, 0.95 by the curve; brought to 1.85 it is cut off.
    let brightest = |name: &str| {
        let photo = desk.photo(name);
        assert_eq!(photo.channels.len(), 3, "{name} is not in colour");
        let red = photo.channels[0].samples();
        red.iter().copied().fold(0.0, f32::max)
    };
    let dimmed = brightest("auto.png");
    assert!((0.85..254.5 / 255.0).contains(&dimmed), "{dimmed}");
    assert_eq!(brightest("clipped.png"), 1.0);
    // An EXR stores light unchanged.
    assert_eq!(pixel(&desk, "a.exr", "R"), pixel(&desk, "b.exr", "R"));
}

/// The mean level of a photo, 0..1.
fn mean_level(desk: &Desk, name: &str) -> f64 {
    let photo = desk.photo(name);
    let samples = photo.channels[..3].iter().flat_map(|c| c.samples());
    let levels: Vec<f64> = samples.map(|&v| v.into()).collect();
    levels.iter().sum::<f64>() / levels.len() as f64
}

#[test]
fn photos_stay_as_bright_in_new_light() {
    let desk = Desk::new();
    let before = mean_level(&desk, "fixtures/tablet.color.jpg");
    let relit = |flags: &str| {
        let photo = "fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
        let ran = desk.make(format!("relight {photo} --light 135,{flags} -o out.png"));
        (mean_level(&desk, "out.png") - before, ran.stderr)
    };
    // A sixteenth of a stop is 1.5 % of a level, and the curve of a display is no square root: 4 levels of 255.
    for light in ["40", "15", "40,5,5,5"] {
        // Shadows spread tones, and no more than 2 % of a picture are to burn out: it stays darker then.
        let (change, _) = relit(&format!("{light} --shadows off"));
        assert!(change.abs() < 4.0 / 255.0, "{light}: {before}, {change}");
    }
    tells(&relit("40,5,5,5").1, "exposure -");
    // Linear numbers stay, and so does what is asked for.
    assert!(relit("40 --exposure 0").0.abs() > 8.0 / 255.0);
}

#[test]
fn enhancement_burns_nothing_that_did_not() {
    let desk = Desk::new();
    // Up to 0.95: bumps would be brighter than white.
    desk.write_bumps("in.exr", 1, [64, 64], 0.95, |_| false);
    // Of a picture that is too bright, all is white before: none is made white.
    desk.write_bumps("bright.exr", 1, [64, 64], 4.0, |_| false);
    let rows = "
        in.exr --highlights clip => 0: more than 1 % of the surface
        bright.exr --scaling 0 => 0: !warning ... 100.0 % before
        bright.exr => 0: !warning ... 100.0 % before
        bright.exr --highlights clip => 0: !warning ... 100.0 % before
    ";
    desk.check("enhance {} -o b.png", rows);
    let picture = |flags: &str| {
        let photo = desk.picture(format!("enhance in.exr {flags}"));
        photo.channels[0].samples().to_vec()
    };
    let plain = picture("--scaling 0");
    let clipped = picture("--highlights clip");
    let shown = picture("");
    let white = |samples: &[f32]| samples.iter().filter(|&&v| v == 1.0).count();
    assert_eq!([white(&plain), white(&shown)], [0, 0]);
    assert!(white(&clipped) > 100);
    for ((plain, clipped), shown) in plain.iter().zip(clipped).zip(shown) {
        // Brighter still, and not darker than before; darker values have unchanged bytes.
        let is_kept = clipped <= *plain && shown == clipped;
        assert!(is_kept || (clipped > *plain && shown >= *plain && shown <= clipped));
    }
}
