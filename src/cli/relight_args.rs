//! The names of `relight`. Every default is read from `params`.

use super::args::{ScalingFlags, WorkArgs};
use super::sequence::numbered;
use super::specular_args::SpecularFlags;
use crate::params::{
    Adaptive, AlbedoSource, Material, MaterialParams, Method, Quantisation, RelightParams, Samples,
    Tangent, WarpBy, WarpingParams,
};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::LazyLock;

static RELIGHT: LazyLock<RelightParams> = LazyLock::new(RelightParams::default);
static TONES: LazyLock<Quantisation> = LazyLock::new(Quantisation::default);

#[derive(Debug, Args)]
pub(super) struct RelightArgs {
    #[command(flatten)]
    pub(super) work: WorkArgs,
    #[command(flatten)]
    pub(super) light: LightFlags,
    #[command(flatten)]
    pub(super) warping: WarpingFlags,
    #[command(flatten)]
    pub(super) scaling: ScalingFlags,
    #[command(flatten)]
    pub(super) material: MaterialFlags,
    #[command(flatten)]
    pub(super) specular: SpecularFlags,
}

/// What lights the surface.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(super) struct LightFlags {
    /// A light far away: degrees counterclockwise from the right of the picture, degrees from the picture
    /// plane toward the viewer, colour. Repeatable.
    #[arg(long, value_name = "AZ,EL[,R,G,B]", allow_hyphen_values = true)]
    pub(super) light: Vec<Numbers<2>>,
    /// A round light far away: as --light, with its radius in degrees. Repeatable.
    #[arg(long, value_name = "AZ,EL,RADIUS[,R,G,B]", allow_hyphen_values = true)]
    pub(super) area_light: Vec<Numbers<3>>,
    /// A light near the surface, in view space and the units of depth: x right, y up, the eye at 0 looking
    /// toward -z; the colour is that at a distance of 1. Repeatable.
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", allow_hyphen_values = true)]
    pub(super) point_light: Vec<Numbers<3>>,
    /// Light from all around, attached to the view: latitude-longitude map, mirror ball or cube cross.
    #[arg(long, value_name = "FILE")]
    pub(super) environment: Option<PathBuf>,
    /// Turns the environment about the vertical.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(super) environment_rotate: f32,
    /// Factor of the environment, or auto: the brightest white surface that faces the viewer shows 1.
    #[arg(long, value_name = "G|auto", default_value_t = RELIGHT.environment_gain, allow_negative_numbers = true)]
    environment_gain: Adaptive,
    /// Lights that stand for the environment, and for each area light; 0 looks prefiltered light up; auto
    /// chooses.
    #[arg(long, value_name = "N|auto", default_value_t = RELIGHT.samples)]
    pub(super) samples: Samples,
    /// A picture of a lit sphere in place of all light; or one for convexities and one for concavities.
    #[arg(long, value_name = "FILE[,FILE]", value_delimiter = ',', num_args = 1..=2)]
    pub(super) lit_sphere: Vec<PathBuf>,
    /// Even light on everything but mirrors, glass and lit spheres.
    #[arg(long, value_name = "A", default_value_t = RELIGHT.material.ambient, allow_negative_numbers = true)]
    ambient: f32,
    /// How light is altered.
    #[arg(long, value_name = "METHOD", value_enum, default_value_t = MethodArg::from(RELIGHT.method))]
    method: MethodArg,
}

/// How light is bent.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light warping")]
pub(super) struct WarpingFlags {
    /// Strength of the warp; times the curvature gain it is the paper's alpha. 0 bends nothing.
    #[arg(long, value_name = "A", default_value_t = RELIGHT.warping.warp, allow_negative_numbers = true)]
    warp: f32,
    /// Contrast by curvature, -1 to 1: above 0 concavities brighten.
    #[arg(long, value_name = "G", default_value_t = RELIGHT.warping.contrast, allow_negative_numbers = true)]
    contrast: f32,
    /// What is warped: sampled lights, or each look-up into the environment.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = WarpByArg::from(RELIGHT.warp_by))]
    warp_by: WarpByArg,
}

/// What the surface is made of.
#[derive(Debug, Args)]
#[command(next_help_heading = "Material")]
pub(super) struct MaterialFlags {
    /// The kind of material.
    #[arg(long, value_name = "KIND", value_enum, default_value_t = MaterialArg::from(RELIGHT.material.material))]
    material: MaterialArg,
    /// Colour of the surface itself: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) albedo: Option<String>,
    /// Where it comes from: a layer; the picture over the shading that fits it best; the picture itself.
    #[arg(long, value_name = "SOURCE", value_enum, default_value_t = AlbedoArg::from(RELIGHT.albedo))]
    albedo_from: AlbedoArg,
    /// Factor of diffuse light.
    #[arg(long, value_name = "D", default_value_t = RELIGHT.material.diffuse_gain, allow_negative_numbers = true)]
    diffuse_gain: f32,
    /// Factor of specular light: 0.25 for phong and blinn-phong, else 1.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    specular_gain: Option<f32>,
    /// phong, blinn-phong: exponent of the highlight, higher is smaller.
    #[arg(long, value_name = "N", default_value_t = RELIGHT.material.shininess, allow_negative_numbers = true)]
    shininess: f32,
    /// sublambert: exponent of the cosine, 0 flat to 1 lambert.
    #[arg(long, value_name = "Z", default_value_t = RELIGHT.material.flatness, allow_negative_numbers = true)]
    flatness: f32,
    /// ashikhmin-shirley: exponents along and across the grain.
    #[arg(long, value_name = "NU,NV", default_value_t = Numbers(RELIGHT.material.coat, None), allow_hyphen_values = true)]
    coat: Numbers<2>,
    /// ashikhmin-shirley: reflectance of the coat, seen from straight above.
    #[arg(long, value_name = "R", default_value_t = RELIGHT.material.reflectance, allow_negative_numbers = true)]
    reflectance: f32,
    /// ashikhmin-shirley: the grain follows the curvature, or an angle in the picture.
    #[arg(long, value_name = "curvature|DEG", default_value_t = RELIGHT.material.tangent, allow_negative_numbers = true)]
    tangent: Tangent,
    /// glass: index of refraction.
    #[arg(long, value_name = "N", default_value_t = RELIGHT.material.ior, allow_negative_numbers = true)]
    ior: f32,
    /// glass: a thin sheet of two parallel surfaces, through which light goes straight on.
    #[arg(long)]
    thin: bool,
    /// Tones above black; toon has 4, other materials all.
    #[arg(long, value_name = "N")]
    toon_levels: Option<u32>,
    /// Softness of the step between tones, 0 to 1.
    #[arg(long, value_name = "S", default_value_t = TONES.softness, allow_negative_numbers = true)]
    toon_softness: f32,
}

/// N numbers and perhaps a colour, separated by commas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Numbers<const N: usize>(pub(super) [f32; N], pub(super) Option<[f32; 3]>);

impl<const N: usize> FromStr for Numbers<N> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f32>> = text
            .split(',')
            .map(|number| number.trim().parse().ok().filter(|v: &f32| v.is_finite()))
            .collect();
        let expected = || format!("expected {N} numbers, or {} with a colour", N + 3);
        let numbers = numbers.ok_or_else(expected)?;
        let (first, color) = numbers.split_first_chunk().ok_or_else(expected)?;
        match color {
            [] => Ok(Self(*first, None)),
            &[r, g, b] if r.min(g).min(b) >= 0.0 => Ok(Self(*first, Some([r, g, b]))),
            [_, _, _] => Err("expected a colour of 0 or more".into()),
            _ => Err(expected()),
        }
    }
}

impl<const N: usize> std::fmt::Display for Numbers<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let color = self.1.iter().flatten();
        let all: Vec<_> = self.0.iter().chain(color).map(f32::to_string).collect();
        f.write_str(&all.join(","))
    }
}

impl<const N: usize> Numbers<N> {
    /// The colour, white where none is given.
    pub(super) fn color(&self) -> [f32; 3] {
        self.1.unwrap_or([1.0; 3])
    }
}

/// An enum of the command line that stands for one of `params`, variant by variant.
macro_rules! mirrored {
    ($name:ident, $of:ident { $($variant:ident),* $(,)? }) => {
        #[derive(Debug, Clone, Copy, ValueEnum)]
        enum $name { $($variant),* }

        impl From<$of> for $name {
            fn from(value: $of) -> Self {
                match value { $($of::$variant => Self::$variant),* }
            }
        }

        impl From<$name> for $of {
            fn from(arg: $name) -> Self {
                match arg { $($name::$variant => Self::$variant),* }
            }
        }
    };
}

pub(super) use mirrored;

mirrored!(
    MethodArg,
    Method {
        Plain,
        Warp,
        Scale,
        Both
    }
);
mirrored!(
    WarpByArg,
    WarpBy {
        Auto,
        Lookups,
        Lights
    }
);
mirrored!(
    AlbedoArg,
    AlbedoSource {
        Auto,
        Layer,
        Estimate,
        Picture,
        White
    }
);
mirrored!(
    MaterialArg,
    Material {
        Lambert,
        Phong,
        BlinnPhong,
        Toon,
        Sublambert,
        AshikhminShirley,
        Mirror,
        Glass,
    }
);

impl RelightArgs {
    /// Everything but the lights.
    pub(super) fn params(&self) -> RelightParams {
        let Self {
            light,
            warping,
            material,
            ..
        } = self;
        let quantisation = Quantisation {
            levels: material.toon_levels.unwrap_or(TONES.levels),
            softness: material.toon_softness,
        };
        let kind = Material::from(material.material);
        let few_tones = material.toon_levels.is_some() || kind == Material::Toon;
        RelightParams {
            method: light.method.into(),
            warping: WarpingParams {
                warp: warping.warp,
                contrast: warping.contrast,
            },
            warp_by: warping.warp_by.into(),
            material: MaterialParams {
                material: kind,
                ambient: light.ambient,
                diffuse_gain: material.diffuse_gain,
                specular_gain: material.specular_gain,
                shininess: material.shininess,
                flatness: material.flatness,
                coat: material.coat.0,
                reflectance: material.reflectance,
                tangent: material.tangent,
                ior: material.ior,
                thin: material.thin,
            },
            albedo: match material.albedo {
                Some(_) => AlbedoSource::Layer,
                None => material.albedo_from.into(),
            },
            quantisation: few_tones.then_some(quantisation),
            samples: light.samples,
            environment_gain: light.environment_gain,
        }
    }

    /// Whether there is light that comes from all around, and less of it in corners.
    pub(super) fn dims_by_occlusion(&self) -> bool {
        self.light.environment.is_some() || self.light.ambient > 0.0
    }

    /// The layer or file of the surface's colour that was named, for one frame of a sequence.
    pub(super) fn albedo_of_frame(&self, frame: Option<i32>) -> Option<String> {
        let name = self.material.albedo.as_deref()?;
        Some(frame.map_or_else(|| name.into(), |frame| numbered(name, frame)))
    }

    /// Files that only this command reads, of one frame in a sequence.
    pub(super) fn files(&self, frame: Option<i32>) -> Vec<PathBuf> {
        let albedo = self.albedo_of_frame(frame).map(PathBuf::from);
        let lights = self.light.environment.iter().chain(&self.light.lit_sphere);
        albedo
            .filter(|path| path.exists())
            .into_iter()
            .chain(lights.cloned())
            .chain(self.specular.of_frame(frame).files())
            .collect()
    }
}
