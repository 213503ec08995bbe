//! The JSON schema of recipes, from the table of parameters and the other flags.

use super::{CHOSEN, FRAMES, VERSION};
use crate::command::commands::{COMMANDS, command_named};
use crate::command::setting::{self, Setting, settings_of};
use crate::params::{Kind, Many, Param};
use clap::Command;
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
    let settings = settings_of(command.get_name()).into_iter();
    let settings = settings.map(|setting| (setting.name.clone(), of_setting(&setting)));
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

fn of_setting(setting: &Setting) -> Value {
    let one = of_value(setting);
    let mut schema = match setting.kind {
        setting::SettingKind::Text {
            is_repeatable: true,
            ..
        } => json!({ "anyOf": [one, { "type": "array", "items": one }] }),
        _ => one,
    };
    schema["description"] = json!(setting.help);
    if let Some(default) = &setting.default {
        schema["default"] = json!(default);
    }
    schema
}

fn of_value(setting: &Setting) -> Value {
    let row = Param::named(&setting.name).map(|row| (row, row.kind, row.many));
    match (&setting.kind, row) {
        (_, Some((row, Kind::Number { whole, word: None }, Many::One))) => of_number(row, whole),
        (setting::SettingKind::Switch, _) => json!({ "type": "boolean" }),
        (setting::SettingKind::Choice(words), _) => json!({ "enum": words }),
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
