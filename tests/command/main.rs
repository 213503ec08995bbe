//! Everything that runs the program, as a user or a farm does.

#[path = "../common/mod.rs"]
mod common;

mod cli;
mod colors;
mod conformance;
#[cfg(unix)]
mod corpus;
mod dependencies;
mod hatch;
mod moving_strokes;
mod names;
mod numbers;
mod outputs;
mod photos;
mod readme;
mod recipes;
mod relight;
mod report;
mod sequences;
mod specular;
#[cfg(unix)]
mod stops;
mod strips;
mod threads;

use relievo::frame::{ColorPlanes, Plane, Window};
use relievo::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use std::fs;
use std::io::BufWriter;
use std::path::Path;
use std::process::{Command, Output};

/// Writes frame `number`: bumps under a light of this luminance, `size` pixels on a side.
fn write_frame(directory: &Path, number: i32, size: usize, luminance: f32) {
    let path = directory.join(format!("in.{number:04}.exr"));
    write_bumps(&path, number, [size, size], luminance, |_| false);
}

/// Writes bumps that are a plane in some rows.
fn write_bumps(
    path: &Path,
    number: i32,
    [width, height]: [usize; 2],
    luminance: f32,
    is_plane: impl Fn(usize) -> bool,
) {
    // z = cos(x) cos(y) with a period of 24 px: slopes are its derivatives, up to 0.5.
    let wave = |x: usize| x as f32 * std::f32::consts::TAU / 24.0 + number as f32;
    let normal = |x: usize, y: usize| {
        if is_plane(y) {
            return glam::Vec3::Z;
        }
        let (x, y) = (wave(x), wave(y));
        glam::Vec3::new(0.5 * x.sin() * y.cos(), -0.5 * x.cos() * y.sin(), 1.0).normalize()
    };
    let plane = |value: &dyn Fn(usize, usize) -> f32| Plane::from_fn(width, height, value);
    let lit = plane(&|x, y| luminance * normal(x, y).z);
    let channels = [
        ("R", lit.clone()),
        ("G", lit.clone()),
        ("B", lit),
        ("N.X", plane(&|x, y| normal(x, y).x)),
        ("N.Y", plane(&|x, y| normal(x, y).y)),
        ("N.Z", plane(&|x, y| normal(x, y).z)),
        ("Z", plane(&|_, _| 5.0)),
    ];
    write_part(path, &channels, Part::default());
}

/// A picture of these planes, by the extension of its name.
fn write_planes(
    path: &Path,
    [r, g, b]: [Plane; 3],
    alpha: Option<&Plane>,
    bits: u8,
    transform: ViewTransform,
) {
    let picture = Picture {
        color: &ColorPlanes { r, g, b },
        alpha,
        grey: false,
        bits,
        transform,
    };
    let format = PictureFormat::of_path(path).unwrap();
    write_atomically(path, Replace::IfWritable, |w| {
        write_picture(w, path, format, &picture)
    })
    .unwrap();
}

/// What a part of a file has beside its channels.
#[derive(Default)]
struct Part {
    chromaticities: Option<[f32; 8]>,
}

fn write_part(path: &Path, channels: &[(&str, Plane)], part: Part) {
    let window = Window::from_size(channels[0].1.width(), channels[0].1.height());
    let channels = channels.iter().map(|(name, plane)| OutputChannel {
        name: (*name).into(),
        plane,
        sample_type: OutputType::Float,
    });
    let part = OutputPart {
        name: "shot".into(),
        data_window: window,
        display_window: window,
        pixel_aspect: 1.0,
        channels: channels.collect(),
        attributes: Vec::new(),
        chromaticities: part.chromaticities,
        compression: Default::default(),
    };
    let mut file = BufWriter::new(fs::File::create(path).unwrap());
    write_results(&mut file, path, &part).unwrap();
}

/// A desk with frames of these numbers, each of its own brightness.
fn desk(numbers: std::ops::RangeInclusive<i32>) -> tempfile::TempDir {
    let desk = tempfile::tempdir().unwrap();
    for number in numbers {
        write_frame(desk.path(), number, 64, 0.5 + 0.1 * number as f32);
    }
    desk
}

fn relievo(directory: &Path, words: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relievo"))
        .args(words.split_whitespace())
        .current_dir(directory)
        // Mesa's choice of a device writes lines of its own to stderr.
        .env("NODEVICE_SELECT", "1")
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// What was said by a run that ended with `code`.
#[track_caller]
fn ended(output: Output, code: i32) -> String {
    let said = said(&output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

fn bytes(directory: &Path, name: &str) -> Vec<u8> {
    fs::read(directory.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Names in a directory that begin so.
fn names(directory: &Path, begin: &str) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.starts_with(begin)).collect();
    names.sort();
    names
}
