//! Memory needed for a frame, estimated from headers alone.

use super::exr::{ExrFile, Limits};
use super::photo::StoredPhoto;
use std::path::Path;

/// Lower bound of the estimate, in bytes per pixel while a frame is made. Measured with 16 channels, the program included:
/// at 1920x1080 `enhance` 69, `shape` 75, `relight` 86, drawings 119; at 3840x2160 43, 58, 66, 62. A strip of `shape`
/// holds all its layers at once: 83.
const LEAST_PER_PIXEL: u64 = 100;

/// Bytes per pixel for a file without light passes, excluding its channels.
const WORK_PER_PIXEL: u64 = 60;

/// Bytes per pixel of a scale beyond the first. Measured with `shape --scale 2,4,8`: 14; in a strip, which holds the
/// curvature of all scales at once, 28.
const SCALE_PER_PIXEL: u64 = 20;

/// Approximate memory for processing the picture `path`, with `more_scales` scales beyond the first; 0 if the header
/// does not tell.
pub(crate) fn frame_bytes(path: &Path, more_scales: usize) -> u64 {
    let scales = SCALE_PER_PIXEL * more_scales as u64;
    let pixels = |width: usize, height: usize| width as u64 * height as u64;
    let of_exr = || {
        let file = ExrFile::open(path, &Limits::default()).ok()?;
        let parts = file.parts.iter().map(|part| part.window);
        let largest = parts.map(|w| pixels(w.width(), w.height())).max()?;
        // All channels may be light passes that are scaled separately.
        let channels = file.channel_ids().count() as u64;
        let per_pixel = LEAST_PER_PIXEL.max(WORK_PER_PIXEL + 4 * channels);
        Some(largest.saturating_mul(per_pixel + scales))
    };
    let of_photo = || {
        let photo = StoredPhoto::open(path, u64::MAX).ok()?;
        Some(
            pixels(photo.header.width, photo.header.height)
                .saturating_mul(LEAST_PER_PIXEL + scales),
        )
    };
    of_exr().or_else(of_photo).unwrap_or(0)
}

/// Most memory that blocks of the picture `path` take while it is read; 0 for a photo, and if the header does not tell.
pub(crate) fn decoding_bytes(path: &Path) -> u64 {
    let file = ExrFile::open(path, &Limits::default());
    file.map_or(0, |file| file.decoding_bytes())
}
