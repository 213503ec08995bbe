//! Mirrors and lenses on the command line.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fixture(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(name);
    path.to_str().unwrap().into()
}

fn relievo(directory: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(arguments)
        .current_dir(directory)
        .output()
        .unwrap()
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
        ("hatch", &["--explain"][..]),
        ("relight", &["--material", "mirror", "--explain"]),
    ] {
        let arguments = [&[command][..], &mirror, more, &["-o", "out.png"]].concat();
        let ran = relievo(desk.path(), &arguments);
        let said = String::from_utf8_lossy(&ran.stderr);
        assert!(ran.status.success(), "{said}");
        let explained = String::from_utf8_lossy(&ran.stdout);
        let is_traced = |line: &str| line.starts_with("run   specular-trace");
        assert!(explained.lines().any(is_traced), "{explained}");
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
        let ran = relievo(desk.path(), &[arguments, &["-o", "out.png"]].concat());
        let said = String::from_utf8_lossy(&ran.stderr);
        assert_eq!(ran.status.code(), Some(code), "{arguments:?}: {said}");
        let errors: Vec<_> = said.lines().filter(|l| l.starts_with("error: ")).collect();
        assert_eq!(errors.len(), 1, "{said}");
        let named = expected.split('|').any(|part| errors[0].contains(part));
        assert!(named, "{arguments:?}: {said}");
        assert!(!desk.path().join("out.png").exists());
    }
}
