//! The parameters of radiance scaling.

use super::table::{Kind, Many, Unit, by_factors, even};
use super::value::{Value, finite};
use super::{Group, Param};
use std::ops::RangeInclusive;

number_or_word! {
    /// A positive number, given or chosen from the frame.
    pub enum Adaptive {
        /// Chosen from the frame.
        Auto = "auto",
        /// Given.
        Fixed(f32),
    }
    whole: false,
    numbers: |number| number.is_finite() && *number > 0.0,
    expected: "expected auto or a number above 0",
}

/// Luminances that count as white, and factors of radiance: all positive values of single precision, so that every
/// automatic choice is valid.
pub(super) const LEVELS: RangeInclusive<f32> = 1e-38..=f32::MAX;
/// Curvature gains in pixels, limited so that gain times curvature stays finite.
const GAINS_PX: RangeInclusive<f32> = 1e-30..=1e30;
/// Scaling magnitudes. Above 60 the result no longer changes: see [`crate::light::radiance_scaling::ScalingCurve::of`].
const MAGNITUDES: RangeInclusive<f32> = 0.0..=1e6;

params! {
    /// Radiance scaling of a shading ([RS] section 4).
    pub struct ScalingParams in Scaling {
        /// Curvature gain in pixels, or auto to fit the frame.
        ///
        /// Curvature is mapped to -1..1: a ball of this radius to tanh(2). Auto takes a gain that shows an ordinary bump
        /// of the frame clearly. Low gains show sharp features only; high ones saturate, and draw noise.
        curvature_gain: Adaptive = Adaptive::Auto,
            flag: "--curvature-gain", alias: Some("gain"), form: "K|auto", group: Group::Shape, unit: Unit::Pixels,
            valid: GAINS_PX, useful: by_factors(0.1, 200.0);
        /// Scaling magnitude: 0 changes nothing.
        ///
        /// The gamma of the paper. 1 is clearly visible; past [`crate::light::radiance_scaling::monotone_limit`]
        /// concavities may show new dark rims.
        scaling: f32 = 1.0, flag: "--scaling", common: true, alias: Some("strength"), form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Scaling magnitude of convexities, for all light without one of its own; --scaling by default.
        scaling_convex: Option<f32> = None,
            flag: "--scaling-convex", form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Scaling magnitude of concavities, for all light without one of its own; --scaling by default.
        scaling_concave: Option<f32> = None,
            flag: "--scaling-concave", form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Scaling magnitude for ambient light and occlusion; --scaling by default.
        scaling_ambient: Option<f32> = None,
            flag: "--scaling-ambient", form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Scaling magnitude for diffuse light; --scaling by default.
        scaling_diffuse: Option<f32> = None,
            flag: "--scaling-diffuse", form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Scaling magnitude for specular light; --scaling by default.
        scaling_specular: Option<f32> = None,
            flag: "--scaling-specular", form: "G", valid: MAGNITUDES, useful: even(0.0, 4.0);
        /// Intensity, 0..1, that scaling leaves unchanged; brighter ones brighten on convexities.
        ///
        /// The alpha of the paper: on convexities intensities below it darken; on concavities the effect is reversed.
        /// Toward 0 convexities only brighten.
        invariant_point: f32 = 0.25,
            flag: "--invariant-point", form: "A", valid: 0.0..=1.0, useful: even(0.01, 0.99);
        /// Which curvature brightens and darkens the light of a lamp: 1 the bends met along its direction in the
        /// picture, as over ridges that lie across it; -1 those met across its direction; 0 all alike.
        ///
        /// The lambda of the paper, for directional lights and light groups.
        anisotropy: f32 = 0.0, flag: "--anisotropy", form: "L", valid: -1.0..=1.0, useful: even(-1.0, 1.0);
        /// Luminance that counts as intensity 1, or auto to fit the picture.
        ///
        /// In scene-linear units. Auto takes a high percentile over the surface. All intensities above it scale alike.
        /// In new light it is for light that is looked up; auto compares that with its median (see middle_light), and
        /// prefiltered diffuse light and lit spheres for a display with their largest ([RS] section 5.3).
        white_level: Adaptive = Adaptive::Auto,
            flag: "--white-level", form: "L|auto",
            valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// White level of one kind of light where lobes are scaled separately: diffuse=0.4. Repeatable.
        term_white_levels: TermWhiteLevels = TermWhiteLevels::NONE,
            flag: "--term-white-level", form: "NAME=L", group: Group::WhiteLevels, many: Many::Repeated, valid: LEVELS;
    }
}

/// The kinds of light that radiance scaling distinguishes.
pub(crate) const TERMS: [&str; 7] = [
    "ambient",
    "diffuse",
    "specular",
    "transmission",
    "subsurface",
    "coat",
    "sheen",
];

/// The white levels given, by kind of light: `diffuse=0.4`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct TermWhiteLevels([Option<f32>; TERMS.len()]);

impl TermWhiteLevels {
    /// No level is given.
    pub const NONE: Self = Self([None; TERMS.len()]);

    /// The level given for `term`, one of `TERMS`.
    pub fn of(&self, term: &str) -> Option<f32> {
        let index = TERMS.iter().position(|&name| name == term)?;
        self.0[index]
    }

    /// These levels, completed by `others` for kinds of light without one.
    pub fn or<'a>(mut self, others: impl Iterator<Item = (&'a str, f32)>) -> Self {
        for (term, level) in others {
            if let Some(index) = TERMS.iter().position(|&name| name == term) {
                self.0[index].get_or_insert(level);
            }
        }
        self
    }
}

impl Value for TermWhiteLevels {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        let mut levels = Self::NONE;
        for one in text.split(',') {
            let (name, level) = one
                .split_once('=')
                .ok_or("expected NAME=L, as in diffuse=0.4")?;
            let term = TERMS.iter().position(|&term| term == name);
            let term = term.ok_or_else(|| format!("expected one of {}", TERMS.join(", ")))?;
            let level = finite(level).filter(|&level| level > 0.0);
            levels.0[term] = Some(level.ok_or("expected a level above 0")?);
        }
        Ok(levels)
    }

    fn text(&self, _: &Param) -> Option<String> {
        let given = TERMS.iter().zip(self.0);
        let given = given.filter_map(|(term, level)| Some(format!("{term}={}", level?)));
        let given: Vec<_> = given.collect();
        (!given.is_empty()).then(|| given.join(","))
    }

    fn outside(&self, row: &Param) -> Option<String> {
        self.0.iter().find_map(|level| level.outside(row))
    }
}

/// The scaling magnitude gamma of convexities, and that of concavities.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Magnitude {
    /// Of convexities.
    pub convex: f32,
    /// Of concavities.
    pub concave: f32,
}

impl Magnitude {
    /// One magnitude for both.
    pub fn of_both(magnitude: f32) -> Self {
        Self {
            convex: magnitude,
            concave: magnitude,
        }
    }

    /// The exponent gamma kappa of mapped curvature.
    #[inline(always)]
    pub fn exponent(self, kappa: f32) -> f32 {
        let magnitude = if kappa >= 0.0 {
            self.convex
        } else {
            self.concave
        };
        magnitude * kappa
    }

    /// The larger ones of both.
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            convex: self.convex.max(other.convex),
            concave: self.concave.max(other.concave),
        }
    }

    /// The larger of the two: of 0 nothing changes.
    pub fn largest(self) -> f32 {
        self.convex.max(self.concave)
    }
}

impl std::fmt::Display for Magnitude {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.convex == self.concave {
            true => write!(f, "{}", self.convex),
            false => write!(f, "{} convex and {} concave", self.convex, self.concave),
        }
    }
}

/// Scaling magnitudes gamma by term.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Magnitudes {
    /// For ambient light and occlusion.
    pub ambient: Magnitude,
    /// For diffusely reflected light.
    pub diffuse: Magnitude,
    /// For specularly reflected light.
    pub specular: Magnitude,
}

impl ScalingParams {
    /// The same with magnitudes of 0.
    pub(crate) fn none(self) -> Self {
        Self {
            scaling: 0.0,
            scaling_convex: None,
            scaling_concave: None,
            scaling_ambient: None,
            scaling_diffuse: None,
            scaling_specular: None,
            ..self
        }
    }

    /// The magnitude of every term.
    pub fn magnitudes(&self) -> Magnitudes {
        let of = |own: Option<f32>| own.map_or_else(|| self.magnitude(), Magnitude::of_both);
        Magnitudes {
            ambient: of(self.scaling_ambient),
            diffuse: of(self.scaling_diffuse),
            specular: of(self.scaling_specular),
        }
    }

    /// The magnitude of a picture as a whole, and of terms without one of their own.
    pub fn magnitude(&self) -> Magnitude {
        Magnitude {
            convex: self.scaling_convex.unwrap_or(self.scaling),
            concave: self.scaling_concave.unwrap_or(self.scaling),
        }
    }
}
