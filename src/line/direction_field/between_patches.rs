//! From patches to pixels: interpolates the directions of the patches around a pixel, never across an edge.

use crate::frame::{Mask, Vector2Planes};
use crate::kernel::memory::Memory;
use crate::kernel::simd::wide;
use crate::line::direction::fill::{Pixel, lacking_of_row};
use crate::line::direction_field;
use crate::line::direction_field::patches::{Links, NONE, Patches};
use glam::Vec2;
use rayon::prelude::*;
use std::ops::Range;

/// Directions of patches in `N` fields, as twice their angles, to be interpolated to pixels.
pub(crate) struct BetweenPatches<'a, const N: usize> {
    pub(crate) patches: &'a Patches,
    pub(crate) mask: &'a Mask,
    pub(crate) doubled: &'a [[[f32; 2]; N]],
}

/// The rows of pixels in a row of cells: x and y of each field.
type Band<'a, const N: usize> = [[&'a mut [f32]; 2]; N];

impl<const N: usize> BetweenPatches<'_, N> {
    /// Directions of pixels, interpolated between those of the surrounding patches, and the covered pixels without one,
    /// where it is 0.
    pub(crate) fn all(&self, memory: &Memory) -> ([Vector2Planes; N], [Vec<Pixel>; N]) {
        let grid = &self.patches.grid;
        let mut is_clear = [[false; 2]; N];
        let mut found = is_clear.each_mut().map(|is_clear| {
            let (x, is_x_clear) = memory.any_plane(self.mask);
            let (y, is_y_clear) = memory.any_plane(self.mask);
            *is_clear = [is_x_clear, is_y_clear];
            Vector2Planes { x, y }
        });
        let mut bands = found.each_mut().map(|field| {
            let planes = [field.x.samples_mut(), field.y.samples_mut()];
            planes.map(|samples| grid.bands(samples).into_iter())
        });
        let mut next = || {
            bands.each_mut().map(|field| {
                let parts = field.each_mut().map(Iterator::next);
                parts.map(|part| part.expect("one for each row of cells"))
            })
        };
        let bands: Vec<Band<N>> = (0..grid.rows).map(|_| next()).collect();
        let lacking: Vec<[Vec<Pixel>; N]> = bands
            .into_par_iter()
            .enumerate()
            .map(|(row, band)| self.fill_band(row, band, &is_clear))
            .collect();
        let lacking = std::array::from_fn(|field| {
            let rows = lacking.iter().flat_map(|lacking| &lacking[field]);
            rows.copied().collect()
        });
        (found, lacking)
    }

    /// The directions in a row of cells, all 0 before where they are `clear`, and the covered pixels without one.
    fn fill_band(&self, row: usize, mut band: Band<N>, clear: &[[bool; 2]; N]) -> [Vec<Pixel>; N] {
        let Patches { grid, .. } = self.patches;
        let mut from = 0;
        for run in self.regular_runs(row) {
            self.fill_cells(from..run.start, row, &mut band, clear);
            from = run.end;
            self.fill_regular(run, row, &mut band);
        }
        self.fill_cells(from..grid.columns, row, &mut band, clear);
        let width = self.mask.width();
        band.map(|[x, y]| {
            let mut lacking = Vec::new();
            let rows = x.chunks_mut(width).zip(y.chunks_mut(width));
            for (py, (x, y)) in grid.y_pixels(row).zip(rows) {
                let span = self.mask.span(py);
                wide!(direction_field::halve_row(
                    &mut x[span.clone()],
                    &mut y[span]
                ));
                lacking_of_row(&mut lacking, self.mask, py, [x, y]);
            }
            lacking
        })
    }

    /// The runs of cells of the usual side in a row that are one whole patch each, as are all the cells around them.
    fn regular_runs(&self, row: usize) -> Vec<Range<usize>> {
        let grid = &self.patches.grid;
        let mut runs = Vec::new();
        if grid.four_across().is_none() || row == 0 || row + 1 >= grid.rows {
            return runs;
        }
        let rows = [row - 1, row, row + 1].map(|row| self.patches.whole(row));
        let mut start = 0;
        for column in 0..=grid.columns {
            let is_whole = column < grid.columns && rows.iter().all(|row| row[column]);
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
    fn fill_regular(&self, run: Range<usize>, row: usize, band: &mut Band<N>) {
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
        for (i, &down) in grid.places(1, &grid.y_pixels(row)).iter().enumerate() {
            let beside = if down < 0.0 { above } else { below };
            let start = i * self.mask.width();
            let pixels = start + xs.start..start + xs.end;
            let mut out = band.each_mut().map(|field| {
                let rows = field.each_mut();
                rows.map(|row| &mut row[pixels.clone()])
            });
            wide!(spread_row(&mut out, own, beside, down, &places));
        }
    }

    /// The pixels of any cells in these columns, in the rows of their band; those of no patch become 0, where they are
    /// not `clear`.
    fn fill_cells(
        &self,
        columns: Range<usize>,
        row: usize,
        band: &mut Band<N>,
        clear: &[[bool; 2]; N],
    ) {
        if columns.is_empty() {
            return;
        }
        let Patches { grid, labels, .. } = self.patches;
        let width = self.mask.width();
        let ys = grid.y_pixels(row);
        let downs = grid.places(1, &ys);
        let all = grid.x_pixels(columns.start).start..grid.x_pixels(columns.end - 1).end;
        let parts = band.iter_mut().flatten().zip(clear.as_flattened());
        for (samples, _) in parts.filter(|(_, is_clear)| !**is_clear) {
            for row in samples.chunks_mut(width) {
                row[all.clone()].fill(0.0);
            }
        }
        for column in columns {
            let xs = grid.x_pixels(column);
            let acrosses = grid.places(0, &xs);
            for (label, patch) in self.patches.of_cell(column, row).enumerate() {
                let pairs = self.around(patch);
                for (field, [x, y]) in band.iter_mut().enumerate() {
                    // Mapping arrays is not inlined.
                    let mut around = [Vec2::ZERO; 9];
                    for (mean, pair) in around.iter_mut().zip(pairs) {
                        let [a, b] = pair.map(|i| Vec2::from(self.doubled[i][field]));
                        *mean = 0.5 * (a + b);
                    }
                    for (i, (py, &v)) in ys.clone().zip(downs).enumerate() {
                        let between = |c: usize| {
                            let beside = if v < 0.0 { around[c] } else { around[c + 6] };
                            around[c + 3] + v.abs() * (beside - around[c + 3])
                        };
                        let (left, here, right) = (between(0), between(1), between(2));
                        let labels = &labels[py * width..][xs.clone()];
                        let x = &mut x[i * width..][xs.clone()];
                        let y = &mut y[i * width..][xs.clone()];
                        let pixels = x.iter_mut().zip(y).zip(labels).zip(acrosses);
                        for (((x, y), &own), &u) in pixels {
                            let side = if u < 0.0 { left } else { right };
                            let z = here + u.abs() * (side - here);
                            *x = if own == label as u8 { z.x } else { *x };
                            *y = if own == label as u8 { z.y } else { *y };
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
pub(crate) fn spread_row<const N: usize>(
    out: &mut [[&mut [f32]; 2]; N],
    own: &[[[f32; 2]; N]],
    beside: &[[[f32; 2]; N]],
    down: f32,
    places: &[f32; 4],
) {
    for (field, [x, y]) in out.iter_mut().enumerate() {
        let between = |i: usize| {
            let ([ax, ay], [bx, by]) = (own[i][field], beside[i][field]);
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
}
