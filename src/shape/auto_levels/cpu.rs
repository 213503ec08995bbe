//! Automatic choices from the whole frame: the gain of the curvature mapping and the white level.

use crate::engine::cpu::percentile::percentile;
use crate::frame::{ColorPlanes, Mask, Plane, Window, luminance};
pub(crate) use crate::shape::auto_levels::WHITE_PERCENT;
use crate::shape::auto_levels::{CURVATURE_PERCENT, flat_curvature, typical_exponent};

/// The gain that maps the 80th percentile of |trace| to 0.35, over curved pixels off edges in `part`, counted from the
/// corner of the planes; `mask` is that of the part.
///
/// The trace is `factor` times its value per pixel of the plane; the gain is at most `most`.
pub(crate) fn curvature_gain(
    trace: &Plane,
    conductance: &Plane,
    (mask, part): (&Mask, Window),
    factor: f32,
    most: f32,
) -> f32 {
    let flat = flat_curvature([part.width(), part.height()], factor);
    let corner = [part.x0 as usize, part.y0 as usize];
    let typical = percentile(mask, CURVATURE_PERCENT, |x, y| {
        curved(trace, conductance, flat, [x + corner[0], y + corner[1]])
    });
    gain_of(typical, most)
}

/// The magnitude of the trace at a pixel, off edges and where the surface is not flat.
pub(super) fn curved(
    trace: &Plane,
    conductance: &Plane,
    flat: f32,
    [x, y]: [usize; 2],
) -> Option<f32> {
    let size = trace.at(x, y).abs();
    (size > flat && conductance.at(x, y) > 0.5).then_some(size)
}

/// The gain for a typical magnitude of the trace.
pub(super) fn gain_of(typical: Option<f32>, most: f32) -> f32 {
    match typical {
        Some(typical) if typical > 0.0 => (typical_exponent() / typical).min(most),
        _ => most,
    }
}

/// A high percentile of the luminance of the covered pixels; 1 if all are black.
pub(crate) fn white_level(color: &ColorPlanes, weights: [f32; 3], mask: &Mask) -> f32 {
    white_of(percentile(mask, WHITE_PERCENT, |x, y| {
        Some(luminance_at(color, weights, x, y))
    }))
}

/// The luminance of a pixel.
#[inline]
pub(crate) fn luminance_at(color: &ColorPlanes, weights: [f32; 3], x: usize, y: usize) -> f32 {
    luminance(
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y)),
        weights,
    )
}

/// The white level from a percentile of luminance.
pub(crate) fn white_of(percentile: Option<f32>) -> f32 {
    percentile.filter(|&white| white > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::auto_levels::most_gain;

    /// The gain of a whole picture without edges.
    fn gain(trace: &Plane, factor: f32, most: f32) -> f32 {
        let (width, height) = (trace.width(), trace.height());
        let whole = (&Mask::full(width, height), Window::from_size(width, height));
        let open = Plane::filled(width, height, 1.0);
        curvature_gain(trace, &open, whole, factor, most)
    }

    #[test]
    fn the_gain_brings_typical_curvature_to_its_target() {
        // Nine tenths of the curved pixels at |trace| 0.05, and a wall: tanh(gain * 0.05) = 0.35.
        let trace = Plane::from_fn(100, 1, |x, _| match x {
            0 => 9.0,
            1..10 => -0.05,
            _ => 1e-5,
        });
        let of_bumps = gain(&trace, 1.0, 200.0);
        assert!(((of_bumps * 0.05).tanh() - 0.35).abs() < 1e-6);
        // A plane: rounding noise is not amplified without limit.
        assert_eq!(gain(&Plane::filled(4, 4, 1e-9), 1.0, 200.0), 200.0);
        // Measured per pixel of a reference a fifth as high, the bumps need a fifth of the gain; pixels too flat to
        // count remain so.
        let fifth = gain(&trace.map(|t| 5.0 * t), 5.0, 200.0);
        assert!((5.0 * fifth / of_bumps - 1.0).abs() < 1e-6);
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
        assert_eq!(gain(&Plane::filled(4, 4, 1e-9), 1.0, 30.0), 30.0);
    }
}
