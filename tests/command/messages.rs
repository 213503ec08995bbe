//! What the program says: of a file, of a run, and of itself.

use crate::common::program::{Desk, Ran, program};
use serde_json::Value;
use std::fs;

#[test]
fn inspect_tells_roles_camera_and_space() {
    let desk = Desk::new();
    for (name, projection) in [("bust.exr", "perspective"), ("gears.exr", "orthographic")] {
        let ran = desk.make(format!("inspect fixtures/{name}"));
        assert_eq!(ran.stderr, "");
        for (start, found) in [
            ("color ", "ViewLayer.Combined.R"),
            ("normal ", "ViewLayer.Normal.X"),
            ("depth ", "ViewLayer.Depth.Z"),
            ("position ", "ViewLayer.Position.X"),
            ("camera ", projection),
            ("normal space", "world"),
        ] {
            let mut lines = ran.stdout.lines();
            let line = lines.find(|line| line.trim_start().starts_with(start));
            let line = line.unwrap_or_else(|| panic!("no {start} in {}", ran.stdout));
            assert!(line.contains(found), "{line}");
        }
    }
}

#[test]
fn inspect_json_is_an_array_of_files() {
    let ran = Desk::new().make("inspect --json fixtures/bust.exr fixtures/tablet.color.jpg");
    let json: Value = serde_json::from_str(&ran.stdout).unwrap();
    let files = json.as_array().unwrap();
    assert_eq!(files.len(), 2);

    let roles = files[0]["roles"].as_array().unwrap().iter();
    let found = roles.map(|r| ["role", "layer"].map(|key| r[key].as_str().unwrap()));
    let expected = [
        ["color", "ViewLayer.Combined"],
        ["normal", "ViewLayer.Normal"],
        ["depth", "ViewLayer.Depth"],
        ["position", "ViewLayer.Position"],
    ];
    assert_eq!(found.collect::<Vec<_>>(), expected);
    let conclusion = |subject: &str| {
        let findings = files[0]["findings"].as_array().unwrap();
        let finding = findings.iter().find(|f| f["subject"] == subject);
        finding.unwrap()["conclusion"].as_str().unwrap()
    };
    assert_eq!(conclusion("normal space"), "world");
    assert!(conclusion("camera").starts_with("perspective, focal 880.0 px"));
    assert_eq!(files[0]["problem"], Value::Null);

    // A photo alone has no normals: a problem that is reported, not an error.
    assert!(files[1]["problem"].as_str().unwrap().contains("--normal"));
    assert_eq!(files[1]["display_window"]["x1"], 256);
}

/// A stage runs, is left out (`-`) or has nothing to do, and there is a reason for it. What is left out is shown with -v.
#[test]
fn explain_tells_why_each_stage_runs_or_not() {
    let desk = Desk::new();
    let usual = desk
        .make("enhance fixtures/gears.exr -o a.png --explain")
        .stdout;
    assert!(!usual.lines().any(|line| line.starts_with('-')), "{usual}");
    let idle = desk
        .make("enhance fixtures/gears.exr -o a.png --scaling 0 --explain -v")
        .stdout;
    let ran = idle.lines().filter_map(|line| line.strip_prefix("ran   "));
    let ran = ran.filter_map(|line| line.split(' ').next());
    assert_eq!(ran.collect::<Vec<_>>(), ["read", "write"], "{idle}");
    for line in usual
        .lines()
        .chain(idle.lines())
        .filter(|line| line.starts_with(['-', 'r']))
    {
        assert!(line.split_whitespace().count() > 2, "no reason: {line}");
    }
    let rows = "
        enhance fixtures/gears.exr -o a.png => 0: ran   diffusion  ... depth-silhouettes: gaps
        enhance fixtures/gears.exr -o a.png -v => 0: -     directions  ... -     normal-rays
        enhance fixtures/gears.exr -o a.png --iterations 0 -v => 0: -     diffusion
        shape fixtures/gears.exr -o a.exr -v => 0: ran   curvature  ... directions: asked for ... ran   normal-rays  ... -     radiance-scaling
        // 240 lines: ten steps of 0.2 have a sigma of 2, and 4 where two pixels count as one.
        shape fixtures/gears.exr -o a.png --reference-height 120 => 0: scale 4.00 px (2.00 px at a height of 120) ... times 2
        // Two stops darker nothing is near white, two stops brighter some is. Pixels in focus show one surface each.
        enhance fixtures/gears.exr -o a.png --exposure -2 => 0: idle  highlights
        enhance fixtures/gears.exr -o a.png --exposure 2 => 0: !idle  highlights
        enhance fixtures/gears.exr -o a.png => 0: idle  fade
        enhance fixtures/blur.exr -o a.png => 0: !idle  fade
        enhance fixtures/tablet.color.jpg -o a.png --normal fixtures/tablet.normal.png -v => 0: -     depth-silhouettes  ... border-silhouettes:
    ";
    desk.check("{} --explain", rows);
}

#[test]
fn timings_hold_every_stage_that_ran() {
    let desk = Desk::new();
    let json = |flags: &str| {
        desk.make(format!(
            "enhance fixtures/gears.exr -o a.png {flags} --timings t.json --threads 3"
        ));
        desk.json("t.json")
    };
    let stages = |json: &Value| -> Vec<String> {
        let stages = json["stages"].as_array().unwrap();
        assert!(
            stages
                .iter()
                .all(|stage| stage["seconds"].as_f64().unwrap() >= 0.0)
        );
        let name = |s: &Value| s["stage"].as_str().unwrap().to_string();
        stages.iter().map(name).collect()
    };
    let usual = json("");
    let size = [&usual["width"], &usual["height"], &usual["threads"]];
    assert_eq!(size, [320, 240, 3]);
    let covered = usual["covered_pixels"].as_u64().unwrap();
    assert!(covered > 0 && covered < 320 * 240);
    assert!(usual["total_seconds"].as_f64().unwrap() > 0.0);
    let usual = stages(&usual);
    assert_eq!(usual.first().unwrap(), "read");
    assert_eq!(usual.last().unwrap(), "write");
    // They are read where the file holds them.
    assert!(!usual.contains(&"normals".into()), "{usual:?}");
    let of_depth = stages(&json("--height ViewLayer.Depth"));
    assert_eq!(of_depth[..2], ["read", "normals"]);
    assert!(usual.contains(&"diffusion".into()), "{usual:?}");
    let fine = stages(&json("--iterations 0"));
    assert!(!fine.contains(&"diffusion".into()), "{fine:?}");
    assert_eq!(stages(&json("--scaling 0")), ["read", "write"]);
}

#[test]
fn quiet_says_nothing_and_verbose_says_what_was_concluded() {
    let desk = Desk::new();
    // A magnitude that is warned about.
    let enhance = "enhance fixtures/gears.exr -o a.png --scaling 9";
    let quiet = desk.make(format!("{enhance} -q"));
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
    let usual = desk.make(enhance);
    assert_eq!(usual.stdout, "");
    assert!(usual.stderr.contains("warning: --scaling 9"));
    assert!(usual.stderr.contains("curvature gain"));
    // Errors are printed even so.
    let rows = "
        fixtures/gears.exr -v => 0: orthographic
        none.exr -q => 1: none.exr
    ";
    desk.check("enhance {} -o b.png", rows);
}

#[test]
fn help_and_version_are_results() {
    let desk = Desk::new();
    for words in [
        "--help",
        "enhance --help",
        "enhance --help-all",
        "--help-all",
        "--version",
    ] {
        let ran = desk.make(words);
        assert_eq!(ran.stderr, "", "{words}");
        assert!(ran.stdout.contains("relievo"), "{words}");
    }
    // Help is what fits a screen or two; all of it is longer.
    for command in ["shape", "enhance", "relight", "hatch", "map"] {
        let [short, all] =
            ["-h", "--help-all"].map(|flag| desk.make(format!("{command} {flag}")).stdout);
        let has = |help: &str, flag: &str| help.contains(&format!("--{flag} "));
        assert!(
            has(&short, "iterations") && !has(&short, "solver"),
            "{short}"
        );
        assert!(has(&all, "iterations") && has(&all, "solver"), "{all}");
        let lines = short.lines().count();
        assert!(lines <= 100, "{command}: {lines}");
    }
    let bare = desk.run("");
    assert_eq!((bare.code, bare.stdout.as_str()), (Some(2), ""));
    assert!(bare.stderr.contains("Usage"));
}

/// Results and messages of a full disk: neither help nor a list is lost without a word, but a picture is made without one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_told_and_one_behind_stderr_is_survived() {
    let desk = Desk::of_frames(1..=1);
    let full = || fs::File::create("/dev/full").unwrap();
    for words in [
        "--help",
        "--version",
        "shape --help",
        "shape --help-all",
        "help hatch",
        "completions bash",
        "man",
        "schema",
        "inspect in.0001.exr",
        "inspect --json in.0001.exr",
    ] {
        let mut command = program(desk.path());
        let ran = Ran::of(command.args(words.split(' ')).stdout(full()));
        let said = ran.refused(1);
        assert!(
            said.starts_with("error: stdout: cannot write: "),
            "{words}: {said}"
        );
    }
    for (input, code) in [("in.0001.exr", 0), ("none.exr", 1)] {
        let output = format!("{input}.png");
        let mut enhance = program(desk.path());
        let enhance = enhance
            .args(["enhance", input, "-o", &output])
            .stderr(full());
        assert_eq!(enhance.status().unwrap().code(), Some(code));
        assert_eq!(desk.has(&output), code == 0);
    }
}

/// What --explain says ran is what --timings has.
#[test]
fn what_is_explained_is_what_ran() {
    let desk = Desk::new();
    let photo = "fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
    let mut count = 0;
    for command in [
        "enhance -o o.png",
        "enhance -o o.png --scaling 0",
        "enhance -o o.png --mix 0",
        "enhance -o o.exr --iterations 0",
        "enhance -o o.png --scale 20 --curvature-gain 4",
        "enhance -o o.png --max-memory 40M",
        "shape -o o.png",
        "shape -o o.exr",
        "shape -o o.exr --scale 2,8",
        "relight -o o.png --light 135,40",
        "relight -o o.exr --light 135,40 --method plain",
        "relight -o o.png --light 135,40 --method scale --albedo-from white",
        "hatch -o o.png",
        "hatch -o o.svg --enlarge 1",
        "hatch -o o.png --lines-only --enlarge 1",
        "hatch -o o.png --style stipple --enlarge 1",
        "map -o o.png",
        "map -o o_{map}.png --map curvature,edges,height",
    ] {
        for input in [
            "fixtures/bust.exr",
            "fixtures/street.exr",
            "fixtures/wheel.0001.exr",
            photo,
        ] {
            let words = format!("{command} {input} --explain --timings t.json -q");
            let ran = desk.run(&words);
            if ran.code != Some(0) {
                // Photos are no frames of strips, and so on: what is refused explains nothing.
                assert!(!ran.stdout.contains("ran "), "{words}");
                continue;
            }
            let json = desk.json("t.json");
            let stages = json["stages"].as_array().unwrap().iter();
            let stages: Vec<_> = stages
                .map(|stage| stage["stage"].as_str().unwrap())
                .collect();
            let told = ran
                .stdout
                .lines()
                .filter_map(|line| line.strip_prefix("ran   "));
            let told: Vec<_> = told
                .filter_map(|line| line.split_whitespace().next())
                .collect();
            assert_eq!(told, stages, "{words}\n{}", ran.stdout);
            count += 1;
        }
    }
    assert!(count >= 60, "{count} command lines ran");
}
