//! The part of a picture that is scaled, and its magnitude, given the light layers present.

use crate::frame::LightLayers;
use crate::params::{Magnitude, ScalingParams};

/// The light layers available for scaling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LightAvailable {
    /// Lobes of diffuse light.
    pub diffuse: bool,
    /// Whether some diffuse light from other surfaces is a separate layer.
    pub diffuse_indirect: bool,
    /// Lobes of specular light.
    pub specular: bool,
    /// Light groups with directions.
    pub groups: bool,
    /// Ambient occlusion.
    pub occlusion: bool,
    /// Whether that is found from the shape, not a layer.
    pub occlusion_is_computed: bool,
    /// Whether the picture is itself ambient occlusion.
    pub picture_is_occlusion: bool,
}

impl LightAvailable {
    /// No layers, only the picture.
    pub const NONE: Self = Self {
        diffuse: false,
        diffuse_indirect: false,
        specular: false,
        groups: false,
        occlusion: false,
        occlusion_is_computed: false,
        picture_is_occlusion: false,
    };

    /// The layers present in `light`.
    pub fn of(light: &LightLayers) -> Self {
        let mut diffuse = light.lobes.iter().filter(|l| l.lobe.is_diffuse());
        Self {
            diffuse: diffuse.clone().next().is_some(),
            diffuse_indirect: diffuse.any(|l| l.indirect.is_some()),
            specular: light.lobes.iter().any(|l| !l.lobe.is_diffuse()),
            groups: !light.groups.is_empty(),
            occlusion: light.occlusion.is_some(),
            occlusion_is_computed: false,
            picture_is_occlusion: light.picture_is_occlusion,
        }
    }

    /// With the occlusion that the shape has, in place of a layer.
    #[must_use]
    pub fn with_computed_occlusion(self) -> Self {
        Self {
            occlusion: true,
            occlusion_is_computed: true,
            ..self
        }
    }
}

/// The part of the picture that radiance scaling is applied to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Subject {
    /// The picture as a whole.
    Picture,
    /// Each lobe separately.
    Lobes,
    /// Light groups by the directions of their lights.
    Groups,
}

/// Enhancement of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Enhancement {
    pub(crate) subject: Subject,
    /// The largest scaling magnitude over the parts of the subject.
    pub(crate) magnitude: Magnitude,
    /// The magnitude for scaling the result by ambient occlusion.
    pub(crate) occlusion: f32,
}

impl Enhancement {
    pub(crate) fn new(light: LightAvailable, scaling: &ScalingParams) -> Self {
        let magnitudes = scaling.magnitudes();
        let subject = match light {
            LightAvailable { groups: true, .. } => Subject::Groups,
            LightAvailable { diffuse: true, .. } | LightAvailable { specular: true, .. } => {
                Subject::Lobes
            }
            _ => Subject::Picture,
        };
        let of = |there: bool, magnitude: Magnitude| match there {
            true => magnitude,
            false => Magnitude::of_both(0.0),
        };
        // Light from other surfaces is ambient light; in a layer of its own, it already includes occlusion.
        let ambient_lobe = subject == Subject::Lobes
            && light.diffuse_indirect
            && scaling.scaling_ambient.is_some();
        let magnitude = match subject {
            Subject::Picture if light.picture_is_occlusion => magnitudes.ambient,
            Subject::Picture => scaling.magnitude(),
            Subject::Groups => magnitudes.diffuse,
            Subject::Lobes => of(light.diffuse, magnitudes.diffuse)
                .or(of(light.specular, magnitudes.specular))
                .or(of(ambient_lobe, magnitudes.ambient)),
        };
        let by_occlusion = light.occlusion && !light.picture_is_occlusion && !ambient_lobe;
        Self {
            subject,
            magnitude,
            occlusion: match by_occlusion {
                true => scaling.scaling_ambient.unwrap_or(0.0),
                false => 0.0,
            },
        }
    }

    /// Whether the picture stays unchanged.
    pub(crate) fn is_idle(&self) -> bool {
        self.magnitude.largest() == 0.0 && self.occlusion == 0.0
    }
}
