//! The parameters of relighting: method, material, and sampling of light.

use super::light::LEVELS;
use super::range::ANGLES_DEG;
use super::table::{Unit, by_factors, even};
use super::{Adaptive, Group};
use std::ops::RangeInclusive;

choices! {
    /// How light is modified to show shape.
    pub enum Method {
        /// Unmodified.
        Plain = "plain",
        /// Light warping: its directions are bent by curvature ([LW]).
        Warp = "warp",
        /// Radiance scaling: reflected light is scaled by curvature ([RS]).
        Scale = "scale",
        /// Directions are bent, then reflected light is scaled ([RS] figure 14).
        Both = "both",
        /// Directions are turned toward the detail that they graze, scale by scale.
        Align = "align",
    }
}

impl Method {
    /// Whether directions of light are bent.
    pub fn warps(self) -> bool {
        matches!(self, Self::Warp | Self::Both)
    }

    /// Whether directions of light are turned to the form.
    pub fn aligns(self) -> bool {
        self == Self::Align
    }

    /// Whether reflected light is scaled.
    pub fn scales(self) -> bool {
        matches!(self, Self::Scale | Self::Both)
    }
}

choices! {
    /// Which way lamps shine on flat work.
    pub enum Raking {
        /// As they are given.
        Given = "given",
        /// In each region from the azimuth that shows most of its detail, on the side of the lamp; at the given elevation.
        Best = "best",
    }
}

params! {
    /// Light warping: bending and contrast ([LW] sections 5 and 6.2).
    pub struct WarpingParams in Warping {
        /// Strength of the warp; multiplied by the curvature gain it is the paper's alpha. 0 bends nothing.
        ///
        /// The bend saturates at 60 degrees for light from the side.
        warp: f32 = 4.0, flag: "--warp", form: "A", valid: FACTORS, useful: even(0.0, 20.0);
        /// Contrast by curvature, -1 to 1: above 0 concavities brighten.
        ///
        /// Convexities then darken; below 0 the effect is reversed. The factor is at most 3 to this power.
        contrast: f32 = 0.0, flag: "--contrast", common: true, form: "G", valid: -1.0..=1.0, useful: even(-1.0, 1.0);
    }
}

choices! {
    /// Which side of the light integral is warped.
    pub enum WarpBy {
        /// Sampled lights; look-ups for prefiltered or mirrored environments.
        Auto = "auto",
        /// Each look-up into the environment ([LW] equation 1).
        Lookups = "lookups",
        /// Sampled lights, each weighted by the Jacobian of the inverse warp ([LW] equation 2).
        Lights = "lights",
    }
}

choices! {
    /// Source of the surface's own colour.
    pub enum AlbedoSource {
        /// A layer if there is one, with metals, glass and lamps by their own; else an estimate from the picture, else white.
        Auto = "auto",
        /// A layer or file, and nothing else: what has no colour there is black.
        Layer = "layer",
        /// The picture divided by the best-fitting shading.
        Estimate = "estimate",
        /// The picture unchanged, for scans under even light.
        Picture = "picture",
        /// White.
        White = "white",
    }
}

/// Factors of light and of the warp.
const FACTORS: RangeInclusive<f32> = 0.0..=1e6;

/// Exponents of highlights: at a million they are a twentieth of a degree wide.
const EXPONENTS: RangeInclusive<f32> = 0.0..=1e6;

/// Default number of samples of an environment: [LW] figure 1.
pub(crate) const AUTO_SAMPLES: u32 = 54;

/// Maximum number of samples of an environment, and of lights.
pub(crate) const MAX_LIGHTS: u32 = 100_000;

number_or_word! {
    /// Number of samples that represent an environment.
    #[derive(Eq)]
    pub enum SampleCount {
        /// Prefiltered if the material allows it, else as many as in the paper.
        Auto = "auto",
        /// A fixed number; 0 uses prefiltered maps.
        Fixed(u32),
    }
    whole: true,
    numbers: |count| *count <= MAX_LIGHTS,
    expected: format!("expected auto or a whole number up to {MAX_LIGHTS}"),
}

number_or_word! {
    /// Grain direction of a brushed anisotropic surface.
    pub enum Tangent {
        /// Along the larger principal curvature.
        Curvature = "curvature",
        /// At a fixed angle in the picture, in degrees counterclockwise from the right.
        Degrees(f32),
    }
    whole: false,
    numbers: |degrees| degrees.is_finite(),
    expected: "expected curvature or an angle in degrees",
}

choices! {
    /// Reflectance model: the lobes of a surface ([RS] section 5).
    pub enum Material {
        /// Diffuse: the cosine with the normal.
        Lambert = "lambert",
        /// Diffuse with a highlight about the mirrored view direction.
        Phong = "phong",
        /// Diffuse with a highlight where the half vector meets the normal.
        BlinnPhong = "blinn-phong",
        /// Diffuse, quantised to few tones.
        Toon = "toon",
        /// Diffuse and flat, as the moon: a power of the cosine below 1.
        Sublambert = "sublambert",
        /// Diffuse under a glossy, possibly brushed coat.
        AshikhminShirley = "ashikhmin-shirley",
        /// A perfect mirror of the environment.
        Mirror = "mirror",
        /// Clear glass, first surface only.
        Glass = "glass",
    }
}

params! {
    /// Material parameters; each material uses its own.
    pub struct MaterialParams in Material {
        /// Ambient light, on all materials but mirrors, glass and lit spheres.
        ///
        /// Relative to a light of intensity 1.
        ambient: f32 = 0.1,
            flag: "--ambient", form: "A", group: Group::Light, valid: FACTORS, useful: even(0.0, 1.0);
        /// Reflectance model.
        material: Material = Material::Lambert, flag: "--material", common: true, form: "KIND";
        /// Factor of diffuse light.
        diffuse_gain: f32 = 0.9, flag: "--diffuse-gain", form: "D", valid: FACTORS, useful: even(0.0, 2.0);
        /// Factor of specular light: 0.25 for phong and blinn-phong, else 1.
        specular_gain: Option<f32> = None,
            flag: "--specular-gain", form: "S", valid: FACTORS, useful: even(0.0, 2.0);
        /// phong, blinn-phong: exponent of the highlight; higher is smaller.
        shininess: f32 = 32.0, flag: "--shininess", form: "N", valid: EXPONENTS, useful: by_factors(1.0, 500.0);
        /// sublambert: exponent of the cosine, 0 flat to 1 lambert.
        flatness: f32 = 0.5, flag: "--flatness", alias: Some("cosine-exponent"), form: "Z", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// ashikhmin-shirley: exponents along and across the grain.
        coat: [f32; 2] = [80.0, 80.0], flag: "--coat", alias: Some("coat-exponents"), form: "NU,NV", valid: EXPONENTS;
        /// ashikhmin-shirley: reflectance of the coat at normal incidence.
        reflectance: f32 = 0.05, flag: "--reflectance", form: "R", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// ashikhmin-shirley: grain direction, along the curvature or at an angle in the picture.
        tangent: Tangent = Tangent::Curvature,
            flag: "--tangent", form: "curvature|DEG", unit: Unit::Degrees, valid: ANGLES_DEG;
        /// glass: index of refraction.
        ior: f32 = 1.5, flag: "--ior", form: "N", valid: 0.1..=10.0, useful: even(1.0, 3.0);
        /// glass: a thin sheet with parallel surfaces, through which light passes undeflected.
        thin: bool = false, flag: "--thin";
    }
}

choices! {
    /// Whether surfaces cast shadows in new light.
    #[derive(Default)]
    pub enum Shadows {
        /// Photos, maps and heights do, of lamps below 45 degrees of elevation and of environments; renders with depth or light
        /// passes don't.
        Auto = "auto" [default],
        /// Always.
        On = "on",
        /// Never.
        Off = "off",
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

/// Number of tones of [`Material::Toon`].
const TOON_LEVELS: u32 = 4;

params! {
    /// Relighting parameters, without the lights themselves.
    pub struct RelightParams in Material {
        /// Factor of the environment; auto makes the brightest white surface facing the viewer show 1.
        environment_gain: Adaptive = Adaptive::Auto,
            flag: "--environment-gain", form: "G|auto", group: Group::Light,
            valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Luminance of mirrored, refracted and HDR light that counts as intensity 1/2, or auto for its median.
        ///
        /// Used by radiance scaling, in the units of the environment: the intensity of a luminance l is l / (l + this).
        /// Auto takes the median of the light that a ball shows, or that traced sight lines meet.
        middle_light: Adaptive = Adaptive::Auto,
            flag: "--middle-light", form: "L|auto", group: Group::Light,
            valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Number of lights that sample the environment and each area light; 0 uses prefiltered maps; auto chooses.
        samples: SampleCount = SampleCount::Auto,
            flag: "--samples", form: "N|auto", group: Group::Light,
            valid: 0.0..=MAX_LIGHTS as f32, useful: even(0.0, 256.0);
        /// Error allowed in light from an environment, in grey levels of 255: 2, or 4 under a coat.
        ///
        /// With --samples auto, for 99 of 100 pixels of a surface of albedo 0.5: as many lights and samples as it takes.
        light_error: Option<f32> = None,
            flag: "--light-error", form: "LEVELS", group: Group::Light, valid: 0.1..=255.0, useful: by_factors(0.5, 16.0);
        /// Whether the surface casts shadows in the light of lamps.
        shadows: Shadows = Shadows::Auto, flag: "--shadows", common: true, form: "WHEN", group: Group::Light;
        /// Whether the surface hides light from all around from itself: that of environments, and ambient light.
        sky_shadows: Shadows = Shadows::Auto, flag: "--sky-shadows", form: "WHEN", group: Group::Light;
        /// Width of a lamp as seen from the surface: the sun has 0.5 degrees. Wider lamps have softer shadows.
        ///
        /// Area lights have their own.
        light_size: f32 = 4.0,
            flag: "--light-size", form: "DEG", group: Group::Light, unit: Unit::Degrees, valid: 0.0..=90.0, useful: even(0.0, 20.0);
        /// Share of a lamp's light that is left in its shadows.
        shadow_fill: f32 = 0.12,
            flag: "--shadow-fill", form: "SHARE", group: Group::Light, valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// How thick surfaces are that hide others, in the unit of depth; auto is 0.15 of the size of what is seen.
        ///
        /// What stands in front of a background casts the shadow of a body as thick, seen along the sight line.
        thickness: Adaptive = Adaptive::Auto,
            flag: "--thickness", form: "LENGTH|auto", group: Group::Light, valid: LEVELS, useful: by_factors(0.01, 10.0);
        /// Light warping.
        warping: WarpingParams;
        /// Warped quantity: sampled lights, or each look-up into the environment.
        warp_by: WarpBy = WarpBy::Auto, flag: "--warp-by", form: "WHAT", group: Group::Warping;
        /// Source of the surface's colour: a layer; the picture divided by the best-fitting shading; the picture
        /// itself.
        albedo: AlbedoSource = AlbedoSource::Auto, flag: "--albedo-from", form: "SOURCE";
        /// Material of the surface.
        material: MaterialParams;
        /// How light is modified to show shape.
        method: Method = Method::Both, flag: "--method", common: true, form: "METHOD", group: Group::Light;
        /// align: share of the way that each scale turns light toward its detail; 0 turns nothing.
        ///
        /// The sigma of Mestres et al., 2021.
        align: f32 = 0.2, flag: "--align", form: "S", valid: 0.0..=1.0, useful: even(0.0, 0.5), group: Group::Light;
        /// Which way lamps shine on flat work: tablets, inscriptions, maps of ground.
        raking: Raking = Raking::Given, flag: "--raking", form: "WHAT", group: Group::Light;
        /// Tones above black; 4 for toon, by default unlimited for other materials.
        toon_levels: Option<u32> = None,
            flag: "--toon-levels", form: "N", valid: 1.0..=1024.0, useful: even(1.0, 12.0);
        /// Softness of the step between tones, 0 to 1.
        ///
        /// A share of one tone: 0 is a hard edge.
        toon_softness: f32 = 0.15, flag: "--toon-softness", form: "S", valid: 0.0..=1.0, useful: even(0.0, 1.0);
    }
}

/// What is asked of materials, so that a new one has to answer.
impl Material {
    /// Whether it shows what is around it in place of light that it scatters.
    pub fn shows_surroundings(self) -> bool {
        match self {
            Self::Mirror | Self::Glass => true,
            Self::Lambert | Self::Toon | Self::Sublambert => false,
            Self::Phong | Self::BlinnPhong | Self::AshikhminShirley => false,
        }
    }

    /// Whether light passes through it.
    pub fn is_clear(self) -> bool {
        match self {
            Self::Glass => true,
            Self::Lambert | Self::Toon | Self::Sublambert => false,
            Self::Phong | Self::BlinnPhong | Self::AshikhminShirley | Self::Mirror => false,
        }
    }

    /// Whether it scatters a highlight.
    pub fn has_highlight(self) -> bool {
        match self {
            Self::Phong | Self::BlinnPhong | Self::AshikhminShirley => true,
            Self::Lambert | Self::Toon | Self::Sublambert | Self::Mirror | Self::Glass => false,
        }
    }

    /// Whether its highlight is about the mirrored view, and not about the normal.
    pub fn glows_about_mirrored_view(self) -> bool {
        match self {
            Self::Phong => true,
            Self::BlinnPhong | Self::AshikhminShirley => false,
            Self::Lambert | Self::Toon | Self::Sublambert | Self::Mirror | Self::Glass => false,
        }
    }

    /// Whether its diffuse base is under a coat, which may be brushed.
    pub fn has_coat(self) -> bool {
        match self {
            Self::AshikhminShirley => true,
            Self::Lambert | Self::Toon | Self::Sublambert | Self::Phong | Self::BlinnPhong => false,
            Self::Mirror | Self::Glass => false,
        }
    }

    /// Whether each of its lobes follows one direction, by which an environment can be filtered beforehand.
    pub fn can_prefilter(self) -> bool {
        match self {
            Self::Lambert | Self::Toon | Self::Phong => true,
            Self::Sublambert | Self::BlinnPhong | Self::AshikhminShirley => false,
            Self::Mirror | Self::Glass => false,
        }
    }

    /// Whether the light on it has few tones, and not its colours.
    pub fn has_toned_light(self) -> bool {
        match self {
            Self::Toon => true,
            Self::Lambert | Self::Sublambert | Self::Phong | Self::BlinnPhong => false,
            Self::AshikhminShirley | Self::Mirror | Self::Glass => false,
        }
    }
}

/// Factor of highlights defined by shape alone.
const HIGHLIGHT: f32 = 0.25;

impl MaterialParams {
    /// The factor of specular light: a quarter for `Phong` and `BlinnPhong`, whose highlight peaks at 1; 1 where
    /// reflectance sets the level.
    pub fn specular(&self) -> f32 {
        self.specular_gain.unwrap_or(match self.material {
            Material::Phong | Material::BlinnPhong => HIGHLIGHT,
            Material::Lambert | Material::Toon | Material::Sublambert => 1.0,
            Material::AshikhminShirley | Material::Mirror | Material::Glass => 1.0,
        })
    }
}

impl RelightParams {
    /// The tones, if luminance is quantised.
    pub fn tones(&self) -> Option<Quantisation> {
        let toon = self.material.material.has_toned_light();
        let levels = self.toon_levels.or_else(|| toon.then_some(TOON_LEVELS))?;
        Some(Quantisation {
            levels,
            softness: self.toon_softness,
        })
    }
}
