//! The parameters of relighting: method, material, and sampling of light.

use super::light::LEVELS;
use super::range::ANGLES_DEG;
use super::table::{Unit, by_factors, even};
use super::{Adaptive, Group};
use std::ops::RangeInclusive;

choices! {
    /// How light is altered to show shape.
    pub enum Method {
        /// Not at all.
        Plain = "plain",
        /// Light warping: its directions are bent by curvature ([LW]).
        Warp = "warp",
        /// Radiance scaling: what is reflected is scaled by curvature ([RS]).
        Scale = "scale",
        /// Directions are bent, then what is reflected is scaled ([RS] figure 14).
        Both = "both",
    }
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

params! {
    /// How light warping bends and brightens ([LW] sections 5 and 6.2).
    pub struct WarpingParams in Warping {
        /// Strength of the warp; times the curvature gain it is the paper's alpha. 0 bends nothing.
        ///
        /// The bend saturates at 60 degrees for light from the side.
        warp: f32 = 4.0, flag: "--warp", form: "A", valid: FACTORS, useful: even(0.0, 20.0);
        /// Contrast by curvature, -1 to 1: above 0 concavities brighten.
        ///
        /// Convexities darken then; below 0 it is the other way round, at most by the factor 3 to this power.
        contrast: f32 = 0.0, flag: "--contrast", form: "G", valid: -1.0..=1.0, useful: even(-1.0, 1.0);
    }
}

choices! {
    /// Which side of the light integral is warped.
    pub enum WarpBy {
        /// Lights where light is sampled, look-ups where it is prefiltered or mirrored.
        Auto = "auto",
        /// Every look-up into the environment ([LW] equation 1).
        Lookups = "lookups",
        /// Sampled lights, each with the Jacobian of the inverse ([LW] equation 2).
        Lights = "lights",
    }
}

choices! {
    /// Where the colour of the surface itself comes from.
    pub enum AlbedoSource {
        /// A layer where there is one, else an estimate from the picture, else white.
        Auto = "auto",
        /// A layer or file.
        Layer = "layer",
        /// The picture divided by the shading that fits it best.
        Estimate = "estimate",
        /// The picture as it is: scans under even light.
        Picture = "picture",
        /// White.
        White = "white",
    }
}

/// Factors of light, and of the warp.
const FACTORS: RangeInclusive<f32> = 0.0..=1e6;

/// Exponents of highlights: at a million they are a twentieth of a degree wide.
const EXPONENTS: RangeInclusive<f32> = 0.0..=1e6;

/// Samples of an environment where none are asked for: [LW] figure 1.
pub(crate) const AUTO_SAMPLES: u32 = 54;

/// Most samples of an environment, and most lights.
pub(crate) const MAX_LIGHTS: u32 = 100_000;

number_or_word! {
    /// How many samples stand for an environment.
    #[derive(Eq)]
    pub enum Samples {
        /// Prefiltered where that serves, else as many as the paper shows.
        Auto = "auto",
        /// This many; 0 looks prefiltered maps up.
        Fixed(u32),
    }
    whole: true,
    numbers: |count| *count <= MAX_LIGHTS,
    expected: format!("expected auto or a whole number up to {MAX_LIGHTS}"),
}

number_or_word! {
    /// Which way the brushed grain of an anisotropic surface runs.
    pub enum Tangent {
        /// Along the curvature larger in size.
        Curvature = "curvature",
        /// At this angle in the picture, degrees counterclockwise from the right.
        Degrees(f32),
    }
    whole: false,
    numbers: |degrees| degrees.is_finite(),
    expected: "expected curvature or an angle in degrees",
}

choices! {
    /// What a surface is made of, as far as its lobes go ([RS] section 5).
    pub enum Material {
        /// Diffuse: the cosine with the normal.
        Lambert = "lambert",
        /// Diffuse, and a highlight about the mirrored view.
        Phong = "phong",
        /// Diffuse, and a highlight where the half vector meets the normal.
        BlinnPhong = "blinn-phong",
        /// Diffuse in few tones.
        Toon = "toon",
        /// Diffuse and flat, as the moon: a power of the cosine below 1.
        Sublambert = "sublambert",
        /// Diffuse under a glossy, possibly brushed coat.
        AshikhminShirley = "ashikhmin-shirley",
        /// A perfect mirror of the environment.
        Mirror = "mirror",
        /// Clear glass, its first surface alone.
        Glass = "glass",
    }
}

params! {
    /// Numbers that materials are tuned by; each uses its own.
    pub struct MaterialParams in Material {
        /// Even light on everything but mirrors, glass and lit spheres.
        ///
        /// It is a share of a light of 1.
        ambient: f32 = 0.1,
            flag: "--ambient", form: "A", group: Group::Light, valid: FACTORS, useful: even(0.0, 1.0);
        /// The kind of material.
        material: Material = Material::Lambert, flag: "--material", form: "KIND";
        /// Factor of diffuse light.
        diffuse_gain: f32 = 0.9, flag: "--diffuse-gain", form: "D", valid: FACTORS, useful: even(0.0, 2.0);
        /// Factor of specular light: 0.25 for phong and blinn-phong, else 1.
        specular_gain: Option<f32> = None,
            flag: "--specular-gain", form: "S", valid: FACTORS, useful: even(0.0, 2.0);
        /// phong, blinn-phong: exponent of the highlight, higher is smaller.
        shininess: f32 = 32.0, flag: "--shininess", form: "N", valid: EXPONENTS, useful: by_factors(1.0, 500.0);
        /// sublambert: exponent of the cosine, 0 flat to 1 lambert.
        flatness: f32 = 0.5, flag: "--flatness", alias: Some("cosine-exponent"), form: "Z", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// ashikhmin-shirley: exponents along and across the grain.
        coat: [f32; 2] = [80.0, 80.0], flag: "--coat", alias: Some("coat-exponents"), form: "NU,NV", valid: EXPONENTS;
        /// ashikhmin-shirley: reflectance of the coat, seen from straight above.
        reflectance: f32 = 0.05, flag: "--reflectance", form: "R", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// ashikhmin-shirley: the grain follows the curvature, or an angle in the picture.
        tangent: Tangent = Tangent::Curvature,
            flag: "--tangent", form: "curvature|DEG", unit: Unit::Degrees, valid: ANGLES_DEG;
        /// glass: index of refraction.
        ior: f32 = 1.5, flag: "--ior", form: "N", valid: 0.1..=10.0, useful: even(1.0, 3.0);
        /// glass: a thin sheet of two parallel surfaces, through which light goes straight on.
        thin: bool = false, flag: "--thin";
    }
}

/// Quantised luminance with soft edges ([LW] section 6.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantisation {
    /// Number of tones above black, 1 or more.
    pub levels: u32,
    /// Width of the step between two tones, as a share of a tone, 0..1: 0 is a hard edge.
    pub softness: f32,
}

/// Tones of [`Material::Toon`].
const TOON_LEVELS: u32 = 4;

params! {
    /// All parameters of relighting beside the lights themselves.
    pub struct RelightParams in Material {
        /// Factor of the environment, or auto: the brightest white surface that faces the viewer shows 1.
        environment_gain: Adaptive = Adaptive::Auto,
            flag: "--environment-gain", form: "G|auto", group: Group::Light,
            valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Lights that stand for the environment, and for each area light; 0 looks prefiltered light up; auto
        /// chooses.
        samples: Samples = Samples::Auto,
            flag: "--samples", form: "N|auto", group: Group::Light,
            valid: 0.0..=MAX_LIGHTS as f32, useful: even(0.0, 256.0);
        /// How light is bent.
        warping: WarpingParams;
        /// What is warped: sampled lights, or each look-up into the environment.
        warp_by: WarpBy = WarpBy::Auto, flag: "--warp-by", form: "WHAT", group: Group::Warping;
        /// Where the surface's colour comes from: a layer; the picture over the shading that fits it best; the picture
        /// itself.
        albedo: AlbedoSource = AlbedoSource::Auto, flag: "--albedo-from", form: "SOURCE";
        /// What the surface is made of.
        material: MaterialParams;
        /// How light is altered.
        method: Method = Method::Both, flag: "--method", form: "METHOD", group: Group::Light;
        /// Tones above black; toon has 4, other materials all.
        toon_levels: Option<u32> = None,
            flag: "--toon-levels", form: "N", valid: 1.0..=1024.0, useful: even(1.0, 12.0);
        /// Softness of the step between tones, 0 to 1.
        ///
        /// It is a share of a tone: 0 is a hard edge.
        toon_softness: f32 = 0.15, flag: "--toon-softness", form: "S", valid: 0.0..=1.0, useful: even(0.0, 1.0);
    }
}

/// Factor of highlights that are known by their shape alone.
const HIGHLIGHT: f32 = 0.25;

impl MaterialParams {
    /// The factor of specular light: a quarter for `Phong` and `BlinnPhong`, whose highlight is 1 at its
    /// brightest; 1 where reflectance determines it.
    pub fn specular(&self) -> f32 {
        self.specular_gain.unwrap_or(match self.material {
            Material::Phong | Material::BlinnPhong => HIGHLIGHT,
            _ => 1.0,
        })
    }
}

impl RelightParams {
    /// The tones, where there are few.
    pub fn tones(&self) -> Option<Quantisation> {
        let toon = self.material.material == Material::Toon;
        let levels = self.toon_levels.or_else(|| toon.then_some(TOON_LEVELS))?;
        Some(Quantisation {
            levels,
            softness: self.toon_softness,
        })
    }
}
