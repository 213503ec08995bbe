//! The part of a picture that is scaled, and its magnitude, given the light layers present.

use crate::params::{Magnitude, ScalingParams};
use crate::plan::{LightAvailable, Plan};

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

impl Plan {
    /// Enhancement of the picture, if any.
    pub(crate) fn enhancement(&self) -> Option<Enhancement> {
        self.settings.get().copied()
    }

    /// The part of the picture changed by radiance scaling, if any.
    pub(crate) fn scaled(&self) -> Option<Subject> {
        let enhancement = self.enhancement()?;
        (enhancement.magnitude.largest() > 0.0).then_some(enhancement.subject)
    }
}
