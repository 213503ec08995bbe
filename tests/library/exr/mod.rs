//! OpenEXR files: round trips, rows on demand, strips, parts and channels added, files with false claims.

mod channels;
mod claims;
mod infinities;
mod rows;

use crate::prelude::*;
use relievo::io::exr::{
    ChannelId, ExrFile, Limits, Merged, OutputChannel, OutputPart, OutputType, PartWriter,
    write_results,
};
use std::io::Cursor;
use std::ops::Range;
use std::path::{Path, PathBuf};

const TARGET: &str = "test";

/// Three planes whose height is not a multiple of a block's, one with a NaN sample.
fn planes() -> [Plane; 3] {
    let mut ramp = Plane::from_fn(23, 71, |x, y| (x as f32 - 3.7) * y as f32);
    ramp.samples_mut()[40] = f32::NAN;
    let waves = Plane::from_fn(23, 71, |x, y| (0.3 * x as f32).sin() + 0.1 * y as f32);
    let half = waves.map(|v| half::f16::from_f32(v).to_f32());
    [ramp, waves, half]
}

/// A part of these channels.
fn part_of<'a>(
    name: &str,
    window: Window,
    channels: &[(&str, &'a Plane, OutputType)],
) -> OutputPart<'a> {
    let channel = |&(name, plane, sample_type): &(&str, &'a Plane, OutputType)| OutputChannel {
        name: name.into(),
        plane,
        sample_type,
    };
    OutputPart {
        name: name.into(),
        data_window: window,
        display_window: Window::from_size(40, 30),
        pixel_aspect: 1.5,
        channels: channels.iter().map(channel).collect(),
        attributes: vec![("software".into(), "relievo test".into())],
        chromaticities: Some([0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]),
        compression: Default::default(),
    }
}

fn part(planes: &[Plane; 3]) -> OutputPart<'_> {
    use OutputType::{Float, Half};
    let [b, c, a] = planes;
    let channels = [("b.Z", b, Float), ("c.Z", c, Float), ("a.Z", a, Half)];
    part_of("strips", Window::at(-4, 9, 23, 71), &channels)
}

fn whole(part: &OutputPart) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    write_results(&mut file, Path::new(TARGET), part).unwrap();
    file.into_inner()
}

/// The file with a part added.
fn appended(input: &ExrFile, part: &OutputPart) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let writer = PartWriter::append(input, &mut file, Path::new(TARGET), &part.description());
    writer.unwrap().write(part).unwrap();
    file.into_inner()
}

/// The file with the channels of a part added to one of its own.
fn merged(input: &ExrFile, index: usize, part: &OutputPart) -> (Vec<u8>, Merged) {
    let (mut file, target) = (Cursor::new(Vec::new()), Path::new(TARGET));
    let added = PartWriter::add_channels(input, index, &mut file, target, &part.description());
    let (writer, merged) = added.unwrap();
    writer.write(part).unwrap();
    (file.into_inner(), merged)
}

/// A folder for bytes, to be read as a file.
struct Saved(tempfile::TempDir);

impl Saved {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn of(&self, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join("saved.exr");
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

/// Saves `bytes`, and opens them.
fn saved(bytes: &[u8], limits: &Limits) -> (Saved, ExrFile) {
    let saved = Saved::new();
    let file = ExrFile::open(&saved.of(bytes), limits).unwrap();
    (saved, file)
}

fn open(path: &Path) -> ExrFile {
    ExrFile::open(path, &Limits::default()).unwrap()
}

fn ids(file: &ExrFile) -> Vec<ChannelId> {
    file.channel_ids().collect()
}

fn read_all(file: &ExrFile) -> Vec<Plane> {
    file.read_channels(&ids(file)).unwrap()
}

/// Real files of these names, that are there.
fn files(names: &str) -> impl Iterator<Item = PathBuf> {
    names
        .split_whitespace()
        .filter_map(|name| real(&format!("{name}.exr")))
}

/// Rows of 0..`height`, cut into strips of the given heights in turn.
fn cuts(height: usize, heights: &[usize]) -> Vec<Range<usize>> {
    let mut cuts = Vec::new();
    let mut heights = heights.iter().cycle();
    let mut next = 0;
    while next < height {
        let end = height.min(next + heights.next().unwrap());
        cuts.push(next..end);
        next = end;
    }
    cuts
}

/// Pushes the planes in strips: each once as rows of the whole planes, and once as planes of its own.
fn push_in_strips<W: std::io::Write + std::io::Seek>(
    mut writer: PartWriter<W>,
    planes: &[Plane; 3],
    heights: &[usize],
) {
    for (i, rows) in cuts(planes[0].height(), heights).into_iter().enumerate() {
        let strip = |plane: &Plane| {
            let at = |x, y| plane.at(x, rows.start + y);
            Plane::from_fn(plane.width(), rows.len(), at)
        };
        let pushed = match i % 2 {
            0 => writer.push(&planes.each_ref(), rows),
            _ => writer.push(&planes.each_ref().map(strip).each_ref(), 0..rows.len()),
        };
        pushed.unwrap();
    }
    writer.finish().unwrap();
}

const HEIGHTS: [&[usize]; 6] = [&[1], &[16], &[7], &[64, 3], &[15, 2, 30], &[1000]];
