//! Our layers as read by Blender and OpenImageIO; each test is skipped, with a notice, where they are not installed.

use crate::common::exr::channel;
use crate::common::program::{fixture, relievo};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// A pixel of the bust's cheek, from the left and from the top of 360 rows.
const PIXEL: [usize; 2] = [240, 209];

/// The layers that `shape` writes, as Blender calls them.
const PASSES: [&str; 18] = [
    "Normal",
    "WeightsConfidence",
    "WeightsSilhouette",
    "WeightsCrease",
    "WeightsConductance",
    "GradientX",
    "GradientY",
    "HessianXx",
    "HessianXy",
    "HessianYy",
    "CurvatureU",
    "CurvatureV",
    "CurvatureMean",
    "CurvatureKappa",
    "DirectionX",
    "DirectionY",
    "DirectionViewX",
    "DirectionViewY",
];

/// Output of a program on files; `None`, with a notice, if `probe` shows that it is not installed.
fn printed(program: &str, probe: &[&str], arguments: &[&str], files: &[String]) -> Option<String> {
    let run = |arguments: &[&str], files: &[String]| {
        Command::new(program)
            .args(arguments)
            .args(files)
            .output()
            .ok()
    };
    if !run(probe, &[]).is_some_and(|ran| ran.status.success()) {
        eprintln!("skipped: {program} {} does not run here", probe.join(" "));
        return None;
    }
    let ran = run(arguments, files).expect("it ran before");
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(
        ran.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    Some(said)
}

/// The bust's shape, with its layers written in every way.
fn written(desk: &Path) -> Vec<String> {
    let ways = ["keep", "channels", "results"];
    let made = ways.map(|way| {
        let input = fixture("bust.exr").display().to_string();
        relievo(
            desk,
            &format!("shape {input} --layers {way} -q -o {way}.exr"),
        )
        .done();
        desk.join(format!("{way}.exr")).display().to_string()
    });
    made.into()
}

/// The words after `kind` in the lines of each file.
fn lines<'a>(file: &'a str, kind: &'a str) -> impl Iterator<Item = &'a str> {
    file.lines()
        .filter_map(move |line| line.strip_prefix(kind)?.strip_prefix(' '))
}

fn check(said: &str, files: &[String]) {
    let each: Vec<&str> = said.split("file ").skip(1).collect();
    assert_eq!(each.len(), files.len(), "{said}");
    for (file, said) in files.iter().zip(each) {
        let passes: BTreeSet<&str> = lines(said, "pass").collect();
        assert_eq!(passes, BTreeSet::from(PASSES), "{file}");
        for value in lines(said, "value") {
            let words: Vec<&str> = value.split(' ').collect();
            let layer = format!("relievo.{}", words[0]);
            let components = if words[0] == "Normal" { "xyz" } else { "VVV" };
            for (component, shown) in components.chars().zip(&words[1..]) {
                let ours = channel(Path::new(file), &format!("{layer}.{component}"));
                let ours = ours.at(PIXEL[0], PIXEL[1]);
                let shown: f32 = shown.parse().unwrap();
                assert!(
                    (shown - ours).abs() <= 1e-6 * ours.abs(),
                    "{layer}: {shown} for {ours}"
                );
            }
        }
    }
}

#[test]
fn blender_shows_all_layers_and_their_values() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/show_layers.py");
    let script = script.display().to_string();
    let [x, y] = [PIXEL[0], 359 - PIXEL[1]].map(|at| at.to_string());
    let desk = tempfile::tempdir().unwrap();
    let files = written(desk.path());
    let blender = [
        "-b",
        "--factory-startup",
        "-noaudio",
        "-P",
        &script,
        "--",
        &x,
        &y,
    ];
    let python = [&script, "--", &x, &y];
    let ran = [
        printed("blender", &["--version"], &blender, &files),
        printed("python3", &["-c", "import bpy"], &python, &files),
    ];
    for said in ran.into_iter().flatten() {
        check(&said, &files);
        // Before its fifth version values are read too, of every pass.
        let values = said.matches("\nvalue ").count();
        let is_old = said
            .lines()
            .any(|line| line == "version 3" || line == "version 4");
        assert_eq!(
            values,
            if is_old {
                PASSES.len() * files.len()
            } else {
                0
            }
        );
    }
}

#[test]
fn openimageio_shows_all_channels() {
    let script = "import sys, OpenImageIO as oiio
for file in sys.argv[1:]:
    image, part = oiio.ImageInput.open(file), 0
    print('file', file)
    while image.seek_subimage(part, 0):
        [print('pass', name) for name in image.spec().channelnames if name.startswith('relievo.')]
        part += 1
";
    let desk = tempfile::tempdir().unwrap();
    let files = written(desk.path());
    let probe = ["-c", "import OpenImageIO"];
    let Some(said) = printed("python3", &probe, &["-c", script], &files) else {
        return;
    };
    let each: Vec<&str> = said.split("file ").skip(1).collect();
    assert_eq!(each.len(), files.len());
    for said in each {
        let layers: BTreeSet<&str> = lines(said, "pass")
            .filter_map(|name| name.strip_prefix("relievo.")?.rsplit_once('.'))
            .map(|(layer, _)| layer)
            .collect();
        assert_eq!(layers, BTreeSet::from(PASSES));
    }
}
