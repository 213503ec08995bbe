//! From patches to pixels: interpolates the directions of the patches around a pixel, never across an edge.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::simd::{Simd, widened};
use crate::frame::{Mask, Vector2Planes};
use crate::line::direction_field::patches::{Links, NONE, Patches};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::Range;

/// Directions of patches, as twice their angles, to be interpolated to pixels.
pub(crate) struct BetweenPatches<'a> {
    pub(crate) patches: &'a Patches,
    pub(crate) mask: &'a Mask,
    pub(crate) doubled: &'a [[f32; 2]],
}

impl BetweenPatches<'_> {
    /// Directions of pixels, interpolated between those of the surrounding patches; 0 without a patch.
    pub(crate) fn all(&self, memory: &Memory) -> Vector2Planes {
        let grid = &self.patches.grid;
        let simd = Simd::widest();
        let [x, y] = [(); 2].map(|()| memory.unwritten(self.mask));
        let mut found = Vector2Planes { x, y };
        let width = found.x.width();
        let (x, y) = (found.x.samples_mut(), found.y.samples_mut());
        grid.bands(x)
            .into_par_iter()
            .zip(grid.bands(y))
            .enumerate()
            .for_each(|(row, (x, y))| {
                let mut from = 0;
                for run in self.regular_runs(row) {
                    self.fill_cells(from..run.start, row, [x, y]);
                    from = run.end;
                    self.fill_regular(run, row, simd, [x, y]);
                }
                self.fill_cells(from..grid.columns, row, [x, y]);
                for (i, (x, y)) in x.chunks_mut(width).zip(y.chunks_mut(width)).enumerate() {
                    let span = self.mask.span(grid.y_pixels(row).start + i);
                    simd.halve_row(&mut x[span.clone()], &mut y[span]);
                }
            });
        found
    }

    /// The runs of cells of the usual side in a row that are one whole patch each, as are all the cells around them.
    fn regular_runs(&self, row: usize) -> Vec<Range<usize>> {
        let grid = &self.patches.grid;
        let mut runs = Vec::new();
        if grid.four_across().is_none() || row == 0 || row + 1 >= grid.rows {
            return runs;
        }
        let mut start = 0;
        for column in 0..=grid.columns {
            let is_whole = column < grid.columns
                && (row - 1..=row + 1).all(|row| self.patches.is_whole(column, row));
            if !is_whole {
                // Those at both ends have others beside them.
                if column > start + 2 {
                    runs.push(start + 1..column - 1);
                }
                start = column + 1;
            }
        }
        runs
    }

    /// The pixels of a regular run of cells, in the rows of their band.
    fn fill_regular(&self, run: Range<usize>, row: usize, simd: Simd, [x, y]: [&mut [f32]; 2]) {
        let Patches { grid, .. } = self.patches;
        let Some(places) = grid.four_across() else {
            return;
        };
        // One patch to a cell: they follow each other.
        let patches = |row: usize| {
            let first = self.patches.of_cell(run.start - 1, row).start;
            &self.doubled[first..][..run.len() + 2]
        };
        let [above, own, below] = [row - 1, row, row + 1].map(patches);
        let xs = grid.x_pixels(run.start).start..grid.x_pixels(run.end - 1).end;
        for (i, py) in grid.y_pixels(row).enumerate() {
            let down = grid.place(1, py);
            let beside = if down < 0.0 { above } else { below };
            let start = i * self.mask.width();
            let pixels = start + xs.start..start + xs.end;
            let (x, y) = (&mut x[pixels.clone()], &mut y[pixels]);
            simd.spread_row(x, y, own, beside, down, &places);
        }
    }

    /// The pixels of any cells in these columns, in the rows of their band.
    fn fill_cells(&self, columns: Range<usize>, row: usize, [x, y]: [&mut [f32]; 2]) {
        if columns.is_empty() {
            return;
        }
        let Patches { grid, labels, .. } = self.patches;
        let width = self.mask.width();
        let ys = grid.y_pixels(row);
        let all = grid.x_pixels(columns.start).start..grid.x_pixels(columns.end - 1).end;
        for i in 0..ys.len() {
            x[i * width..][all.clone()].fill(0.0);
            y[i * width..][all.clone()].fill(0.0);
        }
        for column in columns {
            let xs = grid.x_pixels(column);
            for (label, patch) in self.patches.of_cell(column, row).enumerate() {
                // Mapping arrays is not inlined.
                let mut around = [Vec2::ZERO; 9];
                for (mean, [a, b]) in around.iter_mut().zip(self.around(patch)) {
                    *mean = 0.5 * (Vec2::from(self.doubled[a]) + Vec2::from(self.doubled[b]));
                }
                for (i, py) in ys.clone().enumerate() {
                    let v = grid.place(1, py);
                    let between = |c: usize| {
                        let beside = if v < 0.0 { around[c] } else { around[c + 6] };
                        around[c + 3] + v.abs() * (beside - around[c + 3])
                    };
                    let (left, here, right) = (between(0), between(1), between(2));
                    let steps = [left - here, right - here];
                    let pixels = x[i * width..][xs.clone()]
                        .iter_mut()
                        .zip(&mut y[i * width..][xs.clone()]);
                    let labels = &labels[py * width..][xs.clone()];
                    for ((px, (x, y)), &own) in xs.clone().zip(pixels).zip(labels) {
                        let u = grid.place(0, px);
                        if usize::from(own) == label {
                            let z = here + u.abs() * steps[usize::from(u >= 0.0)];
                            (*x, *y) = (z.x, z.y);
                        }
                    }
                }
            }
        }
    }

    /// A patch and the eight around it, row by row, each the mean of two: a corner may be a different patch when
    /// reached via the side than via the end. Where the surface ends, the nearest patch replaces the missing one.
    fn around(&self, i: usize) -> [[usize; 2]; 9] {
        let Patches { across, down, .. } = self.patches;
        let go = |links: &[u32], i: usize| match links[i] {
            NONE => None,
            there => Some(there as usize),
        };
        let beside = |links: &Links| [go(&links.before, i), go(&links.after, i)];
        let ([left, right], [above, below]) = (beside(across), beside(down));
        let either = |a: Option<usize>, b: Option<usize>| match (a, b) {
            (Some(a), Some(b)) => Some([a, b]),
            (Some(a), None) | (None, Some(a)) => Some([a, a]),
            (None, None) => None,
        };
        let corner =
            |side: Option<usize>, end: Option<usize>, sideways: &[u32], endways: &[u32]| {
                let by_side = side.and_then(|s| go(endways, s));
                let by_end = end.and_then(|e| go(sideways, e));
                either(by_side, by_end)
                    .or_else(|| either(side, end))
                    .unwrap_or([i; 2])
            };
        let next = |there: Option<usize>| [there.unwrap_or(i); 2];
        [
            corner(left, above, &across.before, &down.before),
            next(above),
            corner(right, above, &across.after, &down.before),
            next(left),
            [i; 2],
            next(right),
            corner(left, below, &across.before, &down.after),
            next(below),
            corner(right, below, &across.after, &down.after),
        ]
    }
}

/// A row of pixels in whole cells of four, between the directions of these cells, one more at both ends, and of those
/// `beside` them, above or below; `down` is the place of the row in its cells, and `places` are those of the columns.
#[inline(always)]
fn spread_row(
    x: &mut [f32],
    y: &mut [f32],
    own: &[[f32; 2]],
    beside: &[[f32; 2]],
    down: f32,
    places: &[f32; 4],
) {
    let between = |i: usize| {
        let ([ax, ay], [bx, by]) = (own[i], beside[i]);
        let share = down.abs();
        [ax + share * (bx - ax), ay + share * (by - ay)]
    };
    let (x, y) = (x.as_chunks_mut::<4>().0, y.as_chunks_mut::<4>().0);
    let (mut left, mut here) = (between(0), between(1));
    for (i, (x, y)) in x.iter_mut().zip(y).enumerate() {
        let right = between(i + 2);
        for k in 0..4 {
            let side = if k < 2 { left } else { right };
            x[k] = here[0] + places[k].abs() * (side[0] - here[0]);
            y[k] = here[1] + places[k].abs() * (side[1] - here[1]);
        }
        (left, here) = (here, right);
    }
}

widened! {
    fn spread_row(
        x: &mut [f32],
        y: &mut [f32],
        own: &[[f32; 2]],
        beside: &[[f32; 2]],
        down: f32,
        places: &[f32; 4],
    );
}
