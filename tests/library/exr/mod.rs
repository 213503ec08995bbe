//! OpenEXR files: rows on demand, strips, channels added to a part.

mod channels;
mod infinities;
mod rows;

use crate::common::bits;
use relievo::frame::{Plane, Window};
use relievo::io::exr::{
    ExrFile, Limits, OutputChannel, OutputPart, OutputType, PartWriter, write_results,
};
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

const TARGET: &str = "test";

/// Three planes whose height is not a multiple of a block's, one with a NaN sample.
fn planes() -> [Plane; 3] {
    let mut ramp = Plane::from_fn(23, 71, |x, y| (x as f32 - 3.7) * y as f32);
    ramp.samples_mut()[40] = f32::NAN;
    let waves = Plane::from_fn(23, 71, |x, y| (0.3 * x as f32).sin() + 0.1 * y as f32);
    let half = waves.map(|v| half::f16::from_f32(v).to_f32());
    [ramp, waves, half]
}

fn part(planes: &[Plane; 3]) -> OutputPart<'_> {
    let channels = [
        ("b.Z", OutputType::Float),
        ("c.Z", OutputType::Float),
        ("a.Z", OutputType::Half),
    ];
    OutputPart {
        name: "strips".into(),
        data_window: Window::at(-4, 9, 23, 71),
        display_window: Window::from_size(30, 80),
        pixel_aspect: 1.0,
        channels: channels
            .into_iter()
            .zip(planes)
            .map(|((name, sample_type), plane)| OutputChannel {
                name: name.into(),
                plane,
                sample_type,
            })
            .collect(),
        attributes: vec![("software".into(), "relievo test".into())],
        chromaticities: None,
        compression: Default::default(),
    }
}

fn whole(part: &OutputPart) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    write_results(&mut file, Path::new(TARGET), part).unwrap();
    file.into_inner()
}

/// Saves `bytes`, and opens them.
fn saved(bytes: &[u8], limits: &Limits) -> (tempfile::TempDir, ExrFile) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.exr");
    std::fs::write(&path, bytes).unwrap();
    let file = ExrFile::open(&path, limits).unwrap();
    (directory, file)
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
        let pushed = match i % 2 {
            0 => writer.push(&planes.each_ref(), rows),
            _ => {
                let strips = planes.each_ref().map(|plane| {
                    Plane::from_fn(plane.width(), rows.len(), |x, y| {
                        plane.at(x, rows.start + y)
                    })
                });
                writer.push(&strips.each_ref(), 0..rows.len())
            }
        };
        pushed.unwrap();
    }
    writer.finish().unwrap();
}

const HEIGHTS: [&[usize]; 6] = [&[1], &[16], &[7], &[64, 3], &[15, 2, 30], &[1000]];
