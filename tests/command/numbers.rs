//! Extreme numbers: each is refused with its range, or gives finite results; nothing else is ever written.

use super::inputs::{desk, write_frame};
use crate::common::exr::Part;
use crate::common::program::{names, relievo};
use relievo::frame::Plane;
use relievo::io::colorspace::ColorSpace;
use relievo::io::exr::{ChannelId, ExrFile};
use std::fs;
use std::path::Path;

/// Runs a command line that must be refused with one line containing `expected`, and leave no files.
#[track_caller]
fn refused(here: &Path, words: &str, code: i32, expected: &str) {
    let said = relievo(here, words).ended(code);
    assert!(said.contains(expected), "{words}: {said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert_eq!(names(here, "out"), [""; 0], "{words}");
}

#[test]
fn numbers_out_of_range_are_refused_with_their_range() {
    let desk = desk(1..=1);
    let here = desk.path();
    for (words, expected) in [
        ("enhance --scaling 1e30", "--scaling is 1e30; give 0 to 1e6"),
        ("enhance --scaling nan", "--scaling is NaN; give 0 to 1e6"),
        (
            "enhance --curvature-gain 1e-40",
            "--curvature-gain is 1e-40; give 1e-30 to 1e30",
        ),
        (
            "enhance --white-level 1e-40",
            "--white-level is 1e-40; give 1e-38 to 3.4028235e38",
        ),
        (
            "enhance --term-white-level diffuse=1e-40",
            "--term-white-level is 1e-40; give",
        ),
        (
            "enhance --tolerance 1e-30",
            "--tolerance is 1e-30; give 1e-9 to 1000",
        ),
        (
            "enhance --crease 1,1e38",
            "--crease is 1e38; give 1 to 1e30",
        ),
        (
            "enhance --iterations 4294967295",
            "--iterations is 4294967295; give 0 to 41943039",
        ),
        (
            "enhance --iterations 4000000 --solver explicit",
            "--solver takes 4000000 explicit steps",
        ),
        ("enhance --scale 4097", "--scale is 4097; give 0 to 4096"),
        (
            "enhance --reference-height 0",
            "--reference-height is 0; give 1 or more",
        ),
        (
            "relight --light 30,40 --warp 1e30",
            "--warp is 1e30; give 0 to 1e6",
        ),
        (
            "relight --light 30,40 --shininess 1e30",
            "--shininess is 1e30; give 0 to 1e6",
        ),
        (
            "relight --light 30,40 --coat 1e38,1e38",
            "--coat is 1e38; give 0 to 1e6",
        ),
        (
            "relight --light 30,40 --tangent 1e30",
            "--tangent is 1e30; give -1e6 to 1e6",
        ),
        (
            "relight --light 30,40 --diffuse-gain inf",
            "--diffuse-gain is inf; give 0 to 1e6",
        ),
        (
            "relight --light 30,40,1e38,1,1",
            "--light is 1e38; give 0 to 1e12",
        ),
        (
            "relight --point-light 0,0,1e38",
            "--point-light is 1e38; give -1e9 to 1e9",
        ),
        (
            "relight --area-light 0,0,1e38",
            "--area-light is 1e38; give 0 to 180",
        ),
        (
            "relight --light 30,40 --environment-rotate inf",
            "--environment-rotate is inf; give",
        ),
        (
            "hatch --fallback 1e30",
            "--fallback is 1e30; give -1e6 to 1e6",
        ),
        (
            "hatch --white-point 1e-40",
            "--white-point is 1e-40; give 1e-38 to",
        ),
    ] {
        refused(
            here,
            &format!("{words} in.0001.exr -o out.png"),
            2,
            expected,
        );
    }
    // That many lights must not be created first.
    let lights = "--area-light 1,1,1 ".repeat(1000);
    let words = format!("relight {lights} --samples 100000 in.0001.exr -o out.png");
    refused(
        here,
        &words,
        2,
        "--light makes 100000000 lights; give at most 100000",
    );
}

#[test]
fn a_hundred_thousand_scales_are_refused_at_once() {
    let desk = desk(1..=1);
    let here = desk.path();
    let recipe = |count: usize| {
        let scales: Vec<_> = (1..=count)
            .map(|i| format!("{}", i as f32 / 32.0))
            .collect();
        let text = format!(
            "version = 1\ncommand = \"shape\"\nscale = [{}]\n",
            scales.join(", ")
        );
        fs::write(here.join("look.toml"), text).unwrap();
    };
    for (count, code) in [(100_000, 2), (65, 2)] {
        recipe(count);
        let expected = format!("--scale names {count} scales; give at most 64");
        refused(
            here,
            "run look.toml in.0001.exr -o out.exr",
            code,
            &expected,
        );
    }
    recipe(64);
    relievo(here, "run look.toml in.0001.exr -o whole.exr").ended(0);
}

#[test]
fn cameras_out_of_range_are_refused() {
    let desk = desk(1..=1);
    let here = desk.path();
    for (camera, expected) in [
        (
            r#"{"focal_px": 1e-300}"#,
            "cam.json: its focal length is 1e-300 px; give 0.01 to 1e9",
        ),
        (r#"{"focal_px": 0.005}"#, "its focal length is 0.005 px"),
        (
            r#"{"focal_px": 64, "principal_point_px": [1e300, 32]}"#,
            "its principal point is 1e300 px; give -1e7 to 1e7",
        ),
        (
            r#"{"pixels_per_unit": 1e-300}"#,
            "its number of pixels per unit is 1e-300; give 1e-6 to 1e9",
        ),
        (
            r#"{"focal_px": 64, "resolution": [1e300, 1e300]}"#,
            "its resolution is 1e300; give 1 to",
        ),
    ] {
        fs::write(here.join("cam.json"), camera).unwrap();
        for command in ["enhance", "shape", "relight --light 30,40", "hatch"] {
            let words =
                format!("{command} --foreshortening 1 in.0001.exr --camera cam.json -o out.exr");
            refused(here, &words, 1, expected);
        }
    }
    // The same as text of a sequence.
    let still = r#"{"view_from_world":[1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0],"is_placed":false,"projection":{"type":"perspective","fx":1e-300,"fy":64.0,"cx":32.0,"cy":32.0}}"#;
    let words = format!("shape in.0001.exr --still-camera {still} -o out.exr");
    refused(
        here,
        &words,
        2,
        "--still-camera is out of range: its focal length is 1e-300 px",
    );
}

#[test]
fn what_overflows_in_spite_of_all_ranges_is_not_written() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    // Stages stay within single precision, up to 3.4e38. But for AP1 a display shows 1.7 times the red, less others:
    // for a grey of 3e38 that overflows on the way.
    let plane = |value| Plane::filled(16, 16, value);
    let (grey, zero, one) = (plane(3e38), plane(0.0), plane(1.0));
    let picture = ["R", "G", "B"].map(|name| (name, &grey));
    let normals = [("N.X", &zero), ("N.Y", &zero), ("N.Z", &one)];
    let part = Part::of(picture.into_iter().chain(normals)).chromaticities(ColorSpace::AP1);
    for number in 1..=2 {
        let path = here.join(format!("in.{number:04}.exr"));
        part.clone().write(&path);
    }
    let found = "in.0001.exr: picture at (0, 0) is not finite, from inputs that are; give numbers that are less extreme";
    for out in ["out.png", "out.hdr", "out.tif"] {
        refused(here, &format!("enhance in.0001.exr -o {out}"), 1, found);
    }
    let words = "enhance in.####.exr --frames 1-2 --keep-going -o out.####.png";
    let said = relievo(here, words).ended(1);
    for name in ["in.0001.exr", "in.0002.exr"] {
        let line = format!("error: {name}: picture at (0, 0) is not finite");
        assert_eq!(said.matches(&line).count(), 1, "{said}");
    }
    assert_eq!(names(here, "out"), [""; 0]);
    assert_eq!(names(here, ".relievo"), [""; 0]);
    // Layers stay in AP1, and finite.
    relievo(here, "enhance in.0001.exr -o whole.exr").ended(0);
}

#[test]
fn samples_too_large_for_half_floats_are_clamped_with_one_warning() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_frame(here, 1, 64, 1e6);
    for (how, expected) in [
        (
            "--compression dwaa",
            "--depth-of-output float --compression zip",
        ),
        (
            "--compression dwab --depth-of-output half",
            "--depth-of-output float --compression zip",
        ),
        (
            "--depth-of-output half",
            "keep them with --depth-of-output float\n",
        ),
    ] {
        let words = format!("enhance in.0001.exr {how} --layers results -o out.exr");
        let said = relievo(here, &words).ended(0);
        let warnings: Vec<_> = said.lines().filter(|l| l.starts_with("warning")).collect();
        assert_eq!(warnings.len(), 1, "{said}");
        assert!(
            warnings[0].contains(" samples are too large for half floats and clamped"),
            "{said}"
        );
        assert!(said.contains(expected), "{said}");
        let file = ExrFile::open(&here.join("out.exr"), &Default::default()).unwrap();
        let all: Vec<ChannelId> = file.channel_ids().collect();
        for plane in file.read_channels(&all).unwrap() {
            assert!(
                plane.samples().iter().all(|sample| sample.is_finite()),
                "{how}"
            );
        }
    }
    let said = relievo(here, "enhance in.0001.exr --layers results -o out.exr").ended(0);
    assert!(!said.contains("warning"), "{said}");
}
