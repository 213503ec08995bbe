//! `relievo shape`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::strip_memory;
use super::strips::{self, Shown, StripWork};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::commands::ShapeArgs;
use crate::command::output::{Kind, MOST_PLANES};
use crate::command::shape::display;
use crate::engine::cpu::Runner;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::{Outcome, ScaleShape};
use crate::engine::{self, Engine};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::picture::Picture;
use crate::plan::{Goal, Plan};
use crate::product::Product;
use std::path::PathBuf;

impl FrameCommand for ShapeArgs {
    type Kit = Engine;

    fn work(&self) -> &WorkArgs {
        &self.work
    }

    fn work_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn files(&self, _frame: Option<i32>) -> Vec<PathBuf> {
        Vec::new()
    }

    fn validate(&self) -> Result<()> {
        let output = &self.work.output;
        if matches!(output.kind()?, Kind::Numbers(_)) && output.write.is_empty() {
            return Err(Error::BadParameter {
                name: "-o",
                found: format!("holds up to {MOST_PLANES} planes, and shape makes more"),
                remedy: "choose them, as in --write curvature.mean, or write an .exr".into(),
            });
        }
        match self.work.goal()? {
            Goal::Display => self.work.flags.refuse_more_scales(),
            _ => Ok(()),
        }
    }

    fn prepare(&self) -> Result<Engine> {
        self.work.run.compute.backend.engine()
    }

    fn make(&self, engine: &Engine, job: &Job) -> Result<Chosen> {
        let work = Description {
            args: &self.work,
            goal: self.work.goal()?,
            runner: engine.cpu_runner(),
        };
        let (inputs, needs) = self.work.reading(work.goal, job.frame);
        if self.work.takes_whole() {
            job.work.refuse_too_large(&job.work.input)?;
        } else if strip_memory::goes_in_strips(job)? {
            return strips::make(&work, job, inputs, needs);
        }
        let (mut loaded, read) = job.load(&inputs, needs)?;
        let plan = work.plan(&loaded, &StripChoice::default())?;
        job.tell_plan(&plan);
        if self.work.goal()? == Goal::Layers {
            let layers = job.execute_for_rows(engine, &plan, &mut loaded.frame)?;
            job.release_spare_memory(engine);
            let chosen = job.write_layers(&loaded, &layers, read, |rows| {
                work.named(&rows.frame, &rows.outcome)
            })?;
            engine.recycle(layers.outcome);
            return Ok(chosen);
        }
        let outcome = job.execute(engine, &plan, &mut loaded.frame, engine::Inputs::default())?;
        job.release_spare_memory(engine);
        let done = Done {
            loaded,
            outcome,
            read,
        };
        let dpi = self.work.dpi(&done.loaded.frame);
        let picture = Picture {
            dpi,
            ..display(&done.outcome)
        };
        let chosen = job.write_picture(&done, &picture)?;
        engine.recycle(done.outcome);
        Ok(chosen)
    }
}

/// Strip-wise processing by `shape`.
struct Description<'a> {
    args: &'a WorkArgs,
    goal: Goal,
    runner: &'a Runner,
}

impl StripWork for Description<'_> {
    fn runner(&self) -> &Runner {
        self.runner
    }

    fn plan(&self, strip: &Loaded, found: &StripChoice) -> Result<Plan> {
        self.args.plan(self.goal, &strip.frame, found)
    }

    fn channels<'a>(
        &self,
        _job: &Job,
        strip: &'a Loaded,
        outcome: &'a Outcome,
    ) -> Vec<OutputChannel<'a>> {
        self.named(&strip.frame, outcome)
    }

    fn shown<'a>(&self, strip: &'a Loaded, outcome: &'a Outcome) -> Shown<'a> {
        Shown::Display(Picture {
            dpi: self.args.dpi(&strip.frame),
            ..display(outcome)
        })
    }
}

impl Description<'_> {
    fn named<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Vec<OutputChannel<'a>> {
        let stored = self.args.output.depth_of_output;
        descriptor_channels(frame, outcome, stored.unwrap_or(OutputType::Half))
    }
}

/// The layers of the contract, under its names.
fn descriptor_channels<'a>(
    frame: &'a Frame,
    outcome: &'a Outcome,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let normal = &frame.normal;
    let normals = [("x", &normal.x), ("y", &normal.y), ("z", &normal.z)];
    let normals = normals.map(|(axis, plane)| (format!("normal.{axis}"), plane));
    let of_product = |product: Product| {
        // Half floats tell heights to three digits.
        let sample_type = match product == Product::Height {
            true => OutputType::Float,
            false => sample_type,
        };
        let channels = product.channels().zip(outcome.planes(product));
        channels.map(move |(name, plane)| (name, plane, sample_type))
    };
    let first = Product::all().flat_map(of_product);
    let more = outcome
        .shape
        .more_scales
        .iter()
        .flat_map(ScaleShape::channels);
    let confidence = frame.confidence.as_ref();
    let confidence = confidence.map(|plane| ("weights.confidence".to_string(), plane));
    let typed = |(name, plane)| (name, plane, sample_type);
    let channels = normals.into_iter().chain(confidence).map(typed);
    let channels = channels.chain(first).chain(more.map(typed));
    let channels = channels.map(|(name, plane, sample_type)| OutputChannel {
        name,
        plane,
        sample_type,
    });
    channels.collect()
}
