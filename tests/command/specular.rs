//! Mirrors and lenses on the command line.

use crate::common::program::{self, run};

fn fixture(name: &str) -> String {
    program::fixture(name).to_str().unwrap().into()
}

#[test]
fn a_mirror_is_drawn_and_lit() {
    let desk = tempfile::tempdir().unwrap();
    let (input, map) = (fixture("mirror.exr"), fixture("mirror.surroundings.exr"));
    let mirror = [
        &input[..],
        "--specular-mask",
        "Mirror",
        "--surroundings",
        &map,
    ];
    for (command, more) in [
        ("hatch", &["--enlarge", "2", "--explain"][..]),
        ("relight", &["--material", "mirror", "--explain"]),
    ] {
        let arguments = [&[command][..], &mirror, more, &["-o", "out.png"]].concat();
        let explained = run(desk.path(), &arguments).done().stdout;
        // A pass of its own in drawings, a step of new light.
        let names = [
            "ran   specular-trace ",
            "what mirrored or refracted sight lines meet",
        ];
        assert!(
            names.iter().any(|name| explained.contains(name)),
            "{explained}"
        );
        assert!(desk.path().join("out.png").exists());
    }
}

#[test]
fn what_cannot_be_traced_is_refused_in_one_line() {
    let desk = tempfile::tempdir().unwrap();
    let (input, map) = (fixture("mirror.exr"), fixture("mirror.surroundings.exr"));
    let bust = fixture("bust.exr");
    let photo = fixture("tablet.color.jpg");
    let normal = fixture("tablet.normal.png");
    let cases: [(&[&str], i32, &str); 12] = [
        (
            &["hatch", &input, "--specular-mask", "Mirror"],
            2,
            "--specular-mask names mirrors, but nothing for them to show",
        ),
        (
            &["hatch", &input, "--back", &input],
            2,
            "--back bends sight lines",
        ),
        (
            &["hatch", &input, "--surroundings-camera", "x.json"],
            2,
            "give --surroundings FILE",
        ),
        (
            &["hatch", &input, "--surroundings", &bust],
            1,
            "no equirectangular map",
        ),
        (
            &["hatch", &input, "--surroundings", &photo],
            1,
            "has no position layer",
        ),
        (
            &["hatch", &input, "--surroundings", "absent.exr"],
            1,
            "absent.exr",
        ),
        (
            &["hatch", &input, "--behind", &bust],
            1,
            "but the picture is",
        ),
        (
            &[
                "hatch",
                &input,
                "--specular-mask",
                "Glass",
                "--surroundings",
                &map,
            ],
            1,
            "--specular-mask",
        ),
        (
            &["hatch", &input, "--hit-position", "Glass"],
            1,
            "--hit-position",
        ),
        (
            &["hatch", &photo, "--normal", &normal, "--surroundings", &map],
            1,
            "camera",
        ),
        (
            &[
                "relight",
                &input,
                "--surroundings",
                &map,
                "--light",
                "90,40",
            ],
            2,
            "--material is neither mirror nor glass",
        ),
        (
            &[
                "hatch",
                &input,
                "--surroundings",
                &map,
                "--search-steps",
                "0",
            ],
            2,
            "--search-steps is 0",
        ),
    ];
    for (arguments, code, expected) in cases {
        let error = run(desk.path(), [arguments, &["-o", "out.png"]].concat()).error(code);
        assert!(error.contains(expected), "{arguments:?}: {error}");
        assert!(!desk.path().join("out.png").exists());
    }
}
