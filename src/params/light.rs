//! What radiance scaling can be told.

use crate::error::{Error, Result};
use serde::Serialize;

/// How curvature per pixel is mapped to -1..1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CurvatureGain {
    /// Chosen from the frame, so that an ordinary bump on it is clearly seen.
    Auto,
    /// Given, in pixels: a bump of this radius maps to tanh(2).
    Fixed(f32),
}

impl std::fmt::Display for CurvatureGain {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => write!(f, "auto"),
            Self::Fixed(gain) => write!(f, "{gain}"),
        }
    }
}

impl std::str::FromStr for CurvatureGain {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => positive(text)
                .map(Self::Fixed)
                .ok_or("expected auto or a number above 0".into()),
        }
    }
}

/// The luminance that counts as full intensity when a finished picture is scaled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WhiteLevel {
    /// A high percentile of the surface's own luminance.
    Auto,
    /// Given, scene-linear.
    Fixed(f32),
}

impl std::fmt::Display for WhiteLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => write!(f, "auto"),
            Self::Fixed(level) => write!(f, "{level}"),
        }
    }
}

impl std::str::FromStr for WhiteLevel {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => positive(text)
                .map(Self::Fixed)
                .ok_or("expected auto or a number above 0".into()),
        }
    }
}

fn positive(text: &str) -> Option<f32> {
    text.parse()
        .ok()
        .filter(|v: &f32| v.is_finite() && *v > 0.0)
}

/// How radiance scaling alters a shading ([RS] section 4.2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScalingParams {
    /// Scaling magnitude gamma, 0 or more. 0 changes nothing; 1 is plain to see; past
    /// [`crate::light::radiance_scaling::monotone_limit`] concavities may show new dark rims.
    pub scaling: f32,
    /// Scaling-invariant point alpha, in (0, 1): intensities above it brighten on convexities and
    /// below it darken; concavities the other way round. Toward 0 convexities only brighten.
    pub invariant_point: f32,
    /// How curvature is mapped to -1..1.
    pub curvature_gain: CurvatureGain,
    /// The luminance that counts as intensity 1.
    pub white_level: WhiteLevel,
}

impl Default for ScalingParams {
    fn default() -> Self {
        Self {
            scaling: 1.0,
            invariant_point: 0.25,
            curvature_gain: CurvatureGain::Auto,
            white_level: WhiteLevel::Auto,
        }
    }
}

impl ScalingParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let bad = |name, value: f32, remedy: &str| {
            Err(Error::BadParameter {
                name,
                found: format!("is {value}"),
                remedy: remedy.into(),
            })
        };
        if !(self.scaling >= 0.0 && self.scaling.is_finite()) {
            return bad("--scaling", self.scaling, "give 0 or more");
        }
        if !(0.0..=1.0).contains(&self.invariant_point) {
            return bad("--invariant-point", self.invariant_point, "give 0 to 1");
        }
        Ok(())
    }
}
