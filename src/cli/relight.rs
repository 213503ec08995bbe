//! `relievo relight`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::message;
use super::strip_memory;
use super::strips::{self, Shown, StripWork};
use crate::command::args::WorkArgs;
use crate::command::chosen::{Chosen, look_at_depth};
use crate::command::enhance::dark_rims;
use crate::command::output::MadePicture;
use crate::command::relight::{illumination, light_or_lamp, lit, needs, specular_scene};
use crate::command::relight_args::RelightArgs;
use crate::engine::cpu::Runner;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::engine::{self, Engine};
use crate::error::Result;
use crate::frame::{Frame, SpecularScene};
use crate::io::Loaded;
use crate::io::exr::OutputChannel;
use crate::light::lights::Illumination;
use crate::plan::{LightKinds, Plan};
use std::path::PathBuf;

/// Inputs shared by all relit frames.
pub(super) struct RelightInputs {
    illumination: Illumination,
    engine: Engine,
}

impl FrameCommand for RelightArgs {
    type Kit = RelightInputs;

    fn work(&self) -> &WorkArgs {
        &self.work
    }

    fn work_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn files(&self, frame: Option<i32>) -> Vec<PathBuf> {
        RelightArgs::files(self, frame)
    }

    fn validate(&self) -> Result<()> {
        let work = &self.work;
        work.output.kind()?;
        work.output.refuse_numbers()?;
        work.flags.refuse_more_scales()
    }

    fn prepare(&self) -> Result<RelightInputs> {
        let most = self.work.run.max_memory.for_light();
        let (illumination, lamp) = light_or_lamp(self, illumination(self, most)?);
        if let Some(text) = lamp {
            message::warning(self.work.run.quiet, &text);
        }
        let passed = self.past_the_zenith();
        passed.for_each(|text| message::warning(self.work.run.quiet, &text));
        Ok(RelightInputs {
            illumination,
            engine: self.work.run.compute.backend.engine()?,
        })
    }

    fn make(&self, kit: &RelightInputs, job: &Job) -> Result<Chosen> {
        let needs = needs(&self.params(), &kit.illumination);
        let specular = self.specular.of_frame(job.frame).inputs();
        let mut work = Relight {
            args: self,
            kit,
            scene: None,
        };
        if self.params().method.scales() {
            let warnings = dark_rims(&self.work.flags.params.scaling);
            warnings.iter().for_each(|warning| job.warn(warning));
        }
        if !specular.is_empty() {
            job.work.refuse_too_large(&job.work.input)?;
            strip_memory::refuse_large_surroundings(job, specular.surroundings.as_deref())?;
        } else if strip_memory::goes_in_strips(job)? {
            return strips::make(&work, job, self.inputs(job.frame), needs);
        }
        let (mut loaded, read) = job.load(&self.inputs(job.frame), needs)?;
        if !specular.is_empty() {
            work.scene = Some(specular_scene(&specular, &self.params(), &mut loaded)?);
        }
        let mut plan = work.plan(&loaded, &StripChoice::default())?;
        job.settle_albedo(&mut plan, &loaded.frame);
        job.tell_plan(&plan);
        look_at_depth(&mut loaded);
        let mut outcome = job.execute(&kit.engine, &plan, &mut loaded.frame, work.inputs())?;
        job.keep_picture_alone(&kit.engine, &mut outcome);
        job.work.mix(&loaded.frame, &mut outcome);
        let done = Done {
            loaded,
            outcome,
            read,
        };
        let chosen = job.write_color(&done, work.lit(&done.loaded.frame, &done.outcome))?;
        kit.engine.recycle(done.outcome);
        Ok(chosen)
    }
}

/// Strip-wise processing by `relight`.
struct Relight<'a> {
    args: &'a RelightArgs,
    kit: &'a RelightInputs,
    /// The scene seen in mirrors and through lenses.
    scene: Option<SpecularScene>,
}

impl Relight<'_> {
    fn lit<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> MadePicture<'a> {
        lit(frame, outcome, self.args.work.flags.params.mix)
    }
}

impl StripWork for Relight<'_> {
    fn finish(&self, strip: &Frame, outcome: &mut Outcome) {
        self.args.work.mix(strip, outcome);
    }

    fn runner(&self) -> &Runner {
        self.kit.engine.cpu_runner()
    }

    fn plan(&self, strip: &Loaded, found: &StripChoice) -> Result<Plan> {
        let (kinds, is_traced) = (
            LightKinds::in_light(&self.kit.illumination),
            self.scene.is_some(),
        );
        self.args.plan(&strip.frame, kinds, is_traced, found)
    }

    fn inputs(&self) -> engine::Inputs<'_> {
        engine::Inputs {
            specular: self.scene.as_ref(),
            ..engine::Inputs::lit_by(&self.kit.illumination)
        }
    }

    fn channels<'a>(
        &self,
        job: &Job,
        strip: &'a Loaded,
        outcome: &'a Outcome,
    ) -> Vec<OutputChannel<'a>> {
        job.color_channels(strip, self.lit(&strip.frame, outcome).color)
    }

    fn shown<'a>(&self, strip: &'a Loaded, outcome: &'a Outcome) -> Shown<'a> {
        Shown::Made(self.lit(&strip.frame, outcome))
    }
}
