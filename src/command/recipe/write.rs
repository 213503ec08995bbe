//! From flags to TOML.

use super::{CHOSEN, FRAMES, VERSION, frames_of, is_repeatable, is_setting, is_switch};
use crate::command::chosen::Chosen;
use crate::command::commands::{command_named, long, typed_ids};
use crate::command::flags::Flag;
use clap::{Arg, ArgMatches};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Value;

/// The settings of a command line, to be written with the automatic choices.
#[derive(Debug, Clone)]
pub(crate) struct RecipeText {
    command: String,
    /// As they were typed.
    settings: Vec<Flag>,
    /// The frames the choices are for, by file name.
    frames: String,
    /// Choices made for all frames.
    chosen: Vec<Flag>,
}

impl RecipeText {
    /// The settings typed for the command of `matches`. Those in `kept`, which another recipe had chosen, are listed
    /// apart.
    pub(crate) fn of(matches: &ArgMatches, kept: &[Flag]) -> Self {
        let (name, matches) = matches.subcommand().expect("a command was parsed");
        let command = command_named(name);
        let typed: Vec<&str> = typed_ids(matches).collect();
        let args = command.get_arguments();
        let args = args.filter(|arg| is_setting(arg) && typed.contains(&arg.get_id().as_str()));
        let settings = args.flat_map(|arg| flags_of(arg, matches));
        let is_kept = |flag: &Flag| kept.iter().any(|kept| kept.name() == flag.name());
        let input = matches.try_get_raw("input").ok().flatten();
        Self {
            settings: settings.filter(|flag| !is_kept(flag)).collect(),
            command: name.to_string(),
            frames: input
                .and_then(Iterator::last)
                .map(|input| frames_of(Path::new(input)))
                .unwrap_or_default(),
            chosen: kept.to_vec(),
        }
    }

    /// The settings that were typed.
    pub(crate) fn settings(&self) -> &[Flag] {
        &self.settings
    }

    /// The name of its command.
    #[cfg(feature = "host")]
    pub(crate) fn command(&self) -> &str {
        &self.command
    }

    /// Adds the choices made for all frames.
    pub(crate) fn choosing(mut self, chosen: Vec<Flag>) -> Self {
        self.chosen.extend(chosen);
        self
    }

    /// The recipe text, with the choices in `chosen` for settings it leaves open in a separate table.
    pub(crate) fn with(&self, chosen: &Chosen) -> String {
        let mut text = format!("version = {VERSION}\ncommand = \"{}\"\n", self.command);
        let settings = self.values(&self.settings);
        // Choices for all frames override those for this one.
        let mut open = self.values(&chosen.flags());
        open.extend(self.values(&self.chosen));
        open.retain(|name, _| !settings.contains_key(name));
        for (name, value) in &settings {
            text.push_str(&format!("{name} = {value}\n"));
        }
        if !open.is_empty() {
            let frames = Value::String(self.frames.clone());
            text.push_str(&format!("\n[{CHOSEN}]\n{FRAMES} = {frames}\n"));
        }
        for (name, value) in open {
            text.push_str(&format!("{name} = {value}\n"));
        }
        text
    }

    /// Flags that the command has by name, in TOML.
    fn values(&self, flags: &[Flag]) -> BTreeMap<String, Value> {
        let command = command_named(&self.command);
        let by_name = flags.chunk_by(|a, b| a.name() == b.name());
        let values = by_name.filter_map(|flags| {
            let name = flags[0].name();
            let arg = long(&command, name).filter(|arg| is_setting(arg))?;
            let mut values = flags.iter().filter_map(Flag::value).map(typed_value);
            let value = match is_repeatable(arg) {
                true => Value::Array(values.collect()),
                false => values.next_back().unwrap_or(Value::Boolean(true)),
            };
            Some((name.to_string(), value))
        });
        values.collect()
    }
}

/// The flags typed for one argument, the last of those that count once.
fn flags_of(arg: &Arg, matches: &ArgMatches) -> Vec<Flag> {
    let name = arg.get_long().expect("a setting has a name");
    if is_switch(arg) {
        return vec![Flag::switch(name)];
    }
    let typed = matches.get_raw_occurrences(arg.get_id().as_str());
    let mut flags: Vec<Flag> = typed
        .into_iter()
        .flatten()
        .map(|values| {
            let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
            Flag::new(name, values.join(","))
        })
        .collect();
    if !is_repeatable(arg) {
        flags.drain(..flags.len().saturating_sub(1));
    }
    flags
}

/// A TOML number if the text is one.
fn typed_value(text: &str) -> Value {
    let is_plain = |number: &f64| number.is_finite() && number.to_string() == text;
    match (text.parse::<i64>(), text.parse::<f64>()) {
        (Ok(number), _) if number.to_string() == text => Value::Integer(number),
        (_, Ok(number)) if is_plain(&number) => Value::Float(number),
        _ => Value::String(text.into()),
    }
}
