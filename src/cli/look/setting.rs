//! The settings of a command, from the tables of its flags.

use super::super::invocation::command_named;
use super::super::recipe::{is_repeatable, is_setting, is_switch};
use super::ranges::{RANGES, Range};
use clap::Arg;
use std::any::TypeId;

/// A setting as a control shows it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Setting {
    /// Its flag, without dashes.
    pub(crate) name: String,
    /// The family it belongs to.
    pub(crate) family: String,
    pub(crate) help: String,
    /// What it is measured in; empty for a plain number.
    pub(crate) unit: &'static str,
    /// Its value where none is given; of some there is none.
    pub(crate) default: Option<String>,
    pub(crate) kind: Kind,
}

/// How a setting is chosen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// On or off.
    Switch,
    /// One of these words.
    Choice(Vec<String>),
    /// A number, or the word that may stand in its place.
    Number {
        range: Range,
        is_whole: bool,
        word: Option<String>,
    },
    /// Anything else.
    Text {
        /// What it looks like: `LO,HI`.
        form: String,
        /// Whether it may be given again.
        is_repeatable: bool,
    },
}

/// The settings of a command in the order of its help.
pub(crate) fn settings_of(command: &str) -> Vec<Setting> {
    let command = command_named(command);
    let args = command.get_arguments().filter(|arg| is_setting(arg));
    args.filter_map(setting).collect()
}

fn setting(arg: &Arg) -> Option<Setting> {
    let name = arg.get_long()?;
    let defaults = arg.get_default_values().iter();
    let defaults: Vec<_> = defaults.map(|v| v.to_string_lossy()).collect();
    let has_default = !defaults.is_empty() && !is_switch(arg);
    let forms = arg.get_value_names().unwrap_or_default();
    let form = forms.first().map_or("", |form| form.as_str());
    Some(Setting {
        name: name.into(),
        family: arg.get_help_heading().unwrap_or_default().into(),
        help: arg.get_help().map(ToString::to_string).unwrap_or_default(),
        unit: unit_of(form),
        default: has_default.then(|| defaults.join(",")),
        kind: kind(arg, name, form),
    })
}

fn kind(arg: &Arg, name: &str, form: &str) -> Kind {
    if is_switch(arg) {
        return Kind::Switch;
    }
    let possible = arg.get_possible_values();
    if !possible.is_empty() {
        let words = possible.iter().map(|value| value.get_name().to_string());
        return Kind::Choice(words.collect());
    }
    match RANGES.iter().find(|range| range.name == name) {
        Some(&range) => Kind::Number {
            range,
            is_whole: is_whole(arg, form),
            word: word_of(form),
        },
        None => Kind::Text {
            form: form.into(),
            is_repeatable: is_repeatable(arg),
        },
    }
}

/// Whether only whole numbers will do: what is called N, or is parsed as one.
fn is_whole(arg: &Arg, form: &str) -> bool {
    let parsed = arg.get_value_parser().type_id();
    let is_integer = [TypeId::of::<u32>(), TypeId::of::<u64>()]
        .into_iter()
        .any(|integer| parsed == integer);
    let counts = form == "N|auto" || matches!(form, "PX|none" | "PX|auto");
    is_integer || counts
}

/// The word of `PX|auto` that stands in place of a number.
fn word_of(form: &str) -> Option<String> {
    let words = form.split('|');
    let mut words = words.filter(|word| word.chars().all(|c| c.is_ascii_lowercase()));
    words.next().map(String::from)
}

/// The unit that `PX|auto` names.
fn unit_of(form: &str) -> &'static str {
    let first = form.split(['|', ',', '[']).next();
    match first {
        Some("PX") => "px",
        Some("DEG" | "AZ") => "\u{b0}",
        Some("PPI") => "per inch",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::super::Look;
    use super::*;
    use crate::cli::args::Command;
    use crate::cli::frames::validate;

    fn all() -> Vec<Setting> {
        let commands = Look::commands().iter();
        commands.flat_map(|command| settings_of(command)).collect()
    }

    #[test]
    fn every_range_is_of_a_setting_and_holds_its_default() {
        let all = all();
        for range in RANGES {
            let setting = all.iter().find(|setting| setting.name == range.name);
            let setting = setting.unwrap_or_else(|| panic!("no command has {}", range.name));
            assert!(range.from < range.to, "{}", range.name);
            assert!(!range.is_logarithmic || range.from > 0.0, "{}", range.name);
            let default = setting.default.as_deref();
            let Some(Ok(number)) = default.map(str::parse::<f64>) else {
                continue;
            };
            let holds = (range.from..=range.to).contains(&number);
            assert!(holds, "{} is {number} by default", range.name);
        }
    }

    #[test]
    fn both_ends_of_every_slider_are_taken() {
        for &command in Look::commands() {
            for setting in settings_of(command) {
                let Kind::Number { range, word, .. } = &setting.kind else {
                    continue;
                };
                let ends = [range.from, range.to].map(|end| end.to_string());
                for value in ends.into_iter().chain(word.clone()) {
                    let mut look = Look::default();
                    look.set_command(command);
                    look.set(&setting.name, Some(value.clone()));
                    let parsed = look.parse(std::path::Path::new("render.exr")).unwrap();
                    let valid = match &parsed.cli.command {
                        Command::Shape(args) => validate(args),
                        Command::Enhance(args) => validate(args),
                        Command::Relight(args) => validate(&**args),
                        Command::Hatch(args) => validate(&**args),
                        _ => unreachable!("a look is none of these"),
                    };
                    let name = &setting.name;
                    assert!(valid.is_ok(), "{command} --{name} {value}: {valid:?}");
                }
            }
        }
    }

    #[test]
    fn kinds_follow_the_flags() {
        let all = all();
        let of = |name: &str| all.iter().find(|s| s.name == name).unwrap();
        assert_eq!(of("thin").kind, Kind::Switch);
        assert!(matches!(&of("method").kind, Kind::Choice(words) if words.len() == 4));
        assert!(matches!(
            &of("light").kind,
            Kind::Text {
                is_repeatable: true,
                ..
            }
        ));
        assert_eq!(of("environment-rotate").unit, "\u{b0}");
        assert_eq!(of("scale").unit, "px");
        let Kind::Number { is_whole, word, .. } = &of("curvature-gain").kind else {
            panic!("a gain is a number");
        };
        assert_eq!((is_whole, word.as_deref()), (&false, Some("auto")));
    }
}
