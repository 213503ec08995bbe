//! `relievo enhance`.

use super::args::WorkArgs;
use super::chosen::Chosen;
use super::commands::EnhanceArgs;
use super::frames::FrameCommand;
use super::job::{Done, Job, MadePicture};
use super::strips::{self, StripWork};
use crate::engine::cpu::Runner;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::engine::{self, Engine};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, LightLayers};
use crate::io::exr::OutputChannel;
use crate::io::inputs::Inputs;
use crate::io::{Loaded, Needs};
use crate::light::radiance_scaling::monotone_limit;
use crate::params::{Params, ScalingParams};
use crate::plan::{Available, Goal, LightAvailable, Plan};
use std::path::PathBuf;

impl FrameCommand for EnhanceArgs {
    type Kit = Engine;

    fn work(&self) -> &WorkArgs {
        &self.work
    }

    fn files(&self, frame: Option<i32>) -> Vec<PathBuf> {
        self.light.files(frame).collect()
    }

    fn validate(&self) -> Result<()> {
        self.work.output.kind()?;
        self.work.flags.refuse_more_scales()
    }

    fn prepare(&self) -> Result<Engine> {
        self.work.run.compute.backend.engine()
    }

    fn make(&self, engine: &Engine, job: &Job) -> Result<Chosen> {
        let scaling = self.work.flags.params.scaling;
        let (inputs, needs) = self.reading(job);
        let warnings = dark_rims(&scaling);
        warnings.iter().for_each(|warning| job.warn(warning));
        let work = Enhancement {
            args: self,
            runner: engine.cpu_runner(),
        };
        if strips::is_too_large(job) {
            return strips::make(&work, job, inputs, needs);
        }
        let (loaded, read) = job.load(&inputs, needs)?;
        let plan = work.plan(&loaded, &StripChoice::default())?;
        job.tell_plan(&plan)?;
        work.warnings(&loaded)
            .iter()
            .for_each(|text| job.warn(text));
        let outcome = job.execute(engine, &plan, &loaded.frame, engine::Inputs::default())?;
        let done = Done {
            loaded,
            plan,
            outcome,
            read,
        };
        let chosen = job.write_color(&done, made(&done.loaded.frame, &done.outcome))?;
        engine.recycle(done.outcome);
        Ok(chosen)
    }
}

/// How `enhance` makes its pictures.
struct Enhancement<'a> {
    args: &'a EnhanceArgs,
    runner: &'a Runner,
}

impl StripWork for Enhancement<'_> {
    fn runner(&self) -> &Runner {
        self.runner
    }

    fn plan(&self, strip: &Loaded, found: &StripChoice) -> Result<Plan> {
        self.args.plan(&strip.frame, found)
    }

    fn channels<'a>(
        &self,
        job: &Job,
        strip: &'a Loaded,
        outcome: &'a Outcome,
    ) -> Vec<OutputChannel<'a>> {
        job.color_channels(strip, made(&strip.frame, outcome))
    }

    fn picture<'a>(&self, job: &Job, strip: &'a Loaded, outcome: &'a Outcome) -> MadePicture<'a> {
        job.made_picture(strip, made(&strip.frame, outcome))
    }

    fn warnings(&self, loaded: &Loaded) -> Vec<String> {
        idle_magnitudes(&self.args.work.flags.params.scaling, &loaded.frame.light)
    }
}

/// The picture that was made. A plan with nothing to do leaves it as it came.
pub(super) fn made<'a>(frame: &'a Frame, outcome: &'a Outcome) -> &'a ColorPlanes {
    let color = outcome.color.as_ref().or(frame.color.as_ref());
    color.expect("a picture was asked for")
}

impl EnhanceArgs {
    /// What is read of a frame.
    pub(super) fn reading(&self, job: &Job) -> (Inputs, Needs) {
        let mut inputs = job.work.roles.inputs(&job.work.input);
        inputs.light = Some(self.light.inputs(&self.work.flags.params, job.frame));
        let needs = Needs {
            color: true,
            projection: self.work.flags.params.shape.foreshortening != 0.0,
            ..Needs::default()
        };
        (inputs, needs)
    }

    /// The plan for a frame, with what was found in the whole of which it is a strip.
    pub(super) fn plan(&self, frame: &Frame, found: &StripChoice) -> Result<Plan> {
        let Params { shape, scaling, .. } = self.work.flags.params;
        let available = Available::in_frame(frame);
        Plan::new(Goal::Enhance, available, shape, found.given(scaling))
    }
}

/// Concavities lose their order of brightness past a limit ([RS] only claims it for convexities).
pub(super) fn dark_rims(scaling: &ScalingParams) -> Vec<String> {
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

/// Magnitudes that were asked for and have no light to scale.
fn idle_magnitudes(scaling: &ScalingParams, light: &LightLayers) -> Vec<String> {
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
        // A magnitude of 0 is at peace with nothing to scale.
        magnitude.is_some_and(|g| g > 0.0) && !used
    });
    idle.map(|(name, ..)| format!("{name} changes nothing: no layer of such light is scaled here"))
        .collect()
}
