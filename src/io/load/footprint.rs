//! Memory needed for a frame, estimated from headers alone.

use super::bundle::RoleBundle;
use super::opened::{Opened, OpenedKind};
use super::surroundings::place_in;
use crate::error::Result;
use crate::frame::Window;
use crate::io::exr::{ExrFile, Limits};
use std::path::Path;

/// Memory taken whatever the picture is: the program, histograms. Measured: 17 to 22 MiB in all, with strips of a few
/// rows.
const FIXED_BYTES: u64 = 24 << 20;

/// The same for each thread: tiles, and lights of a batch.
const THREAD_BYTES: u64 = 2 << 20;

/// Memory taken whatever the picture is, with as many threads as there are.
pub(crate) fn program_bytes() -> u64 {
    FIXED_BYTES + rayon::current_num_threads() as u64 * THREAD_BYTES
}

/// Lower bound of the estimate, in bytes per pixel while a frame is made. Measured with 16 channels, the program included:
/// at 1920x1080 `enhance` 54, `shape` 70, `relight` 71, drawings 82; at 3840x2160 48, 58, 64, 64. A strip of `shape`
/// holds all its layers at once: 83.
const LEAST_PER_PIXEL: u64 = 100;

/// Bytes per pixel for a file without light passes, excluding its channels.
const WORK_PER_PIXEL: u64 = 60;

/// Bytes per pixel of a scale beyond the first. Measured with `shape --scale 2,4,8`: 14; in a strip, which holds the
/// curvature of all scales at once, 28.
const SCALE_PER_PIXEL: u64 = 20;

/// Bytes per pixel of a tile itself, beside the frame that repeats it. Measured with all maps of a normal map of 8
/// megapixels: 11 beyond [`LEAST_PER_PIXEL`].
const TILE_PER_PIXEL: u64 = 25;

/// Pixels around a tile that are run with it, repeated: as far as gaps, the steps of the finest scale and normal rays read.
const TILE_BORDER_PX: u64 = 48;

/// Approximate memory for processing the picture `path` beside [`program_bytes`], with `more_scales` scales beyond the
/// first, and borders that may be joined; 0 if the header does not tell.
pub(crate) fn frame_bytes(path: &Path, more_scales: usize, may_wrap: bool) -> u64 {
    let scales = SCALE_PER_PIXEL * more_scales as u64;
    // All channels may be light passes that are scaled separately.
    let of = |size: PictureSize| {
        let per_pixel = LEAST_PER_PIXEL.max(WORK_PER_PIXEL + 4 * size.channels);
        let run = |pixels: u64| pixels.saturating_mul(per_pixel + scales);
        match may_wrap {
            true => run(size.repeated).saturating_add(size.pixels.saturating_mul(TILE_PER_PIXEL)),
            false => run(size.pixels),
        }
    };
    picture_size(path).map_or(0, of)
}

/// The size of a picture.
pub(crate) struct PictureSize {
    /// Those of the largest part.
    pub(crate) pixels: u64,
    /// The same where it is a tile, with its repetition.
    repeated: u64,
    /// The pixels meant to be shown.
    pub(crate) display_window: Window,
    /// Width of a pixel over its height.
    pub(crate) pixel_aspect: f32,
    channels: u64,
}

/// The size of the picture `path`; `None` if its header does not tell.
pub(crate) fn picture_size(path: &Path) -> Option<PictureSize> {
    let with_border = |window: &Window, border: u64| {
        let [width, height] =
            [window.width(), window.height()].map(|side| side as u64 + 2 * border);
        width * height
    };
    let largest = |windows: &[Window], border: u64| {
        let areas = windows.iter().map(|window| with_border(window, border));
        areas.max()
    };
    // A folder is as large as the picture in it.
    let bundle = RoleBundle::of(path).ok()?;
    let inside = bundle.as_ref().and_then(RoleBundle::picture);
    let path = inside.unwrap_or(path);
    let opened = Opened::open(path).ok()?;
    let windows: Vec<Window> = match &opened.kind {
        OpenedKind::Exr(file) => file.parts.iter().map(|part| part.window).collect(),
        OpenedKind::Photo(photo) => vec![photo.header.window()],
    };
    let (display_window, pixel_aspect) = opened.shown(opened.display());
    Some(PictureSize {
        pixels: largest(&windows, 0)?,
        repeated: largest(&windows, TILE_BORDER_PX)?,
        display_window,
        pixel_aspect,
        channels: opened
            .exr()
            .map_or(0, |file| file.channel_ids().count() as u64),
    })
}

/// Most memory that blocks of the picture `path` take while it is read; 0 for a photo, and if the header does not tell.
pub(crate) fn decoding_bytes(path: &Path) -> u64 {
    let file = ExrFile::open(path, &Limits::default());
    file.map_or(0, |file| file.decoding_bytes())
}

/// Bytes per pixel of a map: its planes as read, and the points, normals and colours made from them.
const SURROUNDINGS_PER_PIXEL: u64 = 96;

/// Approximate memory for the surroundings in the panorama at `path`, by its header.
///
/// # Errors
/// As for reading it, except errors that only pixels reveal.
pub(crate) fn surroundings_bytes(path: &Path) -> Result<u64> {
    let window = place_in(&Opened::open(path)?)?.window();
    let pixels = window.width() as u64 * window.height() as u64;
    Ok(pixels.saturating_mul(SURROUNDINGS_PER_PIXEL))
}
