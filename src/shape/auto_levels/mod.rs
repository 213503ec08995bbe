//! What is chosen from the whole frame: the gain of the curvature mapping and white levels, as every backend chooses.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod stage;

use crate::params::COARSE_ROUNDING;

/// Percentage of the surface whose curvature the gain leaves below [`TYPICAL_KAPPA`].
pub(crate) const CURVATURE_PERCENT: u32 = 80;

/// Mapped curvature that the percentile is brought to: clearly seen, far from saturated.
const TYPICAL_KAPPA: f32 = 0.35;

/// Gains past this would draw the rounding of half-float normals (5e-4 per pixel) as relief. It holds at
/// every factor of resolution: diffusion that counts f times as many pixels lowers noise by f^2, more
/// than the factor raises it.
pub(crate) const MAX_GAIN: f32 = 200.0;

/// Mapped curvature up to which the steps between codes of 8 bits may show.
const STEP_KAPPA: f32 = 0.1;

/// What is left of such a step, at the most, after slopes in codes were smoothed: a sixth on domes of 1000 pixels' radius and
/// more.
const LEFT_OF_STEP: f32 = 1.0 / 6.0;

/// The sigma of a Gaussian as high in its middle as a central difference makes a step.
const SIGMA_OF_DIFFERENCE_PX: f32 = 0.8;

/// Percentage of the surface that the white level leaves below it.
pub(crate) const WHITE_PERCENT: u32 = 98;

/// Surfaces that turn by less than this many radians over the whole picture are flat to the eye and
/// have no say: a room is mostly walls. An angle, it is the same at every resolution.
const FLAT_TURN: f32 = 0.25;

/// The greatest gain that is chosen, for normals rounded by up to `rounding` and a trace, `factor` times what it is per
/// pixel, of slopes that were diffused as by a Gaussian of `sigma_px`.
///
/// A step between two codes makes a ridge of curvature 2 rounding / (sqrt(2 pi) sigma).
pub(crate) fn most_gain(rounding: f32, sigma_px: f32, factor: f32) -> f32 {
    if rounding <= COARSE_ROUNDING {
        return MAX_GAIN;
    }
    let width = std::f32::consts::TAU.sqrt() * sigma_px.max(SIGMA_OF_DIFFERENCE_PX);
    (STEP_KAPPA * width / (2.0 * LEFT_OF_STEP * rounding * factor)).min(MAX_GAIN)
}

/// Target of the gain times typical curvature.
pub(crate) fn typical_exponent() -> f32 {
    TYPICAL_KAPPA.atanh()
}

/// The curvature, `factor` times what it is per pixel, up to which a surface is flat in a picture of this size.
pub(crate) fn flat_curvature(size: [usize; 2], factor: f32) -> f32 {
    factor * FLAT_TURN / (size[0] as f32).hypot(size[1] as f32)
}
