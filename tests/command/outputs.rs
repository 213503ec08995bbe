//! Outputs that cannot be written give one line and leave no debris; inputs are never written over.

use crate::common::bits;
use crate::common::program::{Desk, relievo_within};
use relievo::engine::{Engine, Request, Run};
use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load};
use relievo::light::lights::Illumination;
use relievo::params::{Parameters, Params};
use std::fs;

/// Unwritable outputs, with their messages.
#[cfg(unix)]
#[test]
fn what_cannot_be_written_is_one_line_and_no_debris() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::of_frames(1..=2);
    fs::create_dir(desk.at("out.png")).unwrap();
    let rows = "
        none/out.exr => 1: there is no directory none
        out.png => 1: out.png: cannot write
    ";
    desk.check("enhance in.0001.exr -o {}", rows);
    // A full disk: this one never has room.
    if desk.has("/dev/full") {
        desk.check("enhance in.0001.exr -o /dev/full", "=> 2");
    }
    // A directory that nobody may write to; the superuser may.
    fs::create_dir(desk.at("locked")).unwrap();
    fs::set_permissions(desk.at("locked"), fs::Permissions::from_mode(0o555)).unwrap();
    let words = "enhance in.####.exr --frames 1-2 -o locked/out.####.exr --keep-going";
    let output = desk.run(words);
    if output.code == Some(0) {
        eprintln!("skipped: this user may write anywhere");
    } else {
        let said = output.ended(1);
        assert_eq!(said.matches("cannot write").count(), 1, "{said}");
    }
    assert_eq!(desk.names(".relievo"), [""; 0]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_leaves_the_old_file() {
    let desk = Desk::of_frames(1..=1);
    desk.make("enhance in.0001.exr -o out.exr");
    let before = desk.bytes("out.exr");
    // No file may exceed 8 KiB, 16 blocks: the write fails in the middle.
    let words = "enhance in.0001.exr -o out.exr --scaling 0.5 --backend cpu";
    let said = relievo_within("trap '' XFSZ; ulimit -f 16", desk.path(), words).refused(1);
    assert!(said.contains("out.exr: cannot write"), "{said}");
    assert!(desk.bytes("out.exr") == before);
    assert_eq!(desk.names(".relievo"), [""; 0]);
}

/// Inputs are never overwritten, and no file is written twice, under any spelling.
#[cfg(unix)]
#[test]
fn files_are_compared_and_not_their_names() {
    use std::os::unix::fs::symlink;
    let desk = Desk::of_frames(1..=2);
    fs::create_dir(desk.at("st")).unwrap();
    desk.copy("fixtures/clay.png", "st/1.png");
    desk.copy("fixtures/gears.exr", "gears.exr");
    desk.copy("fixtures/gears.camera.json", "camera.json");
    desk.copy("fixtures/tablet.color.jpg", "color.jpg");
    desk.copy("fixtures/tablet.normal.png", "normal.png");
    desk.copy("fixtures/room.hdr", "room.hdr");
    desk.write("look.toml", "version = 1\ncommand = \"enhance\"\n");
    let inputs = desk.names("");
    let inputs = inputs
        .iter()
        .map(String::as_str)
        .filter(|name| *name != "st");
    let inputs: Vec<&str> = inputs.chain(["st/1.png"]).collect();
    let content = || {
        inputs
            .iter()
            .map(|name| desk.bytes(name))
            .collect::<Vec<_>>()
    };
    let before = content();
    fs::hard_link(desk.at("in.0002.exr"), desk.at("next.0001.exr")).unwrap();
    symlink("st", desk.at("links")).unwrap();
    let rows = "
        enhance gears.exr -o gears.exr => 2: is the input
        enhance ./gears.exr -o gears.exr => 2: is the input
        shape gears.exr -o gears.exr => 2: is the input
        enhance color.jpg --normal normal.png -o normal.png => 2: normal.png
        relight gears.exr --environment room.hdr -o room.hdr => 2: is the input
        enhance gears.exr --camera camera.json -o o.png --timings gears.exr => 2: is the input
        enhance gears.exr --camera camera.json -o o.png --timings camera.json => 2: is the input
        enhance in.0001.exr -o o.png --timings ./o.png => 2: output of -o too
        enhance in.0001.exr -o o.png --save-recipe ./o.png => 2: output of -o too
        enhance in.0001.exr -o o.png --timings x --save-recipe st/../x => 2: output of --timings too
        enhance in.0001.exr -o o.png --timings ./in.0001.exr => 2: is the input
        relight in.0001.exr --light 9,9 --lit-sphere st/1.png -o links/1.png => 2: is the input
        hatch in.0001.exr --style st -o links/1.png => 2: lies in st
        hatch in.0001.exr --style st -o st/new.png => 2: lies in st
        run look.toml in.0001.exr -o o.png --save-recipe ./look.toml => 2: is the input
        enhance in.####.exr --frames 1-2 -o in.%04d.exr => 2: is the input
        // The output of one frame is the input of the next.
        enhance in.####.exr --frames 1-2 -o next.####.exr => 2: is the input
        enhance in.####.exr --frames 1-2 -o o.####.png --timings ./o.####.png => 2: output of -o too
        hatch in.####.exr --frames 1-2 --motion next.%04d.exr -o next.####.exr => 2: is the input
    ";
    desk.check("{}", rows);
    assert!(before == content(), "an input was touched");
}

/// An unwritable path is detected before the frame is read: here there is no frame.
#[test]
fn bad_paths_are_found_before_any_work() {
    let desk = Desk::new();
    fs::create_dir(desk.at("folder.png")).unwrap();
    let rows = "
        -o none/x.png => 1: cannot write
        -o folder.png => 1: cannot write
        -o o.png --timings none/x.png => 1: cannot write
        -o o.png --timings folder.png => 1: cannot write
        -o o.png --save-recipe none/x.png => 1: cannot write
        -o o.png --save-recipe folder.png => 1: cannot write
    ";
    desk.check("enhance none.exr {}", rows);
}

#[cfg(unix)]
#[test]
fn outputs_keep_permissions_and_write_protected_ones_stay() {
    use std::os::unix::fs::PermissionsExt;
    let desk = Desk::of_frames(1..=1);
    let set =
        |mode| fs::set_permissions(desk.at("o.png"), fs::Permissions::from_mode(mode)).unwrap();
    let mode = || desk.at("o.png").metadata().unwrap().permissions().mode() & 0o777;
    desk.make("enhance in.0001.exr -o o.png");
    set(0o600);
    desk.make("enhance in.0001.exr -o o.png --scaling 2");
    assert_eq!(mode(), 0o600);
    set(0o400);
    let before = desk.bytes("o.png");
    let row = "=> 1: write-protected; --force replaces it";
    desk.check("enhance in.0001.exr -o o.png --scaling 3", row);
    assert!(desk.bytes("o.png") == before);
    desk.make("enhance in.0001.exr -o o.png --scaling 3 --force");
    assert!(desk.shown("o.png") != before && mode() == 0o400);
}

/// Pipes and devices are refused at once, as inputs and where a killed run's leftovers are looked for.
#[cfg(unix)]
#[test]
fn pipes_are_not_waited_for() {
    let desk = Desk::of_frames(1..=1);
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    let left = [".relievo-HOST-1-abcdef.part", ".relievo-HOST-abcdef.part"];
    for name in left
        .map(|name| name.replace("HOST", &host))
        .iter()
        .chain([&"pipe".into()])
    {
        let made = std::process::Command::new("mkfifo")
            .arg(desk.at(name))
            .status();
        assert!(
            made.is_ok_and(|status| status.success()),
            "mkfifo is missing"
        );
    }
    desk.make("enhance in.0001.exr -o o.png");
    desk.make("enhance in.####.exr --frames 1 -o o.####.png");
    let rows = "
        enhance pipe -o x.png => 1: it is a pipe or a device
        inspect pipe => 1: it is a pipe or a device
        inspect /dev/zero => 1: it is a pipe or a device
        enhance in.0001.exr --normal pipe -o x.png => 1: it is a pipe or a device
        enhance in.0001.exr --camera pipe -o x.png => 1: it is a pipe or a device
        relight in.0001.exr --environment pipe -o x.png => 1: it is a pipe or a device
        relight in.0001.exr --lit-sphere pipe -o x.png => 1: it is a pipe or a device
        run pipe in.0001.exr -o x.png => 1: it is a pipe or a device
        enhance in.0001.exr -o pipe => 2: no known extension
    ";
    desk.check("{}", rows);
}

/// Where no file can be made, that is said before anything is read: the input does not even exist. /proc takes none,
/// whoever asks.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_file_is_named_before_any_work() {
    let desk = Desk::new();
    desk.write("file", "");
    let rows = "
        shape none.exr -o /proc/out.png => 1: cannot write ... !none.exr
        shape none.exr other.exr -o /proc/ => 1: cannot write ... !none.exr
        shape none.exr other.exr -o /proc/out => 1: cannot make ... !none.exr
        shape none.exr other.exr -o file/out => 1: cannot make ... !none.exr
        enhance none.####.exr --frames 1-2 -o /proc/out.####.exr => 1: cannot write ... !none.exr
        map none.exr -o /proc/{map}.png --map curvature,edges => 1: cannot write ... !none.exr
        hatch none.exr -o out.png --save-recipe /proc/look.toml => 1: cannot write ... !none.exr
        relight none.exr -o out.png --timings missing/t.json => 1: cannot write ... !none.exr
        report none.exr -o /proc => 1: cannot write ... !none.exr
        report none.exr -o /proc/report => 1: cannot write ... !none.exr
        report none.exr -o file/report => 1: cannot write ... !none.exr
    ";
    desk.check("{}", rows);
}

/// The library is the program: a request with the settings of a command line saves the same pixels, lines and layers.
#[test]
fn a_request_saves_what_the_program_writes() {
    let desk = Desk::new();
    let engine = Engine::auto();
    for row in [
        "enhance half.png mix=.5 exposure=1 lobes=off",
        "enhance agx.jpg view-transform=agx lobes=off",
        "enhance strong.exr scaling=2 lobes=off",
        "enhance sky.png occlusion=computed scaling-ambient=1 lobes=off",
        "relight lamp.png albedo-from=white",
        "relight lit.exr albedo-from=white method=scale",
        "hatch page.svg style=engraving page=A4",
        "hatch large.png style=lines enlarge=2 mix=.5",
        "hatch ink.tif style=stipple ink=bilevel dpi=200",
        "hatch strokes.exr style=pen tone=relight albedo-from=white",
        "shape shown.png scale=4",
        "shape layers.exr scale=4",
    ] {
        let (command, rest) = row.split_once(' ').unwrap();
        let (file, settings) = rest.split_once(' ').unwrap();
        let mut params = Params::default();
        let computes_occlusion = settings.contains("occlusion=computed");
        let mut words = format!("{command} fixtures/bust.exr -o {file} --layers results");
        for (name, value) in settings.split(' ').filter_map(|one| one.split_once('=')) {
            let is_set = name == "occlusion" || params.set(name, value).unwrap();
            assert!(is_set, "{name}");
            words += &format!(" --{name} {value}");
        }
        if file.ends_with("exr") && matches!(command, "enhance" | "relight") {
            words += " --depth-of-output float";
        }
        desk.make(&words);
        let inputs = Inputs {
            picture: desk.at("fixtures/bust.exr"),
            occlusion: computes_occlusion.then(|| Inputs::NONE.into()),
            ..Inputs::default()
        };
        let needs = Needs {
            color: command == "enhance",
            color_if_any: command != "shape",
            projection: true,
            objects: command == "hatch",
            strength: true,
            confidence: file == "layers.exr",
            confidence_if_any: matches!(command, "enhance" | "relight"),
            ..Needs::default()
        };
        let frame = load(&inputs, needs).unwrap().frame;
        let light = Illumination::default();
        let request = match command {
            "enhance" => Request {
                computes_occlusion,
                ..Request::enhance(params)
            },
            "relight" => Request::relight(params, &light),
            "hatch" => Request::hatch(params),
            _ if file.ends_with("png") => Request::display(params),
            _ => Request::layers(params),
        };
        let outcome = engine.run(&request, &frame, &Run::new()).unwrap();
        let saved = format!("saved_{file}");
        outcome.save(desk.at(&saved), &frame).unwrap();
        match file.rsplit_once('.').unwrap().1 {
            "svg" => assert_eq!(desk.text(file), desk.text(&saved)),
            "exr" => {
                let names = |name| {
                    let file = desk.exr(name);
                    let channels = file.parts[0].channels.iter();
                    channels.map(|c| c.name.clone()).collect::<Vec<_>>()
                };
                assert_eq!(names(file), names(&saved), "{words}");
                for name in names(file) {
                    let [a, b] = [file, &saved].map(|file| bits(&desk.channel(file, &name)));
                    assert!(a == b, "{words}: {name}");
                }
            }
            _ => {
                let [a, b] = [file, &saved].map(|file| desk.photo(file));
                assert!(a.channels == b.channels && a.alpha == b.alpha, "{words}");
            }
        }
    }
}
