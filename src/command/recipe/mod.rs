//! Recipes: settings of a command in TOML, under the names of its flags.

mod presets;
mod read;
mod schema;
mod write;

pub(crate) use presets::PRESETS;
pub use read::Recipe;
pub(crate) use schema::schema;
pub(crate) use write::RecipeText;

use clap::{Arg, ArgAction};
use std::path::Path;

/// Version of the recipes that this program writes, and the newest it reads.
const VERSION: i64 = 1;

/// The recipe table of automatic choices, and its key for the frames they were chosen for.
const CHOSEN: &str = "chosen";
const FRAMES: &str = "frames";

/// The flag that applies a recipe's automatic choices to other frames.
pub(crate) const KEEP_LEVELS: &str = "--keep-levels";

/// The flag naming the frames that choose for all; unused where a recipe already holds their choices.
pub(crate) const SAMPLE_FRAMES: &str = "sample-frames";

/// Names of the presets.
pub(super) fn presets() -> String {
    PRESETS.map(|(name, _)| name).join(", ")
}

/// Whether an argument is a setting worth keeping: not a file of this run, nor a run option.
pub(crate) fn is_setting(arg: &Arg) -> bool {
    let id = arg.get_id().as_str();
    let of_a_run = matches!(arg.get_help_heading(), Some("Run" | "Sequence"));
    let files = ["input", "output", "no_clobber", "force", "help", "help_all"];
    let is_kept = arg.get_long() == Some(SAMPLE_FRAMES) || !of_a_run;
    arg.get_long().is_some() && is_kept && !files.contains(&id)
}

/// Whether the flag takes no value.
pub(crate) fn is_switch(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::SetTrue)
}

/// Whether the flag may be given several times.
pub(super) fn is_repeatable(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append) && arg.get_value_delimiter().is_none()
}

/// The common name of a sequence's frames: the file name with its last number as `#`.
pub(super) fn frames_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    // `%04d` stands for a number, and so does a row of `#`.
    let is_number = |c: char| c.is_ascii_digit() || c == '#';
    let Some(last) = name.rfind(is_number) else {
        return name.into();
    };
    let from = name[..=last].trim_end_matches(is_number).len();
    match name[..from].strip_suffix('%') {
        _ if name[from..].starts_with('#') || !name[last + 1..].starts_with('d') => {
            format!("{}#{}", &name[..from], &name[last + 1..])
        }
        Some(before) => format!("{before}#{}", &name[last + 2..]),
        None => format!("{}#{}", &name[..from], &name[last + 1..]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_a_sequence_are_called_alike() {
        for name in [
            "a/shot.0012.exr",
            "shot.####.exr",
            "b/shot.%04d.exr",
            "shot.7.exr",
        ] {
            assert_eq!(frames_of(Path::new(name)), "shot.#.exr", "{name}");
        }
        assert_eq!(frames_of(Path::new("bust.exr")), "bust.exr");
        assert_eq!(frames_of(Path::new("v2_head.exr")), "v#_head.exr");
        assert_eq!(frames_of(Path::new("..")), "");
    }
}
