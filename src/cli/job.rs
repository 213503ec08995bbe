//! One run from its arguments to its messages: what `shape` and `enhance` share.

use super::args::WorkArgs;
use super::message;
use super::output::write_exr;
use crate::backend::cpu::{self, Outcome};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::io::exr::OutputChannel;
use crate::io::inputs::{Inputs, LightInputs};
use crate::io::output::{check_writable, refuse_overwriting_input, write_atomically};
use crate::io::picture::{Picture, PictureFormat, write_picture};
use crate::io::svg;
use crate::io::{self, Loaded, Needs};
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run that has been given a go.
pub(super) struct Job<'a> {
    args: &'a WorkArgs,
    started: Instant,
}

/// A frame that has been read and what the plan made of it.
pub(super) struct Done {
    pub(super) loaded: Loaded,
    pub(super) outcome: Outcome,
    pub(super) read: Duration,
}

impl<'a> Job<'a> {
    /// Refuses what can be refused before any work is done.
    pub(super) fn new(args: &'a WorkArgs) -> Result<Self> {
        refuse_collisions(args)?;
        if let Some(threads) = args.run.threads {
            // A pool that exists already, in a program that calls this twice, keeps its size.
            let _ = rayon::ThreadPoolBuilder::new()
                .num_threads(threads.into())
                .build_global();
        }
        Ok(Self {
            args,
            started: Instant::now(),
        })
    }

    /// Reads the frame, plans and runs, and says on the way what was asked for.
    pub(super) fn run(&self, goal: Goal, scaling: ScalingParams) -> Result<Done> {
        self.run_on_light(goal, scaling, None)
    }

    /// [`Job::run`] that also reads these layers of light.
    pub(super) fn run_on_light(
        &self,
        goal: Goal,
        scaling: ScalingParams,
        light: Option<LightInputs>,
    ) -> Result<Done> {
        let shape = self.args.shape.params();
        let more_scales = self.args.shape.more_scales();
        if goal != Goal::Layers {
            self.args.shape.refuse_more_scales()?;
        }
        shape.validate()?;
        scaling.validate()?;
        let mut inputs = self.args.roles.inputs(&self.args.input);
        inputs.light = light;
        let needs = Needs {
            color: goal == Goal::Enhance,
            projection: shape.foreshortening != 0.0 || goal == Goal::Layers,
            ..Needs::default()
        };
        let (loaded, read) = self.load(&inputs, needs)?;
        let available = Available::in_frame(&loaded.frame);
        let plan = Plan::at_scales(goal, available, shape, scaling, more_scales)?;
        self.tell_plan(&plan)?;
        let outcome = cpu::run(&plan, &loaded.frame);
        Ok(Done {
            loaded,
            outcome,
            read,
        })
    }

    /// Reads the frame, and says what was concluded.
    pub(super) fn load(&self, inputs: &Inputs, needs: Needs) -> Result<(Loaded, Duration)> {
        let start = Instant::now();
        let loaded = io::load(inputs, needs)?;
        let read = start.elapsed();
        self.tell_findings(&loaded);
        Ok((loaded, read))
    }

    fn tell_findings(&self, loaded: &Loaded) {
        if self.args.run.verbose {
            for finding in &loaded.findings {
                message::say(&message::finding_line(finding));
            }
        }
        for warning in &loaded.warnings {
            let text = format!("{}: {warning}", self.args.input.display());
            message::warning(self.args.run.quiet, &text);
        }
    }

    /// Prints the plan, where asked to.
    pub(super) fn tell_plan(&self, plan: &Plan) -> Result<()> {
        if self.args.run.explain {
            let lines = plan
                .decisions()
                .iter()
                .map(|decision| format!("{decision}\n"));
            message::result(&lines.collect::<String>())?;
        }
        Ok(())
    }

    /// Writes colours to a display file and ends the run.
    pub(super) fn write_picture(
        &self,
        done: &Done,
        format: PictureFormat,
        picture: &Picture,
    ) -> Result<()> {
        let path = &self.args.output.output;
        let start = Instant::now();
        write_atomically(path, !self.args.output.no_clobber, |w| {
            write_picture(w, path, format, picture)
        })?;
        self.finish(done, start.elapsed())
    }

    /// Writes planes to an EXR and ends the run.
    pub(super) fn write_exr(&self, done: &Done, channels: Vec<OutputChannel>) -> Result<()> {
        let start = Instant::now();
        write_exr(&self.args.output, &done.loaded, channels)?;
        self.finish(done, start.elapsed())
    }

    /// Writes a drawing in lines and ends the run.
    pub(super) fn write_svg(&self, done: &Done, drawing: &svg::Drawing) -> Result<()> {
        let path = &self.args.output.output;
        let start = Instant::now();
        write_atomically(path, !self.args.output.no_clobber, |w| {
            svg::write_svg(w, path, drawing)
        })?;
        self.finish(done, start.elapsed())
    }

    /// Writes the timings and says what was done.
    fn finish(&self, done: &Done, write: Duration) -> Result<()> {
        let Done {
            loaded,
            outcome,
            read,
        } = done;
        let total = self.started.elapsed();
        if let Some(path) = &self.args.run.timings {
            let text = timings_json(&loaded.frame, outcome, *read, write, total);
            write_atomically(path, true, |w| {
                std::io::Write::write_all(w, text.as_bytes()).map_err(Error::io(path, "write"))
            })?;
        }
        if !self.args.run.quiet {
            let gain = outcome
                .gain
                .map(|gain| format!("curvature gain {gain:.3}, "));
            let white = outcome
                .white_level
                .map(|white| format!("white level {white:.4}, "));
            let whites = outcome.term_white_levels.iter();
            let whites = whites.map(|(term, white)| format!("white level {term} {white:.4}, "));
            let environment = outcome
                .environment_gain
                .map(|gain| format!("environment gain {gain:.4}, "));
            let drawing = outcome.drawing.as_ref();
            let paper = drawing.map(|drawing| format!("white point {:.4}, ", drawing.white_point));
            let chosen = gain.into_iter().chain(white).chain(paper).chain(whites);
            let chosen: String = chosen.chain(environment).collect();
            let path = self.args.output.output.display();
            message::say(&format!("{path}: {chosen}{:.2} s", total.as_secs_f64()));
        }
        Ok(())
    }
}

/// No output may be one of `inputs`.
pub(super) fn refuse_inputs<'a>(
    args: &WorkArgs,
    inputs: impl Iterator<Item = &'a Path> + Clone,
) -> Result<()> {
    refuse_overwriting_input("-o", &args.output.output, inputs.clone())?;
    match &args.run.timings {
        Some(timings) => refuse_overwriting_input("--timings", timings, inputs),
        None => Ok(()),
    }
}

/// No output may be an input or another output, nor an older file that must stay, nor out of reach.
fn refuse_collisions(args: &WorkArgs) -> Result<()> {
    let output = &args.output.output;
    let inputs = args.roles.files(&args.input);
    let inputs = inputs.iter().map(PathBuf::as_path);
    refuse_inputs(args, inputs)?;
    if let Some(timings) = &args.run.timings
        && timings == output
    {
        return Err(Error::BadParameter {
            name: "--timings",
            found: format!("{} is the output too", timings.display()),
            remedy: "write to another file".into(),
        });
    }
    if args.output.no_clobber && output.exists() {
        return Err(Error::BadParameter {
            name: "-o",
            found: format!("{} exists already", output.display()),
            remedy: "choose another name or leave out --no-clobber".into(),
        });
    }
    check_writable(output, true)
}

fn timings_json(
    frame: &Frame,
    outcome: &Outcome,
    read: Duration,
    write: Duration,
    total: Duration,
) -> String {
    let seconds = |d: Duration| d.as_secs_f64();
    let stages = std::iter::once(("read", read))
        .chain(outcome.timings.iter().copied())
        .chain(std::iter::once(("write", write)));
    let stages: Vec<_> = stages
        .map(|(name, time)| serde_json::json!({ "stage": name, "seconds": seconds(time) }))
        .collect();
    let summary = serde_json::json!({
        "width": frame.data_window.width(),
        "height": frame.data_window.height(),
        "covered_pixels": frame.mask.count(),
        "threads": rayon::current_num_threads(),
        "stages": stages,
        "total_seconds": seconds(total),
    });
    format!("{summary:#}\n")
}
