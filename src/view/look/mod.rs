//! A look: a command and its settings, as stored in recipes and edited in the viewer. Names, defaults and help come
//! from the flags.

mod light_files;
mod view_session;

pub(crate) use crate::command::setting::{Setting, SettingKind, settings_of};
pub(crate) use crate::io::inputs::INPUTS;
pub(crate) use light_files::{ENVIRONMENT, LIT_SPHERE, LightFile, light_files};
pub(crate) use view_session::{ShownFile, ViewPixels, ViewSession, What};

use crate::command::chosen::Chosen;
use crate::command::commands::{ViewArgs, command_named, long};
use crate::command::error_line::misuse_line;
use crate::command::flags::Flag;
use crate::command::invocation::{Invocation, Task};
use crate::command::recipe::{PRESETS, Recipe, is_setting, is_switch};
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::light::lights::LAMP_DEG;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Placeholder output for command lines that are only previewed; nothing is written there.
const NOWHERE: &str = "view.png";

/// The command opened first: new light shows shape on any surface.
const FIRST_COMMAND: &str = "relight";

/// The commands whose results are shown.
const SHOWN: [&str; 4] = ["shape", "enhance", "relight", "hatch"];

/// An error as one line.
pub(crate) type OneLine = String;

/// A command and its settings.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Look {
    command: String,
    /// Settings not at their default, by flag name. Settings unknown to the current command are kept for one that knows
    /// them.
    settings: BTreeMap<String, Vec<String>>,
}

impl Default for Look {
    /// New light from the lamp that also lights drawings.
    fn default() -> Self {
        let [azimuth, elevation] = LAMP_DEG;
        Self {
            command: FIRST_COMMAND.into(),
            settings: [("light".into(), vec![format!("{azimuth},{elevation}")])].into(),
        }
    }
}

impl Look {
    /// The look that a recipe holds.
    ///
    /// # Errors
    /// As [`Recipe::read`]; [`Error::Recipe`] for a command that the window does not show.
    pub(crate) fn of_recipe(path: &Path) -> Result<Self> {
        Self::of(&Recipe::read(path)?, path)
    }

    fn of(recipe: &Recipe, path: &Path) -> Result<Self> {
        if !SHOWN.contains(&&recipe.command[..]) {
            return Err(Error::Recipe {
                path: path.to_path_buf(),
                found: format!("is for {}, which has no window", recipe.command),
                remedy: format!("give one for {}", SHOWN.join(", ")),
            });
        }
        let mut look = Self {
            settings: BTreeMap::new(),
            command: recipe.command.clone(),
        };
        look.add(recipe.flags(&command_named(&recipe.command))?);
        Ok(look)
    }

    /// The names of the presets.
    pub(crate) fn presets() -> impl Iterator<Item = &'static str> {
        PRESETS.iter().map(|(name, _)| *name)
    }

    /// The look of a preset, for the inputs of this one.
    pub(crate) fn preset(&self, name: &str) -> Self {
        let text = PRESETS.iter().find(|(known, _)| *known == name);
        let (_, text) = text.expect("presets are named by their list");
        let path = Path::new(name);
        let look = Recipe::parse(path, text).and_then(|recipe| Self::of(&recipe, path));
        let mut look = look.expect("presets are tested to be recipes");
        let settings = settings_of(&look.command).into_iter();
        for setting in settings.filter(|setting| setting.family == INPUTS) {
            if let Some(values) = self.settings.get(&setting.name) {
                look.settings.insert(setting.name, values.clone());
            }
        }
        look
    }

    /// The names of the commands that are shown.
    pub(crate) fn commands() -> &'static [&'static str] {
        &SHOWN
    }

    pub(crate) fn command(&self) -> &str {
        &self.command
    }

    pub(crate) fn set_command(&mut self, command: &str) {
        self.command = command.into();
    }

    /// The value given to a setting; the first, if it may be given several times.
    pub(crate) fn value(&self, name: &str) -> Option<&str> {
        self.values(name).first().map(String::as_str)
    }

    pub(crate) fn values(&self, name: &str) -> &[String] {
        self.settings.get(name).map_or(&[], Vec::as_slice)
    }

    /// Sets a value, or resets it to its default; settings that conflict with it are removed.
    pub(crate) fn set(&mut self, name: &str, value: Option<String>) {
        self.set_all(name, value.into_iter().collect());
    }

    /// The same for a setting that may be given several times.
    pub(crate) fn set_all(&mut self, name: &str, values: Vec<String>) {
        if values.is_empty() {
            self.settings.remove(name);
            return;
        }
        let mut command = command_named(&self.command);
        command.build();
        if let Some(arg) = long(&command, name) {
            let rivals = command.get_arg_conflicts_with(arg);
            for rival in rivals.into_iter().filter_map(|arg| arg.get_long()) {
                self.settings.remove(rival);
            }
        }
        self.settings.insert(name.into(), values);
    }

    /// The same look with one setting changed.
    pub(crate) fn with(&self, name: &str, value: impl ToString) -> Self {
        let mut look = self.clone();
        look.set(name, Some(value.to_string()));
        look
    }

    /// The same relighting without shape enhancement; `None` for other commands.
    pub(crate) fn unaltered(&self) -> Option<Self> {
        (self.command == FIRST_COMMAND).then(|| self.with("method", "plain"))
    }

    fn add(&mut self, flags: Vec<Flag>) {
        for flag in flags {
            let values = self.settings.entry(flag.name().into()).or_default();
            values.push(flag.value().unwrap_or("true").into());
        }
    }

    /// The settings that the command knows.
    fn flags(&self) -> Vec<Flag> {
        let command = command_named(&self.command);
        let known = self.settings.iter().filter_map(|(name, values)| {
            let arg = long(&command, name).filter(|arg| is_setting(arg))?;
            let flags = values.iter().map(|value| match is_switch(arg) {
                true => Flag::switch(name),
                false => Flag::new(name, value),
            });
            Some(flags.collect::<Vec<_>>())
        });
        known.flatten().collect()
    }

    /// The command line that applies the look to `input` and writes `output`.
    pub(crate) fn invocation(&self, input: &Path, output: &Path) -> Invocation {
        let start = ["relievo".into(), self.command.clone().into()];
        let flags = self.flags();
        let flags = flags.iter().map(Flag::word);
        let end: [OsString; 4] = ["-o".into(), output.into(), "--".into(), input.into()];
        Invocation::of(start.into_iter().chain(flags).chain(end))
    }

    fn parse(&self, input: &Path) -> std::result::Result<Task, OneLine> {
        let invocation = self.invocation(input, Path::new(NOWHERE));
        invocation
            .parse()
            .map_err(|error| misuse_line(&error).replacen("error: ", "", 1))
    }

    /// The recipe of the look, with the automatic choices it leaves open.
    fn recipe(&self, input: &Path, chosen: &Chosen) -> std::result::Result<String, OneLine> {
        Ok(self.parse(input)?.recipe.with(chosen))
    }

    /// The command line that reproduces the result from `input`, quoted for a shell.
    pub(crate) fn command_line(&self, input: &Path, frames: Option<&[i32]>) -> String {
        let flags = self.flags();
        let flags = flags.iter().map(Flag::word);
        let flags = flags.map(|word| word.to_string_lossy().into_owned());
        let input = input.display().to_string();
        let mut words = vec!["relievo".into(), self.command.clone(), input];
        let output = match frames {
            Some(_) => "out.####.png",
            None => "out.png",
        };
        words.extend(["-o".into(), output.into()]);
        if let Some(frames) = frames {
            let numbers: Vec<_> = frames.iter().map(i32::to_string).collect();
            let list = match frames {
                [first, .., last] if (last - first) as usize + 1 == frames.len() => {
                    format!("{first}-{last}")
                }
                _ => numbers.join(","),
            };
            words.push(format!("--frames={list}"));
        }
        words.extend(flags);
        let words: Vec<_> = words.iter().map(|word| quoted(word)).collect();
        words.join(" ")
    }
}

/// A word quoted so that a shell takes it as one.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+%@".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.into(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

/// Writes the picture that a look makes of the first path to the second.
pub(crate) type SavePicture = fn(&Look, &Path, &Path) -> std::result::Result<(), OneLine>;

/// The arguments of a window.
pub(crate) struct Opening {
    pub(crate) input: Option<PathBuf>,
    pub(crate) frames: Option<Vec<i32>>,
    pub(crate) look: Look,
    /// The engine.
    pub(crate) engine: Arc<Engine>,
    /// Saves pictures.
    pub(crate) save: SavePicture,
}

impl Opening {
    /// The recipe and overriding flags given in `args`; pictures are saved by `save`.
    ///
    /// # Errors
    /// As [`Recipe::read`]; [`crate::Error::NoGpu`] where a device is required and none is available.
    pub(crate) fn of(args: &ViewArgs, typed: &[Flag], save: SavePicture) -> Result<Self> {
        let mut look = match &args.recipe {
            Some(path) => Look::of_recipe(path)?,
            None => Look::default(),
        };
        let mut given: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for flag in typed {
            let values = given.entry(flag.name().into()).or_default();
            values.push(flag.value().unwrap_or("true").into());
        }
        for (name, values) in given {
            look.set_all(&name, values);
        }
        Ok(Self {
            input: args.input.clone(),
            frames: args.frames.numbers(),
            look,
            engine: args.compute.backend.engine()?.or_cpu().into(),
            save,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_keeps_the_inputs_and_nothing_else() {
        let look = Look::default().with("normal", "n.png").with("scaling", 2);
        let look = look.with("light", "10,20");
        for name in Look::presets() {
            let preset = look.preset(name);
            assert_eq!(preset.value("normal"), Some("n.png"), "{name}");
            assert_eq!(preset.value("scaling"), None, "{name}");
            assert_ne!(preset.value("light"), Some("10,20"), "{name}");
        }
        // Its own settings are those of its recipe.
        assert_eq!(look.preset("coin").value("line-scale"), Some("0.5"));
        assert_eq!(look.preset("coin").command(), "hatch");
    }
}
