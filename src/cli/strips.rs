//! A picture that does not fit in memory: read, enhanced and written strip by strip.

use super::args::EnhanceArgs;
use super::chosen::Chosen;
use super::job::Job;
use super::output::{Kind, ReadyOutput, color_channels};
use super::progress::strips_bar;
use crate::backend::cpu::{Runner, StripChoice, StripSearch};
use crate::error::{Error, Result};
use crate::frame::Window;
use crate::io::inputs::Inputs;
use crate::io::output::write_atomically;
use crate::io::{self, Loaded, Needs, data_window, frame_bytes};
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use std::ops::Range;

/// Memory that is taken whatever the strips are: blocks being decoded and encoded, histograms, the program.
const FIXED_BYTES: u64 = 256 << 20;

/// Fewer rows are not worth a strip.
const FEWEST_ROWS: usize = 16;

/// Whether a frame takes more memory than it may have, and goes in strips.
///
/// # Errors
/// [`Error::Unsupported`] where it takes more than there is, and cannot go in strips.
pub(super) fn is_too_large(job: &Job) -> Result<bool> {
    let (bytes, memory) = (frame_bytes(&job.work.input), job.work.run.max_memory);
    let [from, to] = [Kind::of(&job.work.input), job.work.output.kind()];
    if let (Ok(Kind::Exr), Kind::Exr) = (from, to?) {
        return Ok(bytes > memory.bytes());
    }
    match bytes > memory.most() {
        true => Err(too_large(job, "goes in strips from EXR to EXR alone")),
        false => Ok(false),
    }
}

/// Refuses a frame that is too large, for commands that need it whole.
pub(super) fn refuse_too_large(job: &Job) -> Result<()> {
    match frame_bytes(&job.work.input) > job.work.run.max_memory.most() {
        true => Err(too_large(job, "needs the picture whole")),
        false => Ok(()),
    }
}

fn too_large(job: &Job, why: &str) -> Error {
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Error::Unsupported {
        path: job.work.input.clone(),
        found: format!(
            "takes about {:.1} GiB, and {:.1} are allowed; this {why}",
            gib(frame_bytes(&job.work.input)),
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
        let frame = frame_bytes(&job.work.input);
        let row = (frame / whole.height().max(1) as u64).max(1);
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

/// A picture to be enhanced, of which strips are read.
struct Source<'a> {
    inputs: Inputs,
    needs: Needs,
    strips: Strips,
    args: &'a EnhanceArgs,
    runner: &'a Runner,
}

impl Source<'_> {
    /// The frame of strip number `index`, with the rows of it that count.
    fn load(&self, index: usize) -> Result<(Loaded, Range<usize>)> {
        let (takes, within) = self.strips.strip(index);
        let inputs = Inputs {
            rows: Some(takes),
            ..self.inputs.clone()
        };
        Ok((io::load(&inputs, self.needs)?, within))
    }

    fn plan(&self, loaded: &Loaded, scaling: ScalingParams) -> Result<Plan> {
        let available = Available::in_frame(&loaded.frame);
        let shape = self.args.work.shape.params();
        Plan::at_scales(Goal::Enhance, available, shape, scaling, &[])
    }
}

/// Enhances the picture of `job` in strips: bit for bit what it would be as a whole with the explicit solver, and
/// within the tolerance of the other.
pub(super) fn enhance(
    args: &EnhanceArgs,
    runner: &Runner,
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
    let mut source = Source {
        inputs,
        needs,
        strips: middle,
        args,
        runner,
    };
    let mut scaling = args.scaling();
    let plan = source.plan(&sample, scaling)?;
    job.tell_plan(&plan)?;
    source.strips = Strips::new(job, whole, plan.reach())?;
    let read = Chosen::of_reading(&sample);
    // Its planes are not needed any more.
    let corner = sample.frame.data_window;
    let pixel = Window::at(corner.x0, corner.y0, 1, 1);
    sample.frame = sample.frame.crop(pixel);
    let choice = choose(&source, job, &plan, scaling)?;
    choice.give(&mut scaling);
    let chosen = read.with(&choice);
    job.write_output(&chosen, |output| {
        write(&source, job, &sample, scaling, &chosen, output)
    })?;
    Ok(chosen)
}

/// The gain and white levels of the whole picture, where they are left open.
fn choose(source: &Source, job: &Job, plan: &Plan, scaling: ScalingParams) -> Result<StripChoice> {
    let Some(mut search) = StripSearch::new(plan, source.strips.whole) else {
        return Ok(StripChoice::default());
    };
    let bar = strips_bar(&job.work.run, "looking", 2 * source.strips.count());
    for time in 0..2 {
        for index in 0..source.strips.count() {
            let (loaded, rows) = source.load(index)?;
            let plan = source.plan(&loaded, scaling)?;
            search.look(source.runner, &plan, &loaded.frame, rows);
            bar.inc(1);
        }
        if time == 0 {
            search.narrow();
        }
    }
    bar.finish_and_clear();
    Ok(search.found())
}

fn write(
    source: &Source,
    job: &Job,
    sample: &Loaded,
    scaling: ScalingParams,
    chosen: &Chosen,
    output: ReadyOutput,
) -> Result<()> {
    let args = &job.work.output;
    let names = |loaded: &Loaded| {
        let color = loaded.frame.color.clone().expect("a picture was asked for");
        let alpha = loaded.frame.alpha.clone();
        let layer = args.color_layer(loaded);
        let channels = color_channels(layer, &color, alpha.as_ref(), args.sample_type(loaded));
        let named = channels.into_iter().map(|c| (c.name, c.sample_type));
        named.collect::<Vec<_>>()
    };
    let part = args.part(
        sample,
        source.strips.whole,
        names(sample),
        job.recipe(chosen),
    );
    let ReadyOutput { path, clobber } = output;
    let bar = strips_bar(&job.work.run, "writing", source.strips.count());
    write_atomically(path, clobber, |w| {
        let (mut writer, warnings) = args.part_writer(sample, w, path, &part)?;
        warnings.iter().for_each(|warning| job.warn(warning));
        for index in 0..source.strips.count() {
            let (loaded, rows) = source.load(index)?;
            let plan = source.plan(&loaded, scaling)?;
            let mut outcome = source.runner.run(&plan, &loaded.frame);
            let made = outcome.color.take();
            let color = made.as_ref().or(loaded.frame.color.as_ref());
            let color = color.expect("a picture was asked for");
            let alpha = loaded.frame.alpha.iter();
            let planes: Vec<_> = [&color.r, &color.g, &color.b]
                .into_iter()
                .chain(alpha)
                .collect();
            writer.push(&planes, rows)?;
            outcome.color = made;
            source.runner.take_back(outcome);
            bar.inc(1);
        }
        bar.finish_and_clear();
        writer.finish()
    })
}
