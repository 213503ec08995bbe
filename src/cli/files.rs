//! The files that a run writes, checked before any work is done.

use crate::command::args::WorkArgs;
use crate::error::{Result, bad};
use crate::io::output::{check_writable, directory_of, remove_leftovers};
use crate::untrusted::shown;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Refuses outputs of `work`, one frame, that could not be written.
///
/// # Errors
/// [`Error::BadParameter`] for a file that must stay; [`Error::Io`].
pub(super) fn check_outputs(work: &WorkArgs) -> Result<()> {
    if let Some(output) = work.output.files().iter().find(|output| output.exists())
        && work.output.no_clobber
    {
        return Err(bad(
            "-o",
            format!("{} exists already", shown(output)),
            "choose another name or leave out --no-clobber",
        ));
    }
    let replace = work.output.replace();
    for (name, path) in outputs_of_frame(work).chain(recipe_of(work)) {
        let replace = if name == "-o" {
            replace
        } else {
            work.output.replace_beside()
        };
        check_writable(&path, replace)?;
    }
    Ok(())
}

/// Removes the leftovers of killed runs from the output directories of `work`, except those already `swept`.
pub(super) fn sweep(work: &WorkArgs, swept: &mut BTreeSet<PathBuf>) {
    for (_, path) in outputs_of_frame(work).chain(recipe_of(work)) {
        let directory = directory_of(&path);
        if !swept.contains(directory) {
            swept.insert(directory.into());
            remove_leftovers(directory);
        }
    }
}

/// The files that are written of one frame, by their flags.
pub(super) fn outputs_of_frame(work: &WorkArgs) -> impl Iterator<Item = (&'static str, PathBuf)> {
    let outputs = work.output.files().into_iter().map(|path| ("-o", path));
    let timings = work.run.timings.iter().cloned();
    outputs.chain(timings.map(|path| ("--timings", path)))
}

fn recipe_of(work: &WorkArgs) -> Option<(&'static str, PathBuf)> {
    Some(("--save-recipe", work.run.save_recipe.clone()?))
}
