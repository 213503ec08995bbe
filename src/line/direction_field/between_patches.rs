//! From patches to pixels: interpolates the directions of the patches around a pixel, never across an edge.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::simd::Simd;
use crate::frame::{Mask, Vector2Planes};
use crate::line::direction_field::patches::{Links, NONE, Patches};
use glam::Vec2;
use rayon::prelude::*;

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
        let mut found = memory.vectors(self.mask);
        let width = found.x.width();
        let (x, y) = (found.x.samples_mut(), found.y.samples_mut());
        grid.bands(x)
            .into_par_iter()
            .zip(grid.bands(y))
            .enumerate()
            .for_each(|(row, (x, y))| {
                for column in 0..grid.columns {
                    self.fill_cell(column, row, [x, y]);
                }
                for (i, (x, y)) in x.chunks_mut(width).zip(y.chunks_mut(width)).enumerate() {
                    let span = self.mask.span(grid.y_pixels(row).start + i);
                    simd.halve_row(&mut x[span.clone()], &mut y[span]);
                }
            });
        found
    }

    /// The pixels of one cell, in the rows of their band.
    fn fill_cell(&self, column: usize, row: usize, [x, y]: [&mut [f32]; 2]) {
        let Patches { grid, labels, .. } = self.patches;
        let width = self.mask.width();
        let (xs, ys) = (grid.x_pixels(column), grid.y_pixels(row));
        let patches = self.patches.of_cell(column, row);
        let is_whole = patches.len() == 1
            && usize::from(self.patches.all[patches.start].pixels) == xs.len() * ys.len();
        if !is_whole {
            for i in 0..ys.len() {
                x[i * width..][xs.clone()].fill(0.0);
                y[i * width..][xs.clone()].fill(0.0);
            }
        }
        for (label, patch) in patches.enumerate() {
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
                if let Some(places) = grid.four_across().filter(|_| is_whole && xs.len() == 4) {
                    let of_four = |out: &mut [f32], here: f32, [left, right]: [f32; 2]| {
                        let out = &mut out[i * width + xs.start..][..4];
                        for (k, (out, u)) in out.iter_mut().zip(places).enumerate() {
                            *out = here + u.abs() * if k < 2 { left } else { right };
                        }
                    };
                    of_four(x, here.x, [steps[0].x, steps[1].x]);
                    of_four(y, here.y, [steps[0].y, steps[1].y]);
                    continue;
                }
                let pixels = x[i * width..][xs.clone()]
                    .iter_mut()
                    .zip(&mut y[i * width..][xs.clone()]);
                let labels = &labels[py * width..][xs.clone()];
                for ((px, (x, y)), &own) in xs.clone().zip(pixels).zip(labels) {
                    let u = grid.place(0, px);
                    let z = here + u.abs() * steps[usize::from(u >= 0.0)];
                    if is_whole || usize::from(own) == label {
                        (*x, *y) = (z.x, z.y);
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
