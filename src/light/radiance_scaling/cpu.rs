//! Radiance scaling of a finished picture, row by row.

use crate::frame::luminance;
use crate::frame::memory::Memory;
use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{ColorPlanes, Mask, Plane, parallel_rows};
use crate::kernel::simd::wide;
use crate::light::radiance_scaling::{limited, scaled, scaling};
use crate::params::Magnitude;
use crate::shape::curvature::mapped_curvature;
use rayon::prelude::*;

/// Radiance scaling of a finished picture: intensity is its luminance over the white level, or given.
pub(crate) struct Scaler {
    pub(crate) magnitude: Magnitude,
    pub(crate) invariant_point: f32,
    pub(crate) gain: f32,
    pub(crate) white: f32,
    pub(crate) weights: [f32; 3],
}

impl Scaler {
    /// The scaled picture; by these intensities, 0..1, where given. Uncovered pixels, and those where curvature is 0, keep
    /// their bits.
    pub(crate) fn scale(
        &self,
        color: &ColorPlanes,
        intensities: Option<&Plane>,
        trace: &Plane,
        mask: &Mask,
        memory: &Memory,
    ) -> ColorPlanes {
        let mut scaled = [(); 3].map(|()| memory.plane(mask));
        parallel_rows(scaled.each_mut())
            .with_min_len(ROWS_PER_TASK)
            .for_each(|(y, mut to)| {
                let from = [&color.r, &color.g, &color.b].map(|plane| plane.row(y));
                let span = mask.span(y);
                let (before, after) = (..span.start, span.end..);
                for (to, from) in to.iter_mut().zip(from) {
                    to[before].copy_from_slice(&from[before]);
                    to[after.clone()].copy_from_slice(&from[after.clone()]);
                }
                let (trace, covered) = (&trace.row(y)[span.clone()], &mask.row(y)[span.clone()]);
                let to = to.map(|to| &mut to[span.clone()]);
                let from = from.map(|from| &from[span.clone()]);
                let given = intensities.map(|plane| &plane.row(y)[span]);
                wide!(scale_row(self, to, from, given, trace, covered));
            });
        let [r, g, b] = scaled;
        ColorPlanes { r, g, b }
    }
}

/// A row of the scaled picture, all slices of equal length.
#[inline(always)]
pub(crate) fn scale_row(
    scaler: &Scaler,
    out: [&mut [f32]; 3],
    from: [&[f32]; 3],
    intensities: Option<&[f32]>,
    trace: &[f32],
    covered: &[bool],
) {
    let of = |rgb| luminance(rgb, scaler.weights) / scaler.white;
    match intensities {
        None => scale_by(scaler, out, from, trace, covered, |_, rgb| of(rgb)),
        Some(given) => {
            let given = &given[..trace.len()];
            scale_by(scaler, out, from, trace, covered, |x, _| {
                limited(given[x], 1.0)
            });
        }
    }
}

/// [`scale_row`] by the intensity of each pixel. Branch-free, so that it vectorises.
#[inline(always)]
fn scale_by(
    scaler: &Scaler,
    [r, g, b]: [&mut [f32]; 3],
    [from_r, from_g, from_b]: [&[f32]; 3],
    trace: &[f32],
    covered: &[bool],
    intensity: impl Fn(usize, [f32; 3]) -> f32,
) {
    let width = trace.len();
    let (r, g, b) = (&mut r[..width], &mut g[..width], &mut b[..width]);
    let (from_r, from_g, from_b) = (&from_r[..width], &from_g[..width], &from_b[..width]);
    let covered = &covered[..width];
    for x in 0..width {
        let rgb = [from_r[x], from_g[x], from_b[x]];
        let kappa = mapped_curvature(trace[x], scaler.gain);
        let exponent = scaler.magnitude.exponent(kappa);
        let sigma = scaling(intensity(x, rgb), exponent, scaler.invariant_point);
        let changes = covered[x] & (trace[x] != 0.0);
        let shown = |c: f32| if changes { scaled(c, sigma) } else { c };
        (r[x], g[x], b[x]) = (shown(rgb[0]), shown(rgb[1]), shown(rgb[2]));
    }
}
