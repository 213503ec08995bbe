//! From TOML to flags.

use super::presets::preset;
use super::{CHOSEN, FRAMES, VERSION, is_repeatable, is_setting, is_switch};
use crate::command::commands::{COMMANDS, command_named, long, names_of};
use crate::command::flags::Flag;
use crate::error::{Error, Result};
use crate::io::open::open_input;
use crate::untrusted::Untrusted;
use clap::{Arg, Command};
use std::io::Read;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// Size limit of a recipe; a thousand settings fit.
const MOST_BYTES: u64 = 1 << 20;

/// The settings of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    pub(in crate::command) path: PathBuf,
    pub(crate) command: String,
    settings: Table,
    /// Automatic choices, and the frames they were chosen for.
    chosen: Table,
    frames: Option<String>,
}

impl Recipe {
    /// Reads a recipe; if there is no such file and the path names a preset, that preset.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Recipe`] for invalid TOML, another version or a missing command, and for settings the
    /// command does not have, with the nearest one it has.
    pub fn read(path: &Path) -> Result<Self> {
        let preset = path.to_str().and_then(preset);
        if let Some(text) = preset.filter(|_| !path.exists()) {
            return Self::parse(path, text);
        }
        if !path.exists() && path.extension().is_none() {
            let remedy = format!("name a recipe, or one of {}", super::presets());
            return Err(bad(path, "is no file, and no preset", &remedy));
        }
        let mut text = Vec::new();
        open_input(path)
            .and_then(|file| file.take(MOST_BYTES + 1).read_to_end(&mut text))
            .map_err(Error::io(path, "read"))?;
        if text.len() as u64 > MOST_BYTES {
            return Err(bad(path, "is larger than a recipe can be", "name a recipe"));
        }
        let text = String::from_utf8(text)
            .map_err(|_| bad(path, "is not text", "name a recipe, a text file"))?;
        Self::parse(path, &text)
    }

    /// Parses `text` as a recipe; `path` is used in errors only.
    ///
    /// # Errors
    /// As [`Recipe::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let mut settings: Table = text.parse().map_err(|error: toml::de::Error| {
            let line = error.span().map_or(1, |span| {
                1 + text[..span.start].bytes().filter(|&b| b == b'\n').count()
            });
            let found = format!("line {line}: {}", Untrusted(error.message()));
            bad(path, &found, "write it as name = value")
        })?;
        match settings.remove("version") {
            Some(Value::Integer(VERSION)) => {}
            Some(Value::Integer(newer)) if newer > VERSION => {
                let found = format!("is of version {newer}, and this program knows {VERSION}");
                return Err(bad(path, &found, "use a newer relievo"));
            }
            _ => {
                return Err(bad(
                    path,
                    "has no version",
                    &format!("add version = {VERSION}"),
                ));
            }
        }
        let command = match settings.remove("command") {
            Some(Value::String(name)) if COMMANDS.contains(&&name[..]) => name,
            _ => {
                let remedy = format!("add command = one of {}", quoted(&COMMANDS));
                return Err(bad(path, "names no command", &remedy));
            }
        };
        let mut chosen = match settings.remove(CHOSEN) {
            None => Table::new(),
            Some(Value::Table(chosen)) => chosen,
            Some(_) => {
                let found = format!("{CHOSEN} is no table");
                return Err(bad(
                    path,
                    &found,
                    &format!("write [{CHOSEN}] after all settings"),
                ));
            }
        };
        let frames = match chosen.remove(FRAMES) {
            Some(Value::String(frames)) => Some(frames),
            _ => None,
        };
        let recipe = Self {
            path: path.into(),
            command,
            settings,
            chosen,
            frames,
        };
        let command = command_named(&recipe.command);
        recipe.flags(&command)?;
        recipe.flags_in(&recipe.chosen, &command)?;
        Ok(recipe)
    }

    /// The command that it runs.
    pub fn command(&self) -> &str {
        &self.command
    }

    /// It as a text that [`Recipe::parse`] reads.
    pub fn text(&self) -> String {
        let mut text = format!(
            "version = {VERSION}\ncommand = \"{}\"\n{}",
            self.command, self.settings
        );
        if !self.chosen.is_empty() {
            let frames = self.frames.iter();
            let frames =
                frames.map(|frames| format!("{FRAMES} = {}\n", Value::String(frames.clone())));
            text.push_str(&format!(
                "\n[{CHOSEN}]\n{}{}",
                frames.collect::<String>(),
                self.chosen
            ));
        }
        text
    }

    /// The settings as flags of `command`.
    pub(crate) fn flags(&self, command: &Command) -> Result<Vec<Flag>> {
        self.flags_in(&self.settings, command)
    }

    /// The automatic choices as flags of `command`.
    pub(in crate::command) fn chosen(&self, command: &Command) -> Result<Vec<Flag>> {
        self.flags_in(&self.chosen, command)
    }

    /// The frames they were chosen for, as [`frames_of`] names them.
    pub(in crate::command) fn frames(&self) -> Option<&str> {
        self.frames.as_deref()
    }

    fn flags_in(&self, table: &Table, command: &Command) -> Result<Vec<Flag>> {
        let mut flags = Vec::new();
        for (name, value) in table {
            let arg = long(command, name).filter(|arg| is_setting(arg));
            let arg = arg.ok_or_else(|| self.unknown(name, command))?;
            flags.extend(self.flags_of(arg, name, value)?);
        }
        Ok(flags)
    }

    fn flags_of(&self, arg: &Arg, name: &str, value: &Value) -> Result<Vec<Flag>> {
        let wrong = |expected: &str| {
            let found = format!("{} is {}", Untrusted(name), value.type_str());
            Err(bad(&self.path, &found, &format!("write {expected}")))
        };
        if is_switch(arg) {
            return match value {
                Value::Boolean(true) => Ok(vec![Flag::switch(name)]),
                Value::Boolean(false) => Ok(Vec::new()),
                _ => wrong("true or false"),
            };
        }
        let values = match value {
            Value::Array(values) if is_repeatable(arg) => values.iter().map(one_or_list).collect(),
            _ => one_or_list(value).map(|text| vec![text]),
        };
        let values: Option<Vec<String>> = values;
        match values {
            Some(values) => Ok(values
                .into_iter()
                .map(|text| Flag::new(name, text))
                .collect()),
            None => wrong("a number, a text, or a list of them"),
        }
    }

    fn unknown(&self, name: &str, command: &Command) -> Error {
        let known = command.get_arguments().filter(|arg| is_setting(arg));
        let likeness = |known: &&str| strsim::jaro_winkler(name, known);
        let nearest = known
            .flat_map(names_of)
            .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let remedy = match nearest.filter(|known| likeness(known) > 0.7) {
            Some(nearest) => format!("the nearest is {nearest}"),
            None => format!("see relievo {} --help", self.command),
        };
        let found = match long(command, name) {
            Some(_) => format!(
                "{} is for the command line, not for a recipe",
                Untrusted(name)
            ),
            None => format!("{} has no setting {}", self.command, Untrusted(name)),
        };
        bad(&self.path, &found, &remedy)
    }
}

/// A value as typed on a command line; lists are joined by commas.
fn one_or_list(value: &Value) -> Option<String> {
    let one = |value: &Value| match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        _ => None,
    };
    match value {
        Value::Array(values) => {
            let values: Option<Vec<String>> = values.iter().map(one).collect();
            values.map(|values| values.join(","))
        }
        value => one(value),
    }
}

fn bad(path: &Path, found: &str, remedy: &str) -> Error {
    Error::Recipe {
        path: path.into(),
        found: found.into(),
        remedy: remedy.into(),
    }
}

fn quoted(names: &[&str]) -> String {
    let names: Vec<_> = names.iter().map(|name| format!("\"{name}\"")).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::presets::PRESETS;
    use super::*;

    fn words(text: &str) -> Vec<std::ffi::OsString> {
        let recipe = Recipe::parse(Path::new("look.toml"), text).unwrap();
        let flags = recipe.flags(&command_named(&recipe.command)).unwrap();
        flags.iter().map(Flag::word).collect()
    }

    fn refusal(text: &str) -> String {
        let refused = Recipe::parse(Path::new("look.toml"), text).unwrap_err();
        refused.to_string()
    }

    #[test]
    fn settings_are_flags() {
        let text = "version = 1\ncommand = \"relight\"\nlight = [[135, 40], \"10,20,1,0.5,0.25\"]\nthin = true\n\
            silhouette = [0.03, 0.04]\nscaling = 1.5\nmaterial = \"phong\"\ncontrast = -0.5\n";
        let mut found = words(text);
        found.sort();
        let expected = [
            "--contrast=-0.5",
            "--light=10,20,1,0.5,0.25",
            "--light=135,40",
            "--material=phong",
            "--scaling=1.5",
            "--silhouette=0.03,0.04",
            "--thin",
        ];
        assert_eq!(found, expected);
        let off = "version = 1\ncommand = \"relight\"\nthin = false";
        assert!(words(off).is_empty());
    }

    #[test]
    fn presets_are_recipes_unless_a_file_has_their_name() {
        for (name, text) in PRESETS {
            let preset = Recipe::read(Path::new(name)).unwrap();
            assert_eq!(preset, Recipe::parse(Path::new(name), text).unwrap());
            let command = if name.ends_with("raking") {
                "relight"
            } else {
                "hatch"
            };
            assert_eq!(preset.command, command, "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        let own = folder.path().join("coin");
        std::fs::write(&own, "version = 1\ncommand = \"shape\"").unwrap();
        assert_eq!(Recipe::read(&own).unwrap().command, "shape");
        let refused = Recipe::read(Path::new("coins")).unwrap_err().to_string();
        assert!(
            refused.contains("no preset; name a recipe, or one of portrait, "),
            "{refused}"
        );
    }

    #[test]
    fn what_is_no_setting_is_refused_with_the_nearest() {
        let of = |line: &str| refusal(&format!("version = 1\ncommand = \"enhance\"\n{line}"));
        assert!(of("scalling = 1").contains("no setting scalling; the nearest is scaling"));
        assert!(of("white_level = 1").contains("the nearest is white-level"));
        assert!(of("threads = 2").contains("threads is for the command line"));
        assert!(of("qqq = 2").contains("see relievo enhance --help"));
        assert!(of("scaling = true").contains("scaling is boolean; write a number"));
        assert!(of("[shape]\nscaling = 1").contains("no setting shape"));
        assert!(of("scaling 1").contains("line 3"));
    }

    #[test]
    fn version_and_command_are_asked_for() {
        assert!(refusal("command = \"enhance\"").contains("has no version; add version = 1"));
        assert!(refusal("version = 9\ncommand = \"enhance\"").contains("use a newer relievo"));
        assert!(refusal("version = 1\ncommand = \"report\"").contains("names no command"));
    }
}
