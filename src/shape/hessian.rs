//! The Hessian of the height field: the derivative of its gradient.
//!
//! Theory: [LW] algorithm 1, step 7, takes Sobel's derivative, which is the plane fitted to the 3x3
//! gradients with weights 1 and 2 by least squares. Changes: each neighbour's weight is multiplied by
//! its conductance, so that nothing is read across an edge, where renderers mix the normals of two
//! surfaces; in the open the fit is Sobel's derivative itself. Practice: scaled by the pixel's own
//! conductance, edges count as flat.

use crate::shape::{Rows, sobel};

/// Pixels read to each side.
pub const REACH: usize = 1;

/// Symmetric Hessian [xx, xy, yy] per pixel, y up, from the 3x3 gradients around column `x`.
///
/// With a foreshortening other than 1 the gradient is not a gradient of anything, and the mean of
/// the two mixed derivatives is taken.
#[inline(always)]
pub fn hessian(gx: &Rows, gy: &Rows, conductance: &Rows, x: usize) -> [f32; 3] {
    let c = conductance.at[x];
    if c == 0.0 {
        return [0.0; 3];
    }
    let [[xx, xy], [yx, yy]] = derivatives(gx, gy, conductance, x);
    [c * xx, c * 0.5 * (xy + yx), c * yy]
}

/// Trace of [`hessian`] alone: all that isotropic scaling needs.
#[inline(always)]
pub fn trace(gx: &Rows, gy: &Rows, conductance: &Rows, x: usize) -> f32 {
    let [xx, _, yy] = hessian(gx, gy, conductance, x);
    xx + yy
}

/// Derivatives [d/dx, d/dy] of both components around column `x`.
#[inline(always)]
fn derivatives(gx: &Rows, gy: &Rows, conductance: &Rows, x: usize) -> [[f32; 2]; 2] {
    let open = conductance.neighbourhood(x);
    let (gx, gy) = (gx.neighbourhood(x), gy.neighbourhood(x));
    if open.iter().flatten().all(|&c| c == 1.0) {
        [sobel(gx), sobel(gy)]
    } else {
        let stencil = Stencil::new(open);
        [stencil.slope(gx), stencil.slope(gy)]
    }
}

/// Sobel's weights of the nine samples in a fit of a plane.
const WEIGHTS: [[f32; 3]; 3] = [[1.0, 2.0, 1.0], [2.0, 0.0, 2.0], [1.0, 2.0, 1.0]];

/// Keeps the fit solvable where the open neighbours lie on one line: there the slope across that
/// line is taken as 0. Small against the least weight of a fit with an open neighbour, 1.
const RIDGE: f32 = 1e-4;

/// A weighted least-squares fit of a plane through the centre of 3x3 samples.
struct Stencil {
    weights: [[f32; 3]; 3],
    /// Sums of weight times dx^2, dx dy, dy^2.
    moments: [f32; 3],
}

impl Stencil {
    #[inline(never)]
    fn new(open: [[f32; 3]; 3]) -> Self {
        let weights: [[f32; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|j| WEIGHTS[i][j] * open[i][j]));
        let mut moments = [RIDGE, 0.0, RIDGE];
        for_offsets(|i, j, dx, dy| {
            let w = weights[i][j];
            moments[0] += w * dx * dx;
            moments[1] += w * dx * dy;
            moments[2] += w * dy * dy;
        });
        Self { weights, moments }
    }

    /// Derivatives [d/dx, d/dy], y up, of the fitted plane.
    #[inline(never)]
    fn slope(&self, samples: [[f32; 3]; 3]) -> [f32; 2] {
        let (mut along_x, mut along_y) = (0.0, 0.0);
        for_offsets(|i, j, dx, dy| {
            let rise = self.weights[i][j] * (samples[i][j] - samples[1][1]);
            along_x += dx * rise;
            along_y += dy * rise;
        });
        let [xx, xy, yy] = self.moments;
        let determinant = xx * yy - xy * xy;
        [
            (yy * along_x - xy * along_y) / determinant,
            (xx * along_y - xy * along_x) / determinant,
        ]
    }
}

/// Calls `visit(row, column, dx, dy)` for the nine samples, y up.
#[inline(always)]
fn for_offsets(mut visit: impl FnMut(usize, usize, f32, f32)) {
    for (i, dy) in [1.0, 0.0, -1.0].into_iter().enumerate() {
        for (j, dx) in [-1.0, 0.0, 1.0].into_iter().enumerate() {
            visit(i, j, dx, dy);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    /// The Hessian in the middle of a 3x3 field whose gradient is linear, with the given
    /// conductances and nonsense wherever they are 0.
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
            // The ridge of 1e-4 against moments of 1 and more.
            assert_close(middle(open), [0.3, 0.1, -0.2], 3e-4);
        }
    }

    #[test]
    fn what_cannot_be_told_is_flat() {
        let along_one_line = [[0.0; 3], [1.0, 1.0, 1.0], [0.0; 3]];
        assert_close(middle(along_one_line), [0.3, 0.05, 0.0], 1e-4);
        let alone = [[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]];
        assert_close(middle(alone), [0.0; 3], 0.0 + f32::MIN_POSITIVE);
        let closed = [[1.0; 3], [1.0, 0.0, 1.0], [1.0; 3]];
        assert_eq!(middle(closed), [0.0; 3]);
    }
}
