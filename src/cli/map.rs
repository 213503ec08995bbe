//! `relievo map`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::map::{Made, MapArgs, Part, Samples};
use crate::command::output::Kind;
use crate::engine::outcome::{Outcome, add_timings};
use crate::engine::{self, Engine};
use crate::error::Result;
use crate::frame::ColorPlanes;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::picture::{Picture, ViewTransform};
use std::path::PathBuf;

impl FrameCommand for MapArgs {
    type Kit = Engine;

    fn work(&self) -> &WorkArgs {
        &self.work
    }

    fn work_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn settled(mut self) -> Self {
        let parts = self.parts().into_iter();
        self.work.output.parts = parts.map(|part| part.name).collect();
        self
    }

    fn files(&self, _frame: Option<i32>) -> Vec<PathBuf> {
        Vec::new()
    }

    fn validate(&self) -> Result<()> {
        self.check()
    }

    fn prepare(&self) -> Result<Engine> {
        self.work.run.compute.backend.engine()
    }

    fn make(&self, engine: &Engine, job: &Job) -> Result<Chosen> {
        job.work.refuse_too_large(&job.work.input)?;
        let (inputs, needs) = self.reading(job.frame);
        let (mut loaded, read) = job.load(&inputs, needs)?;
        let passes = self.passes(&loaded.frame)?;
        let (mut samples, mut all) = (Samples::default(), Outcome::default());
        let scales = passes
            .iter()
            .filter(|pass| pass.plan.chooses_gain())
            .count();
        for pass in &passes {
            job.tell_plan(&pass.plan);
            let inputs = engine::Inputs::default();
            let mut outcome = job.execute(engine, &pass.plan, &mut loaded.frame, inputs)?;
            match (scales, outcome.gain) {
                (..2, _) => all.gain = all.gain.or(outcome.gain),
                (_, Some(gain)) => {
                    let sigma = pass.plan.shape.scale_px();
                    job.note(&format!("scale {sigma:.2}: curvature gain {gain:.3}"));
                }
                _ => {}
            }
            add_timings(&mut all.timings, &outcome.timings);
            samples.take(pass, &mut outcome);
            engine.recycle(outcome);
        }
        let done = Done {
            loaded,
            outcome: all,
            read,
        };
        self.write(job, &done, &samples)
    }
}

impl MapArgs {
    /// Writes each map to a file of its own, or all to one EXR.
    fn write(&self, job: &Job, done: &Done, samples: &Samples) -> Result<Chosen> {
        let (parts, mask) = (self.parts(), &done.loaded.frame.mask);
        let is_exr = job.work.output.kind()? == Kind::Exr;
        if is_exr && !job.work.output.is_per_map() {
            let made: Vec<_> = parts
                .iter()
                .map(|part| (part, self.made(part, samples, mask)))
                .collect();
            let channels = made.iter().map(|(part, made)| self.channel(part, made));
            return job.write_exr(done, channels.collect());
        }
        let mut chosen = Chosen::default();
        for part in &parts {
            let made = self.made(part, samples, mask);
            if let Some(words) = made.in_words(part, mask) {
                job.note(&words);
            }
            let job = job.writing(&part.name);
            chosen = match is_exr {
                true => job.write_exr(done, vec![self.channel(part, &made)])?,
                false => job.write_picture(
                    done,
                    &Picture {
                        grey: true,
                        bits: self.bits(),
                        dpi: self.work.dpi(&done.loaded.frame),
                        ..Picture::of(
                            &ColorPlanes {
                                r: made.grey(mask),
                                ..ColorPlanes::default()
                            },
                            ViewTransform::None,
                        )
                    },
                )?,
            };
        }
        Ok(chosen)
    }

    /// The channel of an EXR that holds a map.
    fn channel<'a>(&self, part: &Part, made: &'a Made) -> OutputChannel<'a> {
        let given = self.work.output.depth_of_output;
        OutputChannel {
            name: format!("map.{}", part.name),
            plane: &made.plane,
            sample_type: given.unwrap_or(OutputType::Float),
        }
    }
}
