//! As many threads as the system allows.

use super::inputs::{bytes, desk};
use crate::common::program::{Ran, relievo};
use std::process::Command;

#[test]
fn more_threads_than_any_machine_has_are_refused() {
    let desk = desk(1..=1);
    let said = relievo(desk.path(), "enhance in.0001.exr -o o.png --threads 65535").ended(2);
    assert!(said.contains("65535 is not in 1..=512"), "{said}");
}

/// When memory for stacks runs out, fewer threads do the work, and make the same picture.
#[cfg(target_os = "linux")]
#[test]
fn where_threads_are_scarce_fewer_do_the_work() {
    let desk = desk(1..=2);
    let here = desk.path();
    relievo(here, "enhance in.0001.exr -o all.png").ended(0);
    let run = |words: &str| {
        let program = env!("CARGO_BIN_EXE_relievo");
        // 512 stacks of 8 MiB need 4 GiB; a quarter of the limit holds 74, and of the halves of 512 the next is 64.
        let script = format!("ulimit -v 2500000; exec {program} {words}");
        Ran::of(Command::new("sh").args(["-c", &script]).current_dir(here)).ended(0)
    };
    let said = run("enhance in.0001.exr -o few.png --threads 512");
    assert!(
        said.contains("note: the system does not allow 512 threads; working with 64"),
        "{said}"
    );
    assert!(bytes(here, "few.png") == bytes(here, "all.png"));
    run("enhance in.####.exr --frames 1-2 -o few.####.png --threads 512");
    assert!(here.join("few.0002.png").exists());
}
