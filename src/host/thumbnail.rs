//! Small pictures, for notebooks and lists.

use crate::error::Result;
use crate::io::picture::{
    Encoding, Picture, PictureFormat, ViewTransform, small, write_picture_as,
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
    size: [usize; 2],
    at: impl Fn(usize, usize, usize) -> f32,
    is_linear: bool,
) -> Result<Vec<u8>> {
    let color = small(size, LONGEST, at);
    let picture = Picture::of(
        &color,
        match is_linear {
            true => ViewTransform::Srgb,
            false => ViewTransform::None,
        },
    );
    let mut png = Cursor::new(Vec::new());
    let name = Path::new("thumbnail.png");
    let encoding = Encoding::default();
    write_picture_as(&mut png, name, PictureFormat::Png, &picture, &encoding)?;
    Ok(png.into_inner())
}
