//! The arguments of `relight`.

use super::args::WorkArgs;
use super::flags::{Section, SumFlag};
use crate::frame::Frame;
use crate::io::SpecularInputs;
use crate::light::lights::DirectionalLight;
use crate::params::table::rows;
use crate::params::{AlbedoSource, Group, Raking, RelightParams, Shadows};
use std::path::PathBuf;
use std::str::FromStr;

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct RelightArgs {
        pub(crate) work: WorkArgs as flatten;
        pub(crate) light: LightFlags as flatten;
        _light: Section<{ Group::Light as u8 }> as flatten;
        _warping: Section<{ Group::Warping as u8 }> as flatten;
        _sum: SumFlag as flatten;
        _scaling: Section<{ Group::Scaling as u8 }> as flatten;
        pub(crate) surface: SurfaceFlags as flatten;
        _material: Section<{ Group::Material as u8 }> as flatten;
        pub(crate) specular: SpecularInputs as flatten;
        _search: Section<{ Group::Specular as u8 }> as flatten;
        _display: Section<{ Group::Display as u8 }> as flatten;
    }
}

rows! {
    /// Lights, environments and lit spheres.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Light")]
    pub(crate) struct LightFlags {
        /// A light far away: degrees counterclockwise from the right of the picture, degrees from the picture
        /// plane toward the viewer, colour. Repeatable.
        pub(crate) light: Vec<LightNumbers<2>> = [long, value_name = "AZ,EL[,R,G,B]", allow_hyphen_values = true];
        /// A round light far away: as --light, with its radius in degrees. Repeatable.
        pub(crate) area_light: Vec<LightNumbers<3>> =
            [hide_short_help = true, long, value_name = "AZ,EL,RADIUS[,R,G,B]", allow_hyphen_values = true];
        /// A light near the surface, in view space and the units of depth: x right, y up, the eye at 0 looking
        /// toward -z; the colour is that at a distance of 1. Repeatable.
        pub(crate) point_light: Vec<LightNumbers<3>> =
            [hide_short_help = true, long, value_name = "X,Y,Z[,R,G,B]", allow_hyphen_values = true];
        /// Light from all around, attached to the view: latitude-longitude map, mirror ball or cube cross.
        pub(crate) environment: Option<PathBuf> = [long, value_name = "FILE"];
        /// A picture of a lit sphere in place of all light; or one for convexities and one for concavities.
        pub(crate) lit_sphere: Vec<PathBuf> =
            [long, value_name = "FILE[,FILE]", value_delimiter = ',', num_args = 1..=2];
    }
}

rows! {
    /// Surface properties other than the parameters of its material.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Material")]
    pub(crate) struct SurfaceFlags {
        /// Colour of the surface itself: a layer of IN or a file.
        pub(crate) albedo: Option<String> = [hide_short_help = true, long, value_name = "NAME|FILE"];
    }
}

/// N numbers and an optional colour, separated by commas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LightNumbers<const N: usize>(pub(crate) [f32; N], pub(crate) Option<[f32; 3]>);

impl<const N: usize> FromStr for LightNumbers<N> {
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

impl<const N: usize> LightNumbers<N> {
    /// The colour, white where none is given.
    pub(crate) fn color(&self) -> [f32; 3] {
        self.1.unwrap_or([1.0; 3])
    }
}

impl RelightArgs {
    /// Relighting parameters without the lights.
    pub(crate) fn params(&self) -> RelightParams {
        let params = self.work.flags.params.relight;
        RelightParams {
            albedo: match self.surface.albedo {
                Some(_) => AlbedoSource::Layer,
                None => params.albedo,
            },
            sky_shadows: match self.work.roles.computes_occlusion() {
                true => Shadows::On,
                false => params.sky_shadows,
            },
            ..params
        }
    }

    /// Warnings for lights with an elevation beyond the zenith.
    pub(crate) fn past_the_zenith(&self) -> impl Iterator<Item = String> {
        let far = self.light.light.iter().map(|light| light.0);
        let round = self
            .light
            .area_light
            .iter()
            .map(|light| [light.0[0], light.0[1]]);
        let passed = far
            .chain(round)
            .filter(|[_, elevation]| elevation.abs() > 90.0);
        passed.map(|[azimuth, elevation]| {
            let over = 180.0_f32.copysign(elevation) - elevation;
            let opposite = (azimuth + 180.0).rem_euclid(360.0);
            format!(
                "a light at {azimuth},{elevation} is past the zenith: it shines from {opposite},{over}"
            )
        })
    }

    /// Warnings for lights that have not risen above the picture plane and cast shadows.
    pub(crate) fn unrisen(&self, frame: &Frame) -> impl Iterator<Item = String> {
        let lights = self.light.light.iter().map(|light| light.0);
        let is_raking = |at| DirectionalLight::white(at).is_raking();
        let params = self.params();
        let casts = match params.shadows {
            Shadows::On => true,
            Shadows::Auto => {
                params.raking == Raking::Given && frame.is_map() && lights.clone().any(is_raking)
            }
            Shadows::Off => false,
        };
        let unrisen = lights.filter(move |[_, elevation]| casts && *elevation <= 0.0);
        unrisen.map(|[azimuth, elevation]| {
            format!(
                "a light at {azimuth},{elevation} is not above the picture plane: most of the surface is in its own shadow"
            )
        })
    }

    /// A warning where sky shadows fill what is behind silhouettes.
    pub(crate) fn filled(&self, frame: &Frame) -> Option<String> {
        let fills = self.params().sky_shadows == Shadows::On && frame.depth.is_some();
        (fills && !frame.is_map()).then(|| {
            "--sky-shadows on takes what stands before a background for solid down to it, and darkens the background beside it: compare --sky-shadows off, or a layer of occlusion".into()
        })
    }

    /// Warnings of lights that were to be turned, and cannot be.
    pub(crate) fn idle_turns(&self) -> impl Iterator<Item = String> {
        let RelightParams {
            method,
            align,
            raking,
            ..
        } = self.params();
        let is_idle = !method.aligns() && align != RelightParams::default().align;
        let align =
            is_idle.then(|| format!("--align {align} changes nothing: give --method align"));
        let overhead = self
            .light
            .light
            .first()
            .is_some_and(|light| light.0[1] == 90.0);
        let raking = (raking == Raking::Best && overhead).then(|| {
            "--raking best changes nothing: the first light shines from the viewer, and has no azimuth".into()
        });
        align.into_iter().chain(raking)
    }
}
