//! Outputs that cannot be written give one line and leave no debris, and layers go where requested.

use super::inputs::{bytes, desk};
use crate::common::bits;
use crate::common::exr::channel;
use crate::common::program::{Ran, fixture, names, program, relievo};
use relievo::engine::{Engine, Request, Run};
use relievo::io::exr::ExrFile;
use relievo::io::inputs::Inputs;
use relievo::io::photo::Photo;
use relievo::io::{Needs, load};
use relievo::light::lights::Illumination;
use relievo::params::{Parameters, Params};
use std::fs;

#[test]
fn layers_go_beside_the_input_into_it_or_alone() {
    let desk = desk(1..=1);
    let here = desk.path();
    for (how, parts, channels) in [
        (
            "keep",
            2,
            &[
                "relievo.Picture.B",
                "relievo.Picture.G",
                "relievo.Picture.R",
            ][..],
        ),
        (
            "channels",
            1,
            &[
                "relievo.Picture.B",
                "relievo.Picture.G",
                "relievo.Picture.R",
            ],
        ),
        ("results", 1, &["B", "G", "R"]),
    ] {
        let words = format!("enhance in.0001.exr -o {how}.exr --layers {how} --compression zips");
        relievo(here, &words).ended(0);
        let file = ExrFile::open(&here.join(format!("{how}.exr")), &Default::default()).unwrap();
        assert_eq!(file.parts.len(), parts, "{how}");
        let last = &file.parts[parts - 1];
        let names: Vec<_> = last.channels.iter().map(|c| c.name.as_str()).collect();
        assert!(
            channels.iter().all(|name| names.contains(name)),
            "{how}: {names:?}"
        );
        // Adding channels keeps the compression of the input.
        let expected = if how == "channels" { "none" } else { "zips" };
        assert_eq!(last.compression, expected, "{how}");
        let own = names.contains(&"N.X");
        assert_eq!(own, how == "channels", "{how}");
    }
}

/// Unwritable outputs, with their messages.
#[cfg(unix)]
#[test]
fn what_cannot_be_written_is_one_line_and_no_debris() {
    use std::os::unix::fs::PermissionsExt;
    let desk = desk(1..=2);
    let here = desk.path();
    let said = relievo(here, "enhance in.0001.exr -o none/out.exr").ended(1);
    assert!(said.contains("there is no directory none"), "{said}");
    fs::create_dir(here.join("out.png")).unwrap();
    let said = relievo(here, "enhance in.0001.exr -o out.png").ended(1);
    assert!(said.contains("out.png: cannot write"), "{said}");
    // A full disk: this one never has room.
    if std::path::Path::new("/dev/full").exists() {
        let said = relievo(here, "enhance in.0001.exr -o /dev/full").ended(2);
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    // A directory that nobody may write to; the superuser may.
    let locked = here.join("locked");
    fs::create_dir(&locked).unwrap();
    fs::set_permissions(&locked, fs::Permissions::from_mode(0o555)).unwrap();
    let output = relievo(
        here,
        "enhance in.####.exr --frames 1-2 -o locked/out.####.exr --keep-going",
    );
    if output.code == Some(0) {
        eprintln!("skipped: this user may write anywhere");
    } else {
        let said = output.ended(1);
        assert_eq!(said.matches("cannot write").count(), 1, "{said}");
    }
    assert_eq!(names(here, ".relievo"), [""; 0]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fills_up_leaves_the_old_file() {
    let desk = desk(1..=1);
    let here = desk.path();
    relievo(here, "enhance in.0001.exr -o out.exr").ended(0);
    let before = bytes(here, "out.exr");
    // No file may exceed 8 KiB: the write fails in the middle.
    let words = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} enhance in.0001.exr -o out.exr --scaling 0.5 --backend cpu",
        env!("CARGO_BIN_EXE_relievo")
    );
    let mut shell = std::process::Command::new("bash");
    let said = Ran::of(shell.args(["-c", &words]).current_dir(here)).ended(1);
    assert!(said.contains("out.exr: cannot write"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(bytes(here, "out.exr") == before);
    assert_eq!(names(here, ".relievo"), [""; 0]);
}

/// Inputs are never overwritten, and no file is written twice, under any spelling.
#[cfg(unix)]
#[test]
fn files_are_compared_and_not_their_names() {
    use std::os::unix::fs::symlink;
    let desk = desk(1..=2);
    let here = desk.path();
    fs::create_dir(here.join("st")).unwrap();
    fs::copy(
        concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/clay.png"),
        here.join("st/1.png"),
    )
    .unwrap();
    fs::hard_link(here.join("in.0002.exr"), here.join("next.0001.exr")).unwrap();
    symlink("st", here.join("links")).unwrap();
    fs::write(
        here.join("look.toml"),
        "version = 1\ncommand = \"enhance\"\n",
    )
    .unwrap();
    let before =
        ["in.0001.exr", "in.0002.exr", "st/1.png", "look.toml"].map(|name| bytes(here, name));
    for (words, found) in [
        (
            "enhance in.0001.exr -o o.png --timings ./o.png",
            "output of -o too",
        ),
        (
            "enhance in.0001.exr -o o.png --save-recipe ./o.png",
            "output of -o too",
        ),
        (
            "enhance in.0001.exr -o o.png --timings x --save-recipe st/../x",
            "output of --timings too",
        ),
        (
            "enhance in.0001.exr -o o.png --timings ./in.0001.exr",
            "is the input",
        ),
        (
            "relight in.0001.exr --light 9,9 --lit-sphere st/1.png -o links/1.png",
            "is the input",
        ),
        ("hatch in.0001.exr --style st -o links/1.png", "lies in st"),
        ("hatch in.0001.exr --style st -o st/new.png", "lies in st"),
        (
            "run look.toml in.0001.exr -o o.png --save-recipe ./look.toml",
            "is the input",
        ),
        // The output of one frame is the input of the next.
        (
            "enhance in.####.exr --frames 1-2 -o next.####.exr",
            "is the input",
        ),
        (
            "enhance in.####.exr --frames 1-2 -o o.####.png --timings ./o.####.png",
            "output of -o too",
        ),
        (
            "hatch in.####.exr --frames 1-2 --motion next.%04d.exr -o next.####.exr",
            "is the input",
        ),
    ] {
        let said = relievo(here, words).ended(2);
        assert!(said.contains(found), "{words}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    let after =
        ["in.0001.exr", "in.0002.exr", "st/1.png", "look.toml"].map(|name| bytes(here, name));
    assert!(before == after);
    assert_eq!(names(here, "o."), [""; 0]);
}

/// An unwritable path is detected before the frame is read: here there is no frame.
#[test]
fn bad_paths_are_found_before_any_work() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    fs::create_dir(here.join("folder.png")).unwrap();
    for flag in ["-o", "--timings", "--save-recipe"] {
        for path in ["none/x.png", "folder.png"] {
            let output = if flag == "-o" { "" } else { "-o o.png" };
            let words = format!("enhance none.exr {output} {flag} {path}");
            let said = relievo(here, &words).ended(1);
            assert!(said.contains("cannot write"), "{words}: {said}");
        }
    }
    assert_eq!(fs::read_dir(here).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn outputs_keep_permissions_and_write_protected_ones_stay() {
    use std::os::unix::fs::PermissionsExt;
    let desk = desk(1..=1);
    let here = desk.path();
    let mode = |mode| fs::set_permissions(here.join("o.png"), fs::Permissions::from_mode(mode));
    let enhance = |rest: &str| relievo(here, &format!("enhance in.0001.exr -o o.png {rest}"));
    enhance("").ended(0);
    mode(0o600).unwrap();
    enhance("--scaling 2").ended(0);
    let is = || {
        fs::metadata(here.join("o.png"))
            .unwrap()
            .permissions()
            .mode()
            & 0o777
    };
    assert_eq!(is(), 0o600);
    mode(0o400).unwrap();
    let before = bytes(here, "o.png");
    let said = enhance("--scaling 3").ended(1);
    assert!(
        said.contains("write-protected; --force replaces it"),
        "{said}"
    );
    assert!(bytes(here, "o.png") == before);
    enhance("--scaling 3 --force").ended(0);
    assert!(bytes(here, "o.png") != before && is() == 0o400);
}

/// Pipes and devices are refused at once, as inputs and where a killed run's leftovers are looked for.
#[cfg(unix)]
#[test]
fn pipes_are_not_waited_for() {
    let desk = desk(1..=1);
    let here = desk.path();
    let pipe = |name: &str| {
        let made = std::process::Command::new("mkfifo")
            .arg(here.join(name))
            .status();
        assert!(
            made.is_ok_and(|status| status.success()),
            "mkfifo is missing"
        );
    };
    pipe("pipe");
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    pipe(&format!(".relievo-{host}-1-abcdef.part"));
    pipe(&format!(".relievo-{host}-abcdef.part"));
    relievo(here, "enhance in.0001.exr -o o.png").ended(0);
    relievo(here, "enhance in.####.exr --frames 1 -o o.####.png").ended(0);
    for words in [
        "enhance pipe -o x.png",
        "inspect pipe",
        "inspect /dev/zero",
        "enhance in.0001.exr --normal pipe -o x.png",
        "enhance in.0001.exr --camera pipe -o x.png",
        "relight in.0001.exr --environment pipe -o x.png",
        "relight in.0001.exr --lit-sphere pipe -o x.png",
        "run pipe in.0001.exr -o x.png",
    ] {
        let said = relievo(here, words).ended(1);
        assert!(said.contains("it is a pipe or a device"), "{words}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    let said = relievo(here, "enhance in.0001.exr -o pipe").ended(2);
    assert!(said.contains("no known extension"), "{said}");
}

/// Where no file can be made, that is said before anything is read: the input does not even exist. /proc takes none,
/// whoever asks.
#[cfg(target_os = "linux")]
#[test]
fn a_folder_that_takes_no_file_is_named_before_any_work() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    fs::write(here.join("file"), "").unwrap();
    for words in [
        "shape none.exr -o /proc/out.png",
        "shape none.exr other.exr -o /proc/",
        "shape none.exr other.exr -o /proc/out",
        "shape none.exr other.exr -o file/out",
        "enhance none.####.exr --frames 1-2 -o /proc/out.####.exr",
        "map none.exr -o /proc/{map}.png --map curvature,edges",
        "hatch none.exr -o out.png --save-recipe /proc/look.toml",
        "relight none.exr -o out.png --timings missing/t.json",
        "report none.exr -o /proc",
        "report none.exr -o /proc/report",
        "report none.exr -o file/report",
    ] {
        let line = relievo(here, words).refused(1);
        let is_said = ["cannot write", "cannot make"]
            .iter()
            .any(|said| line.contains(said));
        assert!(is_said && !line.contains("none.exr"), "{words}: {line}");
    }
    assert_eq!(names(here, ""), ["file"]);
}

/// A full disk loses no help and no list without a word.
#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_an_error() {
    let desk = desk(1..=1);
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
        let full = fs::File::create("/dev/full").unwrap();
        command.args(words.split(' ')).stdout(full);
        let said = Ran::of(&mut command).ended(1);
        assert!(
            said.starts_with("error: stdout: cannot write: "),
            "{words}: {said}"
        );
        assert_eq!(said.lines().count(), 1, "{words}: {said}");
    }
}

/// The library is the program: a request with the settings of a command line saves the same pixels, lines and layers.
#[test]
fn a_request_saves_what_the_program_writes() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    let bust = fixture("bust.exr");
    let engine = Engine::auto();
    for (command, file, settings) in [
        ("enhance", "half.png", "mix=.5 exposure=1 lobes=off"),
        ("enhance", "agx.jpg", "view-transform=agx lobes=off"),
        ("enhance", "strong.exr", "scaling=2 lobes=off"),
        (
            "enhance",
            "sky.png",
            "occlusion=computed scaling-ambient=1 lobes=off",
        ),
        ("relight", "lamp.png", "albedo-from=white"),
        ("relight", "lit.exr", "albedo-from=white method=scale"),
        ("hatch", "page.svg", "style=engraving page=A4"),
        ("hatch", "large.png", "style=lines enlarge=2 mix=.5"),
        ("hatch", "ink.tif", "style=stipple ink=bilevel dpi=200"),
        (
            "hatch",
            "strokes.exr",
            "style=pen tone=relight albedo-from=white",
        ),
        ("shape", "shown.png", "scale=4"),
        ("shape", "layers.exr", "scale=4"),
    ] {
        let mut params = Params::default();
        let computes_occlusion = settings.contains("occlusion=computed");
        let mut words = format!("{command} {} -o {file} --layers results", bust.display());
        for (name, value) in settings.split(' ').filter_map(|one| one.split_once('=')) {
            let is_set = name == "occlusion" || params.set(name, value).unwrap();
            assert!(is_set, "{name}");
            words += &format!(" --{name} {value}");
        }
        if file.ends_with("exr") && matches!(command, "enhance" | "relight") {
            words += " --depth-of-output float";
        }
        relievo(here, &words).ended(0);
        let inputs = Inputs {
            picture: bust.clone(),
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
        let saved = here.join(format!("saved_{file}"));
        outcome.save(&saved, &frame).unwrap();
        let [made, saved] = [here.join(file), saved];
        match file.rsplit_once('.').unwrap().1 {
            "svg" => assert_eq!(fs::read(&made).unwrap(), fs::read(&saved).unwrap()),
            "exr" => {
                let names = |path| {
                    let file = ExrFile::open(path, &Default::default()).unwrap();
                    let channels = file.parts[0].channels.iter();
                    channels.map(|c| c.name.clone()).collect::<Vec<_>>()
                };
                assert_eq!(names(&made), names(&saved), "{words}");
                for name in names(&made) {
                    let [a, b] = [&made, &saved].map(|path| bits(&channel(path, &name)));
                    assert!(a == b, "{words}: {name}");
                }
            }
            _ => {
                let [a, b] = [&made, &saved].map(|path| Photo::read(path).unwrap());
                assert!(a.channels == b.channels && a.alpha == b.alpha, "{words}");
            }
        }
    }
}
