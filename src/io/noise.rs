//! Whether normals of a photo have noise: what removes it costs time, and nearly all maps have none.

use super::photo::{CodeMeaning, StoredPhoto};
use crate::frame::{Vector3Planes, Window, denoise, unround};
use crate::kernel::quantile::quantile;
use rayon::prelude::*;
use std::ops::Range;

/// Blocks that are looked at, in rows and columns of so many.
const BLOCKS: usize = 5;

/// Pixels along a side of a block.
const SIDE: usize = 64;

/// Share of the blocks that may be noisier: edges of leaves, close together, look like noise in a few.
const NOISY: f64 = 0.125;

/// Deviation of slopes from which on it is noise. Clean maps reach .0007, those of cut-out leaves.
const LEAST_NOISE: f32 = 0.002;

/// The deviation of slopes of a photo's normals that is noise; 0 if there is none, or if they cannot be decoded. It is told
/// by blocks of the whole, so that strips of it are treated alike; each lies in one cell of a sheet.
pub(super) fn noise_of(photo: &StoredPhoto) -> f32 {
    let header = &photo.header;
    if !photo.header.may_hold_coded_vectors() {
        return 0.0;
    }
    let mut blocks = Vec::new();
    let [width, height] = photo.cell;
    for rows in spread(header.height, height) {
        let size = Window::from_size(header.width, rows.len());
        let Ok(planes) = photo.planes(rows, CodeMeaning::Stored) else {
            return 0.0;
        };
        for columns in spread(header.width, width) {
            let part = Window::at(columns.start as i32, 0, columns.len(), size.height());
            let block = planes[..3].iter().map(|plane| plane.crop(size, part));
            blocks.push(Vector3Planes::of(block.collect()));
        }
    }
    let removed = |mut block: Vector3Planes| {
        if header.bits == 8 {
            unround(&mut block, header.coding_error());
        }
        let mut quiet = block.clone();
        denoise(&mut quiet, [false; 2]);
        let both = block.vectors().zip(quiet.vectors());
        let mut removed: Vec<f32> = both
            .map(|(code, quiet)| 2.0 * code.distance(quiet))
            .collect();
        quantile(&mut removed, 0.5, f32::total_cmp)
    };
    // Blocks side by side: their own rows are too few to share out.
    let medians = blocks.into_par_iter().filter_map(removed);
    let mut medians: Vec<f32> = medians.collect();
    // Half of all vectors of a deviation of 1 along x and along y are longer than sqrt(2 ln 2).
    let median = quantile(&mut medians, 1.0 - NOISY, f32::total_cmp).unwrap_or_default();
    let deviation = median / (2.0 * std::f32::consts::LN_2).sqrt();
    f32::from(deviation >= LEAST_NOISE) * deviation
}

/// Ranges spread evenly along a side of cells, each within one.
fn spread(length: usize, cell: usize) -> impl Iterator<Item = Range<usize>> {
    let side = SIDE.min(cell);
    (0..BLOCKS).map(move |i| {
        let first = (2 * i + 1) * (length - side) / (2 * BLOCKS);
        let first = first.min(first / cell * cell + cell - side);
        first..first + side
    })
}
