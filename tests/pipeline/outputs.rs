//! Outputs that cannot be written leave one line and no debris, and layers go where they are asked to.

use super::{bytes, desk, ended, names, relievo};
use relievo::io::exr::ExrFile;
use std::fs;

#[test]
fn layers_go_beside_the_input_into_it_or_alone() {
    let desk = desk(1..=1);
    let here = desk.path();
    for (how, parts, channels) in [
        ("keep", 2, &["relievo.B", "relievo.G", "relievo.R"][..]),
        ("channels", 1, &["relievo.B", "relievo.G", "relievo.R"]),
        ("results", 1, &["B", "G", "R"]),
    ] {
        let words = format!("enhance in.0001.exr -o {how}.exr --layers {how} --compression zips");
        ended(relievo(here, &words), 0);
        let file = ExrFile::open(&here.join(format!("{how}.exr")), &Default::default()).unwrap();
        assert_eq!(file.parts.len(), parts, "{how}");
        let last = &file.parts[parts - 1];
        let names: Vec<_> = last.channels.iter().map(|c| c.name.as_str()).collect();
        assert!(
            channels.iter().all(|name| names.contains(name)),
            "{how}: {names:?}"
        );
        // With channels the compression of the input is kept.
        let expected = if how == "channels" { "zip" } else { "zips" };
        assert_eq!(last.compression, expected, "{how}");
        let own = names.contains(&"N.X");
        assert_eq!(own, how == "channels", "{how}");
    }
}

/// What a run cannot write, and what it says.
#[cfg(unix)]
#[test]
fn what_cannot_be_written_is_one_line_and_no_debris() {
    use std::os::unix::fs::PermissionsExt;
    let desk = desk(1..=2);
    let here = desk.path();
    let said = ended(relievo(here, "enhance in.0001.exr -o none/out.exr"), 1);
    assert!(said.contains("there is no directory none"), "{said}");
    fs::create_dir(here.join("out.png")).unwrap();
    let said = ended(relievo(here, "enhance in.0001.exr -o out.png"), 1);
    assert!(said.contains("out.png: cannot write"), "{said}");
    // A full disk: this one never has room.
    if std::path::Path::new("/dev/full").exists() {
        let said = ended(relievo(here, "enhance in.0001.exr -o /dev/full"), 2);
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    // A directory that nobody may write to; the superuser may.
    let locked = here.join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    let output = relievo(
        here,
        "enhance in.####.exr --frames 1-2 -o locked/out.####.exr --keep-going",
    );
    if output.status.success() {
        eprintln!("skipped: this user may write anywhere");
    } else {
        let said = ended(output, 1);
        assert_eq!(said.matches("cannot write").count(), 2, "{said}");
    }
    assert_eq!(names(here, ".relievo"), [""; 0]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_leaves_the_old_file() {
    let desk = desk(1..=1);
    let here = desk.path();
    ended(relievo(here, "enhance in.0001.exr -o out.exr"), 0);
    let before = bytes(here, "out.exr");
    // No file may grow beyond 8 KiB: the write fails in the middle.
    let words = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} enhance in.0001.exr -o out.exr --scaling 0.5 --backend cpu",
        env!("CARGO_BIN_EXE_relievo")
    );
    let shell = std::process::Command::new("bash")
        .args(["-c", &words])
        .current_dir(here)
        .output()
        .unwrap();
    let said = ended(shell, 1);
    assert!(said.contains("out.exr: cannot write"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(bytes(here, "out.exr") == before);
    assert_eq!(names(here, ".relievo"), [""; 0]);
}
