//! Pictures that do not fit in memory: read, processed and written strip by strip.

use super::job::Job;
use super::kit::Kit;
use super::output::ReadyOutput;
use super::progress::strips_bar;
use super::strip_memory::{FEWEST_ROWS, StripMemory, strips_of, whole_bytes};
use super::timings::FrameTimings;
use crate::command::chosen::Chosen;
use crate::engine;
use crate::engine::strip_search::{Choices, StripSearch};
use crate::engine::tiles::Strips;
use crate::error::Result;
use crate::frame::{CONFIDENCE_REACH, Frame, HOLE_REACH, Plane, Window};
use crate::io::inputs::Inputs;
use crate::io::output::OutputKind;
use crate::io::output::picture::MadePicture;
use crate::io::output::write_atomically;
use crate::io::picture::{Brightness, Encoding, Gathered, Whites};
use crate::io::{Holding, InputFiles, Loaded, Needs, program_bytes};
use crate::plan::Plan;
use crate::plan::outcome::Outcome;
use crate::work::source::FrameSource;
use crate::work::{FrameSeen, FrameWork};
use indicatif::ProgressBar;
use std::cell::RefCell;
use std::ops::Range;
use std::time::Instant;

/// A picture of which strips are read.
struct StripSource<'a> {
    files: InputFiles,
    inputs: Inputs,
    needs: Needs,
    whole: Window,
    strips: Strips,
    kit: &'a Kit,
    work: &'a dyn FrameWork,
    choices: Choices,
    timings: RefCell<FrameTimings>,
}

impl StripSource<'_> {
    /// These rows of the picture, and their plan.
    fn load(&self, takes: Range<usize>) -> Result<(Loaded, Plan)> {
        let inputs = Inputs {
            rows: Some(takes),
            ..self.inputs.clone()
        };
        let loaded = self.timed("read", || self.files.load(&inputs, self.needs))?;
        let plan = plan(self.work, self.kit, &loaded, &self.choices)?;
        Ok((loaded, plan))
    }

    /// Reads every strip, from top to bottom, and hands it, its plan and the rows that count to `take`.
    fn each(
        &self,
        bar: &ProgressBar,
        mut take: impl FnMut(&Loaded, &Plan, Range<usize>) -> Result<()>,
    ) -> Result<()> {
        for (takes, rows) in self.strips.each() {
            let (loaded, plan) = self.load(takes)?;
            take(&loaded, &plan, rows)?;
            bar.inc(1);
        }
        Ok(())
    }

    fn timed<T>(&self, name: &'static str, stage: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = stage();
        self.timings.borrow_mut().add(name, start.elapsed());
        done
    }
}

/// Makes the picture of `job` in strips: bit for bit what it would be as a whole.
pub(super) fn make(kit: &Kit, job: &Job, source: FrameSource) -> Result<Chosen> {
    let work = job.work();
    let FrameSource {
        mut inputs, needs, ..
    } = source;
    let holding = Holding {
        stay: true,
        ..Holding::default()
    };
    let files = InputFiles::open(&inputs, holding)?;
    let extent = files.extent(&inputs, needs)?;
    let (whole, photo_bytes) = (extent.window, extent.photo_bytes);
    let args = job.args();
    let mut sample = middle(job, &files, &mut inputs, needs)?;
    sample.settle(&mut inputs);
    inputs.known_camera = sample.known_camera();
    // Strips do not look again for a camera that the middle of the picture does not show.
    let needs = Needs {
        projection: needs.projection && sample.frame.camera.is_some(),
        ..needs
    };
    let first = plan(work, kit, &sample, &Choices::default())?;
    if first.takes_whole() {
        let why = "casts shadows over the whole picture, which --shadows off and --sky-shadows off leave out";
        return Err(args.too_large(&args.input, why, program_bytes() + whole_bytes(job)));
    }
    job.tell_plan(&first);
    let warnings = work.warnings_on(&sample.frame);
    warnings.iter().for_each(|text| job.warn(text));
    let read = Chosen::of_reading(&sample);
    // Its planes are not needed any more: one pixel tells what a strip gives.
    let corner = sample.frame.data_window;
    let pixel = Window::at(corner.x0, corner.y0, 1, 1);
    sample.frame = sample.frame.crop(pixel);
    let gathered = gathered(kit, job, &sample, &first, whole)?;
    let cost = StripMemory::new(job, whole.height(), photo_bytes, gathered.as_ref());
    let mut source = StripSource {
        files,
        inputs,
        needs,
        whole,
        strips: strips_of(job, cost, first.reach() + HOLE_REACH + CONFIDENCE_REACH)?,
        kit,
        work,
        choices: Choices::default(),
        timings: RefCell::new(FrameTimings::of_window(whole)),
    };
    source.choices = choose(&source, job, &first)?;
    let settled = plan(work, kit, &sample, &source.choices)?;
    let outcome = run(work, kit, &settled, &sample.frame)?;
    job.note_gain(&first, outcome.gain);
    let chosen = read.running(&outcome);
    let picture = work.picture(&sample.frame, &outcome);
    let exposure = match picture.as_ref().filter(|_| gathered.is_some()) {
        Some(made) => exposure(&source, job, made)?,
        None => None,
    };
    let chosen = chosen.exposed(exposure);
    let whites = job.write_output(&chosen, |output| {
        let whites = match gathered {
            Some(gathered) => {
                let settings = job.recipe(&chosen);
                let encoding = args
                    .output
                    .encoding(&sample, settings, &args.flags.params)?;
                write_gathered(&source, job, output, (gathered, &encoding), exposure)?
            }
            None => {
                let channels = work.channels(&sample, &outcome, picture.as_ref());
                let channels = args.output.picked(channels)?;
                job.write_part(output, (&sample, whole), &channels, &chosen, |next| {
                    each_made(&source, job, |(strip, outcome), rows| {
                        let picture = work.picture(&strip.frame, outcome);
                        let channels = work.channels(strip, outcome, picture.as_ref());
                        let channels = args.output.picked(channels)?;
                        let planes: Vec<&Plane> = channels.iter().map(|c| c.plane).collect();
                        job.check_channels(&strip.frame, &channels)?;
                        next(&planes, rows, &mut || ())
                    })
                })?;
                Whites::default()
            }
        };
        job.write_timings(&source.timings.borrow())?;
        Ok(whites)
    })?;
    job.explain(&source.timings.borrow(), &chosen, whites)?;
    Ok(chosen)
}

/// Stops that suit new light, of which `sample` is a part, where they are left open: all strips are lit for them.
fn exposure(source: &StripSource, job: &Job, sample: &MadePicture) -> Result<Option<f32>> {
    if !sample.leaves_exposure(&job.args().flags.params.display) {
        return Ok(None);
    }
    let mut brightness = Brightness::default();
    let bar = strips_bar(&job.args().run, "looking", source.strips.count());
    source.each(&bar, |strip, plan, rows| {
        let outcome = source.timed("look", || run(source.work, source.kit, plan, &strip.frame))?;
        if let Some(made) = source.work.picture(&strip.frame, &outcome) {
            brightness.add(&made.color, made.like, &strip.frame.mask, rows);
        }
        source.kit.engine.recycle(outcome);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(Some(brightness.exposure()))
}

/// The plan for a picture or a strip of it, with what was found in the whole.
fn plan(work: &dyn FrameWork, kit: &Kit, strip: &Loaded, choices: &Choices) -> Result<Plan> {
    let plans = work.plans(&mut FrameSeen::new(&strip.frame, &kit.light))?;
    let mut plan = plans.into_iter().next().expect("one plan makes a picture");
    choices.settle(&mut plan);
    Ok(plan)
}

/// The result of a strip.
fn run(work: &dyn FrameWork, kit: &Kit, plan: &Plan, strip: &Frame) -> Result<Outcome> {
    let runner = kit.engine.cpu_runner();
    let mut outcome = runner.execute(plan, strip, engine::PlanInputs::lit_by(&kit.light))?;
    outcome.mix(strip, 1.0, &work.args().flags.params);
    Ok(outcome)
}

/// The middle of the picture, which tells how its layers are to be read: as many rows as fit.
fn middle(job: &Job, files: &InputFiles, inputs: &mut Inputs, needs: Needs) -> Result<Loaded> {
    let extent = files.extent(inputs, needs)?;
    let height = extent.window.height();
    let cost = StripMemory::new(job, height, extent.photo_bytes, None);
    let rows = cost.rows_allowed(job).max(FEWEST_ROWS).min(height);
    let first = (height - rows) / 2;
    inputs.rows = Some(first..first + rows);
    let most = job.args().run.max_memory.bytes();
    if cost.least(0) <= most {
        return Ok(job.load_from(files, inputs, needs)?.0);
    }
    // It will be refused; but what it takes is only known from its plan.
    let sparing = InputFiles::open(inputs, Holding::within(most))?;
    Ok(job.load_from(&sparing, inputs, needs)?.0)
}

/// Gathers the samples of a picture for a display; `None` for layers, and if nothing is written.
fn gathered(
    kit: &Kit,
    job: &Job,
    sample: &Loaded,
    plan: &Plan,
    whole: Window,
) -> Result<Option<Gathered>> {
    let output = &job.args().output;
    let (OutputKind::Picture(format), Some(_)) = (output.kind()?, &output.output) else {
        return Ok(None);
    };
    let outcome = run(job.work(), kit, plan, &sample.frame)?;
    let size = [whole.width(), whole.height()];
    let made = job.work().picture(&sample.frame, &outcome);
    let shown = made.map(|made| job.displayed(sample, made, None));
    Ok(shown.map(|like| Gathered::new(format, size, &like.picture())))
}

/// Settings left open that are chosen from the whole picture.
fn choose(source: &StripSource, job: &Job, plan: &Plan) -> Result<Choices> {
    let (runner, count) = (source.kit.engine.cpu_runner(), source.strips.count());
    let bar = strips_bar(&job.args().run, "looking", StripSearch::USUAL_LOOKS * count);
    let choices = StripSearch::choices(runner, plan, source.whole, |search| {
        let done = bar.position() + count as u64;
        bar.set_length(done.max(bar.length().unwrap_or(0)));
        source.each(&bar, |loaded, _, rows| {
            source.timed("look", || search.look(&loaded.frame, rows))
        })
    });
    bar.finish_and_clear();
    choices
}

/// Makes the strips, gathers what a display is shown of them, and writes it.
fn write_gathered(
    source: &StripSource,
    job: &Job,
    ReadyOutput { path, replace }: ReadyOutput,
    (mut gathered, encoding): (Gathered, &Encoding),
    exposure: Option<f32>,
) -> Result<Whites> {
    let mut whites = Whites::default();
    each_made(source, job, |(strip, outcome), rows| {
        let made = source.work.picture(&strip.frame, outcome);
        let shown = job.displayed(strip, made.expect("a picture is gathered"), exposure);
        let picture = shown.picture();
        job.check_picture(&strip.frame, &picture)?;
        gathered.push(&picture, rows.clone());
        whites = whites.with(job.whites(&shown, &strip.frame.mask, rows));
        Ok(())
    })?;
    source.files.release();
    source.timed("write", || {
        write_atomically(path, replace, |w| gathered.write(w, path, encoding))
    })?;
    Ok(whites)
}

/// Makes every strip, from top to bottom, and hands it, its result and the rows that count to `take`.
fn each_made(
    source: &StripSource,
    job: &Job,
    mut take: impl FnMut((&Loaded, &Outcome), Range<usize>) -> Result<()>,
) -> Result<()> {
    let bar = strips_bar(&job.args().run, "writing", source.strips.count());
    source.each(&bar, |loaded, plan, rows| {
        let outcome = run(source.work, source.kit, plan, &loaded.frame)?;
        let covered = |y| loaded.frame.mask.row(y).iter().filter(|&&c| c).count();
        let covered: usize = rows.clone().map(covered).sum();
        {
            let mut timings = source.timings.borrow_mut();
            timings.covered += covered;
            timings.add_all(&outcome);
        }
        source.timed("write", || take((loaded, &outcome), rows))?;
        source.kit.engine.recycle(outcome);
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(())
}
