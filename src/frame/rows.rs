//! Passes over the frame: rows in parallel, skipping columns without surface.

use crate::frame::memory::Memory;
use crate::frame::{MOST_ROWS_PER_TASK, Mask, Plane, parallel_rows};
use rayon::prelude::*;

/// Minimum number of rows per task, to be worth scheduling.
pub(crate) const ROWS_PER_TASK: usize = 8;

/// Planes of `row(y)(x)` where covered, 0 elsewhere.
pub(crate) fn map_covered<const N: usize, Sample: Fn(usize) -> [f32; N]>(
    mask: &Mask,
    memory: &Memory,
    row: impl Fn(usize) -> Sample + Sync,
) -> [Plane; N] {
    map_rows(mask, memory, |y, mut rows| {
        let (covered, sample) = (mask.row(y), row(y));
        for x in mask.span(y).filter(|&x| covered[x]) {
            for (row, value) in rows.iter_mut().zip(sample(x)) {
                row[x] = value;
            }
        }
    })
}

/// Planes whose rows are filled by `fill(y, rows)`, which must write all covered samples; 0 elsewhere. Rows that start
/// after the run was cancelled are skipped.
pub(crate) fn map_rows<const N: usize>(
    mask: &Mask,
    memory: &Memory,
    fill: impl Fn(usize, [&mut [f32]; N]) + Sync,
) -> [Plane; N] {
    let found = [(); N].map(|()| memory.any_plane(mask));
    let is_full = mask.count() == mask.width() * mask.height();
    let are_blank = found.each_ref().map(|(_, is_zero)| is_full || *is_zero);
    let mut planes = found.map(|(plane, _)| plane);
    each_row(&mut planes, memory, &|y, mut rows| {
        // Just before they are filled, rows are in a core's cache.
        for (row, is_blank) in rows.iter_mut().zip(are_blank) {
            if !is_blank {
                row.fill(0.0);
            }
        }
        if !mask.span(y).is_empty() {
            fill(y, rows);
        }
    });
    planes
}

/// Rayon's part of [`map_rows`], compiled once for all fill functions.
fn each_row<const N: usize>(
    planes: &mut [Plane; N],
    memory: &Memory,
    fill: &(dyn Fn(usize, [&mut [f32]; N]) + Sync),
) {
    parallel_rows(planes.each_mut())
        .with_min_len(ROWS_PER_TASK)
        .with_max_len(MOST_ROWS_PER_TASK)
        .filter(|_| !memory.is_cancelled())
        .for_each(|(y, rows)| fill(y, rows));
}
