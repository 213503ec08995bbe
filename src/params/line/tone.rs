//! Tone: how dark a picture is drawn.

use crate::error::Result;
use crate::params::light::LEVELS;
use crate::params::{Adaptive, in_range};
use serde::Serialize;

/// From the luminance of a picture to the tone of paper: 0 black, 1 the paper itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ToneParams {
    /// Scene-linear luminance, 1e-38 or more, from which on the paper stays white; `Auto` takes a high percentile of the
    /// surface's own.
    pub white_point: Adaptive,
    /// Share of the white point, 0 to 0.99, up to which the drawing is black.
    pub black_point: f32,
    /// Exponent of the tone curve, 0.1 to 10: tone is the share of white to the power of 1 / gamma. At 1
    /// the drawing reflects as much light as the picture, from afar; higher values lighten it, toward what
    /// eyes call as bright.
    pub gamma: f32,
}

impl Default for ToneParams {
    fn default() -> Self {
        Self {
            white_point: Adaptive::Auto,
            black_point: 0.0,
            gamma: 2.2,
        }
    }
}

impl ToneParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        self.white_point.in_range("--white-point", LEVELS)?;
        in_range("--black-point", self.black_point, 0.0..=0.99)?;
        in_range("--tone-gamma", self.gamma, 0.1..=10.0)
    }
}
