//! A command on one frame or on a sequence: several frames at a time, each output written atomically.

use super::exit;
use super::files;
use super::job::Job;
use super::kit::Kit;
use super::make::make;
use super::message;
use super::panics::caught;
use super::progress::{SequenceProgress, Status};
use super::run_log::RunLog;
use super::stop::{self, First};
use super::threads::{FrameThreads, on_threads};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::commands::Command;
use crate::command::error_line::line_of;
use crate::command::flags::Flag;
use crate::command::invocation::Task;
use crate::command::recipe::SAMPLE_FRAMES;
use crate::command::sequence::MissingArg;
use crate::error::Result;
use crate::io::output::{Files, is_whole, write_text};
use crate::work::FrameWork;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Makes the output of one frame; returns the parameters chosen for it.
pub(super) type Make = fn(&Kit, &Job) -> Result<Chosen>;

/// Runs the command on the files its arguments name, on a single picture by `one`, on each frame of a sequence by `make`;
/// returns the exit code.
///
/// # Errors
/// Any [`crate::Error`] of a single picture, and errors before a sequence is begun.
pub(super) fn run(task: &Task, one: fn(&Task) -> Result<()>, make: Make) -> Result<i32> {
    let args = task.command.work().args();
    on_threads(args.run.compute.threads, || {
        caught(&args.input, || match args.frames()? {
            None => {
                stop::mind_signals(First::Drop);
                one(task).map(|()| exit::DONE)
            }
            Some(frames) => sequence(task, frames, make),
        })
    })
}

/// Makes one picture.
pub(super) fn one(task: &Task) -> Result<()> {
    begin(task)?;
    let work = task.command.work();
    let (kit, log) = (Kit::of(work)?, RunLog::default());
    let job = Job::of(task, &log, None);
    let chosen = make(&kit, &job)?;
    save_recipe(work.args(), &task.recipe.with(&chosen))
}

/// Refuses bad arguments of a picture, and clears its folder of leftovers.
pub(super) fn begin(task: &Task) -> Result<()> {
    let args = task.command.work().args();
    check(task, &[None], args)?;
    files::sweep(args, &mut BTreeSet::new());
    Ok(())
}

/// Refuses invalid arguments of a command.
pub(super) fn validate(work: &dyn FrameWork) -> Result<()> {
    work.args().flags.validate()?;
    let args = work.args();
    args.output.refuse_idle(&args.flags.params)?;
    work.check()
}

/// The task with what was `chosen` for all parts of a picture or a sequence, so that none of them chooses again; its recipe
/// is saved.
pub(super) fn settled(
    task: &Task,
    parts: &str,
    chosen: &Chosen,
    more: Option<Flag>,
) -> Result<Task> {
    let (from, words) = (task.command.work().args(), chosen.in_words());
    if !from.run.quiet && !words.is_empty() {
        message::say(&format!("for all {parts}: {words}"));
    }
    let flags: Vec<_> = chosen.flags().into_iter().chain(more).collect();
    let mut settled = task.with(&flags);
    settled.recipe = task.recipe.clone().choosing(flags);
    let to = settled.command.work_mut().args_mut();
    to.input = from.input.clone();
    to.more = from.more.clone();
    to.output = from.output.clone();
    save_recipe(to, &settled.recipe.with(&Chosen::default()))?;
    Ok(settled)
}

/// Refuses bad arguments before any input is read.
fn check(task: &Task, frames: &[Option<i32>], first: &WorkArgs) -> Result<()> {
    validate(task.command.work())?;
    let frames = frames.iter().map(|&frame| task.command.of_frame(frame));
    refuse_collisions(frames, task.typed.recipe())?;
    files::check_outputs(first)
}

/// Checks all pictures at once, each by its command: no output may be an input of any, `recipe` included, or another output.
///
/// # Errors
/// [`Error::BadParameter`] naming the first output that is.
pub(super) fn refuse_collisions(
    pictures: impl Iterator<Item = Command>,
    recipe: Option<&Path>,
) -> Result<()> {
    let mut known = Files::default();
    recipe.into_iter().for_each(|path| known.reads(path));
    let pictures: Vec<_> = pictures.collect();
    for command in &pictures {
        let work = command.work();
        let input = Some(&*work.args().input).filter(|input| input.is_dir());
        let folders = work.folder().into_iter().chain(input);
        folders.for_each(|path| known.reads_all_in(path));
        let files = command.files();
        files.iter().for_each(|path| known.reads(path));
    }
    let all = || pictures.iter().map(|command| command.work().args());
    for (name, path) in all().flat_map(files::outputs_of_frame) {
        known.writes(name, &path)?;
    }
    let mut recipes: Vec<_> = all().filter_map(|a| a.run.save_recipe.as_ref()).collect();
    // All frames of a sequence share one.
    recipes.dedup();
    let mut recipes = recipes.into_iter();
    recipes.try_for_each(|path| known.writes("--save-recipe", path))
}

pub(super) fn save_recipe(work: &WorkArgs, text: &str) -> Result<()> {
    match &work.run.save_recipe {
        Some(path) => write_text(path, work.output.replace_beside(), text),
        None => Ok(()),
    }
}

fn sequence(task: &Task, frames: &[i32], make: Make) -> Result<i32> {
    stop::mind_signals(First::Finish);
    let all: Vec<_> = frames.iter().copied().map(Some).collect();
    let first = task.command.of_frame(Some(frames[0]));
    let first = first.work().args();
    check(task, &all, first)?;
    let mut swept = BTreeSet::new();
    files::sweep(first, &mut swept);
    let samples = task.command.work().args().sequence.samples(frames);
    let chosen = choose(task, &samples, make)?;
    let none = (!samples.is_empty()).then(|| Flag::new(SAMPLE_FRAMES, "none"));
    let task = settled(task, "frames", &chosen, none)?;
    if let Some(code) = stop::asked() {
        return Ok(code);
    }
    let args = task.command.work().args();
    if args.output.output.is_none() {
        return Ok(exit::DONE);
    }
    let quiet = args.run.quiet;
    let kit = Kit::of(task.command.work())?;
    let progress = SequenceProgress::begin(args.run.progress, quiet, frames.len());
    let log = RunLog::of_sequence(progress);
    let run = Sequence {
        task: &task,
        kit: &kit,
        make,
        log: &log,
        frames,
        next: AtomicUsize::new(0),
        failed: AtomicBool::new(false),
        making: making(&task.command, frames),
        swept: Mutex::new(swept),
    };
    let in_memory = args.run.max_memory.bytes() / args.frame_bytes(&first.input).max(1);
    let free_to_use_more = args.run.compute.threads.is_none();
    FrameThreads::of(frames.len(), in_memory, free_to_use_more).each(|| run.make_frames());
    let failed = run.failed.load(Ordering::Relaxed);
    let tally = log.end(quiet);
    Ok(match stop::asked() {
        Some(code) => code,
        None if !failed => exit::DONE,
        None if args.sequence.keep_going && tally.done + tally.skipped > 0 => exit::SOME_FAILED,
        None => exit::FAILED,
    })
}

/// Parameters for all frames, chosen from `samples`; unreadable samples are ignored.
///
/// # Errors
/// That of the first sample if none can be read.
fn choose(task: &Task, samples: &[i32], make: Make) -> Result<Chosen> {
    let (log, kit) = (RunLog::default(), Kit::of(task.command.work())?);
    let samples = samples.iter().take_while(|_| stop::asked().is_none());
    Chosen::for_all(samples.map(|&frame| {
        let job = Job::of(task, &log, Some(frame));
        caught(&job.args().input, || make(&kit, &job))
    }))
}

/// The frames that have to be made.
struct FramesToMake {
    /// By frame: whether the output exists and is complete.
    is_there: Vec<bool>,
    /// From this frame on all outputs exist, so none needs the frames before.
    last_needed: usize,
}

fn making(command: &Command, frames: &[i32]) -> FramesToMake {
    let there = |&frame: &i32| {
        let command = command.of_frame(Some(frame));
        let args = command.work().args();
        let files = args.output.files();
        let are_there = !files.is_empty() && files.iter().all(|path| is_whole(path));
        args.sequence.skip_existing && are_there
    };
    let is_there: Vec<bool> = frames.iter().map(there).collect();
    let last_needed = is_there.iter().rposition(|there| !there);
    FramesToMake {
        last_needed: last_needed.map_or(0, |last| last + 1),
        is_there,
    }
}

/// A sequence that is being made.
struct Sequence<'a> {
    task: &'a Task,
    kit: &'a Kit,
    make: Make,
    log: &'a RunLog,
    frames: &'a [i32],
    next: AtomicUsize,
    failed: AtomicBool,
    making: FramesToMake,
    /// Directories without leftovers of killed runs.
    swept: Mutex<BTreeSet<PathBuf>>,
}

impl Sequence<'_> {
    /// Makes frames, one after another, until none is left or the run is to stop.
    fn make_frames(&self) {
        loop {
            let failed = self.failed.load(Ordering::Relaxed);
            let sequence = &self.task.command.work().args().sequence;
            let goes_on = !failed || sequence.keep_going;
            if !goes_on || stop::asked().is_some() {
                return;
            }
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(&frame) = self.frames.get(index) else {
                return;
            };
            self.make_frame(index, frame);
            self.log.turns.leave(index);
        }
    }

    fn make_frame(&self, index: usize, frame: i32) {
        let started = Instant::now();
        let job = Job {
            index: Some(index),
            writes: !self.making.is_there[index],
            ..Job::of(self.task, self.log, Some(frame))
        };
        let args = job.args();
        let output = args.output.output.clone().unwrap_or_default();
        let (status, what) = match caught(&args.input, || self.made(&job, index)) {
            Ok(status) => (status, output.display().to_string()),
            Err(error) => {
                self.failed.store(true, Ordering::Relaxed);
                let line = line_of(&error);
                self.log.say(&format!("error: {line}"));
                (Status::Failed, line)
            }
        };
        self.log.frame(frame, status, started.elapsed(), what);
    }

    fn made(&self, job: &Job, index: usize) -> Result<Status> {
        let (work, args) = (job.work(), job.args());
        let is_needed = work.motion().is_some() && index < self.making.last_needed;
        if !job.writes && !is_needed {
            return Ok(Status::Skipped);
        }
        if args.sequence.missing_frame == MissingArg::Skip && !args.input.exists() {
            return Ok(Status::Missing);
        }
        if job.writes {
            files::check_outputs(args)?;
            let mut swept = self.swept.lock().unwrap_or_else(PoisonError::into_inner);
            files::sweep(args, &mut swept);
        }
        (self.make)(self.kit, job)?;
        Ok(match job.writes {
            true => Status::Done,
            false => Status::Skipped,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::invocation::Invocation;
    use crate::error::Error;

    /// Makes an empty file for each frame, but panics on the second.
    fn faulty(_: &Kit, job: &Job) -> Result<Chosen> {
        job.in_turn(|| assert_ne!(job.frame, Some(2), "frame 2 is not to my liking"));
        let output = job.args().output.output.as_deref().expect("it was given");
        std::fs::write(output, "made").map_err(Error::io(output, "write"))?;
        Ok(Chosen::default())
    }

    #[test]
    fn a_panic_is_the_failure_of_its_frame_alone() {
        let desk = tempfile::tempdir().unwrap();
        let name = |name: &str| desk.path().join(name).into_os_string();
        let words = |rest: &[&str]| {
            let start = ["relievo", "shape"].map(Into::into);
            let files = [name("in.#.exr"), "-o".into(), name("out.#.png")];
            let rest = rest.iter().map(Into::into);
            let typed = Invocation::of(start.into_iter().chain(files).chain(rest));
            typed.parse().unwrap()
        };
        let frames = ["--frames", "1-4", "--keep-going", "-q"];
        let code = run(&words(&frames), one, faulty).unwrap();
        assert_eq!(code, 3);
        let is_made = |frame: i32| desk.path().join(format!("out.{frame}.png")).exists();
        assert_eq!([1, 2, 3, 4].map(is_made), [true, false, true, true]);
        // As a sample frame it is ignored, unless it is the only one.
        let sampled = ["--frames", "1,3", "--sample-frames", "2", "-q"];
        let failed = run(&words(&sampled), one, faulty).unwrap_err().to_string();
        assert!(failed.contains("frame 2 is not to my liking"), "{failed}");
    }
}
