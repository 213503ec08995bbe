//! Signals and sudden death: frames whole or not at all, and a rerun that ends as if nothing had happened.

use crate::common::program::{Desk, program};
use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

const FRAMES: i32 = 12;
const WORDS: &str = "enhance in.####.exr --frames 1-12 --white-level 1 --curvature-gain 3";

fn desk() -> Desk {
    let desk = Desk::new();
    for number in 1..=FRAMES {
        desk.write_frame(number, 192, 0.5);
    }
    desk
}

fn begun(desk: &Desk, words: &str) -> Child {
    let mut command = program(desk.path());
    let command = command.args(words.split_whitespace());
    command.stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until there are `count` outputs with this prefix, or a minute has passed.
fn wait_for(desk: &Desk, begin: &str, count: usize) {
    let started = Instant::now();
    while desk.names(begin).len() < count && started.elapsed() < Duration::from_secs(60) {
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
    desk.make(format!("{WORDS} -o whole.####.exr"));
    // At the first frame, in the middle, near the end.
    for (round, outputs) in [0, 5, 11].into_iter().enumerate() {
        let words = format!("{WORDS} -o r{round}.####.exr --skip-existing");
        let mut child = begun(&desk, &words);
        wait_for(&desk, &format!("r{round}"), outputs);
        send(&child, "-KILL");
        child.wait().unwrap();
        desk.make(&words);
        for number in 1..=FRAMES {
            let [one, two] = [format!("r{round}"), "whole".into()]
                .map(|n| desk.bytes(&format!("{n}.{number:04}.exr")));
            assert!(one == two, "round {round}, frame {number}");
        }
    }
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let desk = desk();
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    // A file of a run that ended a minute ago, unless it is young.
    let left = |name: &str, is_young: bool| {
        let name = name.replace("HOST", &host);
        let file = fs::File::create(desk.at(&name)).unwrap();
        if !is_young {
            let long_ago = std::time::SystemTime::now() - Duration::from_secs(60);
            file.set_modified(long_ago).unwrap();
        }
        (name, file)
    };
    let (old, _) = left(".relievo-HOST-abcdef.part", false);
    // Another run still writes this one.
    let (held, writer) = left(".relievo-HOST-held.part", false);
    writer.lock().unwrap();
    // One of a process that has ended is left, however young; one of a living process may get its lock yet.
    let mut ended_process = Command::new("true").spawn().unwrap();
    ended_process.wait().unwrap();
    let (young, _) = left(
        &format!(".relievo-HOST-{}-abcdef.part", ended_process.id()),
        true,
    );
    let (living, _) = left(
        &format!(".relievo-HOST-{}-abcdef.part", std::process::id()),
        true,
    );
    // And of another machine nothing is known.
    let (foreign, _) = left(".relievo--elsewhere-.part", false);
    desk.make("enhance in.0001.exr -o ./out.png");
    let are_there = [&old, &held, &young, &living, &foreign].map(|name| desk.has(name));
    assert_eq!(are_there, [false, true, false, true, true]);
    // Sequences sweep too, including the folders of their other outputs.
    fs::create_dir(desk.at("times")).unwrap();
    let times = format!("times/{young}");
    for name in [&young, &times] {
        desk.write(name, b"half a frame");
    }
    desk.make("enhance in.####.exr --frames 1-2 -o out.####.png --timings times/####.json");
    assert!(!desk.has(&young) && !desk.has(&times));
}

#[test]
fn a_signal_lets_the_frame_in_hand_be_finished() {
    let desk = desk();
    for (signal, code) in [("-TERM", 143), ("-INT", 130)] {
        let mut child = begun(&desk, &format!("{WORDS} -o out{code}.####.exr --threads 1"));
        wait_for(&desk, &format!("out{code}"), 1);
        send(&child, signal);
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let made = desk.names(&format!("out{code}"));
        assert!((1..FRAMES as usize).contains(&made.len()), "{made:?}");
        for name in made {
            assert!(relievo::io::output::is_whole(&desk.at(&name)), "{name}");
        }
        assert_eq!(desk.names(".relievo"), [""; 0]);
    }
}

/// Enlarging takes seconds, and a minute what comes after it.
#[test]
fn a_signal_ends_a_drawing_while_its_frame_is_enlarged() {
    let desk = Desk::new();
    desk.write_frame(1, 600, 0.5);
    let words = "hatch in.0001.exr --enlarge 8 --max-memory 64G -o out.png";
    let mut child = begun(&desk, words);
    std::thread::sleep(Duration::from_secs(2));
    let sent = Instant::now();
    send(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(sent.elapsed() < Duration::from_secs(5));
    assert_eq!(desk.names(""), ["in.0001.exr"]);
}
