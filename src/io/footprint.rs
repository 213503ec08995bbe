//! How much memory a frame takes, told from headers alone.

use super::exr::{ExrFile, Limits};
use std::path::Path;

/// Bytes per pixel of what is in memory while a frame is made: some fifty planes of 32-bit floats.
const BYTES_PER_PIXEL: u64 = 200;

/// About how much memory it takes to make something of the picture `path`; 0 where it cannot be told.
pub fn frame_bytes(path: &Path) -> u64 {
    let pixels = |width: usize, height: usize| width as u64 * height as u64;
    let of_exr = || {
        let file = ExrFile::open(path, &Limits::default()).ok()?;
        let parts = file.parts.iter().map(|part| part.window);
        parts.map(|w| pixels(w.width(), w.height())).max()
    };
    let of_photo = || {
        let (width, height) = image::image_dimensions(path).ok()?;
        Some(pixels(width as usize, height as usize))
    };
    let found = of_exr().or_else(of_photo);
    found.unwrap_or(0).saturating_mul(BYTES_PER_PIXEL)
}
