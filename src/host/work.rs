//! A command with its settings, parsed as the command line parses them.

use super::made::{Made, named};
use super::scene::File;
use crate::command::chosen::Chosen;
use crate::command::commands::{COMMANDS, Command, command_named, long};
use crate::command::error_line::misuse_line;
use crate::command::flags::Flag;
use crate::command::invocation::{Invocation, Task};
use crate::command::recipe::{Recipe, is_setting, is_switch};
use crate::command::sequence::SequenceArgs;
use crate::error::{Error, Result};
use crate::io::inputs::{INPUTS, Inputs};
use crate::io::output::page::LINES;
use crate::light::lights::Illumination;
use crate::params::Param;
use crate::work::light_of;
use clap::Arg;
use std::ffi::OsString;
use std::path::Path;

/// Stands for the file that the command line would write, whose kind tells what is made.
const LAYERS: &str = "made.exr";

/// Stands for the file that the command line would read, for scenes of arrays.
const ARRAYS: &str = "arrays";

/// A command with its settings.
#[derive(Debug)]
pub struct Work {
    pub(super) task: Task,
    settings: Vec<(String, String)>,
    pub(super) light: Illumination,
    pub(super) warnings: Vec<String>,
}

impl Work {
    /// A command with these settings, by their names in recipes; one that takes several values may be given several
    /// times. For a file, settings tell how it is read, too.
    ///
    /// # Errors
    /// [`Error::Arguments`] for an unknown command, setting or value; [`Error::BadParameter`] for values outside their
    /// ranges, and for light that cannot be used; any [`Error`] of reading files of light.
    pub fn new(command: &str, settings: &[(String, String)], file: Option<&File>) -> Result<Self> {
        if !COMMANDS.contains(&command) {
            let found = format!("{command} is no command; give {}", COMMANDS.join(", "));
            return Err(Error::Arguments { found });
        }
        let start = ["relievo".into(), command.into()];
        let flags = words(command, settings)?;
        let typed = Invocation::of(start.into_iter().chain(flags).chain(end(file)));
        Self::parsed(typed, settings.to_vec())
    }

    /// The same drawing in lines: what is made of it then is an SVG.
    ///
    /// # Errors
    /// [`Error::Arguments`] for commands that draw nothing; [`Error::BadParameter`] for strokes that are no lines.
    pub fn in_lines(mut self) -> Result<Self> {
        if !matches!(self.task.command, Command::Hatch(_)) {
            let found = "only hatch draws lines".into();
            return Err(Error::Arguments { found });
        }
        let work = self.task.command.work_mut();
        work.args_mut().output.output = Some(LINES.into());
        work.check()?;
        Ok(self)
    }

    pub(super) fn work(&self) -> &dyn crate::work::FrameWork {
        self.task.command.work()
    }

    /// How and from where frames are read.
    pub(super) fn inputs(&self) -> Inputs {
        self.work().args().inputs()
    }

    /// Refuses settings that name layers or files, or how these are read, for scenes of arrays.
    ///
    /// # Errors
    /// [`Error::Arguments`] naming the first one.
    pub(super) fn refuse_names(&self) -> Result<()> {
        let command = command_named(self.task.recipe.command());
        let mut names = self.settings.iter().map(|(name, _)| name);
        let is_of_files = |name: &&String| long(&command, name).is_some_and(names_input);
        names.find(is_of_files).map_or(Ok(()), |setting| {
            let found = format!(
                "{setting} is of layers or files, and the frame is made of arrays: leave it out, or load a file"
            );
            Err(Error::Arguments { found })
        })
    }

    /// The frames that all automatic settings are chosen from.
    pub(super) fn sequence(&self) -> &SequenceArgs {
        &self.work().args().sequence
    }

    /// The command of a recipe, with further settings, which overrule it. Its automatic choices apply to frames of the
    /// names that they were made for.
    ///
    /// # Errors
    /// As [`Work::new`]; [`Error::Recipe`] for settings that the command does not take.
    pub fn of_recipe(
        recipe: &Recipe,
        settings: &[(String, String)],
        file: Option<&File>,
    ) -> Result<Self> {
        let rest = words(&recipe.command, settings)?;
        let rest: Vec<_> = rest.into_iter().chain(end(file)).collect();
        let typed = Invocation::of(["relievo".into()]).of_recipe(recipe, &rest)?;
        let own = recipe.flags(&command_named(&recipe.command))?;
        let own = own.iter().map(named);
        Self::parsed(typed, own.chain(settings.iter().cloned()).collect())
    }

    fn parsed(typed: Invocation, settings: Vec<(String, String)>) -> Result<Self> {
        let task = typed.parse().map_err(|error| Error::Arguments {
            found: misuse_line(&error).replacen("error: ", "", 1),
        })?;
        let work = task.command.work();
        work.args().flags.validate()?;
        work.check()?;
        let (light, said) = light_of(work)?;
        let warnings = work.warnings().into_iter().chain(said).collect();
        Ok(Self {
            task,
            settings,
            light,
            warnings,
        })
    }

    /// Its settings, by their names in recipes.
    pub fn settings(&self) -> &[(String, String)] {
        &self.settings
    }

    /// It as a recipe, with the choices made for `made`, if anything has been made.
    pub fn recipe(&self, made: Option<&Made>) -> String {
        let none = Chosen::default();
        self.task
            .recipe
            .with(made.map_or(&none, |made| &made.chosen))
    }
}

/// Whether an argument names a layer or a file of the frame, or how its colours are stored.
fn names_input(arg: &Arg) -> bool {
    let forms = arg.get_value_names().unwrap_or_default();
    let form = forms.first().map_or("", |form| form.as_str());
    let heading = arg.get_help_heading();
    let is_of_frame = matches!(heading, Some(INPUTS | "Mirrors and lenses"));
    let is_file = is_of_frame && matches!(form, "NAME" | "FILE" | "JSON");
    let is_layer = form.starts_with("NAME|FILE") || form.starts_with("NAME=");
    let is_parameter = arg
        .get_long()
        .is_some_and(|name| Param::named(name).is_some());
    (is_file || is_layer || arg.get_id() == "colorspace") && !is_parameter
}

/// Settings as words of the command line.
fn words(command: &str, settings: &[(String, String)]) -> Result<Vec<OsString>> {
    let command = command_named(command);
    let word = |(name, value): &(String, String)| {
        let known = long(&command, name).filter(|arg| is_setting(arg));
        let arg = known.ok_or_else(|| Error::Arguments {
            found: format!("{} takes no {name}", command.get_name()),
        })?;
        Ok(match (is_switch(arg), &value[..]) {
            (true, "false") => None,
            (true, "true") => Some(Flag::switch(name).word()),
            _ => Some(Flag::new(name, value).word()),
        })
    };
    settings
        .iter()
        .filter_map(|pair| word(pair).transpose())
        .collect()
}

/// The last words of a command line.
fn end(file: Option<&File>) -> Vec<OsString> {
    let path = file.map_or(Path::new(ARRAYS), |file| &file.path);
    vec!["-o".into(), LAYERS.into(), "--".into(), path.into()]
}
