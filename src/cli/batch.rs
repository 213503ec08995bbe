//! A command on several independent pictures, each with its own automatic choices.

use super::exit;
use super::frames::{self, refuse_collisions, validate};
use super::make::make;
use super::message;
use super::panics::caught;
use super::sheet;
use super::stop::{self, First};
use super::threads::on_threads;
use crate::command::batch::PictureBatch;
use crate::command::invocation::Task;
use crate::error::{Error, Result};
use crate::io::output::{check_folder, directory_of};
use std::path::Path;

/// Runs the command on the pictures its arguments name; returns the exit code. For several pictures that are not a
/// sequence it is 3 if some failed, and 1 if all did.
///
/// # Errors
/// Any [`crate::Error`] of a single picture, and errors before the first of several is begun.
pub(super) fn run(task: &Task) -> Result<i32> {
    let args = task.command.work().args();
    match args.batch()? {
        None => frames::run(task, sheet::one, make),
        Some(batch) => on_threads(args.run.compute.threads, || each(&batch, task)),
    }
}

fn each(batch: &PictureBatch, task: &Task) -> Result<i32> {
    stop::mind_signals(First::Finish);
    let own = batch.inputs().map(|input| own(batch, input, task));
    let all = own.collect::<Result<Vec<_>>>()?;
    for Task { command, .. } in &all {
        validate(command.work())?;
        let output = command.work().args().output.output.as_deref();
        let folder = output.map(directory_of);
        if let Some(folder) = folder {
            std::fs::create_dir_all(folder).map_err(Error::io(folder, "make"))?;
            check_folder(folder)?;
        }
    }
    let commands = all.iter().map(|task| task.command.clone());
    refuse_collisions(commands, task.typed.recipe())?;
    let mut failed = 0;
    for task in &all {
        if let Some(code) = stop::asked() {
            return Ok(code);
        }
        let input = &task.command.work().args().input;
        if let Err(error) = caught(input, || sheet::one(task)) {
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

/// The command for one picture.
fn own(batch: &PictureBatch, input: &Path, task: &Task) -> Result<Task> {
    let name = PictureBatch::name_of(input)?;
    let named = task.typed.named(&name).parse();
    let mut own = named.unwrap_or_else(|error| error.exit());
    batch.give(input, name, own.command.work_mut().args_mut());
    Ok(own)
}
