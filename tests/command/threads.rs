//! As many threads as the system allows.

use crate::common::program::{Desk, relievo_within};

/// When memory for stacks runs out, fewer threads do the work, and make the same picture.
#[cfg(target_os = "linux")]
#[test]
fn where_threads_are_scarce_fewer_do_the_work() {
    let desk = Desk::of_frames(1..=2);
    desk.make("enhance in.0001.exr -o all.png");
    // 512 stacks of 8 MiB need 4 GiB; a quarter of the limit holds 74, and of the halves of 512 the next is 64.
    let run = |words: &str| relievo_within("ulimit -v 2500000", desk.path(), words).ended(0);
    let said = run("enhance in.0001.exr -o few.png --threads 512");
    let note = "note: the system does not allow 512 threads; working with 64";
    assert!(said.contains(note), "{said}");
    assert!(desk.shown("few.png") == desk.shown("all.png"));
    run("enhance in.####.exr --frames 1-2 -o few.####.png --threads 512");
    assert!(desk.has("few.0002.png"));
}
