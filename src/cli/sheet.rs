//! A command on a sheet of sprites: all cells are made by what is chosen once, over the sheet.

use super::cells::{Form, MadeCells, Sheet};
use super::frames::{self, FrameCommand, begin, command_of, save_recipe};
use super::job::{Done, Job};
use super::message;
use super::panics::caught;
use super::progress::cells_bar;
use super::run_log::RunLog;
use super::threads::Lanes;
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::grid::CellSize;
use crate::command::hatch::is_svg;
use crate::command::invocation::Invocation;
use crate::command::output::MadePicture;
use crate::command::recipe::RecipeText;
use crate::engine::outcome::Outcome;
use crate::error::{Error, Result};
use crate::frame::ColorPlanes;
use crate::io::exr::OutputChannel;
use crate::io::picture::Picture;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Makes one picture, as it is or cell by cell.
pub(super) fn one<C: FrameCommand>(
    command: &C,
    recipe: &RecipeText,
    invocation: &Invocation,
) -> Result<()> {
    match command.work().sequence.grid {
        Some(grid) => make(command, recipe, invocation, grid),
        None => frames::one(command, recipe, invocation),
    }
}

/// Makes a sheet.
fn make<C: FrameCommand>(
    command: &C,
    recipe: &RecipeText,
    invocation: &Invocation,
    grid: CellSize,
) -> Result<()> {
    begin(command, invocation)?;
    let work = command.work();
    if is_svg(work) {
        return Err(Error::BadParameter {
            name: "--grid",
            found: "makes a sheet of pixels, and an SVG holds lines".into(),
            remedy: "write a .png".into(),
        });
    }
    let sheet = Sheet::new(grid);
    let (log, started) = (RunLog::default(), Instant::now());
    let job =
        |recipe, work: &WorkArgs, cell| Job::of_sheet(work.clone(), sheet.part(cell), &log, recipe);
    let chosen = command.make(&command.prepare()?, &job(recipe, work, None))?;
    let words = chosen.in_words();
    if !work.run.quiet && !words.is_empty() {
        message::say(&format!("for all cells: {words}"));
    }
    let flags = chosen.flags();
    let (command, _) = command_by(command, &invocation.with(&flags));
    let recipe = &recipe.clone().choosing(flags);
    let work = command.work();
    save_recipe(work, &recipe.with(&Chosen::default()))?;
    if work.output.output.is_none() {
        return Ok(());
    }
    let kit = command.prepare()?;
    let cells = sheet.cells();
    let bar = cells_bar(&work.run, cells.len());
    let (next, failed) = (AtomicUsize::new(0), OnceLock::new());
    Lanes::of(cells.len(), u64::MAX, false).each(|| {
        while let Some(&cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
            let job = job(recipe, work, Some(cell));
            match caught(&work.input, || command.make(&kit, &job)) {
                _ if failed.get().is_some() => return,
                Ok(_) => bar.inc(1),
                Err(error) => drop(failed.set(error)),
            }
        }
    });
    bar.finish_and_clear();
    match failed.into_inner() {
        Some(error) => Err(error),
        None => write(sheet, &Job::new(work.clone(), &log, recipe).begun(started)),
    }
}

/// The command with the choices of the sheet, on the same files.
fn command_by<C: FrameCommand>(command: &C, invocation: &Invocation) -> (C, RecipeText) {
    let (mut chosen, recipe) = command_of::<C>(invocation);
    let (from, to) = (command.work(), chosen.work_mut());
    to.input = from.input.clone();
    to.more = from.more.clone();
    to.output = from.output.clone();
    (chosen, recipe)
}

/// Writes what all cells have made.
fn write(sheet: Sheet, job: &Job) -> Result<()> {
    let began = Instant::now();
    let (loaded, MadeCells { files, timings }) = sheet.finish()?;
    let done = Done {
        loaded,
        outcome: Outcome {
            timings,
            ..Outcome::default()
        },
        read: began.elapsed(),
    };
    for (path, (form, planes)) in files {
        let job = job.writing_to(path);
        match form {
            Form::Color { is_derived } => {
                let before = done.loaded.frame.color.as_ref().filter(|_| is_derived);
                let color = &ColorPlanes::of(planes);
                job.write_color(
                    &done,
                    MadePicture {
                        color,
                        before,
                        like: None,
                    },
                )?
            }
            Form::Picture {
                grey,
                bits,
                dpi,
                transform,
            } => {
                let color = ColorPlanes::of(planes);
                job.write_picture(
                    &done,
                    &Picture {
                        grey,
                        bits,
                        dpi,
                        ..Picture::of(&color, transform)
                    },
                )?
            }
            Form::Channels(named) => {
                let channels = named.into_iter().zip(&planes);
                let channel = |((name, sample_type), plane)| OutputChannel {
                    name,
                    plane,
                    sample_type,
                };
                job.write_channels(&done, channels.map(channel).collect())?
            }
        };
    }
    Ok(())
}
