//! What radiance scaling can be told.

use super::in_range;
use crate::error::Result;
use serde::Serialize;
use std::ops::RangeInclusive;

/// A number above 0 that is given, or chosen from the frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Adaptive {
    /// Chosen from the frame.
    Auto,
    /// Given.
    Fixed(f32),
}

/// Luminance that counts as white, and factors of radiance: whatever pictures in single precision have, and as much
/// as is chosen automatically.
pub(super) const LEVELS: RangeInclusive<f32> = 1e-38..=f32::MAX;
/// Curvature gains, in pixels: every product with a curvature is a number.
const GAINS_PX: RangeInclusive<f32> = 1e-30..=1e30;
/// Scaling magnitudes. From 60 on nothing changes any more: see
/// [`crate::light::radiance_scaling::ScalingCurve::of`].
const MAGNITUDES: RangeInclusive<f32> = 0.0..=1e6;

impl Adaptive {
    /// Refuses a number that is given unless it lies in `range`.
    pub(super) fn in_range(self, name: &'static str, range: RangeInclusive<f32>) -> Result<()> {
        match self {
            Self::Auto => Ok(()),
            Self::Fixed(value) => in_range(name, value, range),
        }
    }
}

impl std::fmt::Display for Adaptive {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => write!(f, "auto"),
            Self::Fixed(value) => write!(f, "{value}"),
        }
    }
}

impl std::str::FromStr for Adaptive {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let fixed = || {
            text.parse()
                .ok()
                .filter(|v: &f32| v.is_finite() && *v > 0.0)
        };
        match text {
            "auto" => Ok(Self::Auto),
            _ => fixed()
                .map(Self::Fixed)
                .ok_or("expected auto or a number above 0".into()),
        }
    }
}

/// How radiance scaling alters a shading ([RS] section 4.2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScalingParams {
    /// Scaling magnitude gamma, 0 to 1e6. 0 changes nothing; 1 is plain to see; past
    /// [`crate::light::radiance_scaling::monotone_limit`] concavities may show new dark rims.
    pub scaling: f32,
    /// Magnitude for ambient light and occlusion; [`ScalingParams::scaling`] where `None`.
    pub scaling_ambient: Option<f32>,
    /// Magnitude for diffusely reflected light, likewise.
    pub scaling_diffuse: Option<f32>,
    /// Magnitude for specularly reflected light, likewise.
    pub scaling_specular: Option<f32>,
    /// Scaling-invariant point alpha, in (0, 1): intensities above it brighten on convexities and
    /// below it darken; concavities the other way round. Toward 0 convexities only brighten.
    pub invariant_point: f32,
    /// Gain of the curvature mapped to -1..1, in pixels, 1e-30 to 1e30: a ball of this radius maps to tanh(2). `Auto`
    /// takes one that shows an ordinary bump of the frame clearly. Low gains show sharp features only;
    /// high ones saturate, and draw noise.
    pub curvature_gain: Adaptive,
    /// The scene-linear luminance that counts as intensity 1, from 1e-38 on. `Auto` takes a high percentile of the
    /// surface's own. Above it every intensity scales alike.
    pub white_level: Adaptive,
    /// White levels of single kinds of light, where these are told apart; [`ScalingParams::white_level`] for others.
    pub term_white_levels: TermWhiteLevels,
    /// Anisotropy lambda, -1..1, where the direction of the light is known: at 1 the curvature along the
    /// light counts, at -1 that across it, at 0 their sum.
    pub anisotropy: f32,
}

impl Default for ScalingParams {
    fn default() -> Self {
        Self {
            scaling: 1.0,
            scaling_ambient: None,
            scaling_diffuse: None,
            scaling_specular: None,
            invariant_point: 0.25,
            curvature_gain: Adaptive::Auto,
            white_level: Adaptive::Auto,
            term_white_levels: TermWhiteLevels::NONE,
            anisotropy: 0.0,
        }
    }
}

/// The kinds of light that radiance scaling tells apart.
pub const TERMS: [&str; 7] = [
    "ambient",
    "diffuse",
    "specular",
    "transmission",
    "subsurface",
    "coat",
    "sheen",
];

/// White levels by kind of light, as many as are given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TermWhiteLevels([Option<f32>; TERMS.len()]);

impl TermWhiteLevels {
    /// None is given.
    pub const NONE: Self = Self([None; TERMS.len()]);

    /// The level given for the light called `term`, one of [`TERMS`].
    pub fn of(&self, term: &str) -> Option<f32> {
        let index = TERMS.iter().position(|&name| name == term)?;
        self.0[index]
    }

    /// These levels, and for kinds of light that have none those of `others`.
    pub fn or<'a>(mut self, others: impl Iterator<Item = (&'a str, f32)>) -> Self {
        for (term, level) in others {
            if let Some(index) = TERMS.iter().position(|&name| name == term) {
                self.0[index].get_or_insert(level);
            }
        }
        self
    }
}

impl FromIterator<TermWhiteLevel> for TermWhiteLevels {
    fn from_iter<I: IntoIterator<Item = TermWhiteLevel>>(levels: I) -> Self {
        let mut all = Self::NONE;
        for TermWhiteLevel { term, level } in levels {
            all.0[term] = Some(level);
        }
        all
    }
}

/// The white level of one kind of light: `diffuse=0.4`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TermWhiteLevel {
    /// Index into [`TERMS`].
    term: usize,
    level: f32,
}

impl std::str::FromStr for TermWhiteLevel {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (name, level) = text
            .split_once('=')
            .ok_or("expected NAME=L, as in diffuse=0.4")?;
        let term = TERMS.iter().position(|&term| term == name);
        let term = term.ok_or_else(|| format!("expected one of {}", TERMS.join(", ")))?;
        match level.parse() {
            Ok(level) if level > 0.0 && f32::is_finite(level) => Ok(Self { term, level }),
            _ => Err("expected a level above 0".into()),
        }
    }
}

/// Scaling magnitudes gamma by term.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Magnitudes {
    /// For ambient light and occlusion.
    pub ambient: f32,
    /// For diffusely reflected light.
    pub diffuse: f32,
    /// For specularly reflected light.
    pub specular: f32,
}

impl ScalingParams {
    /// The magnitude of every term.
    pub fn magnitudes(&self) -> Magnitudes {
        Magnitudes {
            ambient: self.scaling_ambient.unwrap_or(self.scaling),
            diffuse: self.scaling_diffuse.unwrap_or(self.scaling),
            specular: self.scaling_specular.unwrap_or(self.scaling),
        }
    }

    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let magnitudes = [
            ("--scaling", Some(self.scaling)),
            ("--scaling-ambient", self.scaling_ambient),
            ("--scaling-diffuse", self.scaling_diffuse),
            ("--scaling-specular", self.scaling_specular),
        ];
        for (name, magnitude) in magnitudes {
            magnitude.map_or(Ok(()), |value| in_range(name, value, MAGNITUDES))?;
        }
        in_range("--invariant-point", self.invariant_point, 0.0..=1.0)?;
        in_range("--anisotropy", self.anisotropy, -1.0..=1.0)?;
        self.curvature_gain.in_range("--curvature-gain", GAINS_PX)?;
        self.white_level.in_range("--white-level", LEVELS)?;
        let levels = self.term_white_levels.0.into_iter().flatten();
        levels
            .into_iter()
            .try_for_each(|level| in_range("--term-white-level", level, LEVELS))
    }
}
