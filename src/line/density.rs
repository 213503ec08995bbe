//! A table from the share of paper white to the optical density that is drawn.

use super::tonal_art_map::MAX_DENSITY;
use crate::frame::{Mask, Plane};
use crate::params::ToneParams;

/// Steps of the table: twice those of an 8-bit display.
pub(crate) const STEPS: usize = 512;

/// Covered pixels are covered by half or more.
pub(crate) const LEAST_ALPHA: f32 = 0.5;

/// The share of the paper that is covered at an optical density.
#[inline(always)]
pub(crate) fn coverage_at(density: f32) -> f32 {
    1.0 - (-density).exp()
}

/// Removes ink beyond the surface: there it is under the line of the silhouette.
pub(crate) fn keep_inside(ink: &mut Plane, mask: &Mask) {
    ink.each_with(mask.plane(), |ink, is_inside| {
        *ink = if is_inside { *ink } else { 0.0 };
    });
}

/// Optical densities, -ln(tone), at even steps of the square root of luminance, from 0 to that of paper white.
pub(crate) fn density_table(params: &ToneParams) -> Vec<f32> {
    let density = |step: usize| {
        let share = (step as f32 / STEPS as f32).powi(2);
        let above_black = (share - params.black_point) / (1.0 - params.black_point);
        let tone = above_black.clamp(0.0, 1.0).powf(params.gamma.recip());
        -tone.ln().max(-MAX_DENSITY)
    };
    (0..=STEPS).map(density).collect()
}
