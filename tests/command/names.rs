//! Untrusted names: of layers, parts, files and settings.

use super::inputs::desk;
use crate::common::exr::Part;
use crate::common::program::{Ran, program, relievo, run};
use relievo::frame::Plane;

/// A colour, a bell, the start of a line, a new line, a one-byte escape, and writing from right to left.
const STEERING: &str = "\u{1b}[31mA\u{7}B\rC\nD\u{9b}2JE\u{202e}F\u{2066}G";

/// Neither stdout nor stderr contains a byte that controls a terminal, except line ends.
#[track_caller]
fn is_plain(ran: &Ran) {
    for text in [&ran.stdout, &ran.stderr] {
        let steers = |c: char| c.is_control() || "\u{202e}\u{2066}".contains(c);
        let found = text.lines().find(|line| line.contains(steers));
        assert_eq!(found, None, "{text:?}");
    }
}

#[test]
fn no_name_reaches_the_terminal_raw() {
    let desk = desk(1..=1);
    let here = desk.path();
    let plane = Plane::filled(4, 4, 0.5);
    let channels = ["X", "Y", "Z"].map(|component| (format!("{STEERING}.{component}"), &plane));
    Part::of(channels).write(&here.join("named.exr"));
    let text = relievo(here, "inspect named.exr");
    is_plain(&text);
    assert!(text.stdout.contains("\\u001b[31mA\\u0007B"));
    let json = relievo(here, "inspect --json named.exr");
    is_plain(&json);
    // JSON loses nothing.
    let read: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    let layer = &read[0]["parts"][0]["layers"][0]["name"];
    assert_eq!(layer.as_str(), Some(STEERING));
    is_plain(&relievo(here, "enhance named.exr -o o.png"));
    let look = format!("version = 1\ncommand = \"enhance\"\n{STEERING:?} = 1\n");
    let look = look
        .replace("\\u{1b}", "\\u001b")
        .replace("\\u{7}", "\\u0007");
    let look = look
        .replace("\\u{9b}", "\\u009b")
        .replace("\\u{202e}", "\\u202e")
        .replace("\\u{2066}", "\\u2066");
    std::fs::write(here.join("look.toml"), look).unwrap();
    let refused = relievo(here, "run look.toml in.0001.exr -o o.png");
    is_plain(&refused);
    assert!(refused.ended(2).contains("has no setting"));
    for words in [
        vec!["inspect", STEERING],
        vec!["enhance", STEERING, "-o", "o.png"],
        vec!["enhance", "in.0001.exr", "-o", STEERING],
        vec![
            "enhance",
            "in.0001.exr",
            "-o",
            "o.png",
            "--normal",
            STEERING,
        ],
        vec![
            "enhance",
            "in.0001.exr",
            "-o",
            "o.png",
            "--scaling",
            STEERING,
        ],
        vec![STEERING],
    ] {
        is_plain(&run(here, &words));
    }
    // A successful one, with verbose output.
    let named = format!("{STEERING}.exr");
    std::fs::copy(here.join("in.0001.exr"), here.join(&named)).unwrap();
    let output = format!("{STEERING}.png");
    let made = run(here, ["enhance", &named, "-o", &output, "-v", "--explain"]);
    is_plain(&made);
    made.ended(0);
    let frames = [
        "enhance",
        &named,
        "-o",
        "#.png",
        "--frames",
        "1-2",
        "--progress",
        "json",
    ];
    is_plain(&run(here, frames));
}

/// Names of files need not be text.
#[cfg(target_os = "linux")]
#[test]
fn a_name_that_is_no_text_loses_no_results() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let desk = desk(1..=1);
    let here = desk.path();
    let name = OsStr::from_bytes(b"b\xffd.exr");
    std::fs::copy(here.join("in.0001.exr"), here.join(name)).unwrap();
    let ran = Ran::of(
        program(here)
            .args(["inspect", "--json", "in.0001.exr"])
            .arg(name),
    )
    .done();
    let read: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let files: Vec<_> = (0..2).map(|i| read[i]["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["in.0001.exr", "b\u{fffd}d.exr"]);
    Ran::of(program(here).args(["enhance", "-o", "o.png"]).arg(name)).done();
}
