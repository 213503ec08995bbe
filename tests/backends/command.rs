//! The program with `--backend gpu`.

use super::on_gpu;
use crate::common::program::{Ran, fixture, program, run};
use relievo::frame::{Plane, Vector2Planes};
use relievo::io::exr::{ChannelId, ExrFile, Limits};
use relievo::product::Product;
use std::ffi::OsStr;
use std::path::Path;

/// Runs a command on a frame.
fn on_bust(directory: &Path, words: &str) -> Ran {
    let (command, flags) = words.split_once(' ').unwrap();
    let (command, flags) = (command.as_ref(), flags.split_whitespace().map(OsStr::new));
    let bust = fixture("bust.exr");
    run(
        directory,
        [command, bust.as_os_str()].into_iter().chain(flags),
    )
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
    let [x, y] = ["relievo.DirectionX.V", "relievo.DirectionY.V"].map(|wanted| {
        let found = channels.iter().find(|(name, _)| name == wanted);
        found.expect("shape writes directions").1.clone()
    });
    Vector2Planes { x, y }
}

#[test]
fn the_program_writes_what_the_cpu_writes() {
    on_gpu(|_| {
        let desk = tempfile::tempdir().unwrap();
        let room = fixture("room.hdr");
        let room = room.display();
        for work in [
            "enhance",
            "shape",
            "hatch --tone enhance",
            &format!("relight --environment {room} --material blinn-phong"),
        ] {
            for backend in ["cpu", "gpu"] {
                let words = format!(
                    "{work} -o {backend}.exr --layers results --depth-of-output float --backend {backend}"
                );
                on_bust(desk.path(), &words).done();
            }
            let [expected, found] =
                ["cpu.exr", "gpu.exr"].map(|name| channels(&desk.path().join(name)));
            assert_eq!(found.len(), expected.len());
            for ((name, found), (_, expected)) in found.iter().zip(&expected) {
                if work.starts_with("hatch") {
                    let apart = Product::Strokes.difference(&[found], &[expected]);
                    let allowed = Product::Strokes.tolerance();
                    assert!(apart < allowed, "{work}: {name} is off by {apart:e}");
                // Directions jump where two curvatures are equal, or to their opposites, which are equivalent.
                } else if !name.starts_with("relievo.Direction") {
                    let apart = Product::Picture.difference(&[found], &[expected]);
                    assert!(apart < 2e-5, "{work}: {name} is off by {apart:e}");
                }
            }
            if work == "shape" {
                let [found, expected] = [&found, &expected].map(|channels| directions(channels));
                let apart = Product::Direction
                    .difference(&[&found.x, &found.y], &[&expected.x, &expected.y]);
                assert!(apart < Product::Direction.tolerance(), "off by {apart:e}");
            }
        }
    });
}

#[test]
fn what_has_no_kernels_runs_on_the_cpu_and_is_named_once_for_all_frames() {
    on_gpu(|_| {
        let desk = tempfile::tempdir().unwrap();
        for frame in 1..=2 {
            let name = format!("in.{frame}.exr");
            std::fs::copy(fixture("bust.exr"), desk.path().join(name)).unwrap();
        }
        let grain = "--light 30,40 --material ashikhmin-shirley --coat 10,200";
        for (work, named) in [
            (format!("relight {grain}"), "a grain along the curvature"),
            ("hatch --tone picture".into(), "tonal-art-map"),
        ] {
            let words = "in.#.exr --frames 1-2 -o out.#.png --progress none --backend gpu";
            let mut program = program(desk.path());
            let (command, flags) = work.split_once(' ').unwrap();
            program
                .arg(command)
                .args(words.split(' '))
                .args(flags.split(' '));
            let said = Ran::of(&mut program).ended(0);
            let told = said.lines().filter(|line| line.contains("the CPU"));
            assert_eq!(told.count(), 1, "{said}");
            assert!(said.contains(named), "{said}");
        }
    });
}

/// Runs the program on frames 1 to 3 of a sequence, on a machine without any adapter.
fn without_adapters(directory: &Path, words: &str) -> Ran {
    for frame in 1..=3 {
        std::fs::copy(
            fixture("bust.exr"),
            directory.join(format!("in.{frame}.exr")),
        )
        .unwrap();
    }
    let mut program = program(directory);
    // The loader of Vulkan finds no drivers, by its new name for their place and its old one.
    program
        .env("VK_DRIVER_FILES", "/dev/null")
        .env("VK_ICD_FILENAMES", "/dev/null");
    Ran::of(program.args(words.split_whitespace()))
}

#[cfg(target_os = "linux")]
#[test]
fn that_there_is_no_adapter_is_said_once_for_all_frames() {
    let desk = tempfile::tempdir().unwrap();
    for samples in ["", "--sample-frames none"] {
        let words = format!(
            "enhance in.#.exr --frames 1-3 -o out.#.png --backend auto --progress none {samples}"
        );
        let said = without_adapters(desk.path(), &words).ended(0);
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
    let line = without_adapters(desk.path(), words).refused(1);
    assert!(
        line.contains("no adapter") && line.contains("libvulkan1"),
        "{line}"
    );
    assert!(!desk.path().join("out.png").exists());
    assert_eq!(std::fs::read_dir(desk.path()).unwrap().count(), 3);
}
