//! Curvature of the rows being lit, computed where it is used: planes of it would be written and read once each.

use crate::frame::{Frame, Plane, Vector2Planes};
use crate::kernel::simd::wide;
use crate::shape::Rows;
use crate::shape::hessian;

/// The source of curvature: the required part of the Hessian, or that part precomputed.
pub(crate) enum CurvedBy<'a> {
    /// All entries.
    Hessian(FlowSlopes<'a>),
    /// Its trace.
    Trace(FlowSlopes<'a>),
    /// Its trace, already computed for choosing the gain.
    Made(&'a Plane),
}

/// The diffused gradient, whose change across open pixels is the Hessian.
pub(crate) struct FlowSlopes<'a> {
    pub(crate) gradient: &'a Vector2Planes,
    pub(crate) conductance: &'a Plane,
    /// Converts from per pixel to per pixel of the reference.
    pub(crate) factor: f32,
}

/// The entries xx, xy and yy of a row, or its trace in the first row.
pub(crate) struct CurvatureRow {
    rows: [Vec<f32>; 3],
}

impl CurvatureRow {
    pub(crate) fn new(width: usize) -> Self {
        Self {
            rows: [(); 3].map(|()| vec![0.0; width]),
        }
    }

    /// Computes row `y`.
    pub(crate) fn make<'a>(&mut self, curvature: &CurvedBy<'a>, frame: &Frame, y: usize) {
        let columns = frame.mask.span(y);
        if columns.is_empty() {
            return;
        }
        let [first, second, third] = &mut self.rows;
        let around = |slopes: &FlowSlopes<'a>| {
            let FlowSlopes {
                gradient,
                conductance,
                ..
            } = slopes;
            [&gradient.x, &gradient.y, conductance].map(|plane| Rows::around(plane, y))
        };
        let factor = match curvature {
            CurvedBy::Hessian(slopes) => {
                let [gx, gy, c] = &around(slopes);
                wide!(hessian::hessian_row(
                    [first, second, third],
                    gx,
                    gy,
                    c,
                    columns.clone()
                ));
                slopes.factor
            }
            CurvedBy::Trace(slopes) => {
                let [gx, gy, c] = &around(slopes);
                wide!(hessian::trace_row(first, gx, gy, c, columns.clone()));
                slopes.factor
            }
            CurvedBy::Made(trace) => {
                first[columns.clone()].copy_from_slice(&trace.row(y)[columns.clone()]);
                1.0
            }
        };
        if factor != 1.0 {
            for row in &mut self.rows {
                row[columns.clone()].iter_mut().for_each(|v| *v *= factor);
            }
        }
    }

    /// Entry `k` of the row.
    pub(crate) fn entry(&self, k: usize) -> &[f32] {
        &self.rows[k]
    }
}
