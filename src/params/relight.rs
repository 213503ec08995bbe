//! What relighting can be told: how light is altered, what the surface is made of, how finely light is
//! sampled.

use super::light::LEVELS;
use super::{Adaptive, in_range};
use crate::error::Result;
use serde::Serialize;
use std::ops::RangeInclusive;

/// How light is altered to show shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Not at all.
    Plain,
    /// Light warping: its directions are bent by curvature ([LW]).
    Warp,
    /// Radiance scaling: what is reflected is scaled by curvature ([RS]).
    Scale,
    /// Directions are bent, then what is reflected is scaled ([RS] figure 14).
    Both,
}

impl Method {
    /// Whether directions are bent.
    pub fn warps(self) -> bool {
        matches!(self, Self::Warp | Self::Both)
    }

    /// Whether what is reflected is scaled.
    pub fn scales(self) -> bool {
        matches!(self, Self::Scale | Self::Both)
    }
}

/// How light warping bends and brightens ([LW] sections 5 and 6.2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WarpingParams {
    /// Strength, 0 to 1e6; the paper's alpha is this times the curvature gain. 0 bends nothing; the
    /// bend saturates at 60 degrees for light from the side.
    pub warp: f32,
    /// Contrast, -1..1: above 0 concavities brighten and convexities darken, below 0 the other way
    /// round, at most by the factor 3 to this power.
    pub contrast: f32,
}

/// Which side of the light integral is warped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WarpBy {
    /// Lights where light is sampled, look-ups where it is prefiltered or mirrored.
    Auto,
    /// Every look-up into the environment ([LW] equation 1).
    Lookups,
    /// Sampled lights, each with the Jacobian of the inverse ([LW] equation 2).
    Lights,
}

/// Where the colour of the surface itself comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AlbedoSource {
    /// A layer where there is one, else an estimate from the picture, else white.
    Auto,
    /// A layer or file.
    Layer,
    /// The picture divided by the shading that fits it best.
    Estimate,
    /// The picture as it is: scans under even light.
    Picture,
    /// White.
    White,
}

/// How many samples stand for an environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Samples {
    /// Prefiltered where that serves, else as many as the paper shows.
    Auto,
    /// This many; 0 looks prefiltered maps up.
    Fixed(u32),
}

/// Factors of light, and of the warp.
const FACTORS: RangeInclusive<f32> = 0.0..=1e6;

/// Exponents of highlights: at a million they are a twentieth of a degree wide.
const EXPONENTS: RangeInclusive<f32> = 0.0..=1e6;

/// Angles in degrees: past a million turns single precision tells no direction.
pub(crate) const ANGLES_DEG: RangeInclusive<f32> = -1e6..=1e6;

/// Samples of an environment where none are asked for: [LW] figure 1.
pub const AUTO_SAMPLES: u32 = 54;

/// Most samples of an environment, and most lights.
pub const MAX_LIGHTS: u32 = 100_000;

impl std::fmt::Display for Samples {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => write!(f, "auto"),
            Self::Fixed(count) => write!(f, "{count}"),
        }
    }
}

impl std::str::FromStr for Samples {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => text
                .parse()
                .ok()
                .filter(|count| *count <= MAX_LIGHTS)
                .map(Self::Fixed)
                .ok_or(format!(
                    "expected auto or a whole number up to {MAX_LIGHTS}"
                )),
        }
    }
}

/// Which way the brushed grain of an anisotropic surface runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tangent {
    /// Along the curvature larger in size.
    Curvature,
    /// At this angle in the picture, degrees counterclockwise from the right.
    Degrees(f32),
}

impl std::fmt::Display for Tangent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Curvature => write!(f, "curvature"),
            Self::Degrees(angle) => write!(f, "{angle}"),
        }
    }
}

impl std::str::FromStr for Tangent {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "curvature" => Ok(Self::Curvature),
            _ => text
                .parse()
                .ok()
                .filter(|angle: &f32| angle.is_finite())
                .map(Self::Degrees)
                .ok_or("expected curvature or an angle in degrees".into()),
        }
    }
}

/// What a surface is made of, as far as its lobes go ([RS] section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// Diffuse: the cosine with the normal.
    Lambert,
    /// Diffuse, and a highlight about the mirrored view.
    Phong,
    /// Diffuse, and a highlight where the half vector meets the normal.
    BlinnPhong,
    /// Diffuse in few tones.
    Toon,
    /// Diffuse and flat, as the moon: a power of the cosine below 1.
    Sublambert,
    /// Diffuse under a glossy, possibly brushed coat.
    AshikhminShirley,
    /// A perfect mirror of the environment.
    Mirror,
    /// Clear glass, its first surface alone.
    Glass,
}

/// Numbers that materials are tuned by; each uses its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MaterialParams {
    /// The kind.
    pub material: Material,
    /// Light that reaches everything alike, as a share of a light of 1, 0 to 1e6. `Mirror`, `Glass` and lit spheres
    /// do not show it.
    pub ambient: f32,
    /// Factor of diffuse light, 0 to 1e6.
    pub diffuse_gain: f32,
    /// Factor of specular light, 0 to 1e6; `None` is [`MaterialParams::specular`]'s own choice.
    pub specular_gain: Option<f32>,
    /// Exponent eta of the highlight of `Phong` and `BlinnPhong`, 0 to 1e6: higher is smaller.
    pub shininess: f32,
    /// Exponent zeta of `Sublambert`, 0 to 1: 0 is flat, 1 is `Lambert`.
    pub flatness: f32,
    /// Exponents n_u and n_v of `AshikhminShirley`, along and across the grain, 0 to 1e6.
    pub coat: [f32; 2],
    /// Reflectance R_s of its coat for light along the normal, 0..1.
    pub reflectance: f32,
    /// Its grain.
    pub tangent: Tangent,
    /// Index of refraction of `Glass`.
    pub ior: f32,
    /// Whether `Glass` is a thin sheet: two parallel interfaces, through which light goes straight on.
    pub thin: bool,
}

/// Quantised luminance with soft edges ([LW] section 6.2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Quantisation {
    /// Number of tones above black, 1 or more.
    pub levels: u32,
    /// Width of the step between two tones, as a share of a tone, 0..1: 0 is a hard edge.
    pub softness: f32,
}

impl Default for Quantisation {
    fn default() -> Self {
        Self {
            levels: 4,
            softness: 0.15,
        }
    }
}

/// All that relighting can be told beside the lights themselves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RelightParams {
    /// How light is altered.
    pub method: Method,
    /// How it is bent.
    pub warping: WarpingParams,
    /// Which side of the integral is bent.
    pub warp_by: WarpBy,
    /// What the surface is made of.
    pub material: MaterialParams,
    /// Where its colour comes from.
    pub albedo: AlbedoSource,
    /// Few tones, where wanted; [`Material::Toon`] has them always.
    pub quantisation: Option<Quantisation>,
    /// How many samples stand for an environment.
    pub samples: Samples,
    /// Factor of the environment, from 1e-38 on; `Auto` makes a white diffuse surface show 1 where it is brightest and
    /// still faces the viewer.
    pub environment_gain: Adaptive,
}

/// Factor of highlights that are told by their shape alone.
const HIGHLIGHT: f32 = 0.25;

impl MaterialParams {
    /// The factor of specular light: a quarter for `Phong` and `BlinnPhong`, whose highlight is 1 at its
    /// brightest; 1 where reflectance tells.
    pub fn specular(&self) -> f32 {
        self.specular_gain.unwrap_or(match self.material {
            Material::Phong | Material::BlinnPhong => HIGHLIGHT,
            _ => 1.0,
        })
    }
}

impl Default for RelightParams {
    fn default() -> Self {
        Self {
            method: Method::Both,
            warping: WarpingParams {
                warp: 4.0,
                contrast: 0.0,
            },
            warp_by: WarpBy::Auto,
            material: MaterialParams {
                material: Material::Lambert,
                ambient: 0.1,
                diffuse_gain: 0.9,
                specular_gain: None,
                shininess: 32.0,
                flatness: 0.5,
                coat: [80.0, 80.0],
                reflectance: 0.05,
                tangent: Tangent::Curvature,
                ior: 1.5,
                thin: false,
            },
            albedo: AlbedoSource::Auto,
            quantisation: None,
            samples: Samples::Auto,
            environment_gain: Adaptive::Auto,
        }
    }
}

impl RelightParams {
    /// The tones, where there are few.
    pub fn tones(&self) -> Option<Quantisation> {
        let toon = self.material.material == Material::Toon;
        self.quantisation
            .or_else(|| toon.then(Quantisation::default))
    }

    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let MaterialParams {
            ambient,
            diffuse_gain,
            specular_gain,
            shininess,
            flatness,
            coat,
            reflectance,
            tangent,
            ior,
            ..
        } = self.material;
        let ranges = [
            ("--warp", self.warping.warp, FACTORS),
            ("--contrast", self.warping.contrast, -1.0..=1.0),
            ("--ambient", ambient, FACTORS),
            ("--diffuse-gain", diffuse_gain, FACTORS),
            ("--specular-gain", specular_gain.unwrap_or(0.0), FACTORS),
            ("--shininess", shininess, EXPONENTS),
            ("--coat", coat[0], EXPONENTS),
            ("--coat", coat[1], EXPONENTS),
            ("--flatness", flatness, 0.0..=1.0),
            ("--reflectance", reflectance, 0.0..=1.0),
            ("--ior", ior, 0.1..=10.0),
        ];
        for (name, value, range) in ranges {
            in_range(name, value, range)?;
        }
        if let Tangent::Degrees(angle) = tangent {
            in_range("--tangent", angle, ANGLES_DEG)?;
        }
        if let Some(Quantisation { levels, softness }) = self.quantisation {
            in_range("--toon-levels", levels as f32, 1.0..=1024.0)?;
            in_range("--toon-softness", softness, 0.0..=1.0)?;
        }
        self.environment_gain.in_range("--environment-gain", LEVELS)
    }
}
