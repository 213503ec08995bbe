//! Untrusted names: of layers, parts, files and settings.

use super::inputs::desk;
use crate::common::exr::Part;
use crate::common::program::{Ran, program, relievo, run};
use relievo::frame::Plane;
use std::fs;

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

/// Most characters of a message: a few names of 120, and what is said about them.
const LONGEST: usize = 900;

/// Whatever the length of a name, messages stay readable: names lose their middle, and the remedy is there.
#[test]
fn long_names_lose_their_middle_in_messages() {
    let desk = desk(1..=1);
    let here = desk.path();
    let plane = Plane::filled(4, 4, 0.5);
    // Blanks and none, below what a system allows as one argument.
    for name in ["long name ".repeat(10_000), "x".repeat(100_000)] {
        let mut named = Part::of([("R", &plane), ("G", &plane), ("B", &plane)]).named(&name);
        named = named.text("view", &name);
        named.write(&here.join("part.exr"));
        let manifest = format!("{{\"{name}\": \"3f800000\", \"b\": \"3f900000\"}}");
        let ranks = ["R", "G", "B", "A"].map(|c| (format!("Crypto00.{c}"), &plane));
        Part::of(ranks)
            .text("cryptomatte/1234567/name", "Crypto")
            .text("cryptomatte/1234567/manifest", &manifest)
            .write(&here.join("objects.exr"));
        let recipe = |line: &str| format!("version = 1\ncommand = \"enhance\"\n{line}\n");
        fs::write(here.join("key.toml"), recipe(&format!("{name:?} = 1"))).unwrap();
        fs::write(
            here.join("value.toml"),
            recipe(&format!("scaling = {name:?}")),
        )
        .unwrap();
        fs::write(here.join("word.toml"), recipe(&name)).unwrap();
        let camera = format!("{{\"camera_type\": {name:?}, \"{name}\": 1}}");
        fs::write(here.join("camera.json"), camera).unwrap();
        let make = ["enhance", "in.0001.exr", "-o", "o.png"];
        let with = |more: &[&'static str]| [&make[..], more, &[&name]].concat();
        for words in [
            vec![&*name],
            vec!["inspect", &name],
            vec!["inspect", "--view", &name, "part.exr"],
            vec!["inspect", "--layer", &name, "part.exr"],
            vec!["report", &name],
            vec!["run", &name],
            vec!["man", &name],
            vec!["completions", &name],
            vec!["enhance", &name, "-o", "o.png"],
            vec!["enhance", &name, "other.exr", "-o", "o.png"],
            vec!["enhance", "in.0001.exr", "-o", &name],
            vec!["enhance", "in.0001.exr", &name],
            vec!["enhance", "objects.exr", "-o", "o.png", "--object", &name],
            vec!["enhance", "objects.exr", "-o", "o.png", "--object", "none"],
            vec!["enhance", "part.exr", "-o", "o.png"],
            vec!["enhance", "in.0001.exr", "-o", "o.exr", "--write", &name],
            vec!["run", "key.toml", "in.0001.exr", "-o", "o.png"],
            vec!["run", "value.toml", "in.0001.exr", "-o", "o.png"],
            vec!["run", "word.toml", "in.0001.exr", "-o", "o.png"],
            vec![
                "relight",
                "in.0001.exr",
                "-o",
                "o.png",
                "--environment",
                &name,
            ],
            vec!["hatch", "in.0001.exr", "-o", "o.png", "--style", &name],
            vec![
                "hatch",
                "in.0001.exr",
                "-o",
                "o.png",
                "--camera",
                "camera.json",
            ],
            with(&["--normal"]),
            with(&["--depth"]),
            with(&["--mask"]),
            with(&["--scaling"]),
            with(&["--frames"]),
            with(&["--camera"]),
            with(&["--light-group"]),
            with(&["--motion"]),
            with(&["--threads"]),
            with(&["--max-memory"]),
            with(&["--timings"]),
            with(&["--save-recipe"]),
            with(&["--crease"]),
        ] {
            let ran = run(here, &words);
            let shown: Vec<_> = words
                .iter()
                .map(|word| &word[..word.len().min(20)])
                .collect();
            let long = ran
                .stderr
                .lines()
                .find(|line| line.chars().count() > LONGEST);
            assert_eq!(long, None, "{shown:?}");
            if let Some(code @ 1..) = ran.code {
                let line = ran.refused(code);
                assert!(!line.contains(&name[..130]), "{shown:?}: {line}");
            }
        }
        for file in ["part.exr", "objects.exr"] {
            let text = run(here, ["inspect", file]).done().stdout;
            let long = text.lines().find(|line| line.chars().count() > LONGEST);
            assert_eq!(long, None);
            // JSON loses nothing.
            let json = run(here, ["inspect", "--json", file]).done().stdout;
            let read: serde_json::Value = serde_json::from_str(&json).unwrap();
            let whole = match file {
                "part.exr" => &read[0]["parts"][0]["name"],
                _ => &read[0]["objects"][0]["names"],
            };
            assert!(whole.to_string().contains(&name));
        }
    }
}

/// The layers that mean something are found among 20,000; what no renderer writes is refused.
#[test]
fn headers_of_many_names_are_read_and_endless_ones_refused() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let (none, one) = (Plane::filled(4, 4, 0.0), Plane::filled(4, 4, 1.0));
    let many = |count: usize, name: &'static str| (0..count).map(move |i| format!("{name}{i:06}"));
    let meant = [
        ["R", "mtl_baseColor.R", "zz.Normal.X"],
        ["G", "mtl_baseColor.G", "zz.Normal.Y"],
        ["B", "mtl_baseColor.B", "zz.Normal.Z"],
        ["Z", "noise.R", "noise.B"],
    ];
    let meant = meant.into_iter().flatten().map(|name| match name {
        "zz.Normal.X" | "zz.Normal.Y" => (name.to_owned(), &none),
        _ => (name.to_owned(), &one),
    });
    let others = many(20_000, "part.of.aov").map(|name| (format!("{name}.R"), &none));
    Part::of(meant.chain(others)).write(&here.join("in.exr"));
    let json = relievo(here, "inspect --json in.exr").done().stdout;
    let read: serde_json::Value = serde_json::from_str(&json).unwrap();
    let layers = read[0]["parts"][0]["layers"].as_array().unwrap();
    // With them the bare channels, and three more layers that have names.
    assert_eq!(layers.len(), 20_004);
    let roles = read[0]["roles"].as_array().unwrap().iter();
    let roles: Vec<_> = roles
        .map(|found| [&found["role"], &found["layer"]].map(|text| text.as_str().unwrap()))
        .collect();
    let expected = [
        ["color", ""],
        ["normal", "zz.Normal"],
        ["depth", ""],
        ["albedo", "mtl_baseColor"],
    ];
    assert_eq!(roles, expected);

    let bare = || Part::of(["R", "G", "B", "C00.R", "C00.G"].map(|name| (name, &one)));
    let with = |texts: &mut dyn Iterator<Item = String>, value: &str| {
        texts.fold(bare(), |part, name| part.text(&name, value))
    };
    let objects: Vec<_> = many(500_001, "o")
        .map(|o| format!("\"{o}\":\"1\""))
        .collect();
    let manifest = format!("{{{}}}", objects.join(","));
    for (part, found) in [
        (
            Part::of(many(32_769, "aov").map(|name| (name, &one))),
            "has 32769 channels",
        ),
        (
            with(&mut many(65_537, "text"), "x"),
            "has more than 65536 attributes",
        ),
        (
            bare()
                .text("name", &"n".repeat(200_000))
                .text("view", &"v".repeat(62_145)),
            "has 262145 bytes of names",
        ),
        (
            with(&mut many(257, "cryptomatte/").map(|id| id + "/name"), "C"),
            "declares 257 layers of Cryptomatte",
        ),
        (
            bare()
                .text("cryptomatte/1/name", "C")
                .text("cryptomatte/1/manifest", &manifest),
            "names more than 500000 objects",
        ),
    ] {
        part.write(&here.join("in.exr"));
        let line = relievo(here, "inspect in.exr").refused(1);
        assert!(line.contains(found), "{line}");
    }
}

/// A name of an input stays within the folder that results go to, and stands as it is.
#[cfg(unix)]
#[test]
fn names_of_inputs_are_put_into_names_of_outputs_once() {
    let desk = desk(1..=1);
    let here = desk.path();
    fs::create_dir(here.join("out")).unwrap();
    let copy = |name: &str| fs::copy(here.join("in.0001.exr"), here.join(name)).unwrap();
    // Their stems are `..` and `.`.
    for name in ["...exr", "..exr"] {
        copy(name);
        for output in ["out/{name}/escaped.png", "out/{name}.png", "out/"] {
            let line = run(here, ["shape", name, "in.0001.exr", "-o", output]).refused(2);
            assert!(line.contains("rename it"), "{line}");
        }
    }
    assert!(!here.join("escaped.png").exists());
    for name in ["{map}.exr", "{name}.exr", "-o.exr", "%d#.exr", "{.exr"] {
        copy(name);
        let input = format!("./{name}");
        let words = [
            "map",
            &input,
            "-o",
            "{name}_{map}.png",
            "--map",
            "curvature,edges",
        ];
        run(here, words).done();
        let stem = name.trim_end_matches(".exr");
        for map in ["curvature", "edges"] {
            assert!(here.join(format!("{stem}_{map}.png")).exists(), "{name}");
        }
    }
    // The name alone has no place for the map.
    let words = [
        "map",
        "{map}.exr",
        "-o",
        "{name}.png",
        "--map",
        "curvature,edges",
    ];
    let line = run(here, words).refused(2);
    assert!(line.contains("put {map} into its name"), "{line}");
    run(here, ["map", "{map}.exr", "-o", "{name}.png"]).done();
    assert!(here.join("{map}.png").exists());
}
