//! Lobes, light groups and ambient occlusion, scaled one by one.

use crate::common::exr::{self, Part};
use crate::common::lobes::*;
use crate::common::program::{Desk, tells};
use crate::common::real_files::real;
use crate::common::{bits, channels};
use relievo::frame::{ColorPlanes, Plane};

const VIEW: &str = "--normal-space view --coverage mask";

fn rgb<'a>(layer: &str, color: &'a ColorPlanes) -> Vec<(String, &'a Plane)> {
    let names = ["R", "G", "B"].map(|c| format!("{layer}.{c}"));
    names.into_iter().zip(channels(color)).collect()
}

/// Writes the scene, its layers under the names given: normal and picture, then the rest.
fn write(desk: &Desk, name: &str, layers: &[(&str, &ColorPlanes)]) {
    let frame = scene();
    let mask = frame.mask.plane().map(|c| if c { 1.0 } else { 0.0 });
    let n = &frame.normal;
    let normal = [("normal.X", &n.x), ("normal.Y", &n.y), ("normal.Z", &n.z)];
    let own = normal.into_iter().chain([("mask.Y", &mask)]);
    let mut all: Vec<_> = own.map(|(name, plane)| (name.to_string(), plane)).collect();
    all.extend(rgb("Combined", frame.color.as_ref().unwrap()));
    for (layer, color) in layers {
        all.extend(rgb(layer, color));
    }
    Part::of(all).write(&desk.at(name));
}

#[test]
fn lobes_are_found_by_name_and_told_of() {
    let desk = Desk::new();
    let frame = scene();
    let [diffuse, specular] = &frame.light.lobes[..] else {
        panic!("two lobes")
    };
    let there = |planes: &'_ Option<ColorPlanes>| planes.clone().unwrap();
    let [direct, indirect, own] = [&diffuse.direct, &diffuse.indirect, &diffuse.color].map(there);
    let [gloss, gloss_own] = [&specular.direct, &specular.color].map(there);
    let [diffuse, specular] =
        [diffuse, specular].map(|lobe| color(|i, x, y| radiance(lobe, i, x, y)));
    let blender = [
        ("DiffDir", &direct),
        ("DiffInd", &indirect),
        ("DiffCol", &own),
        ("GlossDir", &gloss),
        ("GlossCol", &gloss_own),
    ];
    write(&desk, "blender.exr", &blender);
    let arnold = [
        ("diffuse_direct", &diffuse),
        ("albedo", &own),
        ("specular_direct", &specular),
    ];
    write(&desk, "arnold.exr", &arnold);
    let odd = [("dif", &diffuse), ("spec", &specular), ("paint", &own)];
    write(&desk, "odd.exr", &odd);

    let made = |words: &str| {
        let fixed = "--curvature-gain 20 --white-level 1.5 -v --explain -o out.exr";
        let ran = desk.make(format!("enhance {words} {VIEW} {fixed}"));
        (bits(&desk.channel("out.exr", "relievo.G")), ran)
    };
    let (by_blender, said) = made("blender.exr");
    let lobes = "(DiffDir + DiffInd) x DiffCol ... specular lobe    GlossDir x GlossCol";
    tells(
        &said.stderr,
        &format!("diffuse lobe     {lobes} ... light passes     recombine"),
    );
    tells(&said.stdout, "ran   light-lobes ... -     radiance-scaling");
    // The same white light, including the surface's colour: intensities equal Blender's to rounding. (Not those of
    // specular light, whose colour cannot be separated.)
    let [blender, arnold, odd] = [
        "blender.exr",
        "arnold.exr",
        "odd.exr --diffuse dif --specular spec --albedo paint",
    ]
    .map(|words| made(&format!("{words} --scaling-specular 0")).0);
    let picture = bits(&desk.channel("blender.exr", "Combined.G"));
    assert_ne!(blender, picture);
    for other in [&arnold, &odd] {
        for (a, b) in blender.iter().zip(other) {
            let (a, b) = (f32::from_bits(*a), f32::from_bits(*b));
            assert!((a - b).abs() < 1e-5, "{a} is not {b}");
        }
    }
    // One layer named, or lobes refused: the picture as a whole, as ever.
    let (whole, said) = made("blender.exr --lobes off");
    tells(&said.stdout, "ran   radiance-scaling");
    tells(&said.stderr, "!lobe");
    assert_eq!(whole, made("blender.exr --color Combined").0);
    assert_ne!(whole, by_blender);
    assert_eq!(
        made("blender.exr --color Combined --lobes on").0,
        by_blender
    );
    for zero in ["--scaling 0", "--scaling-diffuse 0 --scaling-specular 0"] {
        assert_eq!(made(&format!("blender.exr {zero}")).0, picture);
    }
}

#[test]
fn missing_and_doubtful_passes_are_told() {
    let desk = Desk::new();
    let frame = scene();
    let lobe = &frame.light.lobes[0];
    // Light without its colour is no part of the picture: left alone, and the picture is scaled as a whole.
    write(
        &desk,
        "colorless.exr",
        &[("DiffDir", lobe.direct.as_ref().unwrap())],
    );
    // Arnold's name, but three times the light.
    let thrice = color(|i, x, y| 3.0 * radiance(lobe, i, x, y));
    write(&desk, "doubtful.exr", &[("diffuse_direct", &thrice)]);
    write(&desk, "plain.exr", &[]);
    // Another size.
    let plane = Plane::filled(7, 5, 0.5);
    let small = ["R", "G", "B"].map(|c| (format!("diffuse.{c}"), &plane));
    Part::of(small).write(&desk.at("small.exr"));
    let rows = "
        colorless.exr -o out.exr -v --explain => 0: its color layer is missing ... ran   radiance-scaling
        doubtful.exr -o out.exr => 0: warning:  ... % in the median
        // A magnitude with nothing to scale.
        doubtful.exr -o out.exr --scaling-specular 2 => 0: --scaling-specular changes nothing
        plain.exr -o out.exr --lobes on => 1: no light passes
        plain.exr -o out.exr --light-group key=0,45 => 1: no light group called key
        plain.exr -o out.exr --light-group key=0 => 2: NAME=AZ,EL
        plain.exr -o out.exr --diffuse small.exr => 1: inputs of one size
        plain.exr -o small.exr --diffuse small.exr => 2: is the input
    ";
    desk.check(&format!("enhance {{}} {VIEW}"), rows);
}

#[test]
fn occlusion_is_scaled_as_ambient_light() {
    let desk = Desk::new();
    let open = color(|_, x, y| 0.3 + (x * y) as f32 / 5000.0);
    write(&desk, "occlusion.exr", &[("AO", &open)]);
    let rows = "
        => 0: -     ambient-occlusion
        --scaling-ambient 1 => 0: ran   ambient-occlusion
        --color AO => 0: white level 1.0000
    ";
    let common = format!("enhance occlusion.exr {VIEW} -o out.exr --explain -v {{}}");
    desk.check(&common, rows);
}

#[test]
fn inspect_warns_of_a_magnitude_that_is_planned() {
    let desk = Desk::new();
    write(&desk, "plain.exr", &[]);
    // The limits at 0.2 and 0.5 are 1.44 and 0.48. The usual magnitude is 1.
    let rows = "
        => 0: !dark rims
        --scaling 1.4 --invariant-point 0.2 => 0: !dark rims
        --scaling 1.5 --invariant-point 0.2 => 0: dark rims
        --invariant-point 0.5 => 0: dark rims
    ";
    desk.check("inspect plain.exr {}", rows);
}

#[test]
fn renders_with_all_passes_recombine_and_are_scaled_by_lobe_and_group() {
    for name in [
        "renders/suzanne_480_allpasses_b34_dwaa.exr",
        "renders/suzanne_480_allpasses_b50_multipart_dwaa.exr",
    ] {
        let Some(input) = real(name) else {
            continue;
        };
        let (desk, shown) = (Desk::new(), input.display());
        let made = |flags: &str| {
            let said = desk
                .make(format!("enhance {shown} -o out.exr {flags} -v"))
                .stderr;
            (bits(&desk.channel("out.exr", "relievo.R")), said)
        };
        let picture = bits(&exr::channel(&input, "ViewLayer.Combined.R"));
        let (lobes, said) = made("");
        tells(
            &said,
            "diffuse lobe ... specular lobe ... light passes     recombine to the picture",
        );
        let (whole, _) = made("--lobes off");
        // The directions to the key and fill lights of these renders, rotated to view space.
        let key = "--light-group key=138.4,41.1 --light-group fill=8.8,32.1";
        let (groups, said) = made(key);
        tells(
            &said,
            "light group key  ViewLayer.Combined_key, 1 direction",
        );
        for (made, other) in [(&lobes, &whole), (&groups, &lobes), (&lobes, &picture)] {
            let differ = made.iter().zip(other).filter(|(a, b)| a != b).count();
            assert!(differ > 10_000, "{name}: {differ} pixels differ");
        }
        for made in [&lobes, &groups] {
            let fell = made.iter().zip(&picture).filter(|&(&made, &picture)| {
                let (made, picture) = (f32::from_bits(made), f32::from_bits(picture));
                !made.is_finite() || (made < 0.0 && picture >= 0.0)
            });
            assert_eq!(fell.count(), 0, "{name}");
        }
        for groups in ["", key] {
            assert_eq!(made(&format!("--scaling 0 {groups}")).0, picture, "{name}");
        }
    }
}
