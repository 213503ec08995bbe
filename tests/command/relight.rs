//! `relievo relight` as a user runs it.

use crate::common::program::{Ran, fixture, relievo, run};
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::io::read_environment;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

fn relight(directory: &Path, input: &Path, flags: &[&str]) -> Ran {
    run(
        directory,
        ["relight".as_ref(), input.as_os_str()]
            .into_iter()
            .chain(flags.iter().map(OsStr::new)),
    )
}

/// Runs it on the photo of the tablet and its normal map; returns the picture.
fn tablet(directory: &Path, output: &str, flags: &[&str]) -> Photo {
    let normal = fixture("tablet.normal.png");
    let mut all = vec!["--normal", normal.to_str().unwrap(), "-o", output];
    all.extend(flags);
    let ran = relight(directory, &fixture("tablet.color.jpg"), &all);
    ran.done();
    Photo::read(&directory.join(output)).unwrap()
}

/// A small sky, bright to the left of the viewer.
fn sky(directory: &Path) -> PathBuf {
    let path = directory.join("sky.hdr");
    // Column 16 of 64 is a quarter turn left of the view direction.
    let pixel = |x: u32, _| image::Rgb([if (8..24).contains(&x) { 4.0_f32 } else { 0.25 }; 3]);
    image::Rgb32FImage::from_fn(64, 32, pixel)
        .save(&path)
        .unwrap();
    path
}

/// Mean of a channel over the left and over the right half.
fn halves(plane: &Plane) -> [f32; 2] {
    let half = plane.width() / 2;
    let mut sums = [0.0; 2];
    for y in 0..plane.height() {
        for (x, v) in plane.row(y).iter().enumerate() {
            sums[usize::from(x >= half)] += v;
        }
    }
    sums
}

#[test]
fn a_photo_is_lit_anew_by_every_method_and_keeps_its_size() {
    let desk = tempfile::tempdir().unwrap();
    let mut made = Vec::new();
    for method in ["plain", "warp", "scale", "both"] {
        let name = format!("{method}.png");
        let photo = tablet(
            desk.path(),
            &name,
            &["--light", "75,10", "--method", method],
        );
        assert_eq!((photo.width, photo.height), (256, 256));
        made.push(photo.channels);
    }
    for (i, a) in made.iter().enumerate() {
        assert!(
            made[i + 1..].iter().all(|b| a != b),
            "two methods gave one picture"
        );
    }
}

#[test]
fn colours_of_lights_and_of_the_photo_meet() {
    let desk = tempfile::tempdir().unwrap();
    let flags = [
        "--light",
        "90,45,1,0,0",
        "--ambient",
        "0",
        "--method",
        "plain",
    ];
    let red = tablet(desk.path(), "red.png", &flags);
    assert!(red.channels[0].samples().iter().any(|&v| v > 0.3));
    assert!(red.channels[1].samples().iter().all(|&v| v == 0.0));
}

#[test]
fn every_material_runs_in_an_environment() {
    let desk = tempfile::tempdir().unwrap();
    let sky = sky(desk.path());
    let materials = [
        "lambert",
        "phong",
        "blinn-phong",
        "toon",
        "sublambert",
        "ashikhmin-shirley",
        "mirror",
        "glass",
    ];
    for material in materials {
        let name = format!("{material}.png");
        let flags = [
            "--environment",
            sky.to_str().unwrap(),
            "--material",
            material,
        ];
        let made = tablet(desk.path(), &name, &flags);
        let lit = made.channels[0]
            .samples()
            .iter()
            .filter(|&&v| v > 0.02)
            .count();
        assert!(lit > 10_000, "{material} shows {lit} lit pixels");
    }
}

#[test]
fn an_environment_lights_from_the_side_where_it_is_bright() {
    // Left of the map's middle is left of the viewer; rotated by half a turn it is right.
    let desk = tempfile::tempdir().unwrap();
    let sky = sky(desk.path());
    assert!(read_environment(&sky).unwrap().radiance([-1.0, 0.0, 0.0])[0] > 3.0);
    let bust = fixture("bust.exr");
    let lit = |turn: &str| {
        let flags = [
            "--environment",
            sky.to_str().unwrap(),
            "--environment-rotate",
            turn,
            "--method",
            "plain",
            "--albedo-from",
            "white",
            "-o",
            "turned.png",
        ];
        let ran = relight(desk.path(), &bust, &flags);
        ran.done();
        halves(
            &Photo::read(&desk.path().join("turned.png"))
                .unwrap()
                .channels[0],
        )
    };
    let ([left, right], [turned_left, turned_right]) = (lit("0"), lit("180"));
    assert!(
        left / right > 1.2 * turned_left / turned_right,
        "{left} {right} {turned_left} {turned_right}"
    );
}

#[test]
fn explain_tells_what_was_left_out() {
    let desk = tempfile::tempdir().unwrap();
    let sky = sky(desk.path());
    let sky = sky.to_str().unwrap();
    let explained = |flags: &[&str]| {
        let mut all = vec!["-o", "out.png", "--explain", "-v"];
        all.extend(flags);
        let ran = relight(desk.path(), &fixture("bust.exr"), &all);
        ran.done().stdout
    };
    let line = |text: &str, stage: &str| {
        let found = text
            .lines()
            .find(|line| line.split_whitespace().nth(1) == Some(stage));
        found
            .unwrap_or_else(|| panic!("no {stage}: {text}"))
            .to_string()
    };
    // Equation 1 needs no Jacobian.
    let lookups = explained(&[
        "--environment",
        sky,
        "--method",
        "warp",
        "--warp-by",
        "lookups",
    ]);
    assert!(line(&lookups, "jacobian").starts_with('-'));
    assert!(lookups.contains("warping: strength"), "{lookups}");
    let lights = explained(&["--environment", sky, "--method", "warp"]);
    assert!(lights.contains("jacobian: "), "{lights}");
    // Isotropic scaling needs no eigenvectors, nor the Hessian.
    let scaled = explained(&["--light", "135,40", "--method", "scale"]);
    assert!(line(&scaled, "hessian").contains("no eigenvectors"));
    assert!(line(&scaled, "directions").starts_with('-'));
    // Lights with directions need no prefilter.
    assert!(line(&scaled, "environment-prefilter").contains("directions"));
    // Plain light needs nothing of shape.
    let plain = explained(&["--light", "135,40", "--method", "plain"]);
    for stage in ["conductance", "diffusion", "trace", "auto-gain"] {
        assert!(line(&plain, stage).starts_with('-'), "{stage}");
    }
}

#[test]
fn what_cannot_be_done_is_refused_in_one_line() {
    let desk = tempfile::tempdir().unwrap();
    let bust = fixture("bust.exr");
    let tablet = fixture("tablet.color.jpg");
    let normal = fixture("tablet.normal.png");
    let normal = normal.to_str().unwrap();
    let run = |input: &Path, flags: &[&str]| {
        let mut all = vec!["-o", "out.png"];
        all.extend(flags);
        relight(desk.path(), input, &all)
    };
    for (flags, expected) in [
        (&["--ambient", "0"][..], "--light AZ,EL"),
        (&["--light", "1"], "expected 2 numbers"),
        (&["--light", "1,2,-1,0,0"], "colour of 0 or more"),
        (
            &["--light", "0,45", "--material", "mirror"],
            "--environment",
        ),
        (
            &["--light", "0,45", "--warp", "-1"],
            "--warp is -1; give 0 to 1e6",
        ),
        (&["--light", "0,45", "--contrast", "2"], "-1 to 1"),
        (
            &["--light", "0,45", "--material", "wood"],
            "ashikhmin-shirley",
        ),
        (&["--light", "0,45", "--toon-levels", "0"], "1 to 1024"),
        (&["--light", "0,45", "--samples", "1000000"], "up to 100000"),
        (
            &["--light", "0,45", "--albedo-from", "layer"],
            "--albedo-from",
        ),
    ] {
        let line = run(&bust, flags).error(2);
        assert!(line.contains(expected), "{flags:?}: {line}");
    }
    let line = run(&tablet, &["--normal", normal, "--point-light", "0,0,1"]).error(2);
    assert!(
        line.contains("--point-light") && line.contains("depth"),
        "{line}"
    );
    let line = run(&bust, &["--environment", "nowhere.hdr"]).error(1);
    assert!(line.contains("nowhere.hdr"), "{line}");
    // An input is never written over.
    let sky = sky(desk.path());
    let ran = relight(
        desk.path(),
        &bust,
        &["--environment", "sky.hdr", "-o", "sky.hdr"],
    );
    ran.error(2);
    assert!(sky.metadata().unwrap().len() > 100);
    assert!(!desk.path().join("out.png").exists());
}

#[test]
fn strong_scaling_is_warned_of() {
    let desk = tempfile::tempdir().unwrap();
    let flags = ["--light", "0,45", "--scaling", "5", "-o", "out.png"];
    let ran = relight(desk.path(), &fixture("bust.exr"), &flags);
    let said = ran.stderr;
    assert!(said.contains("warning: --scaling 5 is past"), "{said}");
}

#[test]
fn light_that_is_hardly_meant_is_told() {
    let desk = tempfile::tempdir().unwrap();
    let bust = fixture("bust.exr");
    let lit = |flags: &[&str]| relight(desk.path(), &bust, &[flags, &["-o", "a.png"]].concat());
    let said = |flags: &[&str]| lit(flags).ended(0);
    let dark = said(&[]);
    assert!(dark.contains("no light is given: --light 135,40"), "{dark}");
    assert!(!said(&["--ambient", "1"]).contains("no light"));
    // 120 degrees up are 60 degrees down to the other side.
    let behind = said(&["--light", "10,120"]);
    assert!(behind.contains("it shines from 190,60"), "{behind}");
    let room = fixture("room.hdr");
    let refused = lit(&["--lit-sphere", room.to_str().unwrap()]).ended(1);
    assert!(refused.contains("--environment"), "{refused}");
}

/// What shadows were chosen is said, and what they cannot do.
#[test]
fn shadows_are_told() {
    let desk = tempfile::tempdir().unwrap();
    let [color, normal, bust, room] = [
        "tablet.color.jpg",
        "tablet.normal.png",
        "bust.exr",
        "room.hdr",
    ]
    .map(|name| fixture(name).display().to_string());
    let tablet = format!("{color} --normal {normal} --method plain -o a.png");
    let bust = format!("{bust} --method plain -o a.png");
    let fills = "--sky-shadows on takes what stands before a background for solid";
    let cases = [
        (&tablet, "--light 75,20", 0, ": shadows on"),
        (&tablet, "--light 75,60", 0, ": shadows off"),
        (&tablet, "--light 75,20 --raking best", 0, ": shadows off"),
        (
            &tablet,
            &format!("--environment {room}"),
            0,
            ": sky-shadows on",
        ),
        (
            &bust,
            &format!("--environment {room}"),
            0,
            ": sky-shadows off",
        ),
        (
            &bust,
            &format!("--environment {room} --occlusion computed"),
            0,
            fills,
        ),
        (
            &tablet,
            &format!("--environment {room} --shadows on"),
            2,
            "--sky-shadows on is for environments",
        ),
        (
            &tablet,
            &format!("--environment {room} --material mirror --sky-shadows on"),
            2,
            "a --material that scatters light",
        ),
        (
            &bust,
            "--light 150,25 --shadows on --thickness 0",
            2,
            "--thickness",
        ),
    ];
    for (input, flags, code, expected) in cases {
        let ran = relievo(desk.path(), &format!("relight {input} {flags}"));
        let said = format!("{}{}", ran.stdout, ran.stderr);
        assert!(said.contains(expected), "{flags}: {said}");
        assert_eq!(ran.code, Some(code), "{flags}: {said}");
    }
    for preset in ["raking", "inscription-raking"] {
        relievo(
            desk.path(),
            &format!("run {preset} {color} --normal {normal} -o b.png"),
        )
        .done();
    }
}
