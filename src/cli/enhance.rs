//! `relievo enhance`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::strip_memory;
use super::strips::{self, Shown, StripWork};
use crate::command::args::WorkArgs;
use crate::command::chosen::{Chosen, look_at_depth};
use crate::command::commands::EnhanceArgs;
use crate::command::enhance::{dark_rims, idle_magnitudes, made};
use crate::engine::cpu::Runner;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::engine::{self, Engine};
use crate::error::Result;
use crate::frame::Frame;
use crate::io::Loaded;
use crate::io::exr::OutputChannel;
use crate::plan::Plan;
use std::path::PathBuf;

impl FrameCommand for EnhanceArgs {
    type Kit = Engine;

    fn work(&self) -> &WorkArgs {
        &self.work
    }

    fn work_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn files(&self, frame: Option<i32>) -> Vec<PathBuf> {
        self.light.files(frame).collect()
    }

    fn validate(&self) -> Result<()> {
        self.work.output.kind()?;
        self.work.output.refuse_numbers()?;
        self.work.flags.refuse_more_scales()
    }

    fn prepare(&self) -> Result<Engine> {
        self.work.run.compute.backend.engine()
    }

    fn make(&self, engine: &Engine, job: &Job) -> Result<Chosen> {
        let scaling = self.work.flags.params.scaling;
        let (inputs, needs) = self.reading(job.frame);
        let warnings = dark_rims(&scaling);
        warnings.iter().for_each(|warning| job.warn(warning));
        let work = Enhancement {
            args: self,
            runner: engine.cpu_runner(),
        };
        if strip_memory::goes_in_strips(job)? {
            return strips::make(&work, job, inputs, needs);
        }
        let (mut loaded, read) = job.load(&inputs, needs)?;
        let plan = work.plan(&loaded, &StripChoice::default())?;
        job.tell_plan(&plan);
        work.warnings(&loaded)
            .iter()
            .for_each(|text| job.warn(text));
        look_at_depth(&mut loaded);
        let mut outcome =
            job.execute(engine, &plan, &mut loaded.frame, engine::Inputs::default())?;
        job.keep_picture_alone(engine, &mut outcome);
        job.work.mix(&loaded.frame, &mut outcome);
        let done = Done {
            loaded,
            outcome,
            read,
        };
        let chosen = job.write_color(&done, made(&done.loaded.frame, &done.outcome))?;
        engine.recycle(done.outcome);
        Ok(chosen)
    }
}

/// Strip-wise processing by `enhance`.
struct Enhancement<'a> {
    args: &'a EnhanceArgs,
    runner: &'a Runner,
}

impl StripWork for Enhancement<'_> {
    fn finish(&self, strip: &Frame, outcome: &mut Outcome) {
        self.args.work.mix(strip, outcome);
    }

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
        job.color_channels(strip, made(&strip.frame, outcome).color)
    }

    fn shown<'a>(&self, strip: &'a Loaded, outcome: &'a Outcome) -> Shown<'a> {
        Shown::Made(made(&strip.frame, outcome))
    }

    fn warnings(&self, loaded: &Loaded) -> Vec<String> {
        idle_magnitudes(&self.args.work.flags.params.scaling, &loaded.frame.light)
    }
}
