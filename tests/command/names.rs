//! Untrusted names: of layers, parts, files and settings.

use crate::common::exr::Part;
use crate::common::program::{Desk, Ran, program, run};
use relievo::frame::Plane;
use serde_json::Value;
use std::fs;

/// Arguments that are separated by spaces, with this name for each `NAME`.
fn named<'a>(words: &'a str, name: &'a str) -> impl Iterator<Item = String> + 'a {
    words.split(' ').map(move |word| word.replace("NAME", name))
}

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
    let desk = Desk::of_frames(1..=1);
    let plane = Plane::filled(4, 4, 0.5);
    let channels = ["X", "Y", "Z"].map(|component| (format!("{STEERING}.{component}"), &plane));
    Part::of(channels).write(&desk.at("named.exr"));
    let text = desk.run("inspect named.exr");
    is_plain(&text);
    assert!(text.stdout.contains("\\u001b[31mA\\u0007B"));
    let json = desk.run("inspect --json named.exr");
    is_plain(&json);
    // JSON loses nothing.
    let read: Value = serde_json::from_str(&json.stdout).unwrap();
    let layer = &read[0]["parts"][0]["layers"][0]["name"];
    assert_eq!(layer.as_str(), Some(STEERING));
    // TOML escapes by four digits.
    let mut look = format!("version = 1\ncommand = \"enhance\"\n{STEERING:?} = 1\n");
    for code in ["1b", "7", "9b", "202e", "2066"] {
        look = look.replace(&format!("\\u{{{code}}}"), &format!("\\u{code:0>4}"));
    }
    desk.write("look.toml", look);
    let refused = desk.run("run look.toml in.0001.exr -o o.png");
    is_plain(&refused);
    assert!(refused.ended(2).contains("has no setting"));
    desk.copy("in.0001.exr", &format!("{STEERING}.exr"));
    for (words, code) in [
        ("enhance named.exr -o o.png", None),
        ("inspect NAME", None),
        ("enhance NAME -o o.png", None),
        ("enhance in.0001.exr -o NAME", None),
        ("enhance in.0001.exr -o o.png --normal NAME", None),
        ("enhance in.0001.exr -o o.png --scaling NAME", None),
        ("NAME", None),
        (
            "enhance NAME.exr -o #.png --frames 1-2 --progress json",
            None,
        ),
        // A successful one, with verbose output.
        ("enhance NAME.exr -o NAME.png -v --explain", Some(0)),
    ] {
        let ran = run(desk.path(), named(words, STEERING));
        is_plain(&ran);
        assert!(code.is_none() || ran.code == code, "{words}");
    }
}

/// Names of files need not be text.
#[cfg(target_os = "linux")]
#[test]
fn a_name_that_is_no_text_loses_no_results() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::of_frames(1..=1);
    let name = OsStr::from_bytes(b"b\xffd.exr");
    fs::copy(desk.at("in.0001.exr"), desk.path().join(name)).unwrap();
    let with_it = |words: &str| {
        let mut command = program(desk.path());
        Ran::of(command.args(words.split(' ')).arg(name)).done()
    };
    let json = with_it("inspect --json in.0001.exr").stdout;
    let read: Value = serde_json::from_str(&json).unwrap();
    let files = [0, 1].map(|i| read[i]["file"].as_str().unwrap());
    assert_eq!(files, ["in.0001.exr", "b\u{fffd}d.exr"]);
    with_it("enhance -o o.png");
}

/// Most characters of a message: a few names of 120, and what is said about them.
const LONGEST: usize = 900;

/// Whatever the length of a name, messages stay readable: names lose their middle, and the remedy is there.
#[test]
fn long_names_lose_their_middle_in_messages() {
    let desk = Desk::of_frames(1..=1);
    let plane = Plane::filled(4, 4, 0.5);
    let is_long = |line: &&str| line.chars().count() > LONGEST;
    // Blanks and none, below what a system allows as one argument.
    for name in ["long name ".repeat(10_000), "x".repeat(100_000)] {
        let part = Part::of([("R", &plane), ("G", &plane), ("B", &plane)]).named(&name);
        part.text("view", &name).write(&desk.at("part.exr"));
        let manifest = format!("{{\"{name}\": \"3f800000\", \"b\": \"3f900000\"}}");
        let ranks = ["R", "G", "B", "A"].map(|c| (format!("Crypto00.{c}"), &plane));
        let part = Part::of(ranks).text("cryptomatte/1234567/name", "Crypto");
        let part = part.text("cryptomatte/1234567/manifest", &manifest);
        part.write(&desk.at("objects.exr"));
        for (file, line) in [
            ("key.toml", format!("{name:?} = 1")),
            ("value.toml", format!("scaling = {name:?}")),
            ("word.toml", name.clone()),
        ] {
            desk.write(
                file,
                format!("version = 1\ncommand = \"enhance\"\n{line}\n"),
            );
        }
        let camera = format!("{{\"camera_type\": {name:?}, \"{name}\": 1}}");
        desk.write("camera.json", camera);
        let flags = "normal depth mask scaling frames camera light-group motion threads max-memory timings save-recipe \
                     crease";
        let flags = flags.split(' ');
        let flags = flags.map(|flag| format!("enhance in.0001.exr -o o.png --{flag} NAME"));
        let commands = "
            NAME
            inspect NAME
            inspect --view NAME part.exr
            inspect --layer NAME part.exr
            report NAME
            run NAME
            man NAME
            completions NAME
            enhance NAME -o o.png
            enhance NAME other.exr -o o.png
            enhance in.0001.exr -o NAME
            enhance in.0001.exr NAME
            enhance objects.exr -o o.png --object NAME
            enhance objects.exr -o o.png --object none
            enhance part.exr -o o.png
            enhance in.0001.exr -o o.exr --write NAME
            run key.toml in.0001.exr -o o.png
            run value.toml in.0001.exr -o o.png
            run word.toml in.0001.exr -o o.png
            relight in.0001.exr -o o.png --environment NAME
            hatch in.0001.exr -o o.png --style NAME
            hatch in.0001.exr -o o.png --camera camera.json
        ";
        let commands = commands.trim().lines().map(|line| line.trim().to_string());
        for words in commands.chain(flags) {
            let ran = run(desk.path(), named(&words, &name));
            assert_eq!(ran.stderr.lines().find(is_long), None, "{words}");
            if let Some(code @ 1..) = ran.code {
                let line = ran.refused(code);
                assert!(!line.contains(&name[..130]), "{words}: {line}");
            }
        }
        for file in ["part.exr", "objects.exr"] {
            let text = desk.make(format!("inspect {file}")).stdout;
            assert_eq!(text.lines().find(is_long), None);
            // JSON loses nothing.
            let json = desk.make(format!("inspect --json {file}")).stdout;
            let read: Value = serde_json::from_str(&json).unwrap();
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
    let desk = Desk::new();
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
    Part::of(meant.chain(others)).write(&desk.at("in.exr"));
    let json = desk.make("inspect --json in.exr").stdout;
    let read: Value = serde_json::from_str(&json).unwrap();
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
    let manifests = bare().text("cryptomatte/1/name", "C");
    let manifests = manifests.text("cryptomatte/1/manifest", &manifest);
    let names = bare().text("name", &"n".repeat(200_000));
    let layers = &mut many(257, "cryptomatte/").map(|id| id + "/name");
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
            names.text("view", &"v".repeat(62_145)),
            "has 262145 bytes of names",
        ),
        (with(layers, "C"), "declares 257 layers of Cryptomatte"),
        (manifests, "names more than 500000 objects"),
    ] {
        part.write(&desk.at("in.exr"));
        desk.check("inspect in.exr", &format!("=> 1: {found}"));
    }
}

/// A name of an input stays within the folder that results go to, and stands as it is.
#[cfg(unix)]
#[test]
fn names_of_inputs_are_put_into_names_of_outputs_once() {
    let desk = Desk::of_frames(1..=1);
    fs::create_dir(desk.at("out")).unwrap();
    // Their stems are `..` and `.`.
    for name in ["...exr", "..exr"] {
        desk.copy("in.0001.exr", name);
        for output in ["out/{name}/escaped.png", "out/{name}.png", "out/"] {
            desk.check(
                &format!("shape {name} in.0001.exr -o {output}"),
                "=> 2: rename it",
            );
        }
    }
    assert!(!desk.has("escaped.png"));
    for name in ["{map}.exr", "{name}.exr", "-o.exr", "%d#.exr", "{.exr"] {
        desk.copy("in.0001.exr", name);
        desk.make(format!(
            "map ./{name} -o {{name}}_{{map}}.png --map curvature,edges"
        ));
        let stem = name.trim_end_matches(".exr");
        for map in ["curvature", "edges"] {
            assert!(desk.has(&format!("{stem}_{map}.png")), "{name}");
        }
    }
    // The name alone has no place for the map.
    let rows = "
        --map curvature,edges => 2: put {map} into its name
        => 0
    ";
    desk.check("map {map}.exr -o {name}.png {}", rows);
    assert!(desk.has("{map}.png"));
}
