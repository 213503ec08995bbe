//! A picture that does not fit in memory: read, worked on and written strip by strip.

use super::chosen::Chosen;
use super::job::Job;
use super::output::{Kind, ReadyOutput};
use super::progress::strips_bar;
use crate::backend::cpu::{Outcome, Runner, StripChoice, StripSearch};
use crate::backend::guard::not_finite;
use crate::error::{Error, Result};
use crate::frame::{Frame, Plane, Window};
use crate::io::exr::OutputChannel;
use crate::io::inputs::Inputs;
use crate::io::output::write_atomically;
use crate::io::{self, Loaded, Needs, data_window};
use crate::plan::Plan;
use std::ops::Range;

/// Memory that is taken whatever the strips are: blocks being decoded and encoded, histograms, the program.
const FIXED_BYTES: u64 = 256 << 20;

/// Fewer rows are not worth a strip.
const FEWEST_ROWS: usize = 16;

/// What a command makes of a picture, whole or in strips.
pub(super) trait StripWork {
    fn runner(&self) -> &Runner;

    /// The plan for a picture or a strip of it, with what was found in the whole.
    fn plan(&self, strip: &Loaded, found: &StripChoice) -> Result<Plan>;

    fn run(&self, plan: &Plan, strip: &Frame) -> Outcome;

    /// What is written of a strip.
    fn channels<'a>(
        &self,
        job: &Job,
        strip: &'a Loaded,
        outcome: &'a Outcome,
    ) -> Vec<OutputChannel<'a>>;

    /// What `plan` takes the picture whole for, if anything.
    fn takes_whole(&self, _plan: &Plan) -> Option<&'static str> {
        None
    }
}

/// Whether a frame takes more memory than it may have, and goes in strips.
///
/// # Errors
/// [`Error::Unsupported`] where it takes more than there is, and cannot go in strips.
pub(super) fn is_too_large(job: &Job) -> Result<bool> {
    let (bytes, memory) = (bytes(job), job.work.run.max_memory);
    let [from, to] = [Kind::of(&job.work.input), job.work.output.kind()];
    if let (Ok(Kind::Exr), Kind::Exr) = (from, to?) {
        return Ok(bytes > memory.bytes());
    }
    match bytes > memory.most() {
        true => Err(too_large(job, "goes in strips from EXR to EXR alone")),
        false => Ok(false),
    }
}

/// About how much memory the frame takes.
fn bytes(job: &Job) -> u64 {
    job.work.frame_bytes(&job.work.input)
}

/// Refuses a frame that is too large, for commands that need it whole.
pub(super) fn refuse_too_large(job: &Job) -> Result<()> {
    match bytes(job) > job.work.run.max_memory.most() {
        true => Err(too_large(job, "needs the picture whole")),
        false => Ok(()),
    }
}

/// The refusal of a frame that is too large.
fn too_large(job: &Job, why: &str) -> Error {
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Error::Unsupported {
        path: job.work.input.clone(),
        found: format!(
            "takes about {:.1} GiB, and {:.1} are allowed; this {why}",
            gib(bytes(job)),
            gib(job.work.run.max_memory.most()),
        ),
        remedy: "allow more with --max-memory, or crop it".into(),
    }
}

/// How a picture is cut.
struct Strips {
    whole: Window,
    /// Rows that each strip gives.
    rows: usize,
    /// Rows that it takes above and below.
    reach: usize,
}

impl Strips {
    fn new(job: &Job, whole: Window, reach: usize) -> Result<Self> {
        let row = (bytes(job) / whole.height().max(1) as u64).max(1);
        let free = job.work.run.max_memory.bytes().saturating_sub(FIXED_BYTES);
        let rows = (free / row) as usize;
        match rows.checked_sub(2 * reach).filter(|&r| r >= FEWEST_ROWS) {
            Some(rows) => Ok(Self { whole, rows, reach }),
            None => {
                let fewest = FIXED_BYTES + row * (FEWEST_ROWS + 2 * reach) as u64;
                let why = format!("takes {} MiB even in strips", (fewest >> 20) + 1);
                Err(too_large(job, &why))
            }
        }
    }

    fn count(&self) -> usize {
        self.whole.height().div_ceil(self.rows)
    }

    /// The rows to be read for strip number `index`, and those among them that it gives.
    fn strip(&self, index: usize) -> (Range<usize>, Range<usize>) {
        let height = self.whole.height();
        let gives = index * self.rows..((index + 1) * self.rows).min(height);
        let takes = gives.start.saturating_sub(self.reach)..(gives.end + self.reach).min(height);
        let within = gives.start - takes.start..gives.end - takes.start;
        (takes, within)
    }
}

/// A picture of which strips are read.
struct Source<'a, W> {
    inputs: Inputs,
    needs: Needs,
    strips: Strips,
    work: &'a W,
    found: StripChoice,
}

impl<W: StripWork> Source<'_, W> {
    /// Strip number `index`, its plan, and the rows of it that count.
    fn load(&self, index: usize) -> Result<(Loaded, Plan, Range<usize>)> {
        let (takes, within) = self.strips.strip(index);
        let inputs = Inputs {
            rows: Some(takes),
            ..self.inputs.clone()
        };
        let loaded = io::load(&inputs, self.needs)?;
        let plan = self.work.plan(&loaded, &self.found)?;
        Ok((loaded, plan, within))
    }
}

/// Makes the picture of `job` in strips: bit for bit what it would be as a whole.
pub(super) fn make<W: StripWork>(
    work: &W,
    job: &Job,
    mut inputs: Inputs,
    needs: Needs,
) -> Result<Chosen> {
    let whole = data_window(&inputs, needs)?;
    // The middle of the picture tells how its layers are to be read.
    let middle = Strips::new(job, whole, 0)?;
    inputs.rows = Some(middle.strip(middle.count() / 2).0);
    let (mut sample, _) = job.load(&inputs, needs)?;
    sample.conventions.force(&mut inputs);
    inputs.known_camera = sample.known_camera();
    let plan = work.plan(&sample, &StripChoice::default())?;
    job.tell_plan(&plan)?;
    if let Some(why) = work.takes_whole(&plan) {
        return Err(too_large(job, why));
    }
    let read = Chosen::of_reading(&sample);
    // Its planes are not needed any more: one pixel tells what a strip gives.
    let corner = sample.frame.data_window;
    let pixel = Window::at(corner.x0, corner.y0, 1, 1);
    sample.frame = sample.frame.crop(pixel);
    let mut source = Source {
        inputs,
        needs,
        strips: Strips::new(job, whole, plan.reach())?,
        work,
        found: StripChoice::default(),
    };
    source.found = choose(&source, job, &plan)?;
    let plan = work.plan(&sample, &source.found)?;
    let outcome = work.run(&plan, &sample.frame);
    let chosen = read.with(&source.found, outcome.environment_gain);
    job.write_output(&chosen, |output| {
        let channels = work.channels(job, &sample, &outcome);
        let names = channels.into_iter().map(|c| (c.name, c.sample_type));
        let args = &job.work.output;
        let part = args.part(&sample, whole, names.collect(), job.recipe(&chosen));
        let ReadyOutput { path, replace } = output;
        write_atomically(path, replace, |w| {
            let (mut writer, warnings) = args.part_writer(&sample, w, path, &part)?;
            warnings.iter().for_each(|warning| job.warn(warning));
            write(&source, job, |planes, rows| writer.push(planes, rows))?;
            let clamped = args.clamped(writer.finish()?);
            clamped.iter().for_each(|warning| job.warn(warning));
            Ok(())
        })
    })?;
    Ok(chosen)
}

/// The gain and white levels of the whole picture, where they are left open.
fn choose<W: StripWork>(source: &Source<W>, job: &Job, plan: &Plan) -> Result<StripChoice> {
    let Some(mut search) = StripSearch::new(plan, source.strips.whole) else {
        return Ok(StripChoice::default());
    };
    let bar = strips_bar(&job.work.run, "looking", 2 * source.strips.count());
    for time in 0..2 {
        for index in 0..source.strips.count() {
            let (loaded, plan, rows) = source.load(index)?;
            search.look(source.work.runner(), &plan, &loaded.frame, rows);
            bar.inc(1);
        }
        if time == 0 {
            search.narrow();
        }
    }
    bar.finish_and_clear();
    Ok(search.found())
}

/// Makes every strip, from top to bottom, and has its rows pushed.
fn write<W: StripWork>(
    source: &Source<W>,
    job: &Job,
    mut push: impl FnMut(&[&Plane], Range<usize>) -> Result<()>,
) -> Result<()> {
    let bar = strips_bar(&job.work.run, "writing", source.strips.count());
    for index in 0..source.strips.count() {
        let (loaded, plan, rows) = source.load(index)?;
        let outcome = source.work.run(&plan, &loaded.frame);
        let channels = source.work.channels(job, &loaded, &outcome);
        let planes: Vec<&Plane> = channels.iter().map(|c| c.plane).collect();
        job.refuse(not_finite(&plan, &loaded.frame, &outcome, &planes))?;
        push(&planes, rows)?;
        source.work.runner().take_back(outcome);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}
