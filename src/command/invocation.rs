//! A command line in the making: what was typed, what a recipe adds, and what was chosen for a whole sequence.

use super::commands::{Cli, command_named, long, typed_ids};
use super::flags::Flag;
use super::recipe::Recipe;
use crate::error::Result;
use clap::{ArgMatches, Command, CommandFactory, FromArgMatches};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The words of a command line: the program, the command, and its arguments.
#[derive(Debug, Clone)]
pub(crate) struct Invocation {
    words: Vec<OsString>,
    /// The recipe that some of them come from.
    recipe: Option<PathBuf>,
}

/// What was typed, as clap understands it.
pub(crate) struct Parsed {
    pub(crate) cli: Cli,
    pub(crate) matches: ArgMatches,
}

impl Invocation {
    pub(crate) fn of(words: impl IntoIterator<Item = OsString>) -> Self {
        Self {
            words: words.into_iter().collect(),
            recipe: None,
        }
    }

    /// The recipe that was read for it.
    pub(crate) fn recipe(&self) -> Option<&Path> {
        self.recipe.as_deref()
    }

    pub(crate) fn parse(&self) -> std::result::Result<Parsed, clap::Error> {
        let matches = Cli::command().try_get_matches_from(&self.words)?;
        let cli = Cli::from_arg_matches(&matches)?;
        Ok(Parsed { cli, matches })
    }

    /// The command that `recipe` stands for: its settings, then `rest`, which has the last word.
    ///
    /// # Errors
    /// [`crate::Error::Recipe`] for settings that the command does not take.
    pub(crate) fn of_recipe(&self, recipe: &Recipe, rest: &[OsString]) -> Result<Self> {
        let mut command = command_named(&recipe.command);
        command.build();
        let typed = given_in(&command, rest);
        let overruled = |flag: &Flag| {
            let arg = long(&command, flag.name());
            arg.is_some_and(|arg| {
                let rivals = command.get_arg_conflicts_with(arg);
                let mut ids = rivals.iter().map(|a| a.get_id().as_str());
                typed.contains(arg.get_id().as_str()) || ids.any(|id| typed.contains(id))
            })
        };
        let settings = recipe.flags(&command)?;
        let kept = settings.iter().filter(|flag| !overruled(flag));
        let start = [
            self.words.first().cloned().unwrap_or_default(),
            recipe.command.clone().into(),
        ];
        Ok(Self {
            recipe: Some(recipe.path.clone()),
            words: start
                .into_iter()
                .chain(kept.map(Flag::word))
                .chain(rest.iter().cloned())
                .collect(),
        })
    }

    /// The same with `flags`, as far as the command knows them; they overrule what stands there.
    pub(crate) fn with(&self, flags: &[Flag]) -> Self {
        let command = command_named(&self.words[1].to_string_lossy());
        let known = flags.iter().filter(|f| long(&command, f.name()).is_some());
        let end = self.words.iter().position(|word| word == OsStr::new("--"));
        let (before, after) = self.words.split_at(end.unwrap_or(self.words.len()));
        Self {
            recipe: self.recipe.clone(),
            words: before
                .iter()
                .cloned()
                .chain(known.map(Flag::word))
                .chain(after.iter().cloned())
                .collect(),
        }
    }
}

/// The ids of the arguments in `words`, as far as they can be understood alone.
fn given_in(command: &Command, words: &[OsString]) -> std::collections::BTreeSet<String> {
    let name = OsString::from(command.get_name());
    let lenient = command.clone().ignore_errors(true);
    let matches = lenient.try_get_matches_from(std::iter::once(&name).chain(words));
    match matches {
        Ok(matches) => typed_ids(&matches).map(String::from).collect(),
        Err(_) => Default::default(),
    }
}
