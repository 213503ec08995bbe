//! `relievo map`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::map::{MapArgs, Samples};
use crate::command::output::Kind;
use crate::engine::outcome::{Outcome, add_timings};
use crate::engine::{self, Engine};
use crate::error::Result;
use crate::frame::{Plane, Vector3Planes};
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
        self.work.output.tiff_holds_numbers = self.keeps_numbers();
        self
    }

    fn files(&self, _frame: Option<i32>) -> Vec<PathBuf> {
        self.detail.iter().cloned().collect()
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
        let detail = self.detail(&inputs, &loaded.frame)?;
        for warning in detail.iter().flat_map(|detail| &detail.warnings) {
            job.warn(&format!("--detail: {warning}"));
        }
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
        let (normal, said) = self.normals(&done.loaded.frame, detail.as_ref().map(|d| &d.frame))?;
        said.iter().for_each(|said| job.note(said));
        self.write(job, &done, &samples, &normal)
    }
}

impl MapArgs {
    /// Writes each map to a file of its own, or all to one EXR.
    fn write(
        &self,
        job: &Job,
        done: &Done,
        samples: &Samples,
        normal: &Vector3Planes,
    ) -> Result<Chosen> {
        let (parts, frame) = (self.parts(), &done.loaded.frame);
        let kind = job.work.output.kind()?;
        if kind == Kind::Exr && !job.work.output.is_per_map() {
            let mut made = Vec::new();
            for part in &parts {
                let of_part = self.made(part, samples, frame, normal)?;
                made.extend(of_part.named(&part.name));
            }
            return job.write_channels(done, self.channels(&made));
        }
        let mut chosen = Chosen::default();
        for part in &parts {
            let made = self.made(part, samples, frame, normal)?;
            let is_picture = matches!(kind, Kind::Picture(_));
            if let Some(words) = made.in_words(part, &frame.mask, is_picture) {
                job.note(&words);
            }
            let job = job.writing(&part.name);
            chosen = match is_picture {
                false => job.write_channels(done, self.channels(&made.named(&part.name)))?,
                true => job.write_picture(
                    done,
                    &Picture {
                        grey: made.is_grey(),
                        bits: self.bits(),
                        dpi: self.work.dpi(frame),
                        ..Picture::of(&made.picture(&frame.mask), ViewTransform::None)
                    },
                )?,
            };
        }
        Ok(chosen)
    }

    /// The channels of an EXR that hold maps.
    fn channels<'a>(&self, maps: &'a [(String, Plane)]) -> Vec<OutputChannel<'a>> {
        let given = self.work.output.depth_of_output;
        let channel = |(name, plane): &'a (String, Plane)| OutputChannel {
            name: match self.is_of_normals(name) {
                true => name.clone(),
                false => format!("map.{name}"),
            },
            plane,
            sample_type: given.unwrap_or(OutputType::Float),
        };
        maps.iter().map(channel).collect()
    }
}
