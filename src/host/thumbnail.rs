//! Small pictures, for notebooks and lists.

use crate::error::Result;
use crate::io::picture::{ViewTransform, small_png};

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
    let transform = match is_linear {
        true => ViewTransform::Srgb,
        false => ViewTransform::None,
    };
    small_png(size, LONGEST, at, transform)
}
