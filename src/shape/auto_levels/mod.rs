//! Automatic choices from the whole frame, shared by all backends: the gain of the curvature mapping and white levels.

pub(crate) mod cpu;
pub(crate) mod gain_search;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod stage;

use crate::kernel::quantile::quantile;
use crate::params::COARSE_ROUNDING;

/// Mapped curvature where that is typical: clearly visible, far from saturated.
const TYPICAL_KAPPA: f32 = 0.38;

/// Curvature counts up to this factor of its 80th percentile, so that a few wrong normals don't rule.
const CLIP: f32 = 8.0;
const CLIP_SHARE: f64 = 0.8;

/// Higher gains would draw the rounding of half-float normals (5e-4 per pixel) as relief. The limit holds for every
/// resolution factor: diffusion over f times as many pixels lowers noise by f^2, more than the factor raises it.
pub(crate) const MAX_GAIN: f32 = 200.0;

/// Mapped curvature up to which steps between 8-bit codes may show.
const STEP_KAPPA: f32 = 0.1;

/// Remainder of such a step, at most, after smoothing of quantised slopes: a sixth on domes with a radius of 1000
/// pixels and more.
const LEFT_OF_STEP: f32 = 1.0 / 6.0;

/// The sigma of a Gaussian with the peak that a central difference gives a step.
pub(crate) const SIGMA_OF_DIFFERENCE_PX: f32 = 0.8;

/// Percentage of the surface below the white level.
pub(crate) const WHITE_PERCENT: u32 = 98;

/// Surfaces that turn by fewer radians than this over the whole picture look flat and are ignored: a room is mostly
/// walls. As an angle it is the same at every resolution.
const FLAT_TURN: f32 = 0.25;

/// Upper limit of an automatic gain, for normals rounded by up to `rounding` and a trace, `factor` times its value per
/// pixel, of slopes diffused as by a Gaussian of `sigma_px`, or the mean of several that are mixed.
///
/// A step between two codes makes a ridge of curvature 2 rounding / (sqrt(2 pi) sigma): with weights in proportion to
/// sigma, a mixed one is as high as that of their mean.
pub(crate) fn most_gain(rounding: f32, sigma_px: f32, factor: f32) -> f32 {
    if rounding <= COARSE_ROUNDING {
        return MAX_GAIN;
    }
    let width = std::f32::consts::TAU.sqrt() * sigma_px.max(SIGMA_OF_DIFFERENCE_PX);
    (STEP_KAPPA * width / (2.0 * LEFT_OF_STEP * rounding * factor)).min(MAX_GAIN)
}

/// The gain, at most `most`, for these magnitudes of curvature with their weights: it maps typical curvature, the mean
/// weighted by curvature itself, to [`TYPICAL_KAPPA`].
///
/// So a wall adds area, but hardly weight: the gain is that of the shapes beside it.
pub(crate) fn gain_of(curved: &[[f32; 2]], most: f32) -> f32 {
    let mut sizes: Vec<f32> = curved.iter().map(|&[size, _]| size).collect();
    let Some(high) = quantile(&mut sizes, CLIP_SHARE, f32::total_cmp) else {
        return most;
    };
    let [mut sum, mut squares] = [0.0; 2];
    for &[size, weight] in curved {
        let size = f64::from(size.min(CLIP * high));
        let share = f64::from(weight) * size;
        sum += share;
        squares += share * size;
    }
    ((f64::from(TYPICAL_KAPPA.atanh()) * sum / squares) as f32).min(most)
}

/// The curvature, `factor` times its value per pixel, below which a surface counts as flat in a picture of this size.
pub(crate) fn flat_curvature(size: [usize; 2], factor: f32) -> f32 {
    factor * FLAT_TURN / (size[0] as f32).hypot(size[1] as f32)
}
