//! The program with `--backend gpu`.

use super::on_gpu;
use relievo::backend::difference;
use relievo::frame::Plane;
use relievo::io::exr::{ChannelId, ExrFile, Limits};
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
        let room = fixtures().join("room.hdr");
        let room = room.display();
        for work in [
            "enhance",
            "shape",
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
                // Directions leap where two curvatures are alike.
                if !name.starts_with("direction_view") {
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
    let words = "relight --light 30,40 --material ashikhmin-shirley --coat 10,200 -o lit.png";
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
}
