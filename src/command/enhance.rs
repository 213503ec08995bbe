//! `relievo enhance`: the layers it needs, and its plan.

use super::commands::EnhanceArgs;
use super::output::MadePicture;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::error::Result;
use crate::frame::{Frame, LightLayers};
use crate::io::Needs;
use crate::io::inputs::Inputs;
use crate::light::radiance_scaling::monotone_limit;
use crate::params::{Params, ScalingParams};
use crate::plan::{Available, Goal, LightAvailable, Plan};

/// The enhanced picture and the frame's own. A plan with nothing to do leaves the picture unchanged.
pub(crate) fn made<'a>(frame: &'a Frame, outcome: &'a Outcome) -> MadePicture<'a> {
    let before = frame.color.as_ref();
    let color = outcome.color.as_ref().or(before);
    MadePicture {
        color: color.expect("a picture was asked for"),
        before,
        like: None,
    }
}

impl EnhanceArgs {
    /// Inputs and layers to read for a frame.
    pub(crate) fn reading(&self, frame: Option<i32>) -> (Inputs, Needs) {
        let mut inputs = self.work.inputs(frame);
        inputs.light = Some(self.light.inputs(&self.work.flags.params, frame));
        let needs = Needs {
            color: true,
            strength: true,
            confidence_if_any: true,
            projection: true,
            ..Needs::default()
        };
        (inputs, needs)
    }

    /// The plan for a frame, with choices made on the whole picture if the frame is a strip of it.
    pub(crate) fn plan(&self, frame: &Frame, found: &StripChoice) -> Result<Plan> {
        let Params {
            shape,
            scaling,
            mix,
            ..
        } = self.work.flags.params;
        let available = Available::in_frame(frame);
        // None of the change shows: it is left out.
        let scaling = match mix {
            0.0 => ScalingParams {
                scaling: 0.0,
                scaling_ambient: None,
                scaling_diffuse: None,
                scaling_specular: None,
                ..scaling
            },
            _ => found.given(scaling),
        };
        Plan::new(Goal::Enhance, available, shape, scaling)
    }
}

/// Warns past the limit beyond which concavities lose their order of brightness ([RS] claims it only for convexities).
pub(crate) fn dark_rims(scaling: &ScalingParams) -> Vec<String> {
    let limit = monotone_limit(scaling.invariant_point);
    let magnitudes = [
        ("--scaling", Some(scaling.scaling)),
        ("--scaling-ambient", scaling.scaling_ambient),
        ("--scaling-diffuse", scaling.scaling_diffuse),
        ("--scaling-specular", scaling.scaling_specular),
    ];
    let past = magnitudes
        .into_iter()
        .filter_map(|(name, magnitude)| Some((name, magnitude.filter(|&g| g > limit)?)));
    past.map(|(name, magnitude)| {
        format!(
            "{name} {magnitude} is past {limit:.2}: deep concavities may show new dark rims; lower it or \
             --invariant-point"
        )
    })
    .collect()
}

/// Magnitudes that were given but have no light to scale.
pub(crate) fn idle_magnitudes(scaling: &ScalingParams, light: &LightLayers) -> Vec<String> {
    let available = LightAvailable::of(light);
    let LightAvailable {
        groups,
        occlusion,
        picture_is_occlusion,
        ..
    } = available;
    let ambient = occlusion || picture_is_occlusion || (available.diffuse_indirect && !groups);
    let terms = [
        ("--scaling-ambient", scaling.scaling_ambient, ambient),
        (
            "--scaling-diffuse",
            scaling.scaling_diffuse,
            available.diffuse || groups,
        ),
        (
            "--scaling-specular",
            scaling.scaling_specular,
            available.specular && !groups,
        ),
    ];
    let idle = terms.into_iter().filter(|&(_, magnitude, used)| {
        // A magnitude of 0 needs no light.
        magnitude.is_some_and(|g| g > 0.0) && !used
    });
    idle.map(|(name, ..)| format!("{name} changes nothing: no layer of such light is scaled here"))
        .collect()
}
