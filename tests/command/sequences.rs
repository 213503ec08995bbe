//! Frame after frame: one choice for all, and the handling of frames that fail, are missing or already exist.

use super::inputs::{bytes, desk, write_frame, write_planes};
use crate::common::program::{names, relievo};
use relievo::frame::Plane;
use relievo::io::picture::ViewTransform;
use std::fs;

#[test]
fn all_frames_get_the_same_values_and_each_the_bits_of_a_run_of_its_own() {
    let desk = desk(1..=6);
    let here = desk.path();
    let said = relievo(
        here,
        "enhance in.####.exr --frames 1-6 -o out.####.exr --threads 3",
    )
    .ended(0);
    // White levels rise with the frames, 0.6 to 1.1 at most; of five samples, frames 1, 2, 3, 4 and 6, the median is
    // the third's: its brightest normals face the viewer, 0.8 x 1.
    let line = said.lines().find(|line| line.starts_with("for all frames"));
    let line = line.unwrap_or_else(|| panic!("{said}"));
    assert!(
        line.contains("white level 0.7") || line.contains("white level 0.8"),
        "{line}"
    );
    assert!(said.contains("6 of 6 frames done"), "{said}");

    // One thread, in chunks, by the recipe: the same bits.
    relievo(
        here,
        "enhance in.####.exr --frames 1-6 --save-recipe look.toml",
    )
    .ended(0);
    let recipe = fs::read_to_string(here.join("look.toml")).unwrap();
    for setting in [
        "white-level = 0.",
        "normal-space = \"view\"",
        "sample-frames = \"none\"",
    ] {
        assert!(recipe.contains(setting), "{setting} in\n{recipe}");
    }
    for chunk in ["1-2", "3,4", "5-6"] {
        let words =
            format!("run look.toml in.####.exr --frames {chunk} -o two.####.exr --threads 1");
        relievo(here, &words).ended(0);
    }
    relievo(here, "run look.toml in.0004.exr -o alone.exr").ended(0);
    for number in 1..=6 {
        let [one, two] = ["out", "two"].map(|name| bytes(here, &format!("{name}.{number:04}.exr")));
        assert!(one == two, "frame {number}");
    }
    assert!(bytes(here, "alone.exr") == bytes(here, "out.0004.exr"));
}

#[test]
fn every_command_takes_sequences() {
    let desk = desk(1..=3);
    for (command, flags) in [
        ("shape", ""),
        ("relight", "--light 135,40"),
        ("hatch", "--contours off"),
        ("hatch", "--motion none"),
    ] {
        let words = format!("{command} {flags} in.####.exr --frames 1-3 -o {command}.%04d.png");
        relievo(desk.path(), &words).ended(0);
        assert_eq!(names(desk.path(), command).len(), 3, "{words}");
    }
}

/// The kind of depth is chosen for all frames, and --height excludes --depth-kind.
#[test]
fn heights_are_read_in_sequences() {
    let desk = tempfile::tempdir().unwrap();
    let step = Plane::from_fn(24, 24, |x, y| ((x + y) / 8) as f32 / 6.0);
    for name in ["h.0001.png", "h.0002.png"] {
        let planes = [0; 3].map(|_| step.clone());
        write_planes(
            &desk.path().join(name),
            planes,
            None,
            16,
            ViewTransform::None,
        );
    }
    let words = "normals h.####.png --height h.####.png --frames 1-2 -o n.####.png";
    relievo(desk.path(), words).ended(0);
    assert_eq!(names(desk.path(), "n.").len(), 2);
}

#[test]
fn whole_outputs_are_skipped_and_broken_ones_made_again() {
    let desk = desk(1..=4);
    let here = desk.path();
    let words = "enhance in.####.exr --frames 1-4 -o out.####.exr --white-level 1";
    relievo(here, words).ended(0);
    let whole: Vec<_> = (1..=4)
        .map(|n| bytes(here, &format!("out.{n:04}.exr")))
        .collect();
    fs::remove_file(here.join("out.0002.exr")).unwrap();
    // A copy that broke off, and an empty file.
    fs::write(here.join("out.0003.exr"), &whole[2][..whole[2].len() - 1]).unwrap();
    fs::write(here.join("out.0004.exr"), b"").unwrap();
    let said = relievo(here, &format!("{words} --skip-existing")).ended(0);
    assert!(said.contains("3 of 4 frames done"), "{said}");
    assert!(said.contains("1 there already"), "{said}");
    for number in 1..=4 {
        assert!(
            bytes(here, &format!("out.{number:04}.exr")) == whole[number - 1],
            "{number}"
        );
    }
}

#[test]
fn strokes_that_follow_on_are_the_same_when_frames_are_skipped() {
    let desk = desk(1..=4);
    let here = desk.path();
    let words = "hatch in.####.exr --frames 1-4 -o out.####.png --tone picture";
    relievo(here, words).ended(0);
    let third = bytes(here, "out.0003.png");
    fs::remove_file(here.join("out.0003.png")).unwrap();
    relievo(here, &format!("{words} --skip-existing")).ended(0);
    assert!(bytes(here, "out.0003.png") == third);
}

#[test]
fn a_frame_that_fails_stops_the_run_or_is_left_behind() {
    let desk = desk(1..=5);
    let here = desk.path();
    fs::write(here.join("in.0002.exr"), b"no picture").unwrap();
    fs::remove_file(here.join("in.0004.exr")).unwrap();
    let words = "enhance in.####.exr --frames 1-5 -o out.####.png --threads 1 --progress none";
    let said = relievo(here, words).ended(1);
    assert!(said.contains("error: in.0002.exr"), "{said}");
    assert_eq!(names(here, "out"), ["out.0001.png"]);

    let said = relievo(here, &format!("{words} --keep-going")).ended(3);
    assert!(said.contains("3 of 5 frames done"), "{said}");
    assert!(said.contains("2 failed: 2,4"), "{said}");
    assert_eq!(said.matches("error:").count(), 2, "{said}");
    assert!(said.contains("in.0004.exr: cannot read"), "{said}");

    let said = relievo(here, &format!("{words} --keep-going --missing-frame skip")).ended(3);
    assert!(said.contains("1 missing"), "{said}");
    assert!(said.contains("1 failed: 2"), "{said}");
    assert_eq!(names(here, ".relievo"), [""; 0]);
    // A sequence without any frame fails plainly.
    relievo(
        here,
        "enhance in.####.exr --frames 2 -o out.####.png --keep-going",
    )
    .ended(1);
}

#[test]
fn frames_have_any_number() {
    let desk = tempfile::tempdir().unwrap();
    for number in [-2, -1, 0] {
        write_frame(desk.path(), number, 32, 0.5);
    }
    relievo(
        desk.path(),
        "enhance in.%04d.exr --frames -2-0:2 -o out.%04d.png",
    )
    .ended(0);
    assert_eq!(names(desk.path(), "out"), ["out.-002.png", "out.0000.png"]);
}

#[test]
fn progress_is_lines_of_text_or_of_json() {
    let desk = desk(1..=3);
    let here = desk.path();
    fs::remove_file(here.join("in.0003.exr")).unwrap();
    let words = "shape in.####.exr --frames 1-3 -o out.####.png --keep-going --threads 1";
    let said = relievo(here, &format!("{words} --progress plain")).ended(3);
    assert!(said.contains("[1/3] out.0001.png: done, "), "{said}");

    let said = relievo(here, &format!("{words} --progress json --skip-existing")).ended(3);
    let events: Vec<serde_json::Value> = said
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect();
    assert_eq!(events[0]["event"], "begin");
    assert_eq!(events[0]["total"], 3);
    let frames: Vec<_> = events.iter().filter(|e| e["event"] == "frame").collect();
    assert_eq!(frames[0]["status"], "skipped");
    assert_eq!(frames[2]["status"], "failed");
    assert_eq!(frames[2]["frame"], 3);
    assert_eq!(frames[2]["finished"], 3);
    assert!(
        frames[2]["message"]
            .as_str()
            .unwrap()
            .contains("in.0003.exr")
    );
    let end = &events[events.len() - 1];
    assert_eq!((&end["skipped"], &end["failed"]), (&2.into(), &1.into()));
}

#[test]
fn inputs_of_a_sequence_are_not_written_over() {
    let desk = desk(1..=2);
    let before = bytes(desk.path(), "in.0001.exr");
    let said = relievo(
        desk.path(),
        "enhance in.####.exr --frames 1-2 -o in.%04d.exr",
    )
    .ended(2);
    assert!(said.contains("is the input"), "{said}");
    assert!(bytes(desk.path(), "in.0001.exr") == before);
}

#[test]
fn a_camera_that_stands_still_is_recovered_once() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let bust = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/bust.exr");
    for number in 1..=3 {
        fs::copy(bust, here.join(format!("in.{number}.exr"))).unwrap();
    }
    let words = "enhance in.#.exr --frames 1-3 -o out.#.exr --save-recipe look.toml";
    relievo(here, words).ended(0);
    let recipe = fs::read_to_string(here.join("look.toml")).unwrap();
    assert!(recipe.contains("still-camera = "), "{recipe}");
    // Determined anew it is the same, like the frames.
    relievo(here, "enhance in.2.exr -o alone.png").ended(0);
    relievo(here, "run look.toml in.2.exr -o by_recipe.png").ended(0);
    assert!(bytes(here, "alone.png") == bytes(here, "by_recipe.png"));
}
