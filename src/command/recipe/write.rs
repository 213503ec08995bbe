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
    settings: BTreeMap<String, Value>,
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
        let is_kept = |name: &str| kept.iter().any(|flag| flag.name() == name);
        let args = command.get_arguments();
        let args = args.filter(|arg| is_setting(arg) && typed.contains(&arg.get_id().as_str()));
        let settings = args.map(|arg| {
            let name = arg.get_long().expect("a setting has a name");
            (name.to_string(), value(arg, matches))
        });
        let input = matches.get_raw("input").and_then(Iterator::last);
        Self {
            settings: settings.filter(|(name, _)| !is_kept(name)).collect(),
            command: name.to_string(),
            frames: input
                .map(|input| frames_of(Path::new(input)))
                .unwrap_or_default(),
            chosen: kept.to_vec(),
        }
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
        for (name, value) in &self.settings {
            text.push_str(&format!("{name} = {value}\n"));
        }
        let chosen = self.chosen_values(chosen);
        if !chosen.is_empty() {
            let frames = Value::String(self.frames.clone());
            text.push_str(&format!("\n[{CHOSEN}]\n{FRAMES} = {frames}\n"));
        }
        for (name, value) in chosen {
            text.push_str(&format!("{name} = {value}\n"));
        }
        text
    }

    /// Automatic choices by setting name, without the settings that were typed.
    fn chosen_values(&self, chosen: &Chosen) -> BTreeMap<String, Value> {
        let command = command_named(&self.command);
        let mut found = BTreeMap::new();
        let of_frame = chosen.flags();
        // Choices for all frames override those for this one.
        for flags in [&of_frame, &self.chosen] {
            for flags in flags.chunk_by(|a, b| a.name() == b.name()) {
                let name = flags[0].name();
                let arg = long(&command, name).filter(|arg| is_setting(arg));
                let Some(arg) = arg.filter(|_| !self.settings.contains_key(name)) else {
                    continue;
                };
                let mut values = flags.iter().filter_map(Flag::value).map(typed_value);
                let value = match is_repeatable(arg) {
                    true => Value::Array(values.collect()),
                    false => values.next_back().unwrap_or(Value::Boolean(true)),
                };
                found.insert(name.to_string(), value);
            }
        }
        found
    }
}

/// The value typed for one argument.
fn value(arg: &Arg, matches: &ArgMatches) -> Value {
    if is_switch(arg) {
        return Value::Boolean(true);
    }
    let occurrences = matches.get_raw_occurrences(arg.get_id().as_str());
    let mut occurrences = occurrences.into_iter().flatten().map(|values| {
        let values: Vec<_> = values.map(|v| v.to_string_lossy()).collect();
        typed_value(&values.join(","))
    });
    match is_repeatable(arg) {
        true => Value::Array(occurrences.collect()),
        false => occurrences.next_back().unwrap_or(Value::Boolean(true)),
    }
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
