//! The Hessian of the height field: the Sobel derivative of its gradient.

use crate::shape::{Rows, sobel};

/// Symmetric Hessian [xx, xy, yy] per pixel, y up, from the 3x3 gradients around column `x`,
/// scaled by the pixel's conductance: edges count as flat.
///
/// Source: [LW] algorithm 1, step 7. With a foreshortening other than 1 the gradient is not a
/// gradient of anything, and the mean of the two mixed derivatives is taken.
#[inline(always)]
pub fn hessian(gx: &Rows, gy: &Rows, x: usize, conductance: f32) -> [f32; 3] {
    if conductance == 0.0 {
        return [0.0; 3];
    }
    let [xx, xy] = sobel(gx.neighbourhood(x));
    let [yx, yy] = sobel(gy.neighbourhood(x));
    [
        conductance * xx,
        conductance * 0.5 * (xy + yx),
        conductance * yy,
    ]
}

/// Trace of [`hessian`] alone: all that isotropic scaling needs.
#[inline(always)]
pub fn trace(gx: &Rows, gy: &Rows, x: usize, conductance: f32) -> f32 {
    if conductance == 0.0 {
        return 0.0;
    }
    let [xx, _] = sobel(gx.neighbourhood(x));
    let [_, yy] = sobel(gy.neighbourhood(x));
    conductance * xx + conductance * yy
}

/// Pixels read to each side.
pub const REACH: usize = 1;
