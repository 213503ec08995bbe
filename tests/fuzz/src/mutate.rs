//! Command lines altered as command lines: whole words, real flags, hostile values.

use arbitrary::{Arbitrary, Result, Unstructured};
use clap::{Arg, Command};
use libfuzzer_sys::fuzzer_mutate;
use std::sync::LazyLock;

/// Which flags are added.
#[derive(Clone, Copy, PartialEq)]
pub enum Flags {
    /// Flags of any command.
    Any,
    /// Flags of `relight` that name no file.
    Light,
}

static PROGRAM: LazyLock<Command> = LazyLock::new(|| {
    let mut program = relievo::cli::command();
    program.build();
    program
});

const COMMANDS: &str = "shape enhance relight hatch map inspect run";

/// Names on the desk of `targets`, in several spellings, and one that does not exist.
const PATHS: &str = "frame.exr ./frame.exr sub/../frame.exr link.exr astray.exr spoiled.exr wild.exr torn.exr \
    shot.####.exr shot.%04d.exr shot.0001.exr plain.png photo.jpg scan.tif sky.hdr ball.png camera.json look.toml \
    extra ./extra st st/1.png sub pipe absent.exr N Z";

/// Names of outputs.
const OUTPUTS: &str = "out.exr out.png out.jpg out.tif out.hdr out.svg out.####.exr sub/out.exr OUT.EXR out \
    frame.exr ./plain.png st/1.png pipe";

/// Numbers that break formulas; the last is none.
const NUMBERS: &str = "0 -0 1 -1 2 0.5 1e-300 1e300 1e-30 1e30 1e-7 65504 65505 1e38 3.5e38 -1e38 nan inf -inf \
    1e999 90 180 100000 65535 4294967295 4294967296 ";

/// Numbers that JSON can hold.
const IN_JSON: &str = "1e-300 1e300 -1e300 1e-45 1e38 1e39 0 -0.0 5e-324 1.7e308 1 12 -7";

const LISTS: &str = "1-3 1 1-9y1 1-3x2 3-1 2: -5--1 1-100000 1,1 0-4294967296 1-3x0";

const WORDS: &str = "auto none '' - -- -q N=1,2 \u{1b}[31m \u{202e}x \u{e9} 0.3mm";

/// One of some words.
fn one(words: &str, u: &mut Unstructured) -> Result<String> {
    let words: Vec<&str> = words.split(' ').collect();
    Ok((*u.choose(&words)?).into())
}

/// Mutates the command line in the first `size` bytes of `data`, within `data`; returns the new size.
pub fn words(data: &mut [u8], size: usize, seed: u32, flags: Flags) -> usize {
    let room = data.len();
    if seed.is_multiple_of(32) {
        return fuzzer_mutate(data, size, room);
    }
    let noise = noise(seed);
    let altered = altered(&data[..size], &mut Unstructured::new(&noise), flags);
    let altered = altered.unwrap_or_default();
    let size = altered.len().min(room);
    data[..size].copy_from_slice(&altered[..size]);
    size
}

/// Pseudo-random bytes (xorshift), the same for every run with one seed.
fn noise(seed: u32) -> Vec<u8> {
    let mut state = u64::from(seed) << 1 | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    (0..256).flat_map(|_| next().to_le_bytes()).collect()
}

fn altered(data: &[u8], u: &mut Unstructured, flags: Flags) -> Result<Vec<u8>> {
    let (words, extra) = match data.windows(2).position(|pair| pair == b"\n\n") {
        Some(end) => (&data[..end], data[end + 2..].to_vec()),
        None => (data, Vec::new()),
    };
    let lines = words.split(|&b| b == b'\n').filter(|line| !line.is_empty());
    let mut lines: Vec<Vec<u8>> = lines.map(<[u8]>::to_vec).collect();
    for _ in 0..u.int_in_range(1..=4)? {
        alter_words(&mut lines, u, flags)?;
    }
    let extra = match u.int_in_range(0..=3)? {
        0 => camera(u)?.into_bytes(),
        1 if flags == Flags::Any => recipe(u)?.into_bytes(),
        2 if u.ratio(1, 4)? => spoiled(extra, u)?,
        _ => extra,
    };
    Ok([lines.join(&b'\n'), b"\n\n".to_vec(), extra].concat())
}

/// Longer command lines fail for one reason or another.
const MOST_WORDS: usize = 12;

fn alter_words(lines: &mut Vec<Vec<u8>>, u: &mut Unstructured, flags: Flags) -> Result<()> {
    if lines.is_empty() && flags == Flags::Any || lines.len() > MOST_WORDS {
        *lines = match flags {
            Flags::Any => begun(u)?,
            Flags::Light => Vec::new(),
        };
    }
    match u.int_in_range(0..=15)? {
        0..=3 if !lines.is_empty() => {
            let at = u.choose_index(lines.len())?;
            lines.remove(at);
        }
        4 if flags == Flags::Any => *lines = begun(u)?,
        5 if flags == Flags::Any && !lines.is_empty() => {
            let at = u.choose_index(lines.len())?;
            lines[at] = value(u)?.into_bytes();
        }
        6 if !lines.is_empty() => {
            let at = u.choose_index(lines.len())?;
            lines[at] = spoiled(std::mem::take(&mut lines[at]), u)?;
        }
        _ => {
            let command = match (flags, lines.first()) {
                (Flags::Any, Some(word)) => String::from_utf8_lossy(word).into_owned(),
                _ => "relight".into(),
            };
            lines.extend(flag(&command, flags, u)?);
        }
    }
    Ok(())
}

/// A command line that can work.
fn begun(u: &mut Unstructured) -> Result<Vec<Vec<u8>>> {
    let from = if u.ratio(2, 3)? { "frame.exr" } else { PATHS };
    let to = if u.ratio(1, 2)? { "out.exr" } else { OUTPUTS };
    let words = [COMMANDS, from, "-o", to].into_iter();
    words.map(|word| Ok(one(word, u)?.into_bytes())).collect()
}

/// A flag of `command` with a value, usually a valid one.
fn flag(command: &str, flags: Flags, u: &mut Unstructured) -> Result<Vec<Vec<u8>>> {
    let command = PROGRAM.find_subcommand(command).unwrap_or(&PROGRAM);
    let arguments = command.get_arguments();
    let named = arguments.filter(|arg| arg.get_long().is_some());
    let named = named.filter(|arg| flags == Flags::Any || !names_a_file(arg));
    let named: Vec<_> = named.collect();
    if named.is_empty() {
        return Ok(Vec::new());
    }
    let arg = u.choose(&named)?;
    let mut words = vec![format!("--{}", arg.get_long().unwrap_or_default())];
    if arg.get_action().takes_values() {
        words.push(value_of(arg, u)?);
    }
    // In one word a value may begin with a hyphen, and both are removed together.
    if flags == Flags::Light || u.ratio(1, 2)? {
        words = vec![words.join("=")];
    }
    Ok(words.into_iter().map(String::into_bytes).collect())
}

fn value_name(arg: &Arg) -> String {
    arg.get_value_names().unwrap_or_default().join(" ")
}

fn names_a_file(arg: &Arg) -> bool {
    let name = value_name(arg);
    let files = ["FILE", "DIR", "LIST", "JSON"];
    files.iter().any(|file| name.contains(file))
}

fn value_of(arg: &Arg, u: &mut Unstructured) -> Result<String> {
    let possible = arg.get_possible_values();
    let name = value_name(arg);
    let commas = |end| {
        name.split(end)
            .next()
            .unwrap_or_default()
            .matches(',')
            .count()
    };
    let is_written = ["output", "save-recipe", "timings"]
        .map(Some)
        .contains(&arg.get_long());
    Ok(match () {
        () if u.ratio(1, 20)? => value(u)?,
        () if !possible.is_empty() => u.choose(&possible)?.get_name().into(),
        () if is_written => one(OUTPUTS, u)?,
        () if name.contains("LIST") => one(LISTS, u)?,
        () if names_a_file(arg) => one(PATHS, u)?,
        // As many numbers as in the name of the value.
        () => {
            let count = u.int_in_range(commas('[')..=commas('|'))? + 1;
            let numbers: Result<Vec<_>> = (0..count).map(|_| number(u)).collect();
            numbers?.join(",")
        }
    })
}

/// Any value.
fn value(u: &mut Unstructured) -> Result<String> {
    match u.int_in_range(0..=5)? {
        0 => one(PATHS, u),
        1 => one(OUTPUTS, u),
        2 => one(LISTS, u),
        3 => one(WORDS, u),
        _ => number(u),
    }
}

/// A number: ordinary, hostile, or of any bits.
fn number(u: &mut Unstructured) -> Result<String> {
    Ok(match u.int_in_range(0..=7)? {
        0 => f32::arbitrary(u)?.to_string(),
        1 | 2 => u.int_in_range(0..=100)?.to_string(),
        3 | 4 => (f32::from(u8::arbitrary(u)?) / 255.0).to_string(),
        _ => one(NUMBERS, u)?,
    })
}

/// A number representable in JSON.
fn json_number(u: &mut Unstructured) -> Result<String> {
    Ok(match u.int_in_range(0..=2)? {
        0 => match f64::arbitrary(u)? {
            finite if finite.is_finite() => format!("{finite:e}"),
            _ => "30".into(),
        },
        1 => u.int_in_range(1..=100)?.to_string(),
        _ => one(IN_JSON, u)?,
    })
}

/// A camera file: well-formed, with hostile numbers.
fn camera(u: &mut Unstructured) -> Result<String> {
    let lens = one("intrinsics_px focal_px pixels_per_unit", u)?;
    let pair = ["principal_point_px", "resolution"];
    let mut keys = Vec::new();
    for (key, form, is_there) in [
        (&lens[..], "#", lens != "intrinsics_px"),
        (
            &lens,
            "{\"fx\": #, \"fy\": #, \"cx\": #, \"cy\": #}",
            lens == "intrinsics_px",
        ),
        (pair[0], "[#, #]", u.ratio(1, 3)?),
        (pair[1], "[#, #]", u.ratio(1, 3)?),
        (
            "camera_type",
            &format!("\"{}\"", one("PERSP ORTHO PANO ", u)?),
            u.ratio(1, 3)?,
        ),
        (
            "world_to_camera",
            MATRICES[usize::from(u.ratio(3, 4)?)],
            u.ratio(1, 2)?,
        ),
    ] {
        if is_there {
            keys.push(format!("\"{key}\": {}", with_numbers(form, u)?));
        }
    }
    Ok(format!("{{{}}}", keys.join(", ")))
}

/// Any sixteen numbers; a frame that is scaled by one number, `@`, and moved.
const MATRICES: [&str; 2] = [
    "[[#, #, #, #], [#, #, #, #], [#, #, #, #], [#, #, #, #]]",
    "[[@, 0, 0, #], [0, @, 0, #], [0, 0, @, #], [0, 0, 0, 1]]",
];

/// The text with a number for each `#`, and one for all `@`.
fn with_numbers(form: &str, u: &mut Unstructured) -> Result<String> {
    let mut text = form.replace('@', &json_number(u)?);
    while text.contains('#') {
        text = text.replacen('#', &json_number(u)?, 1);
    }
    Ok(text)
}

/// A recipe with some settings of its command.
fn recipe(u: &mut Unstructured) -> Result<String> {
    let name = one("shape enhance relight hatch report", u)?;
    let mut text = format!("version = 1\ncommand = \"{name}\"\n");
    for _ in 0..u.int_in_range(0..=4)? {
        let flag = flag(&name, Flags::Any, u)?;
        let mut flag = flag.iter().map(|word| String::from_utf8_lossy(word));
        let key = flag.next().unwrap_or_default();
        let value = flag.next().unwrap_or_else(|| "true".into());
        let quote = if u.ratio(1, 2)? { "\"" } else { "" };
        text += &format!("{} = {quote}{value}{quote}\n", key.trim_start_matches('-'));
    }
    Ok(text)
}

/// The bytes with a few changed, cut or added.
fn spoiled(mut bytes: Vec<u8>, u: &mut Unstructured) -> Result<Vec<u8>> {
    if bytes.is_empty() || u.ratio(1, 8)? {
        bytes.extend(u.bytes(4)?);
    }
    for _ in 0..u.int_in_range(1..=3)? {
        let at = u.choose_index(bytes.len())?;
        let any = u8::arbitrary(u)?;
        bytes[at] = *u.choose(&[0, 0x1b, b'-', b'0', b'9', b'e', b'#', 0x7f, 0xff, any])?;
    }
    if u.ratio(1, 8)? {
        bytes.truncate(u.choose_index(bytes.len())?);
    }
    Ok(bytes)
}
