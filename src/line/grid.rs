//! Blocks of pixels as cells of a coarser grid: their means, and interpolation back to pixels.

use crate::frame::memory::Memory;
use crate::frame::rows::map_rows;
use crate::frame::{Mask, Plane};
use glam::Vec2;
use std::ops::Range;

/// Cells along a picture's size, the root of its area, where it has so many pixels: strokes carry no finer forms.
const CELLS: f32 = 700.0;

/// The side of cells, in pixels, in a picture of this size.
pub(crate) fn cell_px(size_px: f32) -> usize {
    ((size_px / CELLS) as usize).max(1)
}

/// Cells of `step` by `step` pixels; those with any surface are covered.
pub(crate) struct Grid {
    step: usize,
    pub(crate) mask: Mask,
    /// The two cells around each column and each row of pixels, and how far it lies toward the second.
    places: [Vec<([usize; 2], f32)>; 2],
}

impl Grid {
    pub(crate) fn new(pixels: &Mask, step: usize) -> Self {
        let lengths = [pixels.width(), pixels.height()];
        let [width, height] = lengths.map(|length| length.div_ceil(step));
        let mut covered = Plane::filled(width, height, false);
        for y in 0..pixels.height() {
            let row = covered.row_mut(y / step);
            for run in pixels.runs(y) {
                row[run.start / step..=(run.end - 1) / step].fill(true);
            }
        }
        Self {
            step,
            mask: Mask::new(covered),
            places: lengths.map(|length| places(length, step)),
        }
    }

    /// The means over cells of `row(y)(x)`, over covered pixels.
    pub(crate) fn means<const N: usize, Sample: Fn(usize) -> [f32; N]>(
        &self,
        pixels: &Mask,
        memory: &Memory,
        row: impl Fn(usize) -> Sample + Sync,
    ) -> [Plane; N] {
        let step = self.step;
        let height = pixels.height();
        map_rows(&self.mask, memory, |cells, mut means| {
            let columns = self.mask.span(cells);
            let mut counts = vec![0.0_f32; columns.len()];
            let mut sums = vec![[0.0; N]; columns.len()];
            for y in cells * step..((cells + 1) * step).min(height) {
                let sample = row(y);
                for run in pixels.runs(y) {
                    for (cell, part) in parts(run, step) {
                        let i = cell - columns.start;
                        counts[i] += part.len() as f32;
                        for x in part {
                            let sums = sums[i].iter_mut().zip(sample(x));
                            sums.for_each(|(sum, v)| *sum += v);
                        }
                    }
                }
            }
            for (i, cell) in columns.enumerate().filter(|&(i, _)| counts[i] > 0.0) {
                let means = means.iter_mut().zip(sums[i]);
                means.for_each(|(row, sum)| row[cell] = sum / counts[i]);
            }
        })
    }

    /// The least sample of a plane of pixels in each cell; 0 where nothing is covered.
    pub(crate) fn least(&self, pixels: &Plane) -> Plane {
        self.folded(pixels, f32::INFINITY, f32::min)
    }

    /// The greatest sample of a plane of pixels in each cell; 0 where nothing is covered.
    pub(crate) fn most(&self, pixels: &Plane) -> Plane {
        self.folded(pixels, f32::NEG_INFINITY, f32::max)
    }

    fn folded(&self, pixels: &Plane, none: f32, fold: impl Fn(f32, f32) -> f32 + Sync) -> Plane {
        let step = self.step;
        let mut cells = Plane::filled(self.mask.width(), self.mask.height(), 0.0);
        cells.each_row(|row, cells| {
            for run in self.mask.runs(row) {
                let cells = &mut cells[run.clone()];
                cells.fill(none);
                let columns = run.start * step..(run.end * step).min(pixels.width());
                for y in row * step..((row + 1) * step).min(pixels.height()) {
                    let parts = pixels.row(y)[columns.clone()].chunks(step);
                    for (cell, part) in cells.iter_mut().zip(parts) {
                        *cell = part.iter().copied().fold(*cell, &fold);
                    }
                }
            }
        });
        cells
    }

    /// A plane of cells interpolated at the covered pixels of row `y`: the mean of the four cells around, weighted by
    /// distance, of those covered.
    pub(crate) fn row(&self, cells: &Plane, y: usize, pixels: &Mask) -> Vec<f32> {
        if self.step == 1 {
            return cells.row(y).to_vec();
        }
        let [columns, rows] = &self.places;
        let (rows, down) = rows[y];
        let mut between = vec![Vec2::ZERO; cells.width()];
        for (row, weight) in rows.into_iter().zip([1.0 - down, down]) {
            let columns = self.mask.span(row);
            let samples = self.mask.row(row)[columns.clone()]
                .iter()
                .zip(&cells.row(row)[columns.clone()]);
            for (sum, (&covered, &sample)) in between[columns].iter_mut().zip(samples) {
                let weight = if covered { weight } else { 0.0 };
                *sum += Vec2::new(weight * sample, weight);
            }
        }
        let mut row = vec![0.0; pixels.width()];
        let span = pixels.span(y);
        for (sample, ([before, next], across)) in row[span.clone()].iter_mut().zip(&columns[span]) {
            let sum = (1.0 - across) * between[*before] + across * between[*next];
            // A covered pixel's own cell weighs a quarter at the least.
            *sample = sum.x / sum.y;
        }
        row
    }
}

/// The two cells around each of so many pixels along an axis, and how far it lies toward the second.
fn places(pixels: usize, step: usize) -> Vec<([usize; 2], f32)> {
    let last = pixels.div_ceil(step).max(1) - 1;
    let place = |pixel: usize| {
        // Halves of pixels from the middle of the cell before the first.
        let at = 2 * pixel + 1 + step;
        let (cell, rest) = (at / (2 * step), at % (2 * step));
        let around = [cell.saturating_sub(1).min(last), cell.min(last)];
        (around, rest as f32 / (2 * step) as f32)
    };
    (0..pixels).map(place).collect()
}

/// The cells of `step` pixels that a run of pixels passes, each with the pixels in it.
#[inline]
pub(crate) fn parts(run: Range<usize>, step: usize) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut cell = run.start / step;
    let mut from = run.start;
    std::iter::from_fn(move || {
        let to = ((cell + 1) * step).min(run.end);
        let part = (from < to).then_some((cell, from..to))?;
        (cell, from) = (cell + 1, to);
        Some(part)
    })
}
