//! The Hessian of the height field: the derivative of its gradient.
//!
//! Theory: [LW] algorithm 1, step 7, takes Sobel's derivative, which is the least-squares plane fit to the 3x3
//! gradients with weights 1 and 2. Changes: each neighbour's weight is multiplied by its conductance, so that nothing
//! is read across an edge, where renderers mix the normals of two surfaces; away from edges the fit is Sobel's
//! derivative itself. Practice: scaled by the pixel's own conductance, edges count as flat.

use crate::shape::{Rows, Shifted, inner_columns, outer_columns, sobel};
use std::ops::Range;

/// Pixels read to each side.
pub(crate) const REACH: usize = 1;

/// Symmetric Hessian [xx, xy, yy] per pixel, y up, from the 3x3 gradients around column `x`.
///
/// With a foreshortening other than 1 the field is not the gradient of any height, and the mean of the two mixed
/// derivatives is taken.
#[inline(always)]
pub(crate) fn hessian(gx: &Rows, gy: &Rows, conductance: &Rows, x: usize) -> [f32; 3] {
    fitted(
        gx.neighbourhood(x),
        gy.neighbourhood(x),
        conductance.neighbourhood(x),
    )
}

/// [`hessian`] of the pixels of a row in `columns`.
#[inline(always)]
pub(crate) fn hessian_row(
    out: [&mut [f32]; 3],
    gx: &Rows,
    gy: &Rows,
    conductance: &Rows,
    columns: Range<usize>,
) {
    let [xx, xy, yy] = out;
    let inner = inner_columns(&columns, xx.len());
    for x in outer_columns(&columns, &inner) {
        [xx[x], xy[x], yy[x]] = hessian(gx, gy, conductance, x);
    }
    for start in inner.clone().step_by(BLOCK) {
        let columns = start..(start + BLOCK).min(inner.end);
        let block = ColumnBlock::new(gx, gy, conductance, &columns);
        let n = columns.len();
        let (xx, xy) = (&mut xx[columns.clone()][..n], &mut xy[columns.clone()][..n]);
        let yy = &mut yy[columns][..n];
        if block.is_open() {
            for i in 0..n {
                [xx[i], xy[i], yy[i]] = block.in_the_open(i);
            }
        } else {
            for i in 0..n {
                [xx[i], xy[i], yy[i]] = block.fitted(i);
            }
        }
    }
}

/// Only the trace of [`hessian`], for the pixels of a row in `columns`: all that isotropic scaling needs.
#[inline(always)]
pub(crate) fn trace_row(
    trace: &mut [f32],
    gx: &Rows,
    gy: &Rows,
    conductance: &Rows,
    columns: Range<usize>,
) {
    let inner = inner_columns(&columns, trace.len());
    for x in outer_columns(&columns, &inner) {
        let [xx, _, yy] = hessian(gx, gy, conductance, x);
        trace[x] = xx + yy;
    }
    for start in inner.clone().step_by(BLOCK) {
        let columns = start..(start + BLOCK).min(inner.end);
        let block = ColumnBlock::new(gx, gy, conductance, &columns);
        let n = columns.len();
        let trace = &mut trace[columns][..n];
        if block.is_open() {
            for (i, trace) in trace.iter_mut().enumerate() {
                let [xx, _, yy] = block.in_the_open(i);
                *trace = xx + yy;
            }
        } else {
            for (i, trace) in trace.iter_mut().enumerate() {
                let [xx, _, yy] = block.fitted(i);
                *trace = xx + yy;
            }
        }
    }
}

/// Columns checked together: without edges around them they need no fit.
const BLOCK: usize = 128;

/// Some columns of the rows around a row.
struct ColumnBlock<'a> {
    gx: [Shifted<'a>; 3],
    gy: [Shifted<'a>; 3],
    open: [Shifted<'a>; 3],
}

impl<'a> ColumnBlock<'a> {
    #[inline(always)]
    fn new(gx: &Rows<'a>, gy: &Rows<'a>, open: &Rows<'a>, columns: &Range<usize>) -> Self {
        let of = |rows: &Rows<'a>| {
            [
                Shifted::new(rows.above, columns),
                Shifted::new(rows.at, columns),
                Shifted::new(rows.below, columns),
            ]
        };
        Self {
            gx: of(gx),
            gy: of(gy),
            open: of(open),
        }
    }

    #[inline(always)]
    fn is_open(&self) -> bool {
        self.open.iter().all(|row| all_open(row.reach))
    }

    #[inline(always)]
    fn in_the_open(&self, i: usize) -> [f32; 3] {
        in_the_open(around(&self.gx, i), around(&self.gy, i))
    }

    #[inline(always)]
    fn fitted(&self, i: usize) -> [f32; 3] {
        fitted(
            around(&self.gx, i),
            around(&self.gy, i),
            around(&self.open, i),
        )
    }
}

/// The samples around the `i`-th column.
#[inline(always)]
fn around(rows: &[Shifted; 3], i: usize) -> [[f32; 3]; 3] {
    [rows[0].around(i), rows[1].around(i), rows[2].around(i)]
}

/// The Hessian from 3x3 gradients away from edges.
#[inline(always)]
pub(crate) fn in_the_open(gx: [[f32; 3]; 3], gy: [[f32; 3]; 3]) -> [f32; 3] {
    let ([xx, xy], [yx, yy]) = (sobel(gx), sobel(gy));
    [xx, 0.5 * (xy + yx), yy]
}

/// The Hessian from 3x3 samples of both components of the gradient and of the conductance.
#[inline(always)]
pub(crate) fn fitted(gx: [[f32; 3]; 3], gy: [[f32; 3]; 3], open: [[f32; 3]; 3]) -> [f32; 3] {
    let plain = in_the_open(gx, gy);
    let fit = plane_fit(gx, gy, open);
    let c = open[1][1];
    let is_open = open.iter().fold(true, |all, row| all & all_open(row));
    // Both are computed and one is selected: a branch would prevent vectorisation.
    let chosen = |i: usize| {
        let value = if is_open { plain[i] } else { fit[i] };
        if c == 0.0 { 0.0 } else { value }
    };
    [chosen(0), chosen(1), chosen(2)]
}

/// The Hessian by a plane fit weighted by conductance.
#[inline(always)]
pub(crate) fn plane_fit(gx: [[f32; 3]; 3], gy: [[f32; 3]; 3], open: [[f32; 3]; 3]) -> [f32; 3] {
    let stencil = Stencil::new(open);
    let ([xx, xy], [yx, yy]) = (stencil.slope(gx), stencil.slope(gy));
    let c = open[1][1];
    [c * xx, c * 0.5 * (xy + yx), c * yy]
}

/// Whether all conductances are 1.
#[inline(always)]
fn all_open(conductance: &[f32]) -> bool {
    conductance.iter().fold(true, |all, &c| all & (c == 1.0))
}

/// Sobel's weights of the nine samples in a plane fit.
const WEIGHTS: [[f32; 3]; 3] = [[1.0, 2.0, 1.0], [2.0, 0.0, 2.0], [1.0, 2.0, 1.0]];

/// Regularises the fit where the open neighbours lie on one line: the slope across that line is then 0. Small compared
/// with 1, the smallest weight of a fit with an open neighbour; and so large that rounding counts no more than 2^-24 / RIDGE,
/// 3e-5, where they lie on a diagonal.
pub(crate) const RIDGE: f32 = 2e-3;

/// A weighted least-squares fit of a plane through the centre of 3x3 samples, y up.
struct Stencil {
    weights: [[f32; 3]; 3],
    /// Sums of weight times dx^2, dx dy, dy^2.
    moments: [f32; 3],
}

impl Stencil {
    #[inline(always)]
    fn new(open: [[f32; 3]; 3]) -> Self {
        let w = each(|i, j| WEIGHTS[i][j] * open[i][j]);
        let (west, east) = (column(w, 0), column(w, 2));
        let (north, south) = (row(w, 0), row(w, 2));
        let moments = [
            (west + east) + RIDGE,
            (w[0][2] + w[2][0]) - (w[0][0] + w[2][2]),
            (north + south) + RIDGE,
        ];
        Self {
            weights: w,
            moments,
        }
    }

    /// Derivatives [d/dx, d/dy] of the fitted plane.
    #[inline(always)]
    fn slope(&self, samples: [[f32; 3]; 3]) -> [f32; 2] {
        let rise = each(|i, j| self.weights[i][j] * (samples[i][j] - samples[1][1]));
        let along_x = column(rise, 2) - column(rise, 0);
        let along_y = row(rise, 0) - row(rise, 2);
        let [xx, xy, yy] = self.moments;
        let determinant = xx * yy - xy * xy;
        [
            (yy * along_x - xy * along_y) / determinant,
            (xx * along_y - xy * along_x) / determinant,
        ]
    }
}

/// 3x3 values. Written out: `map` over an array is not always inlined, and this is the innermost loop.
#[inline(always)]
fn each(value: impl Fn(usize, usize) -> f32) -> [[f32; 3]; 3] {
    let row = |i: usize| [value(i, 0), value(i, 1), value(i, 2)];
    [row(0), row(1), row(2)]
}

/// Sum of a column of 3x3 values.
#[inline(always)]
fn column(values: [[f32; 3]; 3], j: usize) -> f32 {
    (values[0][j] + values[2][j]) + values[1][j]
}

/// Sum of a row of 3x3 values.
#[inline(always)]
fn row(values: [[f32; 3]; 3], i: usize) -> f32 {
    (values[i][0] + values[i][2]) + values[i][1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    /// The Hessian at the centre of a 3x3 field with a linear gradient and the given conductances, and nonsense
    /// wherever they are 0.
    fn middle(open: [[f32; 3]; 3]) -> [f32; 3] {
        // g = (0.3 x + 0.1 y, 0.1 x - 0.2 y) + const, y up: its Hessian is [0.3, 0.1, -0.2].
        let sample = |i: usize, j: usize, a: f32, b: f32| {
            if open[i][j] == 0.0 {
                1e6
            } else {
                5.0 + a * j as f32 - b * i as f32
            }
        };
        let gx = Plane::from_fn(3, 3, |j, i| sample(i, j, 0.3, 0.1));
        let gy = Plane::from_fn(3, 3, |j, i| sample(i, j, 0.1, -0.2));
        let c = Plane::from_fn(3, 3, |j, i| open[i][j]);
        hessian(
            &Rows::around(&gx, 1),
            &Rows::around(&gy, 1),
            &Rows::around(&c, 1),
            1,
        )
    }

    fn assert_close(got: [f32; 3], expected: [f32; 3], tolerance: f32) {
        for (g, e) in got.into_iter().zip(expected) {
            assert!((g - e).abs() < tolerance, "{got:?}, not {expected:?}");
        }
    }

    #[test]
    fn a_linear_gradient_is_met_exactly_in_the_open() {
        assert_close(middle([[1.0; 3]; 3]), [0.3, 0.1, -0.2], 1e-6);
    }

    #[test]
    fn nothing_is_read_across_an_edge() {
        // An edge along the right column, then along a corner, then one that leaves three pixels.
        let right = [[1.0, 1.0, 0.0]; 3];
        let corner = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        let few = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        for open in [right, corner, few] {
            // The ridge of 2e-3 against moments of 1 and more, of an entry of 0.3 and one of 0.2.
            assert_close(middle(open), [0.3, 0.1, -0.2], 1e-3);
        }
    }

    #[test]
    fn what_cannot_be_told_is_flat() {
        let along_one_line = [[0.0; 3], [1.0, 1.0, 1.0], [0.0; 3]];
        // The ridge of 2e-3 against a moment of 4: 5e-4 of 0.3.
        assert_close(middle(along_one_line), [0.3, 0.05, 0.0], 2e-4);
        let alone = [[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]];
        assert_close(middle(alone), [0.0; 3], 0.0 + f32::MIN_POSITIVE);
        let closed = [[1.0; 3], [1.0, 0.0, 1.0], [1.0; 3]];
        assert_eq!(middle(closed), [0.0; 3]);
    }
}
