//! Signals and sudden death: frames whole or not at all, and a rerun that ends as if nothing had happened.

use super::inputs::{bytes, write_frame};
use crate::common::program::{names, program, relievo};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const FRAMES: i32 = 12;
const WORDS: &str = "enhance in.####.exr --frames 1-12 --white-level 1 --curvature-gain 3";

fn desk() -> tempfile::TempDir {
    let desk = tempfile::tempdir().unwrap();
    for number in 1..=FRAMES {
        write_frame(desk.path(), number, 192, 0.5);
    }
    desk
}

fn begun(directory: &Path, words: &str) -> Child {
    program(directory)
        .args(words.split_whitespace())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until there are `count` outputs with this prefix, or a minute has passed.
fn wait_for(directory: &Path, begin: &str, count: usize) {
    let started = Instant::now();
    while names(directory, begin).len() < count && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

#[test]
fn a_killed_run_goes_on_to_the_same_bits() {
    let desk = desk();
    let here = desk.path();
    relievo(here, &format!("{WORDS} -o whole.####.exr")).ended(0);
    // At the first frame, in the middle, near the end.
    for (round, outputs) in [0, 5, 11].into_iter().enumerate() {
        let words = format!("{WORDS} -o r{round}.####.exr --skip-existing");
        let mut child = begun(here, &words);
        wait_for(here, &format!("r{round}"), outputs);
        send(&child, "-KILL");
        child.wait().unwrap();
        relievo(here, &words).ended(0);
        for number in 1..=FRAMES {
            let [one, two] = [format!("r{round}"), "whole".into()]
                .map(|n| bytes(here, &format!("{n}.{number:04}.exr")));
            assert!(one == two, "round {round}, frame {number}");
        }
    }
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let desk = desk();
    let here = desk.path();
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    let left = here.join(format!(".relievo-{host}-abcdef.part"));
    std::fs::write(&left, b"half a frame").unwrap();
    let long_ago = std::time::SystemTime::now() - Duration::from_secs(60);
    let file = std::fs::File::options().write(true).open(&left).unwrap();
    file.set_modified(long_ago).unwrap();
    // Another run still writes this one.
    let held = here.join(format!(".relievo-{host}-held.part"));
    let writer = std::fs::File::create(&held).unwrap();
    writer.set_modified(long_ago).unwrap();
    writer.lock().unwrap();
    // One of a process that has ended is left, however young; one of a living process may get its lock yet.
    let mut ended_process = std::process::Command::new("true").spawn().unwrap();
    ended_process.wait().unwrap();
    let young = here.join(format!(
        ".relievo-{host}-{}-abcdef.part",
        ended_process.id()
    ));
    std::fs::write(&young, b"half a frame").unwrap();
    let living = here.join(format!(
        ".relievo-{host}-{}-abcdef.part",
        std::process::id()
    ));
    std::fs::write(&living, b"half a frame").unwrap();
    // And of another machine nothing is known.
    let foreign = here.join(".relievo--elsewhere-.part");
    let file = std::fs::File::create(&foreign).unwrap();
    file.set_modified(long_ago).unwrap();
    relievo(here, "enhance in.0001.exr -o ./out.png").ended(0);
    assert!(!left.exists() && held.exists() && foreign.exists());
    assert!(!young.exists() && living.exists());
    // Sequences sweep too, including the folders of their other outputs.
    std::fs::create_dir(here.join("times")).unwrap();
    let times = here.join("times").join(young.file_name().unwrap());
    for path in [&young, &times] {
        std::fs::write(path, b"half a frame").unwrap();
    }
    let words = "enhance in.####.exr --frames 1-2 -o out.####.png --timings times/####.json";
    relievo(here, words).ended(0);
    assert!(!young.exists() && !times.exists());
}

#[test]
fn a_signal_lets_the_frame_in_hand_be_finished() {
    let desk = desk();
    let here = desk.path();
    for (signal, code) in [("-TERM", 143), ("-INT", 130)] {
        let mut child = begun(here, &format!("{WORDS} -o out{code}.####.exr --threads 1"));
        wait_for(here, &format!("out{code}"), 1);
        send(&child, signal);
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let made = names(here, &format!("out{code}"));
        assert!((1..FRAMES as usize).contains(&made.len()), "{made:?}");
        for name in made {
            let whole = relievo::io::output::is_whole(&here.join(&name));
            assert!(whole, "{name}");
        }
        assert_eq!(names(here, ".relievo"), [""; 0]);
    }
}

/// Enlarging takes seconds, and a minute what comes after it.
#[test]
fn a_signal_ends_a_drawing_while_its_frame_is_enlarged() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_frame(here, 1, 600, 0.5);
    let words = "hatch in.0001.exr --enlarge 8 --max-memory 64G -o out.png";
    let mut child = begun(here, words);
    std::thread::sleep(Duration::from_secs(2));
    let sent = Instant::now();
    send(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(sent.elapsed() < Duration::from_secs(5));
    assert_eq!(names(here, ""), ["in.0001.exr"]);
}
