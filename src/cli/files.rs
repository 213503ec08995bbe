//! The files that a run reads and writes, checked before any work is done.

use super::args::WorkArgs;
use super::frames::FrameCommand;
use crate::error::{Error, Result};
use crate::io::output::{Files, check_writable, directory_of, remove_leftovers};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Checks all `frames` at once, `None` being a single picture: no output may be an input of any frame, `recipe` included,
/// or another output.
///
/// # Errors
/// [`Error::BadParameter`] naming the first output that is.
pub(super) fn refuse_collisions<C: FrameCommand>(
    command: &C,
    recipe: Option<&Path>,
    frames: &[Option<i32>],
) -> Result<()> {
    let mut files = Files::default();
    recipe.into_iter().for_each(|path| files.reads(path));
    let folder = command.folder();
    folder.into_iter().for_each(|path| files.reads_all_in(path));
    let works = frames.iter().map(|&frame| match frame {
        Some(number) => (frame, command.work().of_frame(number)),
        None => (frame, command.work().clone()),
    });
    let works: Vec<_> = works.collect();
    for (frame, work) in &works {
        let of_command = command.files(*frame);
        for path in work.roles.files(&work.input).iter().chain(&of_command) {
            files.reads(path);
        }
    }
    for (_, work) in &works {
        for (name, path) in outputs_of_frame(work) {
            files.writes(name, path)?;
        }
    }
    match &command.work().run.save_recipe {
        Some(path) => files.writes("--save-recipe", path),
        None => Ok(()),
    }
}

/// Refuses outputs of `work`, one frame, that could not be written.
///
/// # Errors
/// [`Error::BadParameter`] for a file that must stay; [`Error::Io`].
pub(super) fn check_outputs(work: &WorkArgs) -> Result<()> {
    if let Some(output) = work.output.output.as_ref().filter(|o| o.exists())
        && work.output.no_clobber
    {
        return Err(Error::BadParameter {
            name: "-o",
            found: format!("{} exists already", output.display()),
            remedy: "choose another name or leave out --no-clobber".into(),
        });
    }
    let replace = work.output.replace();
    for (name, path) in outputs_of_frame(work).chain(recipe_of(work)) {
        let replace = if name == "-o" {
            replace
        } else {
            work.output.replace_beside()
        };
        check_writable(path, replace)?;
    }
    Ok(())
}

/// Removes what killed runs left in the directories that `work` writes to, other than those `swept` before.
pub(super) fn sweep(work: &WorkArgs, swept: &mut BTreeSet<PathBuf>) {
    for (_, path) in outputs_of_frame(work).chain(recipe_of(work)) {
        let directory = directory_of(path);
        if !swept.contains(directory) {
            swept.insert(directory.into());
            remove_leftovers(directory);
        }
    }
}

fn outputs_of_frame(work: &WorkArgs) -> impl Iterator<Item = (&'static str, &Path)> {
    let outputs = [
        ("-o", &work.output.output),
        ("--timings", &work.run.timings),
    ];
    let given = outputs.into_iter();
    given.filter_map(|(name, path)| Some((name, path.as_deref()?)))
}

fn recipe_of(work: &WorkArgs) -> Option<(&'static str, &Path)> {
    Some(("--save-recipe", work.run.save_recipe.as_deref()?))
}
