//! The program with `--backend gpu`.

use super::on_gpu;
use relievo::engine::difference;
use relievo::frame::{Plane, Vector2Planes};
use relievo::io::exr::{ChannelId, ExrFile, Limits};
use relievo::product::Product;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

fn relievo(directory: &Path, words: &str) -> Output {
    let fixture = fixtures().join("bust.exr");
    let mut words = words.split_whitespace();
    Command::new(env!("CARGO_BIN_EXE_relievo"))
        .arg(words.next().unwrap())
        .arg(fixture)
        .args(words)
        .current_dir(directory)
        // What Mesa says of its own is not counted.
        .env("NODEVICE_SELECT", "1")
        .output()
        .unwrap()
}

/// All channels of a file, with their names.
fn channels(path: &Path) -> Vec<(String, Plane)> {
    let file = ExrFile::open(path, &Limits::default()).unwrap();
    let ids: Vec<ChannelId> = file.channel_ids().collect();
    let names = file.parts[0].channels.iter().map(|c| c.name.clone());
    names.zip(file.read_channels(&ids).unwrap()).collect()
}

/// The directions of the surface's own curvature among channels.
fn directions(channels: &[(String, Plane)]) -> Vector2Planes {
    let [x, y] = ["direction.x", "direction.y"].map(|wanted| {
        let found = channels.iter().find(|(name, _)| name == wanted);
        found.expect("shape writes directions").1.clone()
    });
    Vector2Planes { x, y }
}

#[test]
fn the_program_writes_what_the_cpu_writes() {
    on_gpu(|_| {
        let desk = tempfile::tempdir().unwrap();
        let room = fixtures().join("room.hdr");
        let room = room.display();
        for work in [
            "enhance",
            "shape",
            "hatch",
            &format!("relight --environment {room} --material blinn-phong"),
        ] {
            for backend in ["cpu", "gpu"] {
                let words = format!(
                    "{work} -o {backend}.exr --layers results --depth-of-output float --backend {backend}"
                );
                let ran = relievo(desk.path(), &words);
                assert!(ran.status.success(), "{ran:?}");
            }
            let [expected, found] =
                ["cpu.exr", "gpu.exr"].map(|name| channels(&desk.path().join(name)));
            assert_eq!(found.len(), expected.len());
            for ((name, found), (_, expected)) in found.iter().zip(&expected) {
                if work == "hatch" {
                    let apart = Product::Strokes.apart(&[found], &[expected]);
                    let allowed = Product::Strokes.tolerance();
                    assert!(apart < allowed, "{work}: {name} is off by {apart:e}");
                // Directions leap where two curvatures are alike, or to their opposites, which are the same.
                } else if !name.starts_with("direction") {
                    let apart = difference(found, expected);
                    assert!(apart < 2e-5, "{work}: {name} is off by {apart:e}");
                }
            }
            if work == "shape" {
                let [found, expected] = [&found, &expected].map(|channels| directions(channels));
                let apart =
                    Product::Direction.apart(&[&found.x, &found.y], &[&expected.x, &expected.y]);
                assert!(apart < Product::Direction.tolerance(), "off by {apart:e}");
            }
        }
    });
}

#[test]
fn what_has_no_kernels_is_refused_by_name_and_done_otherwise() {
    let desk = tempfile::tempdir().unwrap();
    let grain = "--light 30,40 --material ashikhmin-shirley --coat 10,200 -o lit.png";
    for work in ["relight", "hatch"] {
        let words = format!("{work} {grain}");
        on_gpu(|_| {
            let refused = relievo(desk.path(), &format!("{words} --backend gpu"));
            let line = String::from_utf8(refused.stderr).unwrap();
            assert_eq!(refused.status.code(), Some(2), "{line}");
            assert!(
                line.contains("--backend") && line.lines().count() == 1,
                "{line}"
            );
            assert!(line.contains("a grain along the curvature"), "{line}");
        });
        let done = relievo(desk.path(), &format!("{words} --backend auto"));
        assert!(done.status.success() && desk.path().join("lit.png").exists());
        std::fs::remove_file(desk.path().join("lit.png")).unwrap();
    }
}

/// Runs the program on frames 1 to 3 of a sequence, on a machine without any adapter.
fn without_adapters(directory: &Path, words: &str) -> Output {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bust.exr");
    for frame in 1..=3 {
        std::fs::copy(&fixture, directory.join(format!("in.{frame}.exr"))).unwrap();
    }
    Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(words.split_whitespace())
        .current_dir(directory)
        // Where the loader of Vulkan looks for drivers, by its new name and its old one.
        .env("VK_DRIVER_FILES", "/dev/null")
        .env("VK_ICD_FILENAMES", "/dev/null")
        .output()
        .unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn that_there_is_no_adapter_is_said_once_for_all_frames() {
    let desk = tempfile::tempdir().unwrap();
    for samples in ["", "--sample-frames none"] {
        let words = format!(
            "enhance in.#.exr --frames 1-3 -o out.#.png --backend auto --progress none {samples}"
        );
        let ran = without_adapters(desk.path(), &words);
        let said = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.success(), "{said}");
        let told = said.lines().filter(|line| line.contains("no GPU"));
        let told: Vec<_> = told.collect();
        assert_eq!(told.len(), 1, "{said}");
        assert!(told[0].contains("the CPU does it"), "{said}");
        for frame in 1..=3 {
            std::fs::remove_file(desk.path().join(format!("out.{frame}.png"))).unwrap();
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_adapter_that_was_asked_for_and_is_not_there_is_an_error_and_nothing_is_written() {
    let desk = tempfile::tempdir().unwrap();
    let words = "enhance in.1.exr -o out.png --backend gpu";
    let ran = without_adapters(desk.path(), words);
    let said = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(1), "{said}");
    assert!(
        said.lines().count() == 1 && said.contains("no adapter") && said.contains("libvulkan1"),
        "{said}"
    );
    assert!(!desk.path().join("out.png").exists());
    assert_eq!(std::fs::read_dir(desk.path()).unwrap().count(), 3);
}
