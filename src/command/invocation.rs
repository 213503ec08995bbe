//! A command line being assembled: the words typed, the flags of a recipe, and the choices for a whole sequence.

use super::commands::{Cli, Command, command_named, help_on_all, long, program, typed_ids};
use super::flags::Flag;
use super::output::NAME;
use super::recipe::{KEEP_LEVELS, Recipe, RecipeText, frames_of};
use crate::error::Result;
use crate::untrusted::shown;
use clap::FromArgMatches;
use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The words of a command line: the program, the command, and its arguments.
#[derive(Debug, Clone)]
pub(crate) struct Invocation {
    words: Vec<OsString>,
    /// The recipe that some of them come from.
    recipe: Option<PathBuf>,
    /// Flags that the recipe holds as chosen for these same frames.
    kept: Vec<Flag>,
    /// Note about choices that the recipe made for other frames.
    note: Option<String>,
}

/// A command line, parsed: the command with its settings, which the recipe has as they were typed.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    pub(crate) command: Command,
    pub(crate) recipe: RecipeText,
    pub(crate) typed: Invocation,
}

impl Task {
    /// The task with further `flags`, which override earlier ones.
    ///
    /// # Panics
    /// If the command does not take them.
    pub(crate) fn with(&self, flags: &[Flag]) -> Self {
        let task = self.typed.with(flags).parse();
        task.unwrap_or_else(|error| error.exit())
    }
}

impl Invocation {
    pub(crate) fn of(words: impl IntoIterator<Item = OsString>) -> Self {
        Self {
            words: words.into_iter().collect(),
            recipe: None,
            kept: Vec::new(),
            note: None,
        }
    }

    /// The recipe it was read from.
    pub(crate) fn recipe(&self) -> Option<&Path> {
        self.recipe.as_deref()
    }

    /// A note for the user about the recipe.
    pub(crate) fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Help on all options of its command, if it asks for that.
    pub(crate) fn help_on_all(&self) -> Option<String> {
        help_on_all(&self.words)
    }

    pub(crate) fn parse(self) -> std::result::Result<Task, clap::Error> {
        let matches = program().clone().try_get_matches_from(&self.words)?;
        let mut command = Cli::from_arg_matches(&matches)?.command;
        if let Command::Map(args) | Command::Normals(args) = &mut command {
            args.settle();
        }
        Ok(Task {
            command,
            recipe: RecipeText::of(&matches, &self.kept),
            typed: self,
        })
    }

    /// The command line for `recipe`: its settings, then `rest`, which overrides them. Its automatic choices apply to
    /// frames of the same name, and to others with `--keep-levels`.
    ///
    /// # Errors
    /// [`crate::Error::Recipe`] for settings that the command does not take.
    pub(crate) fn of_recipe(&self, recipe: &Recipe, rest: &[OsString]) -> Result<Self> {
        let mut command = command_named(&recipe.command);
        command.build();
        let keeps = rest.iter().any(|word| word == KEEP_LEVELS);
        let rest: Vec<_> = rest.iter().filter(|word| *word != KEEP_LEVELS).collect();
        let TypedWords { typed, input } = typed_words(&command, &rest);
        let overruled = |flag: &&Flag| {
            let arg = long(&command, flag.name());
            arg.is_some_and(|arg| {
                let rivals = command.get_arg_conflicts_with(arg);
                let mut ids = rivals.iter().map(|a| a.get_id().as_str());
                typed.contains(arg.get_id().as_str()) || ids.any(|id| typed.contains(id))
            })
        };
        let (settings, chosen) = (recipe.flags(&command)?, recipe.chosen(&command)?);
        let same = recipe.frames().is_some() && recipe.frames() == input.as_deref();
        let takes_chosen = same || keeps;
        let kept = chosen
            .iter()
            .filter(|flag| takes_chosen && !overruled(flag));
        let kept: Vec<Flag> = kept.cloned().collect();
        let is_left = !takes_chosen && !chosen.is_empty() && !typed.contains("quiet");
        let note = is_left.then(|| {
            let (path, of) = (shown(&recipe.path), recipe.frames().unwrap_or("others"));
            format!("{path}: what was chosen for {of} is chosen anew; {KEEP_LEVELS} takes it")
        });
        let start = [
            self.words.first().cloned().unwrap_or_default(),
            recipe.command.clone().into(),
        ];
        let settings = settings.iter().filter(|flag| !overruled(flag));
        let flags = settings.chain(&kept).map(Flag::word);
        Ok(Self {
            recipe: Some(recipe.path.clone()),
            words: start
                .into_iter()
                .chain(flags)
                .chain(rest.into_iter().cloned())
                .collect(),
            kept,
            note,
        })
    }

    /// Replaces the name placeholder by `name`.
    pub(crate) fn named(&self, name: &str) -> Self {
        let named = |word: &OsString| match word.to_str() {
            // A file is called so, and no option.
            Some(text) if text.starts_with(NAME) && name.starts_with('-') => {
                format!("./{}", text.replace(NAME, name)).into()
            }
            Some(text) => text.replace(NAME, name).into(),
            None => word.clone(),
        };
        Self {
            words: self.words.iter().map(named).collect(),
            ..self.clone()
        }
    }

    /// Adds the `flags` that the command knows; they override earlier ones.
    pub(crate) fn with(&self, flags: &[Flag]) -> Self {
        let command = command_named(&self.words[1].to_string_lossy());
        let known = flags.iter().filter(|f| long(&command, f.name()).is_some());
        let end = self.words.iter().position(|word| word == OsStr::new("--"));
        let (before, after) = self.words.split_at(end.unwrap_or(self.words.len()));
        Self {
            recipe: self.recipe.clone(),
            kept: self.kept.clone(),
            note: None,
            words: before
                .iter()
                .cloned()
                .chain(known.map(Flag::word))
                .chain(after.iter().cloned())
                .collect(),
        }
    }
}

/// Facts needed from a partial command line, as far as clap can parse it alone.
#[derive(Default)]
struct TypedWords {
    /// Ids of the arguments that were typed.
    typed: BTreeSet<String>,
    /// The common name of the input's frames.
    input: Option<String>,
}

fn typed_words(command: &clap::Command, words: &[&OsString]) -> TypedWords {
    let name = OsString::from(command.get_name());
    let lenient = command.clone().ignore_errors(true);
    let words = std::iter::once(&name).chain(words.iter().copied());
    let Ok(matches) = lenient.try_get_matches_from(words) else {
        return TypedWords::default();
    };
    let input = matches.get_raw("input").and_then(Iterator::last);
    TypedWords {
        typed: typed_ids(&matches).map(String::from).collect(),
        input: input.map(|input| frames_of(Path::new(input))),
    }
}
