//! Frame after frame: one choice for all, and the handling of frames that fail, are missing or already exist.

use super::inputs::grey;
use crate::common::program::{Desk, tells};
use relievo::frame::Plane;
use serde_json::Value;
use std::fs;

#[test]
fn all_frames_get_the_same_values_and_each_the_bits_of_a_run_of_its_own() {
    let desk = Desk::of_frames(1..=6);
    let enhance = "enhance in.####.exr --frames 1-6";
    let said = desk
        .make(format!("{enhance} -o out.####.exr --threads 3"))
        .stderr;
    // White levels rise with the frames, 0.6 to 1.1 at most; of five samples, frames 1, 2, 3, 4 and 6, the median is
    // the third's: its brightest normals face the viewer, 0.8 x 1.
    let line = said.lines().find(|line| line.starts_with("for all frames"));
    let line = line.unwrap_or_else(|| panic!("{said}"));
    let levels = ["white level 0.7", "white level 0.8"];
    assert!(levels.iter().any(|level| line.contains(level)), "{line}");
    tells(&said, "6 of 6 frames done");

    // One thread, in chunks, by the recipe: the same bits.
    desk.make(format!("{enhance} --save-recipe look.toml"));
    let settings = "white-level = 0. ... normal-space = \"view\" ... sample-frames = \"none\"";
    tells(&desk.text("look.toml"), settings);
    for chunk in ["1-2", "3,4", "5-6"] {
        desk.make(format!(
            "run look.toml in.####.exr --frames {chunk} -o two.####.exr --threads 1"
        ));
    }
    desk.make("run look.toml in.0004.exr -o alone.exr");
    for number in 1..=6 {
        let [one, two] = ["out", "two"].map(|name| desk.bytes(&format!("{name}.{number:04}.exr")));
        assert!(one == two, "frame {number}");
    }
    assert!(desk.bytes("alone.exr") == desk.bytes("out.0004.exr"));
}

#[test]
fn every_command_takes_sequences() {
    let desk = Desk::of_frames(1..=3);
    for (command, flags) in [
        ("shape", ""),
        ("relight", "--light 135,40"),
        ("hatch", "--contours off"),
        ("hatch", "--motion none"),
    ] {
        let words = format!("{command} {flags} in.####.exr --frames 1-3 -o {command}.%04d.png");
        desk.make(&words);
        assert_eq!(desk.names(command).len(), 3, "{words}");
    }
}

/// The kind of depth is chosen for all frames, and --height excludes --depth-kind.
#[test]
fn heights_are_read_in_sequences() {
    let desk = Desk::new();
    for name in ["h.0001.png", "h.0002.png"] {
        let step = Plane::from_fn(24, 24, |x, y| ((x + y) / 8) as f32 / 6.0);
        desk.write_codes(name, grey(step), 16);
    }
    desk.make("normals h.####.png --height h.####.png --frames 1-2 -o n.####.png");
    assert_eq!(desk.names("n.").len(), 2);
}

#[test]
fn whole_outputs_are_skipped_and_broken_ones_made_again() {
    let desk = Desk::of_frames(1..=4);
    let words = "enhance in.####.exr --frames 1-4 -o out.####.exr --white-level 1";
    desk.make(words);
    let content = || [1, 2, 3, 4].map(|n| desk.bytes(&format!("out.{n:04}.exr")));
    let whole = content();
    fs::remove_file(desk.at("out.0002.exr")).unwrap();
    // A copy that broke off, and an empty file.
    desk.write("out.0003.exr", &whole[2][..whole[2].len() - 1]);
    desk.write("out.0004.exr", b"");
    let said = desk.make(format!("{words} --skip-existing")).stderr;
    tells(&said, "3 of 4 frames done ... 1 there already");
    assert!(content() == whole);
}

#[test]
fn strokes_that_follow_on_are_the_same_when_frames_are_skipped() {
    let desk = Desk::of_frames(1..=4);
    let words = "hatch in.####.exr --frames 1-4 -o out.####.png --tone picture";
    desk.make(words);
    let third = desk.shown("out.0003.png");
    fs::remove_file(desk.at("out.0003.png")).unwrap();
    desk.make(format!("{words} --skip-existing"));
    assert!(desk.shown("out.0003.png") == third);
}

#[test]
fn a_frame_that_fails_stops_the_run_or_is_left_behind() {
    let desk = Desk::of_frames(1..=5);
    desk.write("in.0002.exr", b"no picture");
    fs::remove_file(desk.at("in.0004.exr")).unwrap();
    let words = "enhance in.####.exr --frames 1-5 -o out.####.png --threads 1 --progress none";
    tells(&desk.run(words).ended(1), "error: in.0002.exr");
    assert_eq!(desk.names("out"), ["out.0001.png"]);

    let said = desk.run(format!("{words} --keep-going")).ended(3);
    assert_eq!(said.matches("error:").count(), 2, "{said}");
    tells(
        &said,
        "3 of 5 frames done ... 2 failed: 2,4 ... in.0004.exr: cannot read",
    );

    let said = desk
        .run(format!("{words} --keep-going --missing-frame skip"))
        .ended(3);
    tells(&said, "1 missing ... 1 failed: 2");
    assert_eq!(desk.names(".relievo"), [""; 0]);
    // A sequence without any frame fails plainly.
    desk.run("enhance in.####.exr --frames 2 -o out.####.png --keep-going")
        .ended(1);
}

#[test]
fn frames_have_any_number() {
    let desk = Desk::new();
    for number in [-2, -1, 0] {
        desk.write_frame(number, 32, 0.5);
    }
    desk.make("enhance in.%04d.exr --frames -2-0:2 -o out.%04d.png");
    assert_eq!(desk.names("out"), ["out.-002.png", "out.0000.png"]);
}

#[test]
fn progress_is_lines_of_text_or_of_json() {
    let desk = Desk::of_frames(1..=3);
    fs::remove_file(desk.at("in.0003.exr")).unwrap();
    let words = "shape in.####.exr --frames 1-3 -o out.####.png --keep-going --threads 1";
    let said = desk.run(format!("{words} --progress plain")).ended(3);
    tells(&said, "[1/3] out.0001.png: done, ");

    let said = desk
        .run(format!("{words} --progress json --skip-existing"))
        .ended(3);
    let events = said
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    let events: Vec<Value> = events.collect();
    assert_eq!(events[0]["event"], "begin");
    assert_eq!(events[0]["total"], 3);
    let frames: Vec<_> = events.iter().filter(|e| e["event"] == "frame").collect();
    assert_eq!(frames[0]["status"], "skipped");
    assert_eq!(frames[2]["status"], "failed");
    assert_eq!(frames[2]["frame"], 3);
    assert_eq!(frames[2]["finished"], 3);
    tells(frames[2]["message"].as_str().unwrap(), "in.0003.exr");
    let end = &events[events.len() - 1];
    assert_eq!([&end["skipped"], &end["failed"]], [2, 1]);
}

#[test]
fn a_camera_that_stands_still_is_recovered_once() {
    let desk = Desk::new();
    for number in 1..=3 {
        desk.copy("fixtures/bust.exr", &format!("in.{number}.exr"));
    }
    desk.make("enhance in.#.exr --frames 1-3 -o out.#.exr --save-recipe look.toml");
    tells(&desk.text("look.toml"), "still-camera = ");
    // Determined anew it is the same, like the frames.
    desk.make("enhance in.2.exr -o alone.png");
    desk.make("run look.toml in.2.exr -o by_recipe.png");
    assert!(desk.shown("alone.png") == desk.shown("by_recipe.png"));
}
