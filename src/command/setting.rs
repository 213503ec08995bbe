//! The settings of a command: its parameters from their table, its inputs and outputs from their flags.

use super::commands::command_named;
use super::recipe::{is_repeatable, is_setting, is_switch};
use crate::params::{self, Param, Useful};
use clap::Arg;

/// A setting as a control shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Flag name without dashes.
    pub name: String,
    /// Parameter family.
    pub family: String,
    /// What it does, in a sentence or two.
    pub help: String,
    /// Whether short lists show it.
    pub is_common: bool,
    /// Unit; empty for a plain number.
    pub unit: &'static str,
    /// Default value, if there is one.
    pub default: Option<String>,
    /// How it is chosen.
    pub kind: SettingKind,
}

/// How a setting is chosen.
#[derive(Debug, Clone, PartialEq)]
pub enum SettingKind {
    /// On or off.
    Switch,
    /// One of these words.
    Choice(Vec<String>),
    /// A number, or a word accepted in its place.
    Number {
        /// Range of a slider.
        range: Useful,
        /// Whether it must be a whole number.
        is_whole: bool,
        /// The word.
        word: Option<String>,
    },
    /// Anything else.
    Text {
        /// Form of the text, as in `LO,HI`.
        form: String,
        /// Whether it may be given several times.
        is_repeatable: bool,
    },
}

/// The settings of a command in the order of its help.
pub fn settings_of(command: &str) -> Vec<Setting> {
    let command = command_named(command);
    let args = command.get_arguments().filter(|arg| is_setting(arg));
    args.filter_map(setting).collect()
}

fn setting(arg: &Arg) -> Option<Setting> {
    let name = arg.get_long()?;
    let row = Param::named(name);
    let defaults = arg.get_default_values().iter();
    let defaults: Vec<_> = defaults.map(|v| v.to_string_lossy()).collect();
    let has_default = !defaults.is_empty() && !is_switch(arg);
    let kind = row.and_then(slider).unwrap_or_else(|| kind(arg));
    Some(Setting {
        name: name.into(),
        family: arg.get_help_heading().unwrap_or_default().into(),
        help: arg.get_help().map(ToString::to_string).unwrap_or_default(),
        is_common: !arg.is_hide_short_help_set(),
        unit: row.map_or("", |row| row.unit.suffix()),
        default: has_default.then(|| defaults.join(",")),
        kind,
    })
}

/// A slider, for parameters with a useful range.
fn slider(row: &Param) -> Option<SettingKind> {
    match row.kind {
        params::Kind::Number { whole, word } => Some(SettingKind::Number {
            range: row.useful?,
            is_whole: whole,
            word: word.map(String::from),
        }),
        _ => None,
    }
}

fn kind(arg: &Arg) -> SettingKind {
    if is_switch(arg) {
        return SettingKind::Switch;
    }
    let possible = arg.get_possible_values();
    if !possible.is_empty() {
        let words = possible.iter().map(|value| value.get_name().to_string());
        return SettingKind::Choice(words.collect());
    }
    let forms = arg.get_value_names().unwrap_or_default();
    SettingKind::Text {
        form: forms.first().map_or("", |form| form.as_str()).into(),
        is_repeatable: is_repeatable(arg),
    }
}

#[cfg(test)]
mod tests {
    use super::super::commands::COMMANDS;
    use super::*;

    fn all() -> Vec<Setting> {
        let commands = COMMANDS.iter();
        commands.flat_map(|command| settings_of(command)).collect()
    }

    #[test]
    fn every_parameter_with_a_flag_is_a_setting() {
        let all = all();
        for row in Param::all().iter().filter(|row| row.has_flag()) {
            let setting = all.iter().find(|setting| setting.name == row.name());
            let setting = setting.unwrap_or_else(|| panic!("no command has {}", row.flag));
            assert_eq!(setting.family, row.group.name(), "{}", row.flag);
            let has_slider = matches!(setting.kind, SettingKind::Number { .. });
            assert_eq!(has_slider, row.useful.is_some(), "{}", row.flag);
        }
    }

    #[test]
    fn kinds_follow_the_flags() {
        let all = all();
        let of = |name: &str| all.iter().find(|s| s.name == name).unwrap();
        assert_eq!(of("thin").kind, SettingKind::Switch);
        assert!(matches!(&of("method").kind, SettingKind::Choice(words) if words.len() == 5));
        assert!(matches!(
            &of("light").kind,
            SettingKind::Text {
                is_repeatable: true,
                ..
            }
        ));
        assert_eq!(of("environment-rotate").unit, "\u{b0}");
        assert_eq!(of("scale").unit, "px");
        let SettingKind::Number { is_whole, word, .. } = &of("curvature-gain").kind else {
            panic!("a gain is a number");
        };
        assert_eq!((is_whole, word.as_deref()), (&false, Some("auto")));
    }
}
