//! Multigrid for the equation of the height: a cycle over halved resolutions, used to precondition conjugate gradients.
//!
//! Cells are pixels; a cell of the next level is two by two of them. Corrections are interpolated from the nearest
//! cells (a half of the cell's own, a quarter of each neighbour's) except across closed faces, and residuals are
//! gathered by the transpose, so the cycle is symmetric, as conjugate gradients ask.

use super::faces::Faces;
use crate::frame::Plane;
use rayon::prelude::*;

/// Damping of two sweeps of Jacobi's method, the Chebyshev pair for the upper three quarters of the spectrum, 1/2 to 2.
const DAMPING: [f32; 2] = [0.562, 1.388];

/// Sweeps on the smallest level.
const LAST_SWEEPS: usize = 12;

/// Cells along the longer side of the smallest level.
const SMALLEST: usize = 4;

/// Faces of the next level below this share are not interpolated across.
const CLOSED: f32 = 0.05;

/// The equation at one resolution: `sum over faces of weight (z - neighbour) + pull z = right-hand side`.
pub(super) struct GridLevel {
    faces: Faces,
    /// Pull toward given depth; `None` if there is none.
    pull: Option<Plane>,
    /// Work planes: the correction, its right-hand side, and one more.
    z: Plane,
    right: Plane,
    spare: Plane,
}

impl GridLevel {
    fn new(faces: Faces, pull: Option<Plane>) -> Self {
        let empty = || Plane::filled(faces.x.width(), faces.x.height(), 0.0);
        Self {
            z: empty(),
            right: empty(),
            spare: empty(),
            faces,
            pull,
        }
    }

    /// This level and all below it.
    pub(super) fn all(faces: Faces, pull: Option<Plane>) -> Vec<Self> {
        let mut levels = vec![Self::new(faces, pull)];
        while let Some(last) = levels.last() {
            if last.z.width().max(last.z.height()) <= SMALLEST {
                break;
            }
            let pull = last.pull.as_ref().map(summed);
            let next = Self::new(last.faces.halved(), pull);
            levels.push(next);
        }
        levels
    }

    /// Calls `cell(x, (A z)(x), diagonal(x))` for every cell of row `y`.
    #[inline(always)]
    fn each_cell(&self, z: &Plane, y: usize, mut cell: impl FnMut(usize, f32, f32)) {
        let (width, height) = (z.width(), z.height());
        let (above, below) = ((y + height - 1) % height, (y + 1) % height);
        let [at, up, down] = [y, above, below].map(|y| &z.row(y)[..width]);
        let right = &self.faces.x.row(y)[..width];
        let [w_up, w_down] = [above, y].map(|y| &self.faces.y.row(y)[..width]);
        let pull = self.pull.as_ref().map(|pull| pull.row(y));
        let mut at_column = |x: usize, before: usize, after: usize| {
            let (l, r, u, d) = (right[before], right[x], w_up[x], w_down[x]);
            let own = pull.map_or(0.0, |pull| pull[x]);
            let diagonal = (l + r) + (u + d) + own;
            let others = (l * at[before] + r * at[after]) + (u * up[x] + d * down[x]);
            cell(x, diagonal * at[x] - others, diagonal);
        };
        at_column(0, width - 1, 1 % width);
        for x in 1..width.saturating_sub(1) {
            at_column(x, x - 1, x + 1);
        }
        if width > 1 {
            at_column(width - 1, width - 2, 0);
        }
    }

    /// The equation's left-hand side of `z`, and its product with `z`.
    pub(super) fn applied(&self, z: &Plane, out: &mut Plane) -> f64 {
        summed_rows(out, |y, out| {
            self.each_cell(z, y, |x, az, _| out[x] = az);
            dot(out, z.row(y))
        })
    }

    /// One sweep of Jacobi's method from `from` to `to`.
    fn sweep(&self, right: &Plane, from: &Plane, to: &mut Plane, damping: f32) {
        to.each_row(|y, to| {
            let (right, at) = (right.row(y), from.row(y));
            self.each_cell(from, y, |x, az, diagonal| {
                to[x] = at[x] + step(right[x] - az, diagonal, damping);
            });
        });
    }

    /// The first sweep, from 0.
    fn first_sweep(&self, right: &Plane, to: &mut Plane, damping: f32) {
        to.each_row(|y, to| {
            let own = right.row(y);
            self.each_cell(right, y, |x, _, diagonal| {
                to[x] = step(own[x], diagonal, damping);
            });
        });
    }
}

/// A step of Jacobi's method. A cell without open faces stays.
#[inline(always)]
fn step(residual: f32, diagonal: f32, damping: f32) -> f32 {
    if diagonal > 0.0 {
        damping * residual / diagonal
    } else {
        0.0
    }
}

/// One cycle: an approximate solution `z` of the equation of the first level, linear and symmetric in `right`.
pub(super) fn cycle(levels: &mut [GridLevel], right: &Plane, z: &mut Plane) {
    let Some((own, rest)) = levels.split_first_mut() else {
        return;
    };
    let mut spare = std::mem::take(&mut own.spare);
    own.first_sweep(right, &mut spare, DAMPING[0]);
    own.sweep(right, &spare, z, DAMPING[1]);
    if let Some(next) = rest.first_mut() {
        spare.each_row(|y, residual| {
            let right = right.row(y);
            own.each_cell(z, y, |x, az, _| residual[x] = right[x] - az);
        });
        let (mut gathered, mut correction) =
            (std::mem::take(&mut next.right), std::mem::take(&mut next.z));
        gather(&spare, &next.faces, &mut gathered);
        cycle(rest, &gathered, &mut correction);
        if let Some(next) = rest.first_mut() {
            interpolate(&correction, &next.faces, z);
            (next.right, next.z) = (gathered, correction);
        }
        own.sweep(right, z, &mut spare, DAMPING[1]);
        own.sweep(right, &spare, z, DAMPING[0]);
    } else {
        for _ in 0..LAST_SWEEPS {
            own.sweep(right, z, &mut spare, DAMPING[0]);
            own.sweep(right, &spare, z, DAMPING[1]);
        }
    }
    own.spare = spare;
}

/// The share that a cell takes of a neighbour across a face of the next level.
#[inline(always)]
fn share(face: f32) -> f32 {
    if face > CLOSED { 0.25 } else { 0.0 }
}

/// Adds the corrections of the next level to `z`.
fn interpolate(correction: &Plane, faces: &Faces, z: &mut Plane) {
    let (w, h) = (correction.width(), correction.height());
    z.each_row(|y, z| {
        let row = y / 2;
        // The row of cells on the nearer side, and the faces to it.
        let (beside, between) = match y % 2 {
            0 => ((row + h - 1) % h, (row + h - 1) % h),
            _ => ((row + 1) % h, row),
        };
        let [at, beside] = [row, beside].map(|y| correction.row(y));
        let (across, along) = (faces.y.row(between), faces.x.row(row));
        for (x, z) in z.iter_mut().enumerate() {
            let column = x / 2;
            let (next, face) = match x % 2 {
                0 => ((column + w - 1) % w, (column + w - 1) % w),
                _ => ((column + 1) % w, column),
            };
            let (s, t) = (share(along[face]), share(across[column]));
            *z += (1.0 - s - t) * at[column] + s * at[next] + t * beside[column];
        }
    });
}

/// Gathers residuals to the next level, by the transpose of [`interpolate`].
fn gather(residual: &Plane, faces: &Faces, gathered: &mut Plane) {
    let (w, h) = (gathered.width(), gathered.height());
    gathered.each_row(|row, out| {
        let (above, below) = ((row + h - 1) % h, (row + 1) % h);
        let rows = [2 * above + 1, 2 * row, 2 * row + 1, 2 * below];
        let at = |i: usize, x: usize| residual.get(x, rows[i]).unwrap_or(0.0);
        let along = faces.x.row(row);
        let [up, down] = [above, row].map(|y| faces.y.row(y));
        for (column, out) in out.iter_mut().enumerate() {
            let (before, after) = ((column + w - 1) % w, (column + 1) % w);
            let (l, r) = (share(along[before]), share(along[column]));
            let (u, d) = (share(up[column]), share(down[column]));
            let (x, next) = (2 * column, 2 * column + 1);
            let own = at(1, x) * (1.0 - l - u)
                + at(1, next) * (1.0 - r - u)
                + at(2, x) * (1.0 - l - d)
                + at(2, next) * (1.0 - r - d);
            let sides = l * (at(1, 2 * before + 1) + at(2, 2 * before + 1))
                + r * (at(1, 2 * after) + at(2, 2 * after));
            let ends = u * (at(0, x) + at(0, next)) + d * (at(3, x) + at(3, next));
            *out = own + sides + ends;
        }
    });
}

/// Sums over two by two cells.
fn summed(fine: &Plane) -> Plane {
    let [w, h] = [fine.width(), fine.height()].map(|length| length.div_ceil(2));
    Plane::from_fn(w, h, |x, y| {
        let rows = fine.rows_within(
            2 * x..(2 * x + 2).min(fine.width()),
            2 * y..(2 * y + 2).min(fine.height()),
        );
        rows.flatten().sum()
    })
}

/// The sum of what `work` gives for each row, in the same order at every run.
fn summed_rows(out: &mut Plane, work: impl Fn(usize, &mut [f32]) -> f64 + Sync) -> f64 {
    let width = out.width().max(1);
    let rows = out.samples_mut().par_chunks_mut(width).enumerate();
    let sums: Vec<f64> = rows.map(|(y, row)| work(y, row)).collect();
    sums.iter().sum()
}

/// The product of two rows, added up in groups so that the compiler takes several at a time.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f64 {
    let groups = a.chunks(64).zip(b.chunks(64));
    let sums = groups.map(|(a, b)| {
        let mut sums = [0.0_f32; 8];
        let (a8, a_rest) = a.as_chunks::<8>();
        let (b8, b_rest) = b.as_chunks::<8>();
        for (a, b) in a8.iter().zip(b8) {
            for i in 0..8 {
                sums[i] += a[i] * b[i];
            }
        }
        let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
        f64::from(sums.iter().sum::<f32>() + rest)
    });
    sums.sum()
}
