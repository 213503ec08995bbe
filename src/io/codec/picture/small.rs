//! Small versions of pictures.

use super::{Encoding, Picture, PictureFormat, ViewTransform, write_picture_as};
use crate::error::Result;
use crate::frame::{ColorPlanes, Plane};
use std::io::Cursor;
use std::path::Path;

/// A picture of `size`, columns by rows, made so small that no side is longer than `longest`: each pixel is the mean of a
/// square. `at` gives the sample at a column and a row, of red, green or blue.
pub(crate) fn small(
    [width, height]: [usize; 2],
    longest: usize,
    at: impl Fn(usize, usize, usize) -> f32,
) -> ColorPlanes {
    let step = width.max(height).div_ceil(longest).max(1);
    let mean = |x: usize, y: usize, c: usize| {
        let [columns, rows] =
            [(x, width), (y, height)].map(|(at, end)| at * step..((at + 1) * step).min(end));
        let count = rows.len() * columns.len();
        let samples = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        samples.map(|(x, y)| at(x, y, c)).sum::<f32>() / count as f32
    };
    let [width, height] = [width, height].map(|side| side.div_ceil(step));
    let channel = |c| Plane::from_fn(width, height, |x, y| mean(x, y, c));
    ColorPlanes::of((0..3).map(channel).collect())
}

/// The same as a PNG.
///
/// # Errors
/// Any [`crate::Error`] of encoding.
pub(crate) fn small_png(
    size: [usize; 2],
    longest: usize,
    at: impl Fn(usize, usize, usize) -> f32,
    transform: ViewTransform,
) -> Result<Vec<u8>> {
    let color = small(size, longest, at);
    let (mut png, name) = (Cursor::new(Vec::new()), Path::new("small.png"));
    let (picture, encoding) = (Picture::of(&color, transform), Encoding::default());
    write_picture_as(&mut png, name, PictureFormat::Png, &picture, &encoding)?;
    Ok(png.into_inner())
}
