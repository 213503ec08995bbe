//! From patches to pixels: interpolates the directions of the patches around a pixel, never across an edge.

use crate::frame::memory::Memory;
use crate::frame::{Mask, Vector2Planes};
use crate::kernel::simd::wide;
use crate::line::direction_field;
use crate::line::direction_field::patches::{Links, NONE, Patches};
use glam::Vec2;
use rayon::prelude::*;

/// Directions of patches in `N` fields, as twice their angles, to be interpolated to pixels.
pub(crate) struct BetweenPatches<'a, const N: usize> {
    pub(crate) patches: &'a Patches,
    pub(crate) mask: &'a Mask,
    pub(crate) doubled: &'a [[[f32; 2]; N]],
}

impl<const N: usize> BetweenPatches<'_, N> {
    /// Directions of pixels, interpolated between those of the surrounding patches; 0 where there is none.
    pub(crate) fn all(&self, memory: &Memory) -> [Vector2Planes; N] {
        let grid = &self.patches.grid;
        std::array::from_fn(|field| {
            let [mut x, mut y] = [(); 2].map(|()| memory.plane(self.mask));
            let [xs, ys] = [&mut x, &mut y].map(|plane| grid.bands(plane.samples_mut()));
            let bands = xs.into_par_iter().zip(ys).enumerate();
            bands.for_each(|(row, (x, y))| self.fill_band(field, row, [x, y]));
            Vector2Planes { x, y }
        })
    }

    /// The directions of one field in a row of cells; those of no patch are 0.
    fn fill_band(&self, field: usize, row: usize, [x, y]: [&mut [f32]; 2]) {
        let Patches { grid, labels, .. } = self.patches;
        let width = self.mask.width();
        let ys = grid.pixels(1, row);
        for (py, start) in ys.clone().zip((0..).step_by(width)) {
            let span = self.mask.span(py);
            let covered = start + span.start..start + span.end;
            x[covered.clone()].fill(0.0);
            y[covered].fill(0.0);
        }
        let downs = grid.places(1, &ys);
        for column in 0..grid.columns {
            let xs = grid.pixels(0, column);
            let acrosses = grid.places(0, &xs);
            for (label, patch) in self.patches.of_cell(column, row).enumerate() {
                // Mapping arrays is not inlined.
                let mut around = [Vec2::ZERO; 9];
                for (mean, pair) in around.iter_mut().zip(self.around(patch)) {
                    let [a, b] = pair;
                    let sum =
                        Vec2::from(self.doubled[a][field]) + Vec2::from(self.doubled[b][field]);
                    *mean = 0.5 * sum;
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
        for (x, y) in x.chunks_mut(width).zip(y.chunks_mut(width)) {
            wide!(direction_field::halve_row(x, y));
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
        let either =
            |a: Option<usize>, b: Option<usize>| a.or(b).zip(b.or(a)).map(<[usize; 2]>::from);
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
