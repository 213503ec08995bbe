//! What Blender and OpenImageIO show of our layers; each test is skipped, with a line, where they are not installed.

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

/// What a program prints, if it is there.
fn printed(program: &str, arguments: &[&str], files: &[String]) -> Option<String> {
    let output = Command::new(program).args(arguments).args(files).output();
    let ran = output.ok().filter(|ran| ran.status.success())?;
    Some(String::from_utf8_lossy(&ran.stdout).into_owned())
}

/// The bust's shape in every way that its layers may go to a file.
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
    match printed("blender", &blender, &files) {
        Some(said) => {
            check(&said, &files);
            let is_old = !said.contains("Blender 5");
            assert_eq!(said.matches("value ").count() > 0, is_old);
        }
        None => eprintln!("skipped: there is no blender that runs here"),
    }
    match printed("python3", &[&script, "--", &x, &y], &files) {
        Some(said) => check(&said, &files),
        None => eprintln!("skipped: python3 has no module bpy"),
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
    let Some(said) = printed("python3", &["-c", script], &files) else {
        eprintln!("skipped: python3 has no module OpenImageIO");
        return;
    };
    for said in said.split("file ").skip(1) {
        let layers: BTreeSet<&str> = lines(said, "pass")
            .filter_map(|name| name.strip_prefix("relievo.")?.rsplit_once('.'))
            .map(|(layer, _)| layer)
            .collect();
        assert_eq!(layers, BTreeSet::from(PASSES));
    }
}
