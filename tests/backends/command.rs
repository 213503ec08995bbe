//! The program with `--backend gpu`.

use super::on_gpu;
use relievo::backend::{Product, difference};
use relievo::frame::Plane;
use relievo::io::exr::{ChannelId, ExrFile, Limits};
use std::path::Path;
use std::process::{Command, Output};

fn relievo(directory: &Path, words: &str) -> Output {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bust.exr");
    let mut words = words.split_whitespace();
    Command::new(env!("CARGO_BIN_EXE_relievo"))
        .arg(words.next().unwrap())
        .arg(fixture)
        .args(words)
        .current_dir(directory)
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

#[test]
fn the_program_writes_what_the_cpu_writes() {
    on_gpu(|_| {
        let desk = tempfile::tempdir().unwrap();
        for work in ["enhance", "shape", "hatch"] {
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
                    let apart = Product::Strokes.apart(found, expected);
                    let allowed = Product::Strokes.tolerance();
                    assert!(apart < allowed, "{work}: {name} is off by {apart:e}");
                // Directions leap where two curvatures are alike.
                } else if !name.starts_with("direction_view") {
                    let apart = difference(found, expected);
                    assert!(apart < 2e-5, "{work}: {name} is off by {apart:e}");
                }
            }
        }
    });
}

#[test]
fn what_has_no_kernels_is_refused_by_name_and_done_otherwise() {
    let desk = tempfile::tempdir().unwrap();
    for words in [
        "relight --light 30,40 -o lit.png",
        "hatch --light 30,40 -o lit.png",
        "hatch --style lines -o lit.png",
    ] {
        on_gpu(|_| {
            let refused = relievo(desk.path(), &format!("{words} --backend gpu"));
            let line = String::from_utf8(refused.stderr).unwrap();
            assert_eq!(refused.status.code(), Some(2), "{line}");
            assert!(
                line.contains("--backend") && line.lines().count() == 1,
                "{line}"
            );
        });
        let done = relievo(desk.path(), &format!("{words} --backend auto"));
        assert!(done.status.success() && desk.path().join("lit.png").exists());
        std::fs::remove_file(desk.path().join("lit.png")).unwrap();
    }
}
