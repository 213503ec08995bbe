//! From flags to TOML.

use super::{VERSION, is_repeatable, is_setting, is_switch};
use crate::command::chosen::Chosen;
use crate::command::commands::{command_named, long, typed_ids};
use crate::command::flags::Flag;
use clap::{Arg, ArgMatches};
use std::collections::BTreeMap;
use toml::Value;

/// The settings of a command line, to be written with what was chosen.
#[derive(Debug, Clone)]
pub(crate) struct RecipeText {
    command: String,
    settings: BTreeMap<String, Value>,
}

impl RecipeText {
    /// The settings that were typed for the command of `matches`.
    pub(crate) fn of(matches: &ArgMatches) -> Self {
        let (name, matches) = matches.subcommand().expect("a command was parsed");
        let command = command_named(name);
        let typed: Vec<&str> = typed_ids(matches).collect();
        let args = command.get_arguments();
        let args = args.filter(|arg| is_setting(arg) && typed.contains(&arg.get_id().as_str()));
        let settings = args.map(|arg| {
            let name = arg.get_long().expect("a setting has a name");
            (name.to_string(), value(arg, matches))
        });
        Self {
            settings: settings.collect(),
            command: name.to_string(),
        }
    }

    /// The recipe with what was `chosen` in place of what was left open.
    pub(crate) fn with(&self, chosen: &Chosen) -> String {
        let command = command_named(&self.command);
        let mut settings = self.settings.clone();
        let flags = chosen.flags();
        for flags in flags.chunk_by(|a, b| a.name() == b.name()) {
            let name = flags[0].name();
            let Some(arg) = long(&command, name).filter(|arg| is_setting(arg)) else {
                continue;
            };
            let mut values = flags.iter().filter_map(Flag::value).map(typed_value);
            let value = match is_repeatable(arg) {
                true => Value::Array(values.collect()),
                false => values.next_back().unwrap_or(Value::Boolean(true)),
            };
            settings.insert(name.to_string(), value);
        }
        let mut text = format!("version = {VERSION}\ncommand = \"{}\"\n", self.command);
        for (name, value) in &settings {
            text.push_str(&format!("{name} = {value}\n"));
        }
        text
    }
}

/// What was typed for one argument.
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

/// A number where the text is one.
fn typed_value(text: &str) -> Value {
    let is_plain = |number: &f64| number.is_finite() && number.to_string() == text;
    match (text.parse::<i64>(), text.parse::<f64>()) {
        (Ok(number), _) if number.to_string() == text => Value::Integer(number),
        (_, Ok(number)) if is_plain(&number) => Value::Float(number),
        _ => Value::String(text.into()),
    }
}
