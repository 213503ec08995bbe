//! Recipes: settings of a command in TOML, under the names of its flags.

mod presets;
mod read;
mod schema;
mod write;

pub use read::Recipe;
pub(crate) use schema::schema;
pub(crate) use write::RecipeText;

use clap::{Arg, ArgAction};

/// Version of the recipes that this program writes, and the newest it reads.
const VERSION: i64 = 1;

/// The flag that says which frames choose for all: none do where a recipe holds what they chose.
pub(crate) const SAMPLE_FRAMES: &str = "sample-frames";

/// Commands that a recipe may stand for.
pub(super) const COMMANDS: [&str; 4] = ["shape", "enhance", "relight", "hatch"];

/// The names of the recipes that come with the program.
pub(super) fn presets() -> String {
    presets::PRESETS.map(|(name, _)| name).join(", ")
}

/// Whether an argument is a setting, to be kept: not a file of this run, nor how it is run.
pub(super) fn is_setting(arg: &Arg) -> bool {
    let id = arg.get_id().as_str();
    let of_a_run = matches!(arg.get_help_heading(), Some("Run" | "Sequence"));
    let files = ["input", "output", "no_clobber", "force", "help"];
    let is_kept = arg.get_long() == Some(SAMPLE_FRAMES) || !of_a_run;
    arg.get_long().is_some() && is_kept && !files.contains(&id)
}

/// Whether it is on where it is given, and takes no value.
pub(super) fn is_switch(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// Whether it may be given again, for another value.
pub(super) fn is_repeatable(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append) && arg.get_value_delimiter().is_none()
}
