//! Pictures that do not fit in memory: read, processed and written strip by strip.

use super::job::Job;
use super::output::{ReadyOutput, attributes};
use super::progress::strips_bar;
use super::strip_memory::{Cost, FEWEST_ROWS, strips_of};
use super::timings::Timings;
use crate::command::chosen::Chosen;
use crate::command::output::{Kind, MadePicture};
use crate::engine;
use crate::engine::cpu::Runner;
use crate::engine::cpu::strips::{StripChoice, StripSearch};
use crate::engine::outcome::Outcome;
use crate::engine::tiles::Strips;
use crate::error::Result;
use crate::frame::{CONFIDENCE_REACH, ColorPlanes, Frame, HOLE_REACH, Plane, Window};
use crate::io::exr::OutputChannel;
use crate::io::inputs::Inputs;
use crate::io::output::write_atomically;
use crate::io::picture::{Brightness, Encoding, Gathered, Picture, Whites};
use crate::io::{InputFiles, Loaded, Needs};
use crate::plan::Plan;
use std::cell::RefCell;
use std::ops::Range;
use std::time::Instant;

/// The work of a command on a picture, whole or in strips.
pub(super) trait StripWork {
    fn runner(&self) -> &Runner;

    /// The plan for a picture or a strip of it, with what was found in the whole.
    fn plan(&self, strip: &Loaded, found: &StripChoice) -> Result<Plan>;

    /// Inputs of a plan other than the picture.
    fn inputs(&self) -> engine::Inputs<'_> {
        engine::Inputs::default()
    }

    /// Finishes all results of a strip, pixel by pixel.
    fn finish(&self, _strip: &Frame, _outcome: &mut Outcome) {}

    /// The layers of a strip written to an EXR.
    fn channels<'a>(
        &self,
        job: &Job,
        strip: &'a Loaded,
        outcome: &'a Outcome,
    ) -> Vec<OutputChannel<'a>>;

    /// The colours of a strip shown by a picture.
    fn shown<'a>(&self, strip: &'a Loaded, outcome: &'a Outcome) -> Shown<'a>;

    /// Warnings about the settings given for this picture.
    fn warnings(&self, _loaded: &Loaded) -> Vec<String> {
        Vec::new()
    }
}

/// The contents of a picture.
pub(super) enum Shown<'a> {
    /// A picture, as it is in linear light.
    Made(MadePicture<'a>),
    /// A display of something else.
    Display(Picture<'a>),
}

impl Shown<'_> {
    /// The result of `take` for the displayed picture of a strip at this exposure, and the one before.
    fn with<T>(
        &self,
        job: &Job,
        strip: &Loaded,
        exposure: Option<f32>,
        take: impl FnOnce(&Picture, Option<&ColorPlanes>) -> T,
    ) -> T {
        match *self {
            Self::Made(made) => {
                let displayed = job.displayed(strip, made, exposure);
                take(&displayed.picture(), displayed.before())
            }
            Self::Display(ref picture) => take(picture, None),
        }
    }
}

/// A picture of which strips are read.
struct Source<'a, W> {
    files: InputFiles,
    inputs: Inputs,
    needs: Needs,
    whole: Window,
    strips: Strips,
    work: &'a W,
    found: StripChoice,
    timings: RefCell<Timings>,
}

impl<W: StripWork> Source<'_, W> {
    /// These rows of the picture, and their plan.
    fn load(&self, takes: Range<usize>) -> Result<(Loaded, Plan)> {
        let inputs = Inputs {
            rows: Some(takes),
            ..self.inputs.clone()
        };
        let loaded = self.timed("read", || self.files.load(&inputs, self.needs))?;
        let plan = self.work.plan(&loaded, &self.found)?;
        Ok((loaded, plan))
    }

    fn timed<T>(&self, name: &'static str, stage: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = stage();
        self.timings.borrow_mut().add(name, start.elapsed());
        done
    }
}

/// Makes the picture of `job` in strips: bit for bit what it would be as a whole.
pub(super) fn make<W: StripWork>(
    work: &W,
    job: &Job,
    mut inputs: Inputs,
    needs: Needs,
) -> Result<Chosen> {
    let files = InputFiles::open_for_strips(&inputs)?;
    let extent = files.extent(&inputs, needs)?;
    let (whole, photo_bytes) = (extent.window, extent.photo_bytes);
    let mut sample = middle(job, &files, &mut inputs, needs)?;
    sample.settle(&mut inputs);
    inputs.known_camera = sample.known_camera();
    // Strips do not look again for a camera that the middle of the picture does not show.
    let needs = Needs {
        projection: needs.projection && sample.frame.camera.is_some(),
        ..needs
    };
    let plan = work.plan(&sample, &StripChoice::default())?;
    job.tell_plan(&plan);
    let warnings = work.warnings(&sample);
    warnings.iter().for_each(|text| job.warn(text));
    let read = Chosen::of_reading(&sample);
    // Its planes are not needed any more: one pixel tells what a strip gives.
    let corner = sample.frame.data_window;
    let pixel = Window::at(corner.x0, corner.y0, 1, 1);
    sample.frame = sample.frame.crop(pixel);
    let gathered = gathered(work, job, &sample, &plan, whole)?;
    let cost = Cost::new(job, whole.height(), photo_bytes, gathered.as_ref());
    let mut source = Source {
        files,
        inputs,
        needs,
        whole,
        strips: strips_of(job, cost, plan.reach() + HOLE_REACH + CONFIDENCE_REACH)?,
        work,
        found: StripChoice::default(),
        timings: RefCell::new(Timings::of_window(whole)),
    };
    source.found = choose(&source, job, &plan)?;
    job.note_gain(&plan, source.found.gain);
    let plan = work.plan(&sample, &source.found)?;
    let outcome = run(work, &plan, &sample.frame)?;
    let chosen = read.with(&source.found, &outcome);
    let shown = gathered.as_ref().map(|_| work.shown(&sample, &outcome));
    let exposure = match shown {
        Some(Shown::Made(made)) => exposure(&source, job, made)?,
        _ => None,
    };
    let chosen = chosen.exposed(exposure);
    job.write_output(&chosen, |output| {
        let whites = match gathered {
            Some(gathered) => {
                let settings = job.recipe(&chosen);
                let encoding =
                    job.work
                        .output
                        .encoding(&sample, settings, &job.work.flags.params)?;
                write_gathered(&source, job, output, (gathered, &encoding), exposure)?
            }
            None => {
                let channels = job
                    .work
                    .output
                    .picked(work.channels(job, &sample, &outcome))?;
                let recipe = job.recipe(&chosen);
                write_part(&source, job, output, (&sample, &channels), recipe)?;
                Whites::default()
            }
        };
        job.write_timings(&source.timings.borrow())?;
        Ok(whites)
    })?;
    job.explain(&source.timings.borrow(), &chosen)?;
    Ok(chosen)
}

/// Stops that suit new light, of which `sample` is a part, where they are left open: all strips are lit for them.
fn exposure<W: StripWork>(
    source: &Source<W>,
    job: &Job,
    sample: MadePicture,
) -> Result<Option<f32>> {
    if !sample.leaves_exposure(&job.work) {
        return Ok(None);
    }
    let bar = strips_bar(&job.work.run, "looking", source.strips.count());
    let mut brightness = Brightness::default();
    for (takes, rows) in source.strips.each() {
        let (loaded, plan) = source.load(takes)?;
        let outcome = source.timed("look", || run(source.work, &plan, &loaded.frame))?;
        if let Shown::Made(made) = source.work.shown(&loaded, &outcome) {
            brightness.add(made.color, made.like, &loaded.frame.mask, rows);
        }
        source.work.runner().recycle(outcome);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Some(brightness.exposure()))
}

/// The result of a strip.
fn run<W: StripWork>(work: &W, plan: &Plan, strip: &Frame) -> Result<Outcome> {
    let mut outcome = work.runner().execute(plan, strip, work.inputs())?;
    work.finish(strip, &mut outcome);
    Ok(outcome)
}

/// The middle of the picture, which tells how its layers are to be read: as many rows as fit.
fn middle(job: &Job, files: &InputFiles, inputs: &mut Inputs, needs: Needs) -> Result<Loaded> {
    let extent = files.extent(inputs, needs)?;
    let height = extent.window.height();
    let cost = Cost::new(job, height, extent.photo_bytes, None);
    let rows = cost.rows_allowed(job).max(FEWEST_ROWS).min(height);
    let first = (height - rows) / 2;
    inputs.rows = Some(first..first + rows);
    let most = job.work.run.max_memory.bytes();
    if cost.least(0) <= most {
        return Ok(job.load_from(files, inputs, needs)?.0);
    }
    // It will be refused; but what it takes is only known from its plan.
    let sparing = InputFiles::open_within(inputs, most)?;
    Ok(job.load_from(&sparing, inputs, needs)?.0)
}

/// Gathers the samples of a picture for a display; `None` for layers, and if nothing is written.
fn gathered<W: StripWork>(
    work: &W,
    job: &Job,
    sample: &Loaded,
    plan: &Plan,
    whole: Window,
) -> Result<Option<Gathered>> {
    let Kind::Picture(format) = job.work.output.kind()? else {
        return Ok(None);
    };
    if job.work.output.output.is_none() {
        return Ok(None);
    }
    let outcome = run(work, plan, &sample.frame)?;
    let size = [whole.width(), whole.height()];
    let shown = work.shown(sample, &outcome);
    let gathered = shown.with(job, sample, None, |like, _| {
        Gathered::new(format, size, like)
    });
    Ok(Some(gathered))
}

/// Settings left open that are chosen from the whole picture.
fn choose<W: StripWork>(source: &Source<W>, job: &Job, plan: &Plan) -> Result<StripChoice> {
    let Some(mut search) = StripSearch::new(plan, source.whole) else {
        return Ok(StripChoice::default());
    };
    let count = source.strips.count();
    let bar = strips_bar(&job.work.run, "looking", StripSearch::USUAL_LOOKS * count);
    for look in 1.. {
        if look > StripSearch::USUAL_LOOKS {
            bar.inc_length(count as u64);
        }
        for (takes, rows) in source.strips.each() {
            let (loaded, plan) = source.load(takes)?;
            let runner = source.work.runner();
            source.timed("look", || search.look(runner, &plan, &loaded.frame, rows))?;
            bar.inc(1);
        }
        if !search.next_look() {
            break;
        }
    }
    bar.finish_and_clear();
    Ok(search.found())
}

/// Makes the strips and writes them to a part of an EXR that is like `sample`, or as numbers, with the channels it has.
fn write_part<W: StripWork>(
    source: &Source<W>,
    job: &Job,
    output: ReadyOutput,
    (sample, channels): (&Loaded, &[OutputChannel]),
    recipe: String,
) -> Result<()> {
    let args = &job.work.output;
    let attributes = attributes(&job.work, sample, recipe);
    let part = args.part(sample, source.whole, channels, attributes);
    let warnings = args.write_part(output, sample, &part, |next| {
        each_made(source, job, |(strip, outcome), rows| {
            let channels = args.picked(source.work.channels(job, strip, outcome))?;
            let planes: Vec<&Plane> = channels.iter().map(|c| c.plane).collect();
            job.check_channels(&strip.frame, &channels)?;
            next(&planes, rows, &mut || ())
        })
    })?;
    warnings.iter().for_each(|warning| job.warn(warning));
    Ok(())
}

/// Makes the strips, gathers what a display is shown of them, and writes it.
fn write_gathered<W: StripWork>(
    source: &Source<W>,
    job: &Job,
    ReadyOutput { path, replace }: ReadyOutput,
    (mut gathered, encoding): (Gathered, &Encoding),
    exposure: Option<f32>,
) -> Result<Whites> {
    let mut whites = Whites::default();
    each_made(source, job, |(strip, outcome), rows| {
        let shown = source.work.shown(strip, outcome);
        let counted = shown.with(job, strip, exposure, |picture, before| {
            job.check_picture(&strip.frame, picture)?;
            gathered.push(picture, rows.clone());
            Ok(match shown {
                Shown::Made(_) => job.whites((picture, before), &strip.frame.mask, rows),
                Shown::Display(_) => Whites::default(),
            })
        })?;
        whites = whites.with(counted);
        Ok(())
    })?;
    source.files.release();
    source.timed("write", || {
        write_atomically(path, replace, |w| gathered.write(w, path, encoding))
    })?;
    Ok(whites)
}

/// Makes every strip, from top to bottom, and hands it, its result and the rows that count to `take`.
fn each_made<W: StripWork>(
    source: &Source<W>,
    job: &Job,
    mut take: impl FnMut((&Loaded, &Outcome), Range<usize>) -> Result<()>,
) -> Result<()> {
    let bar = strips_bar(&job.work.run, "writing", source.strips.count());
    for (takes, rows) in source.strips.each() {
        let (loaded, plan) = source.load(takes)?;
        let outcome = run(source.work, &plan, &loaded.frame)?;
        let covered = |y| loaded.frame.mask.row(y).iter().filter(|&&c| c).count();
        let covered: usize = rows.clone().map(covered).sum();
        {
            let mut timings = source.timings.borrow_mut();
            timings.covered += covered;
            timings.add_all(&outcome);
        }
        source.timed("write", || take((&loaded, &outcome), rows))?;
        source.work.runner().recycle(outcome);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(())
}
