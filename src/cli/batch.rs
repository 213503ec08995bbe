//! A command on several independent pictures, each with its own automatic choices.

use super::exit;
use super::frames::{self, FrameCommand, command_of, refuse_collisions, validate};
use super::message;
use super::panics::caught;
use super::sheet;
use super::stop::{self, First};
use super::threads::on_threads;
use crate::command::batch::Batch;
use crate::command::invocation::Invocation;
use crate::command::recipe::RecipeText;
use crate::error::{Error, Result};
use crate::io::output::{check_folder, directory_of};
use std::path::Path;

/// A command for one picture, with its record for the recipe.
type Own<C> = (C, RecipeText, Invocation);

/// Runs the command on the pictures its arguments name; returns the exit code. For several pictures that are not a
/// sequence it is 3 if some failed, and 1 if all did.
///
/// # Errors
/// Any [`crate::Error`] of a single picture, and errors before the first of several is begun.
pub(super) fn run<C: FrameCommand>(invocation: &Invocation) -> Result<i32> {
    let (command, _) = command_of::<C>(invocation);
    let work = command.work();
    match work.batch()? {
        None => frames::run::<C>(invocation, sheet::one),
        Some(batch) => on_threads(work.run.compute.threads, || each::<C>(&batch, invocation)),
    }
}

fn each<C: FrameCommand>(batch: &Batch, invocation: &Invocation) -> Result<i32> {
    stop::mind_signals(First::Finish);
    let own = batch
        .inputs()
        .map(|input| own::<C>(batch, input, invocation));
    let all = own.collect::<Result<Vec<_>>>()?;
    for (command, ..) in &all {
        validate(command)?;
        let output = command.work().output.output.as_deref();
        let folder = output.map(directory_of);
        folder.into_iter().try_for_each(make_folder)?;
    }
    let commands = all.iter().map(|(command, ..)| (command, None));
    refuse_collisions(commands, invocation.recipe())?;
    let mut failed = 0;
    for (command, recipe, invocation) in &all {
        if let Some(code) = stop::asked() {
            return Ok(code);
        }
        let input = &command.work().input;
        if let Err(error) = caught(input, || sheet::one(command, recipe, invocation)) {
            message::error(&error);
            failed += 1;
        }
    }
    Ok(match failed {
        0 => exit::DONE,
        _ if failed < all.len() => exit::SOME_FAILED,
        _ => exit::FAILED,
    })
}

/// The command line for one picture.
fn own<C: FrameCommand>(batch: &Batch, input: &Path, invocation: &Invocation) -> Result<Own<C>> {
    let name = Batch::name_of(input)?;
    let invocation = invocation.named(&name);
    let (mut command, recipe) = command_of::<C>(&invocation);
    batch.give(input, name, command.work_mut());
    Ok((command, recipe, invocation))
}

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(Error::io(folder, "make"))?;
    check_folder(folder)
}
