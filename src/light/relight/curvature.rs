//! Curvature of the rows being lit, computed where it is used: planes of it would be written and read once each.

use crate::engine::cpu::simd::Simd;
use crate::frame::{Frame, Plane, Vector2Planes};
use crate::shape::Rows;

/// The source of curvature, or precomputed curvature.
pub(crate) struct Curvature<'a> {
    pub(crate) gradient: &'a Vector2Planes,
    pub(crate) conductance: &'a Plane,
    /// Converts from per pixel to per pixel of the reference.
    pub(crate) factor: f32,
    pub(crate) kind: Kind<'a>,
}

/// The required part of the Hessian.
pub(crate) enum Kind<'a> {
    /// All entries.
    Hessian,
    /// Its trace.
    Trace,
    /// Its trace, already computed for choosing the gain.
    Made(&'a Plane),
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
    pub(crate) fn make(&mut self, curvature: &Curvature, frame: &Frame, y: usize, simd: Simd) {
        let Curvature {
            gradient,
            conductance,
            ..
        } = curvature;
        let around = [&gradient.x, &gradient.y, conductance].map(|plane| Rows::around(plane, y));
        let [gx, gy, c] = &around;
        let columns = frame.mask.span(y);
        if columns.is_empty() {
            return;
        }
        let [first, second, third] = &mut self.rows;
        match curvature.kind {
            Kind::Hessian => {
                simd.hessian_row([first, second, third], gx, gy, c, columns.clone());
            }
            Kind::Trace => simd.trace_row(first, gx, gy, c, columns.clone()),
            Kind::Made(trace) => {
                first[columns.clone()].copy_from_slice(&trace.row(y)[columns]);
                return;
            }
        }
        if curvature.factor != 1.0 {
            for row in &mut self.rows {
                row[columns.clone()]
                    .iter_mut()
                    .for_each(|v| *v *= curvature.factor);
            }
        }
    }

    /// Entry `k` of the row.
    pub(crate) fn entry(&self, k: usize) -> &[f32] {
        &self.rows[k]
    }
}
