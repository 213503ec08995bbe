//! Our layers as read by Blender and OpenImageIO; each test is skipped, with a notice, where they are not installed.

use crate::common::exr::channel;
use crate::common::program::Desk;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// A pixel of the bust's cheek, from the left and from the top of 360 rows.
const PIXEL: [usize; 2] = [240, 209];

/// The layers that `shape` writes, as Blender calls them.
#[rustfmt::skip]
const PASSES: [&str; 18] = [
    "Normal",
    "WeightsConfidence", "WeightsSilhouette", "WeightsCrease", "WeightsConductance",
    "GradientX", "GradientY",
    "HessianXx", "HessianXy", "HessianYy",
    "CurvatureU", "CurvatureV", "CurvatureMean", "CurvatureKappa",
    "DirectionX", "DirectionY", "DirectionViewX", "DirectionViewY",
];

/// Output of a program on files; `None`, with a notice, if `probe` shows that it is not installed.
fn printed(program: &str, probe: &[&str], arguments: &[&str], files: &[String]) -> Option<String> {
    let run = |arguments: &[&str], files: &[String]| {
        let mut command = Command::new(program);
        command.args(arguments).args(files).output().ok()
    };
    if !run(probe, &[]).is_some_and(|ran| ran.status.success()) {
        eprintln!("skipped: {program} {} does not run here", probe.join(" "));
        return None;
    }
    let ran = run(arguments, files).expect("it ran before");
    let [said, errors] =
        [ran.stdout, ran.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(ran.status.success(), "{said}{errors}");
    Some(said)
}

/// The bust's shape, with its layers written in every way.
fn written(desk: &Desk) -> Vec<String> {
    let made = ["keep", "channels", "results"].map(|way| {
        desk.make(format!(
            "shape fixtures/bust.exr --layers {way} -q -o {way}.exr"
        ));
        desk.at(&format!("{way}.exr")).display().to_string()
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
                let is_near = (shown - ours).abs() <= 1e-6 * ours.abs();
                assert!(is_near, "{layer}: {shown} for {ours}");
            }
        }
    }
}

#[test]
fn blender_shows_all_layers_and_their_values() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/show_layers.py");
    let script = script.display().to_string();
    let [x, y] = [PIXEL[0], 359 - PIXEL[1]].map(|at| at.to_string());
    let desk = Desk::new();
    let files = written(&desk);
    let options = ["-b", "--factory-startup", "-noaudio", "-P"];
    let python = [&script, "--", &x, &y];
    let blender = [&options[..], &python].concat();
    let ran = [
        printed("blender", &["--version"], &blender, &files),
        printed("python3", &["-c", "import bpy"], &python, &files),
    ];
    for said in ran.into_iter().flatten() {
        check(&said, &files);
        // Before its fifth version values are read too, of every pass.
        let values = said.matches("\nvalue ").count();
        let is_old = |line| ["version 3", "version 4"].contains(&line);
        let is_old = said.lines().any(is_old);
        let expected = usize::from(is_old) * PASSES.len() * files.len();
        assert_eq!(values, expected);
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
    let desk = Desk::new();
    let files = written(&desk);
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
