//! Small pictures, for notebooks and lists.

use crate::error::Result;
use crate::frame::{ColorPlanes, Plane};
use crate::io::picture::{
    Display, Encoding, Picture, PictureFormat, ViewTransform, write_picture_as,
};
use std::io::Cursor;
use std::path::Path;

/// The longest side of a small picture, in pixels.
const LONGEST: usize = 512;

/// A small picture of `size` samples, columns by rows, as a PNG: `at` gives the sample at a column and a row, of red,
/// green or blue, linear or as it is to be shown.
///
/// # Errors
/// Any [`crate::Error`] of encoding.
pub fn thumbnail(
    [width, height]: [usize; 2],
    at: impl Fn(usize, usize, usize) -> f32,
    is_linear: bool,
) -> Result<Vec<u8>> {
    let step = width.max(height).div_ceil(LONGEST).max(1);
    let mean = |x: usize, y: usize, c: usize| {
        let (rows, columns) = (
            y * step..((y + 1) * step).min(height),
            x * step..((x + 1) * step).min(width),
        );
        let count = rows.len() * columns.len();
        let samples = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        samples.map(|(x, y)| at(x, y, c)).sum::<f32>() / count as f32
    };
    let channel = |c| {
        Plane::from_fn(width.div_ceil(step), height.div_ceil(step), |x, y| {
            mean(x, y, c)
        })
    };
    let color = ColorPlanes {
        r: channel(0),
        g: channel(1),
        b: channel(2),
    };
    let picture = Picture {
        color: &color,
        alpha: None,
        grey: false,
        bits: 8,
        dpi: None,
        transform: match is_linear {
            true => ViewTransform::Srgb,
            false => ViewTransform::None,
        },
        display: Display::default(),
    };
    let mut png = Cursor::new(Vec::new());
    let name = Path::new("thumbnail.png");
    write_picture_as(
        &mut png,
        name,
        PictureFormat::Png,
        &picture,
        &Encoding::default(),
    )?;
    Ok(png.into_inner())
}
