//! From the luminance of a picture to the optical density that is drawn.

use super::light::luminance;
use crate::frame::{ColorPlanes, Frame};
use crate::line::tonal_art_map::MAX_DENSITY;
use crate::params::ToneParams;
use std::ops::Range;

/// The optical density of a picture, -ln(tone), looked up by luminance.
pub(super) struct Densities<'a> {
    color: &'a ColorPlanes,
    frame: &'a Frame,
    weights: [f32; 3],
    /// Luminance of paper white.
    white: f32,
    /// Densities at even steps of the square root of luminance, from 0 to white.
    table: Vec<f32>,
}

/// Steps of the table: twice those of an 8-bit display.
const STEPS: usize = 512;

impl<'a> Densities<'a> {
    pub(super) fn new(
        color: &'a ColorPlanes,
        frame: &'a Frame,
        weights: [f32; 3],
        white: f32,
        params: &ToneParams,
    ) -> Self {
        let density = |step: usize| {
            let share = (step as f32 / STEPS as f32).powi(2);
            let above_black = (share - params.black_point) / (1.0 - params.black_point);
            let tone = above_black.clamp(0.0, 1.0).powf(params.gamma.recip());
            -tone.ln().max(-MAX_DENSITY)
        };
        Self {
            color,
            frame,
            weights,
            white,
            table: (0..=STEPS).map(density).collect(),
        }
    }

    /// The densities of `columns` of row `y`.
    pub(super) fn row(&self, out: &mut [f32], y: usize, columns: Range<usize>) {
        let [r, g, b] = [&self.color.r, &self.color.g, &self.color.b]
            .map(|plane| &plane.row(y)[columns.clone()]);
        let alpha = self.frame.alpha.as_ref();
        let alpha = alpha.map(|plane| &plane.row(y)[columns.clone()]);
        for (i, out) in out.iter_mut().enumerate() {
            let seen = luminance([r[i], g[i], b[i]], self.weights);
            // The picture is premultiplied: a rim that covers half a pixel is as light as the rest.
            let whole = alpha.map_or(1.0, |alpha| alpha[i].clamp(LEAST_ALPHA, 1.0));
            *out = self.density(seen / (whole * self.white));
        }
    }

    #[inline(always)]
    fn density(&self, share: f32) -> f32 {
        // A NaN is black.
        let at = STEPS as f32 * share.max(0.0).min(1.0).sqrt();
        let step = (at as usize).min(STEPS - 1);
        let (a, b) = (self.table[step], self.table[step + 1]);
        a + (at - step as f32) * (b - a)
    }
}

/// Covered pixels are covered by half or more.
const LEAST_ALPHA: f32 = 0.5;
