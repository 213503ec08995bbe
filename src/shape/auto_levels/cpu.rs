//! Automatic choices from the whole frame: the gain of the curvature mapping and the white level.

use crate::engine::cpu::percentile::{PercentileSearch, percentile};
use crate::frame::{ColorPlanes, Mask, Plane, Window, luminance};
pub(crate) use crate::shape::auto_levels::WHITE_PERCENT;
use crate::shape::auto_levels::{CURVATURE_PERCENT, flat_curvature, typical_exponent};
use std::ops::Range;

/// The gain that maps the 80th percentile of |trace| to 0.35, over curved pixels off edges.
///
/// The trace is `factor` times its value per pixel of the plane; the gain is at most `most`.
pub(crate) fn curvature_gain(trace: &Plane, conductance: &Plane, factor: f32, most: f32) -> f32 {
    let whole = Window::from_size(trace.width(), trace.height());
    gain_within(trace, conductance, whole, factor, most)
}

/// [`curvature_gain`] of the pixels in `part`, counted from the corner of the planes.
pub(crate) fn gain_within(
    trace: &Plane,
    conductance: &Plane,
    part: Window,
    factor: f32,
    most: f32,
) -> f32 {
    let flat = flat_curvature([part.width(), part.height()], factor);
    let columns = part.x0 as usize..part.x1 as usize;
    let curved = |y| {
        let y = y + part.y0 as usize;
        let row = |plane| &Plane::row(plane, y)[columns.clone()];
        curved(row(trace), row(conductance), flat)
    };
    gain_of(percentile(part.height(), CURVATURE_PERCENT, curved), most)
}

/// The magnitudes of the trace in a row, off edges and where the surface is not flat.
fn curved<'a>(
    trace: &'a [f32],
    conductance: &'a [f32],
    flat: f32,
) -> impl Iterator<Item = f32> + 'a {
    let samples = trace.iter().zip(conductance);
    samples
        .filter(|&(_, &c)| c > 0.5)
        .map(|(t, _)| t.abs())
        .filter(move |&t| t > flat)
}

/// The gain for a typical magnitude of the trace.
fn gain_of(typical: Option<f32>, most: f32) -> f32 {
    match typical {
        Some(typical) if typical > 0.0 => (typical_exponent() / typical).min(most),
        _ => most,
    }
}

/// A search for the gain in a picture passed as groups of rows, each twice.
#[derive(Debug, Clone)]
pub(crate) struct GainSearch {
    pub(crate) search: PercentileSearch,
    flat: f32,
    most: f32,
}

impl GainSearch {
    /// For a picture of this size, a trace of `factor` times its value per pixel, and a gain of at most `most`.
    pub(crate) fn new(size: [usize; 2], factor: f32, most: f32) -> Self {
        Self {
            search: PercentileSearch::new(CURVATURE_PERCENT),
            flat: flat_curvature(size, factor),
            most,
        }
    }

    pub(crate) fn add(&mut self, rows: Range<usize>, trace: &Plane, conductance: &Plane) {
        let flat = self.flat;
        self.search
            .add(rows, |y| curved(trace.row(y), conductance.row(y), flat));
    }

    pub(crate) fn gain(&self) -> f32 {
        gain_of(self.search.found(), self.most)
    }
}

/// A high percentile of the luminance of the covered pixels; 1 if all are black.
pub(crate) fn white_level(color: &ColorPlanes, weights: [f32; 3], mask: &Mask) -> f32 {
    let luminances = |y| luminances(color, weights, mask, y);
    white_of(percentile(mask.height(), WHITE_PERCENT, luminances))
}

/// The white level of a precomputed `luminance`.
pub(crate) fn white_level_of(luminance: &Plane, mask: &Mask) -> f32 {
    let samples = |y| covered(luminance, mask, y);
    white_of(percentile(mask.height(), WHITE_PERCENT, samples))
}

/// The covered samples of a row.
pub(crate) fn covered<'a>(
    plane: &'a Plane,
    mask: &'a Mask,
    y: usize,
) -> impl Iterator<Item = f32> + 'a {
    let (row, covered) = (plane.row(y), mask.row(y));
    mask.span(y).filter(|&x| covered[x]).map(|x| row[x])
}

/// The luminance of the covered pixels of a row.
pub(crate) fn luminances(
    color: &ColorPlanes,
    weights: [f32; 3],
    mask: &Mask,
    y: usize,
) -> impl Iterator<Item = f32> {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(|plane| plane.row(y));
    let covered = mask.row(y);
    mask.span(y)
        .filter(|&x| covered[x])
        .map(move |x| luminance([r[x], g[x], b[x]], weights))
}

/// The white level from a percentile of luminance.
pub(crate) fn white_of(percentile: Option<f32>) -> f32 {
    percentile.filter(|&white| white > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::auto_levels::most_gain;

    #[test]
    fn the_gain_brings_typical_curvature_to_its_target() {
        // Nine tenths of the curved pixels at |trace| 0.05, and a wall: tanh(gain * 0.05) = 0.35.
        let trace = Plane::from_fn(100, 1, |x, _| match x {
            0 => 9.0,
            1..10 => -0.05,
            _ => 1e-5,
        });
        let gain = curvature_gain(&trace, &Plane::filled(100, 1, 1.0), 1.0, 200.0);
        assert!(((gain * 0.05).tanh() - 0.35).abs() < 1e-6);
        // A plane: rounding noise is not amplified without limit.
        assert_eq!(
            curvature_gain(
                &Plane::filled(4, 4, 1e-9),
                &Plane::filled(4, 4, 1.0),
                1.0,
                200.0
            ),
            200.0
        );
        // Measured per pixel of a reference a fifth as high, the bumps need a fifth of the gain; pixels too flat to
        // count remain so.
        let fifth = curvature_gain(
            &trace.map(|t| 5.0 * t),
            &Plane::filled(100, 1, 1.0),
            5.0,
            200.0,
        );
        assert!((5.0 * fifth / gain - 1.0).abs() < 1e-6);
    }

    #[test]
    fn steps_of_coarse_normals_stay_out_of_sight() {
        // A sixth of 2/255, differenced over two pixels, is a ridge of 6.5e-4: tanh(153 * 6.5e-4) = 0.1.
        let at_8_bits = most_gain(1.0 / 255.0, 0.5, 1.0);
        assert!((at_8_bits - 153.4).abs() < 0.1, "{at_8_bits}");
        // Measured in pixels of a reference a third as high, the ridge is three times as high.
        assert!((most_gain(1.0 / 255.0, 0.5, 3.0) - 51.1).abs() < 0.1);
        // Diffused by two pixels it is a fifth as high.
        assert_eq!(most_gain(1.0 / 255.0, 2.0, 1.0), 200.0);
        // Steps of half floats are too fine to be visible.
        assert_eq!(most_gain(1.0 / 4096.0, 1.0, 1.0), 200.0);
        assert_eq!(most_gain(0.0, 0.0, 1.0), 200.0);
        let flat = Plane::filled(4, 4, 1e-9);
        assert_eq!(
            curvature_gain(&flat, &Plane::filled(4, 4, 1.0), 1.0, 30.0),
            30.0
        );
    }
}
