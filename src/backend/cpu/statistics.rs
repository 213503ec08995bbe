//! What is chosen from the whole frame: the gain of the curvature mapping and the white level.

use crate::frame::{ColorPlanes, Mask, Plane};

/// Share of the surface whose curvature the gain leaves below [`TYPICAL_KAPPA`].
const CURVATURE_PERCENTILE: f64 = 0.80;

/// Mapped curvature that the percentile is brought to: clearly seen, far from saturated.
const TYPICAL_KAPPA: f32 = 0.35;

/// Gains past this would draw the rounding of half-float normals (5e-4 per pixel) as relief. It holds at
/// every factor of resolution: diffusion that counts f times as many pixels lowers noise by f^2, more
/// than the factor raises it.
const MAX_GAIN: f32 = 200.0;

/// Share of the surface that the white level leaves below it.
const WHITE_PERCENTILE: f64 = 0.98;

/// Surfaces that turn by less than this many radians over the whole picture are flat to the eye and
/// have no say: a room is mostly walls. An angle, it is the same at every resolution.
const FLAT_TURN: f32 = 0.25;

/// The gain that maps the 80th percentile of |trace| to 0.35, over what is curved, edges left out.
///
/// The trace is `factor` times what it is per pixel of the plane.
pub(super) fn curvature_gain(trace: &Plane, conductance: &Plane, factor: f32) -> f32 {
    let flat = factor * FLAT_TURN / (trace.width() as f32).hypot(trace.height() as f32);
    let curved = trace
        .samples()
        .iter()
        .zip(conductance.samples())
        .filter(|&(_, &c)| c > 0.5)
        .map(|(t, _)| t.abs())
        .filter(|&t| t > flat)
        .collect();
    match percentile(curved, CURVATURE_PERCENTILE) {
        Some(typical) if typical > 0.0 => (TYPICAL_KAPPA.atanh() / typical).min(MAX_GAIN),
        _ => MAX_GAIN,
    }
}

/// A high percentile of the luminance of the covered pixels; 1 where none has any.
pub(super) fn white_level(color: &ColorPlanes, weights: [f32; 3], mask: &Mask) -> f32 {
    let covered = mask.plane().samples();
    let rgb = color
        .r
        .samples()
        .iter()
        .zip(color.g.samples())
        .zip(color.b.samples());
    let luminances = rgb
        .zip(covered)
        .filter(|&(_, &covered)| covered)
        .map(|(((r, g), b), _)| super::light::luminance([*r, *g, *b], weights))
        .collect();
    percentile(luminances, WHITE_PERCENTILE)
        .filter(|&white| white > 0.0)
        .unwrap_or(1.0)
}

/// The value below which the share `share` of the finite ones lies; `None` if there are none.
fn percentile(mut values: Vec<f32>, share: f64) -> Option<f32> {
    values.retain(|v| v.is_finite());
    let last = values.len().checked_sub(1)?;
    let index = (share * last as f64).round() as usize;
    Some(*values.select_nth_unstable_by(index, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_hostile_values() {
        assert_eq!(percentile(vec![], 0.5), None);
        assert_eq!(percentile(vec![f32::NAN, f32::INFINITY], 0.5), None);
        assert_eq!(percentile(vec![3.0, f32::NAN, 1.0, 2.0], 0.5), Some(2.0));
    }

    #[test]
    fn the_gain_brings_typical_curvature_to_its_target() {
        // Nine tenths of what is curved at |trace| 0.05, and a wall: tanh(gain * 0.05) = 0.35.
        let trace = Plane::from_fn(100, 1, |x, _| match x {
            0 => 9.0,
            1..10 => -0.05,
            _ => 1e-5,
        });
        let gain = curvature_gain(&trace, &Plane::filled(100, 1, 1.0), 1.0);
        assert!(((gain * 0.05).tanh() - TYPICAL_KAPPA).abs() < 1e-6);
        // A plane: rounding noise is not blown up without end.
        assert_eq!(
            curvature_gain(&Plane::filled(4, 4, 1e-9), &Plane::filled(4, 4, 1.0), 1.0),
            MAX_GAIN
        );
        // Told per pixel of a reference a fifth as high, the bumps have a fifth of the gain; what was too
        // flat to count still is.
        let fifth = curvature_gain(&trace.map(|t| 5.0 * t), &Plane::filled(100, 1, 1.0), 5.0);
        assert!((5.0 * fifth / gain - 1.0).abs() < 1e-6);
    }
}
