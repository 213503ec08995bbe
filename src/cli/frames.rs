//! A command on one frame or on a sequence: several frames at a time, each output written atomically.

use super::exit;
use super::files;
use super::job::Job;
use super::message;
use super::panics::caught;
use super::progress::{Progress, Status};
use super::run_log::RunLog;
use super::stop::{self, First};
use super::threads::{Lanes, on_threads};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::error_line::line_of;
use crate::command::flags::Flag;
use crate::command::invocation::Invocation;
use crate::command::recipe::{RecipeText, SAMPLE_FRAMES};
use crate::command::sequence::MissingArg;
use crate::error::Result;
use crate::io::output::{Files, is_whole, write_text};
use clap::FromArgMatches;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A command that makes one output of each frame.
pub(super) trait FrameCommand: FromArgMatches + Send + Sync {
    /// Inputs shared by all frames: lights, textures, memory.
    type Kit: Sync;

    fn work(&self) -> &WorkArgs;

    fn work_mut(&mut self) -> &mut WorkArgs;

    /// The command with what follows from its arguments.
    fn settled(self) -> Self {
        self
    }

    /// Files that only this command reads, of one frame of a sequence.
    fn files(&self, frame: Option<i32>) -> Vec<PathBuf>;

    /// A folder whose files are all inputs.
    fn folder(&self) -> Option<&Path> {
        None
    }

    /// Whether a frame depends on the ones before it.
    fn follows_on(&self) -> bool {
        false
    }

    /// Refuses invalid arguments, single or in combination.
    fn validate(&self) -> Result<()>;

    /// Prepares the inputs shared by all frames.
    fn prepare(&self) -> Result<Self::Kit>;

    /// Makes the output of one frame; returns the parameters chosen for it.
    fn make(&self, kit: &Self::Kit, job: &Job) -> Result<Chosen>;
}

/// Makes one picture by a command, with its record for the recipe.
pub(super) type One<C> = fn(&C, &RecipeText, &Invocation) -> Result<()>;

/// Runs the command on the files its arguments name, on a single picture by `one`; returns the exit code.
///
/// # Errors
/// Any [`crate::Error`] of a single picture, and errors before a sequence is begun.
pub(super) fn run<C: FrameCommand>(invocation: &Invocation, one: One<C>) -> Result<i32> {
    let (command, recipe) = command_of::<C>(invocation);
    let (threads, input) = (
        command.work().run.compute.threads,
        command.work().input.clone(),
    );
    on_threads(threads, || {
        caught(&input, || match command.work().frames()? {
            None => {
                stop::mind_signals(First::Drop);
                one(&command, &recipe, invocation).map(|()| exit::DONE)
            }
            Some(frames) => {
                let frames = frames.to_vec();
                sequence(command, recipe, invocation, &frames)
            }
        })
    })
}

/// The command as parsed before, and its settings.
pub(super) fn command_of<C: FrameCommand>(invocation: &Invocation) -> (C, RecipeText) {
    let parsed = invocation.parse();
    let matches = parsed.map(|parsed| parsed.matches);
    let matches = matches.unwrap_or_else(|error| error.exit());
    let (_, own) = matches.subcommand().expect("a command was parsed");
    let command = C::from_arg_matches(own).unwrap_or_else(|error| error.exit());
    let command = command.settled();
    (command, RecipeText::of(&matches, invocation.kept()))
}

/// Makes one picture.
pub(super) fn one<C: FrameCommand>(
    command: &C,
    recipe: &RecipeText,
    invocation: &Invocation,
) -> Result<()> {
    begin(command, invocation)?;
    let work = command.work();
    let kit = command.prepare()?;
    let log = RunLog::default();
    let job = Job::new(work.clone(), &log, recipe);
    let chosen = command.make(&kit, &job)?;
    save_recipe(work, &recipe.with(&chosen))
}

/// Refuses bad arguments of a picture, and clears its folder of leftovers.
pub(super) fn begin<C: FrameCommand>(command: &C, invocation: &Invocation) -> Result<()> {
    let work = command.work();
    check(command, invocation.recipe(), &[None], work)?;
    files::sweep(work, &mut BTreeSet::new());
    Ok(())
}

/// Refuses invalid arguments of `command`.
pub(super) fn validate<C: FrameCommand>(command: &C) -> Result<()> {
    command.work().flags.validate()?;
    command.work().output.refuse_idle()?;
    command.validate()
}

/// Refuses bad arguments before any input is read.
fn check<C: FrameCommand>(
    command: &C,
    recipe: Option<&Path>,
    frames: &[Option<i32>],
    first: &WorkArgs,
) -> Result<()> {
    validate(command)?;
    let frames = frames.iter().map(|&frame| (command, frame));
    refuse_collisions(frames, recipe)?;
    files::check_outputs(first)
}

/// Checks all pictures at once, each by its command and, in a sequence, its number: no output may be an input of any,
/// `recipe` included, or another output.
///
/// # Errors
/// [`Error::BadParameter`] naming the first output that is.
pub(super) fn refuse_collisions<'a, C: FrameCommand + 'a>(
    pictures: impl Iterator<Item = (&'a C, Option<i32>)>,
    recipe: Option<&Path>,
) -> Result<()> {
    let mut known = Files::default();
    recipe.into_iter().for_each(|path| known.reads(path));
    let mut works = Vec::new();
    for (command, frame) in pictures {
        let folder = command.folder();
        folder.into_iter().for_each(|path| known.reads_all_in(path));
        let work = match frame {
            Some(number) => command.work().of_frame(number),
            None => command.work().clone(),
        };
        if work.input.is_dir() {
            known.reads_all_in(&work.input);
        }
        let of_command = command.files(frame);
        for path in work.roles.files(&work.input).iter().chain(&of_command) {
            known.reads(path);
        }
        works.push(work);
    }
    for work in &works {
        for (name, path) in files::outputs_of_frame(work) {
            known.writes(name, &path)?;
        }
    }
    let mut recipes: Vec<_> = works
        .iter()
        .filter_map(|w| w.run.save_recipe.as_ref())
        .collect();
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

fn sequence<C: FrameCommand>(
    command: C,
    recipe: RecipeText,
    invocation: &Invocation,
    frames: &[i32],
) -> Result<i32> {
    stop::mind_signals(First::Finish);
    let quiet = command.work().run.quiet;
    let all: Vec<_> = frames.iter().copied().map(Some).collect();
    let first = command.work().of_frame(frames[0]);
    check(&command, invocation.recipe(), &all, &first)?;
    let mut swept = BTreeSet::new();
    files::sweep(&first, &mut swept);
    let kit = command.prepare()?;
    let samples = command.work().sequence.samples(frames);
    let chosen = choose(&command, &kit, &recipe, &samples)?;
    if !quiet && chosen != Chosen::default() {
        message::say(&format!("for all frames: {}", chosen.in_words()));
    }
    // The chosen parameters replace the flags, so no frame chooses again.
    let mut flags = chosen.flags();
    if !samples.is_empty() {
        flags.push(Flag::new(SAMPLE_FRAMES, "none"));
    }
    let (command, _) = command_of::<C>(&invocation.with(&flags));
    let recipe = recipe.choosing(flags);
    save_recipe(command.work(), &recipe.with(&Chosen::default()))?;
    if let Some(code) = stop::asked() {
        return Ok(code);
    }
    if command.work().output.output.is_none() {
        return Ok(exit::DONE);
    }
    drop(kit);
    let kit = command.prepare()?;
    let progress = Progress::begin(command.work().run.progress, quiet, frames.len());
    let log = RunLog::of_sequence(progress);
    let run = Sequence {
        command: &command,
        kit: &kit,
        recipe: &recipe,
        log: &log,
        frames,
        next: AtomicUsize::new(0),
        failed: AtomicBool::new(false),
        making: making(command.work(), frames),
        swept: Mutex::new(swept),
    };
    let work = command.work();
    let in_memory = work.run.max_memory.bytes() / work.frame_bytes(&first.input).max(1);
    let free_to_use_more = work.run.compute.threads.is_none();
    Lanes::of(frames.len(), in_memory, free_to_use_more).each(|| run.make_frames());
    let failed = run.failed.load(Ordering::Relaxed);
    let tally = log.end(quiet);
    Ok(match stop::asked() {
        Some(code) => code,
        None if !failed => exit::DONE,
        None if command.work().sequence.keep_going && tally.done + tally.skipped > 0 => {
            exit::SOME_FAILED
        }
        None => exit::FAILED,
    })
}

/// Parameters for all frames, chosen from `samples`; unreadable samples are ignored.
///
/// # Errors
/// That of the first sample if none can be read.
fn choose<C: FrameCommand>(
    command: &C,
    kit: &C::Kit,
    recipe: &RecipeText,
    samples: &[i32],
) -> Result<Chosen> {
    let log = RunLog::default();
    let mut each = Vec::new();
    let mut first_error = None;
    for &frame in samples {
        if stop::asked().is_some() {
            break;
        }
        let work = command.work().of_frame(frame);
        let job = Job::to_choose(work, frame, &log, recipe);
        match caught(&job.work.input, || command.make(kit, &job)) {
            Ok(chosen) => each.push(chosen),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    match first_error {
        Some(error) if each.is_empty() => Err(error),
        _ => Ok(Chosen::for_all(&each)),
    }
}

/// The frames that have to be made.
struct Making {
    /// By frame: whether the output exists and is complete.
    is_there: Vec<bool>,
    /// From this frame on all outputs exist, so none needs the frames before.
    last_needed: usize,
}

fn making(work: &WorkArgs, frames: &[i32]) -> Making {
    let there = |&frame: &i32| {
        let work = work.of_frame(frame);
        let files = work.output.files();
        let are_there = !files.is_empty() && files.iter().all(|path| is_whole(path));
        work.sequence.skip_existing && are_there
    };
    let is_there: Vec<bool> = frames.iter().map(there).collect();
    let last_needed = is_there.iter().rposition(|there| !there);
    Making {
        last_needed: last_needed.map_or(0, |last| last + 1),
        is_there,
    }
}

/// A sequence that is being made.
struct Sequence<'a, C: FrameCommand> {
    command: &'a C,
    kit: &'a C::Kit,
    recipe: &'a RecipeText,
    log: &'a RunLog,
    frames: &'a [i32],
    next: AtomicUsize,
    failed: AtomicBool,
    making: Making,
    /// Directories without leftovers of killed runs.
    swept: Mutex<BTreeSet<PathBuf>>,
}

impl<C: FrameCommand> Sequence<'_, C> {
    /// Makes frames, one after another, until none is left or the run is to stop.
    fn make_frames(&self) {
        loop {
            let failed = self.failed.load(Ordering::Relaxed);
            let goes_on = !failed || self.command.work().sequence.keep_going;
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
        let work = self.command.work().of_frame(frame);
        let output = work.output.output.clone().unwrap_or_default();
        let input = work.input.clone();
        let (status, what) = match caught(&input, || self.made(index, frame, work)) {
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

    fn made(&self, index: usize, frame: i32, work: WorkArgs) -> Result<Status> {
        let is_there = self.making.is_there[index];
        let is_needed = self.command.follows_on() && index < self.making.last_needed;
        if is_there && !is_needed {
            return Ok(Status::Skipped);
        }
        if work.sequence.missing_frame == MissingArg::Skip && !work.input.exists() {
            return Ok(Status::Missing);
        }
        if is_there {
            let job = Job::in_sequence(work, frame, index, self.log, self.recipe);
            self.command.make(self.kit, &job.without_output())?;
            return Ok(Status::Skipped);
        }
        files::check_outputs(&work)?;
        files::sweep(
            &work,
            &mut self.swept.lock().unwrap_or_else(PoisonError::into_inner),
        );
        let job = Job::in_sequence(work, frame, index, self.log, self.recipe);
        self.command.make(self.kit, &job)?;
        Ok(Status::Done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use clap::ArgMatches;

    /// A command that makes an empty file for each frame, but panics on the second.
    struct Faulty(WorkArgs);

    impl FromArgMatches for Faulty {
        fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
            WorkArgs::from_arg_matches(matches).map(Self)
        }

        fn update_from_arg_matches(
            &mut self,
            matches: &ArgMatches,
        ) -> std::result::Result<(), clap::Error> {
            self.0.update_from_arg_matches(matches)
        }
    }

    impl FrameCommand for Faulty {
        type Kit = ();

        fn work(&self) -> &WorkArgs {
            &self.0
        }

        fn work_mut(&mut self) -> &mut WorkArgs {
            &mut self.0
        }

        fn files(&self, _: Option<i32>) -> Vec<PathBuf> {
            Vec::new()
        }

        fn validate(&self) -> Result<()> {
            Ok(())
        }

        fn prepare(&self) -> Result<()> {
            Ok(())
        }

        fn make(&self, (): &(), job: &Job) -> Result<Chosen> {
            job.in_turn(|| assert_ne!(job.frame, Some(2), "frame 2 is not to my liking"));
            let output = job.work.output.output.as_deref().expect("it was given");
            std::fs::write(output, "made").map_err(Error::io(output, "write"))?;
            Ok(Chosen::default())
        }
    }

    #[test]
    fn a_panic_is_the_failure_of_its_frame_alone() {
        let desk = tempfile::tempdir().unwrap();
        let name = |name: &str| desk.path().join(name).into_os_string();
        let words = |rest: &[&str]| {
            let start = ["relievo", "shape"].map(Into::into);
            let files = [name("in.#.exr"), "-o".into(), name("out.#.png")];
            let rest = rest.iter().map(Into::into);
            Invocation::of(start.into_iter().chain(files).chain(rest))
        };
        let frames = ["--frames", "1-4", "--keep-going", "-q"];
        let code = run::<Faulty>(&words(&frames), one).unwrap();
        assert_eq!(code, 3);
        let is_made = |frame: i32| desk.path().join(format!("out.{frame}.png")).exists();
        assert_eq!([1, 2, 3, 4].map(is_made), [true, false, true, true]);
        // As a sample frame it is ignored, unless it is the only one.
        let sampled = ["--frames", "1,3", "--sample-frames", "2", "-q"];
        let failed = run::<Faulty>(&words(&sampled), one)
            .unwrap_err()
            .to_string();
        assert!(failed.contains("frame 2 is not to my liking"), "{failed}");
    }
}
