//! `relievo enhance`: the shading that a picture has, scaled by shape.

use super::{FrameSeen, FrameWork};
use crate::command::args::WorkArgs;
use crate::command::commands::EnhanceArgs;
use crate::command::named::Named;
use crate::engine::request::Request;
use crate::error::{Result, bad};
use crate::frame::{Frame, LightLayers};
use crate::io::Needs;
use crate::io::inputs::Inputs;
use crate::io::output::picture::MadePicture;
use crate::light::lights::Illumination;
use crate::light::radiance_scaling::monotone_limit;
use crate::params::ScalingParams;
use crate::plan::outcome::Outcome;
use crate::plan::{Available, LightAvailable, Plan};

impl FrameWork for EnhanceArgs {
    fn args(&self) -> &WorkArgs {
        &self.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn names(&mut self) -> Vec<Named<'_>> {
        let mut all = self.work.names();
        all.extend(self.light.names());
        all
    }

    fn check(&self) -> Result<()> {
        if self.work.roles.computes_occlusion()
            && self.work.flags.params.scaling.scaling_ambient.is_none()
        {
            let found = "is computed, but scaled by nothing";
            return Err(bad(
                "--occlusion",
                found,
                "give --scaling-ambient, such as 1",
            ));
        }
        self.work.check_one_picture()
    }

    fn warnings(&self) -> Vec<String> {
        dark_rims(&self.work.flags.params.scaling)
    }

    fn warnings_on(&self, frame: &Frame) -> Vec<String> {
        idle_magnitudes(
            &self.work.flags.params.scaling,
            self.light_available(&frame.light),
        )
    }

    fn reading(&self, _: &Illumination) -> Result<(Inputs, Needs)> {
        let mut inputs = self.work.inputs();
        if self.work.roles.computes_occlusion() {
            inputs.occlusion = Some(Inputs::NONE.into());
        }
        inputs.light = Some(self.light.inputs(&self.work.flags.params));
        let needs = Needs {
            color: true,
            strength: true,
            confidence_if_any: true,
            projection: true,
            ..Needs::default()
        };
        Ok((inputs, needs))
    }

    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>> {
        let request = Request {
            computes_occlusion: self.work.roles.computes_occlusion(),
            ..Request::enhance(self.work.flags.params)
        };
        Ok(vec![request.plan(Available::in_frame(seen.frame))?])
    }

    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>> {
        MadePicture::enhanced(frame, outcome)
    }
}

impl EnhanceArgs {
    /// The light that can be scaled.
    fn light_available(&self, light: &LightLayers) -> LightAvailable {
        let own = LightAvailable::of(light);
        match self.work.roles.computes_occlusion() {
            true => own.with_computed_occlusion(),
            false => own,
        }
    }
}

/// Warns past the limit beyond which concavities lose their order of brightness ([RS] claims it only for convexities).
pub(crate) fn dark_rims(scaling: &ScalingParams) -> Vec<String> {
    let limit = monotone_limit(scaling.invariant_point);
    let of_all = match scaling.scaling_concave {
        Some(concave) => ("--scaling-concave", Some(concave)),
        None => ("--scaling", Some(scaling.scaling)),
    };
    let magnitudes = [
        of_all,
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
fn idle_magnitudes(scaling: &ScalingParams, available: LightAvailable) -> Vec<String> {
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
