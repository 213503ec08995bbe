//! The same through the program, from files.

use super::*;
use crate::common::bits as bits_of;
use crate::common::exr::{Part, channel};
use crate::common::program::{Ran, run};
use crate::common::real_files::real;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

fn enhance(input: &Path, output: &Path, flags: &[&str]) -> Ran {
    let paths = [
        "enhance".as_ref(),
        input.as_os_str(),
        "-o".as_ref(),
        output.as_os_str(),
    ];
    run(
        Path::new("."),
        paths.into_iter().chain(flags.iter().map(OsStr::new)),
    )
}

#[track_caller]
fn refused(ran: Ran, word: &str) {
    let code = ran.code.unwrap();
    let line = ran.refused(code);
    assert!(line.contains(word), "{line}");
}

fn rgb<'a>(layer: &str, color: &'a ColorPlanes) -> Vec<(String, &'a Plane)> {
    let names = ["R", "G", "B"].map(|c| format!("{layer}.{c}"));
    names.into_iter().zip(channels(color)).collect()
}

/// The bits of a channel of a file.
fn channel_bits(path: &Path, name: &str) -> Vec<u32> {
    bits_of(&channel(path, name))
}

/// The scene as a file, its layers under the names given: normal and picture, then the rest.
fn file(desk: &Path, name: &str, layers: &[(&str, &ColorPlanes)]) -> PathBuf {
    let frame = scene();
    let mask = frame.mask.plane().map(|c| if c { 1.0 } else { 0.0 });
    let normal = [&frame.normal.x, &frame.normal.y, &frame.normal.z];
    let mut all: Vec<(String, &Plane)> = ["normal.X", "normal.Y", "normal.Z"]
        .map(String::from)
        .into_iter()
        .zip(normal)
        .collect();
    all.push(("mask.Y".into(), &mask));
    all.extend(rgb("Combined", frame.color.as_ref().unwrap()));
    for (layer, color) in layers {
        all.extend(rgb(layer, color));
    }
    let path = desk.join(name);
    Part::of(all).write(&path);
    path
}

const VIEW: [&str; 4] = ["--normal-space", "view", "--coverage", "mask"];

#[test]
fn lobes_are_found_by_name_and_told_of() {
    let desk = tempfile::tempdir().unwrap();
    let frame = scene();
    let lobes = &frame.light.lobes;
    let [direct, indirect, own, gloss, gloss_own] = [
        &lobes[0].direct,
        &lobes[0].indirect,
        &lobes[0].color,
        &lobes[1].direct,
        &lobes[1].color,
    ]
    .map(|planes| planes.as_ref().unwrap());
    let together = |lobe: usize| color(|i, x, y| radiance(&lobes[lobe], i, x, y));
    let (diffuse, specular) = (together(0), together(1));
    let blender = [
        ("DiffDir", direct),
        ("DiffInd", indirect),
        ("DiffCol", own),
        ("GlossDir", gloss),
        ("GlossCol", gloss_own),
    ];
    let blender = file(desk.path(), "blender.exr", &blender);
    let arnold = [
        ("diffuse_direct", &diffuse),
        ("albedo", own),
        ("specular_direct", &specular),
    ];
    let arnold = file(desk.path(), "arnold.exr", &arnold);
    let odd = [("dif", &diffuse), ("spec", &specular), ("paint", own)];
    let odd = file(desk.path(), "odd.exr", &odd);

    let output = desk.path().join("out.exr");
    let fixed = [
        "--curvature-gain",
        "20",
        "--white-level",
        "1.5",
        "-v",
        "--explain",
    ];
    let flags = |more: &[&'static str]| [&VIEW[..], &fixed, more].concat();
    let made = |input: &Path, more: &[&'static str]| {
        let ran = enhance(input, &output, &flags(more)).done();
        (channel_bits(&output, "relievo.G"), ran)
    };
    let (by_blender, said) = made(&blender, &[]);
    let line = "diffuse lobe     (DiffDir + DiffInd) x DiffCol";
    assert!(said.stderr.contains(line), "{}", said.stderr);
    assert!(
        said.stderr.contains("specular lobe    GlossDir x GlossCol"),
        "{}",
        said.stderr
    );
    assert!(
        said.stderr.contains("light passes     recombine"),
        "{}",
        said.stderr
    );
    assert!(said.stdout.contains("ran   light-lobes"), "{}", said.stdout);
    assert!(
        said.stdout.contains("-     radiance-scaling"),
        "{}",
        said.stdout
    );
    // The same white light, including the surface's colour: intensities equal Blender's to rounding. (Not those of
    // specular light, whose colour cannot be separated.)
    let diffuse_alone = ["--scaling-specular", "0"];
    let [(a, _), (b, _), (c, _)] = [
        made(&blender, &diffuse_alone),
        made(&arnold, &diffuse_alone),
        made(
            &odd,
            &[
                "--scaling-specular",
                "0",
                "--diffuse",
                "dif",
                "--specular",
                "spec",
                "--albedo",
                "paint",
            ],
        ),
    ];
    let picture = channel_bits(&blender, "Combined.G");
    assert_ne!(a, picture);
    for other in [&b, &c] {
        for (a, b) in a.iter().zip(other) {
            let (a, b) = (f32::from_bits(*a), f32::from_bits(*b));
            assert!((a - b).abs() < 1e-5, "{a} is not {b}");
        }
    }
    // One layer named, or lobes refused: the picture as a whole, as ever.
    let (whole, said) = made(&blender, &["--lobes", "off"]);
    assert!(
        said.stdout.contains("ran   radiance-scaling"),
        "{}",
        said.stdout
    );
    assert!(!said.stderr.contains("lobe"), "{}", said.stderr);
    assert_eq!(whole, made(&blender, &["--color", "Combined"]).0);
    assert_ne!(whole, by_blender);
    let forced = made(&blender, &["--color", "Combined", "--lobes", "on"]).0;
    assert_eq!(forced, by_blender);
    for zero in [
        &["--scaling", "0"][..],
        &["--scaling-diffuse", "0", "--scaling-specular", "0"],
    ] {
        assert_eq!(made(&blender, &[zero, &[]].concat()).0, picture);
    }
}

#[test]
fn missing_and_doubtful_passes_are_told() {
    let desk = tempfile::tempdir().unwrap();
    let frame = scene();
    let lobe = &frame.light.lobes[0];
    let direct = lobe.direct.as_ref().unwrap();
    let output = desk.path().join("out.exr");
    // Light without its colour is no part of the picture: left alone, and the picture is scaled as a whole.
    let colorless = file(desk.path(), "colorless.exr", &[("DiffDir", direct)]);
    let said = enhance(
        &colorless,
        &output,
        &[&VIEW[..], &["-v", "--explain"]].concat(),
    );
    assert!(
        said.stderr.contains("its color layer is missing"),
        "{}",
        said.stderr
    );
    assert!(
        said.stdout.contains("ran   radiance-scaling"),
        "{}",
        said.stdout
    );
    // Arnold's name, but three times the light.
    let thrice = color(|i, x, y| 3.0 * radiance(lobe, i, x, y));
    let doubtful = file(desk.path(), "doubtful.exr", &[("diffuse_direct", &thrice)]);
    let said = enhance(&doubtful, &output, &VIEW);
    assert_eq!(said.code, Some(0));
    let warning = "warning: ";
    assert!(said.stderr.contains(warning) && said.stderr.contains("% in the median"));
    // A magnitude with nothing to scale.
    let said = enhance(
        &doubtful,
        &output,
        &[&VIEW[..], &["--scaling-specular", "2"]].concat(),
    );
    assert!(
        said.stderr.contains("--scaling-specular changes nothing"),
        "{}",
        said.stderr
    );

    let plain = file(desk.path(), "plain.exr", &[]);
    refused(
        enhance(&plain, &output, &[&VIEW[..], &["--lobes", "on"]].concat()),
        "no light passes",
    );
    let group = ["--light-group", "key=0,45"];
    refused(
        enhance(&plain, &output, &[&VIEW[..], &group].concat()),
        "no light group called key",
    );
    let bad = ["--light-group", "key=0"];
    refused(
        enhance(&plain, &output, &[&VIEW[..], &bad].concat()),
        "NAME=AZ,EL",
    );
    // Another size.
    let small = desk.path().join("small.exr");
    let plane = Plane::filled(7, 5, 0.5);
    let layer = |c: &str| (format!("diffuse.{c}"), &plane);
    Part::of(["R", "G", "B"].map(layer)).write(&small);
    let named = ["--diffuse", small.to_str().unwrap()];
    refused(
        enhance(&plain, &output, &[&VIEW[..], &named].concat()),
        "inputs of one size",
    );
    // The output may not be that file.
    refused(
        enhance(&plain, &small, &[&VIEW[..], &named].concat()),
        "is the input",
    );
}

#[test]
fn occlusion_is_scaled_as_ambient_light() {
    let desk = tempfile::tempdir().unwrap();
    let open = color(|_, x, y| 0.3 + (x * y) as f32 / 5000.0);
    let input = file(desk.path(), "occlusion.exr", &[("AO", &open)]);
    let output = desk.path().join("out.exr");
    let said = |flags: &[&str]| {
        enhance(
            &input,
            &output,
            &[&VIEW[..], &["--explain", "-v"], flags].concat(),
        )
        .done()
    };
    assert!(said(&[]).stdout.contains("-     ambient-occlusion"));
    let with = said(&["--scaling-ambient", "1"]);
    assert!(
        with.stdout.contains("ran   ambient-occlusion"),
        "{}",
        with.stdout
    );
    let alone = said(&["--color", "AO"]);
    assert!(
        alone.stderr.contains("white level 1.0000"),
        "{}",
        alone.stderr
    );
}

#[test]
fn inspect_warns_of_a_magnitude_that_is_planned() {
    let desk = tempfile::tempdir().unwrap();
    let input = file(desk.path(), "plain.exr", &[]);
    let inspected = |flags: &[&str]| {
        let paths = ["inspect", input.to_str().unwrap()];
        run(Path::new("."), [&paths[..], flags].concat())
            .done()
            .stdout
    };
    // The limits at 0.2 and 0.5 are 1.44 and 0.48.
    let rims = "dark rims";
    assert!(!inspected(&[]).contains(rims));
    assert!(!inspected(&["--scaling", "1.4", "--invariant-point", "0.2"]).contains(rims));
    assert!(inspected(&["--scaling", "1.5", "--invariant-point", "0.2"]).contains(rims));
    // The usual magnitude of 1.
    assert!(inspected(&["--invariant-point", "0.5"]).contains(rims));
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
        let desk = tempfile::tempdir().unwrap();
        let output = desk.path().join("out.exr");
        let made = |flags: &[&str]| {
            let ran = enhance(&input, &output, &[flags, &["-v"]].concat()).done();
            (channel_bits(&output, "relievo.R"), ran.stderr)
        };
        let picture = channel_bits(&input, "ViewLayer.Combined.R");
        let (lobes, said) = made(&[]);
        for line in [
            "diffuse lobe",
            "specular lobe",
            "light passes     recombine to the picture",
        ] {
            assert!(said.contains(line), "{name}: {said}");
        }
        let (whole, _) = made(&["--lobes", "off"]);
        // The directions to the key and fill lights of these renders, rotated to view space.
        let key = [
            "--light-group",
            "key=138.4,41.1",
            "--light-group",
            "fill=8.8,32.1",
        ];
        let (groups, said) = made(&key);
        assert!(
            said.contains("light group key  ViewLayer.Combined_key, 1 direction"),
            "{said}"
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
        let zero = [&["--scaling", "0"][..], &["--scaling", "0", key[0], key[1]]];
        for flags in zero {
            assert_eq!(made(flags).0, picture, "{name}");
        }
    }
}
