//! The JSON schema of recipes, from the table of parameters and the other flags.

use super::{CHOSEN, COMMANDS, FRAMES, VERSION, is_repeatable, is_setting, is_switch};
use crate::command::commands::command_named;
use crate::params::{Kind, Many, Param, param};
use clap::{Arg, Command};
use serde_json::{Map, Value, json};

/// The schema of all recipes: one object for each command.
pub(crate) fn schema() -> Value {
    let commands: Vec<Value> = COMMANDS
        .iter()
        .map(|name| of_command(&command_named(name)))
        .collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "relievo recipe",
        "oneOf": commands,
    })
}

fn of_command(command: &Command) -> Value {
    let mut properties = Map::new();
    properties.insert("version".into(), json!({ "const": VERSION }));
    properties.insert("command".into(), json!({ "const": command.get_name() }));
    let settings = command.get_arguments().filter(|arg| is_setting(arg));
    let settings = settings.filter_map(|arg| Some((arg.get_long()?.into(), of_setting(arg))));
    let settings: Map<String, Value> = settings.collect();
    let mut chosen = settings.clone();
    let frames = "the frames that it is for, by the name of their files, `#` for the number";
    chosen.insert(
        FRAMES.into(),
        json!({ "type": "string", "description": frames }),
    );
    properties.extend(settings);
    properties.insert(
        CHOSEN.into(),
        json!({
            "type": "object",
            "description": "what was chosen automatically, and is taken for the same frames alone",
            "properties": chosen,
            "additionalProperties": false,
        }),
    );
    json!({
        "type": "object",
        "title": command.get_name(),
        "description": command.get_about().map(ToString::to_string),
        "properties": properties,
        "required": ["version", "command"],
        "additionalProperties": false,
    })
}

fn of_setting(arg: &Arg) -> Value {
    let one = of_value(arg);
    let mut schema = match is_repeatable(arg) {
        true => json!({ "anyOf": [one, { "type": "array", "items": one }] }),
        false => one,
    };
    let mut say = |name: &str, value: Option<String>| {
        if let (Some(value), Some(schema)) = (value, schema.as_object_mut()) {
            schema.insert(name.into(), value.into());
        }
    };
    say("description", arg.get_help().map(ToString::to_string));
    let defaults = arg.get_default_values().iter();
    let defaults: Vec<_> = defaults.map(|v| v.to_string_lossy()).collect();
    let shown = !defaults.is_empty() && !arg.is_hide_default_value_set();
    say(
        "default",
        shown
            .then(|| defaults.join(","))
            .filter(|_| !is_switch(arg)),
    );
    schema
}

fn of_value(arg: &Arg) -> Value {
    if is_switch(arg) {
        return json!({ "type": "boolean" });
    }
    let possible = arg.get_possible_values();
    if !possible.is_empty() {
        let names: Vec<_> = possible.iter().map(|value| value.get_name()).collect();
        return json!({ "enum": names });
    }
    let row = arg.get_long().and_then(param);
    match row.map(|row| (row, row.kind, row.many)) {
        Some((row, Kind::Number { whole, word: None }, Many::One)) => of_number(row, whole),
        _ => json!({ "type": ["string", "number", "array"] }),
    }
}

/// Schema of a number within its range.
fn of_number(row: &Param, whole: bool) -> Value {
    let mut schema = match whole {
        true => json!({ "type": "integer", "minimum": 0 }),
        false => json!({ "type": "number" }),
    };
    let ends = [("minimum", row.valid.start()), ("maximum", row.valid.end())];
    for (name, end) in ends.into_iter().filter(|(_, end)| end.is_finite()) {
        schema[name] = match whole {
            true => json!(*end as i64),
            // Only the digits of single precision.
            false => json!(end.to_string().parse::<f64>().unwrap_or(f64::from(*end))),
        };
    }
    schema
}
