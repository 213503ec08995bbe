//! Flags of parameters, generated from the parameter table, and flags as typed.

use crate::error::{Result, bad};
use crate::params::table::rows;
use crate::params::{Choice, Kind, Many, Param, Parameters, Params, Scale, Style, check_scales};
use clap::builder::{PossibleValuesParser, ValueParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A flag with its value: `--name=value`; without one, a switch.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Flag {
    name: String,
    value: Option<String>,
}

impl Flag {
    pub(crate) fn new(name: impl Into<String>, value: impl ToString) -> Self {
        Self {
            name: name.into(),
            value: Some(value.to_string()),
        }
    }

    pub(crate) fn switch(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            value: None,
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn value(&self) -> Option<&str> {
        self.value.as_deref()
    }

    /// The flag as typed on a command line.
    pub(crate) fn word(&self) -> OsString {
        match &self.value {
            Some(value) => format!("--{}={value}", self.name).into(),
            None => format!("--{}", self.name).into(),
        }
    }
}

/// Parameters of a command line, and the flags that go beyond them.
#[derive(Debug, Clone)]
pub(crate) struct Flags {
    pub(crate) params: Params,
    /// All sigmas of `--scale`, unless they are mixed.
    scales: Vec<f32>,
    /// All weights of `--sum`, of a picture of light or a drawing.
    sum: Vec<f32>,
    /// Whether a picture of light shows all scales added up.
    is_light: bool,
    /// All radii of `--occlusion-radius`.
    pub(crate) radii: Vec<f32>,
    /// The folder given to `--style`.
    pub(super) folder_of_strokes: Option<PathBuf>,
}

impl Flags {
    /// Sigmas of the scales after the first.
    pub(crate) fn more_scales(&self) -> &[f32] {
        self.scales.get(1..).unwrap_or(&[])
    }

    /// Refuses parameters outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub(crate) fn validate(&self) -> Result<()> {
        check_scales(self.scales.len())?;
        if !self.sum.is_empty() && !self.is_light {
            let found = "is of a picture of light, and a drawing shows one scale";
            return Err(bad("--sum", found, "leave it out"));
        }
        if !self.sum.is_empty() {
            let count = match self.scales.is_empty() {
                true => self.params.shape.scale.weighted().count().max(1),
                false => self.scales.len(),
            };
            weights_for(&self.sum, count)?;
        }
        self.params.validate()
    }

    /// Refuses several scales where only one result is made.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the flag that takes several.
    pub(crate) fn refuse_more_scales(&self) -> Result<()> {
        if self.more_scales().is_empty() {
            return Ok(());
        }
        Err(bad(
            "--scale",
            "names several scales",
            "give one, or write the layers of all with `shape` to an .exr; `enhance` and `relight` mix up to four",
        ))
    }
}

/// The weights of so many scales, of one for each or one for all.
///
/// # Errors
/// [`Error::BadParameter`] for another number of weights, and for those that add up to nothing.
pub(crate) fn weights_for(sum: &[f32], scales: usize) -> Result<Vec<f32>> {
    let weights = match sum {
        [one] => vec![*one; scales],
        _ if sum.len() == scales => sum.to_vec(),
        _ => {
            let found = format!("has {} weights for {scales} scales", sum.len());
            return Err(bad(
                "--sum",
                found,
                "give one for each scale, or one for all",
            ));
        }
    };
    let total: f32 = weights.iter().map(|weight| weight.abs()).sum();
    if !(total > 0.0 && total.is_finite()) {
        let found = "has weights that add up to nothing".to_string();
        return Err(bad(
            "--sum",
            found,
            "give finite numbers, not all of them 0",
        ));
    }
    Ok(weights)
}

rows! {
    /// The weights of scales in one picture of light.
    #[derive(Debug, Clone)]
    pub(crate) struct SumFlag {
        /// Weights of the scales of --scale 2,12 in the picture, beside their sizes: one for each, or one for all.
        _sum: Vec<f32> =
            [hide_short_help = true, id = "sum", long = "sum", value_name = "WEIGHT,..", value_delimiter = ',', allow_hyphen_values = true, help_heading = "Shape"];
    }
}

impl FromArgMatches for Flags {
    /// Reads every parameter that the command has, whichever section declares it.
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut params = Params::default();
        for row in Param::all() {
            if let Some(values) = values(matches, row.name()) {
                // Of several values of one number the first is the parameter.
                let is_number = matches!(row.kind, Kind::Number { .. });
                let first = &values[..values.len().min(1)];
                let of_row = if is_number { first } else { &values[..] };
                let set = params.set(row.name(), &of_row.join(","));
                set.map_err(|expected| clap::Error::raw(ErrorKind::ValueValidation, expected))?;
            }
        }
        let numbers = |name: &str| -> Vec<f32> {
            let values = values(matches, name).unwrap_or_default();
            values
                .iter()
                .filter_map(|value| value.parse().ok())
                .collect()
        };
        let mut scales = numbers("scale");
        // One picture of light shows several scales mixed; a drawing has strokes, too.
        let has_light = values(matches, "scaling").is_some();
        let is_light = has_light && values(matches, "style").is_none();
        let sum = if has_light {
            numbers("sum")
        } else {
            Vec::new()
        };
        if is_light && scales.len() > 1 {
            let even = [1.0];
            let weights = if sum.is_empty() { &even[..] } else { &sum };
            let weights = weights_for(weights, scales.len()).unwrap_or_default();
            let mixed: Vec<_> = scales.iter().copied().zip(weights).collect();
            if let Some(mixed) = Scale::mixed(&mixed) {
                params.shape.scale = mixed;
                scales.clear();
            }
        }
        let style =
            values(matches, "style").filter(|_| params.line.strokes.style == Style::Pictures);
        Ok(Self {
            params,
            scales,
            sum,
            is_light,
            radii: numbers("occlusion-radius"),
            folder_of_strokes: style.and_then(|style| style.last().map(PathBuf::from)),
        })
    }

    fn update_from_arg_matches(
        &mut self,
        matches: &ArgMatches,
    ) -> std::result::Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Flags {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

/// Values of the argument `name`, given or default; `None` if the command has no such argument.
fn values(matches: &ArgMatches, name: &str) -> Option<Vec<String>> {
    let values = matches.try_get_raw(name).ok()??;
    Some(
        values
            .map(|value| value.to_string_lossy().into_owned())
            .collect(),
    )
}

/// Marks where the flags of one parameter group stand among a command's flags.
#[derive(Debug, Clone)]
pub(super) struct Section<const GROUP: u8>;

impl<const GROUP: u8> Args for Section<GROUP> {
    fn augment_args(command: Command) -> Command {
        let rows = Param::all()
            .iter()
            .filter(|row| row.has_flag() && row.group as u8 == GROUP);
        command.args(rows.map(|row| arg(row)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const GROUP: u8> FromArgMatches for Section<GROUP> {
    fn from_arg_matches(_: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        Ok(Self)
    }

    fn update_from_arg_matches(&mut self, _: &ArgMatches) -> std::result::Result<(), clap::Error> {
        Ok(())
    }
}

/// The flag of a parameter.
fn arg(row: &'static Param) -> Arg {
    let arg = Arg::new(row.name())
        .long(row.name())
        .visible_aliases(row.alias)
        .help(row.help())
        .help_heading(row.group.name())
        .hide_short_help(!row.common)
        .conflicts_with_all(row.rival);
    if row.kind == Kind::Switch {
        return arg.action(ArgAction::SetTrue);
    }
    let arg = arg
        .value_name(row.form)
        .value_parser(value_parser(row))
        .allow_negative_numbers(matches!(row.kind, Kind::Number { .. } | Kind::Text));
    let arg = match row.many {
        Many::One => arg,
        Many::Listed => arg.action(ArgAction::Append).value_delimiter(','),
        Many::Repeated => arg.action(ArgAction::Append),
    };
    match (row.default)() {
        Some(default) => arg.default_value(default),
        None => arg,
    }
}

/// Parser for the values of a parameter.
fn value_parser(row: &'static Param) -> ValueParser {
    match row.kind {
        Kind::Choice(all) => PossibleValuesParser::new(all.iter().map(|choice| choice.name)).into(),
        Kind::ChoiceOrFolder(all) => ValueParser::new(move |text: &str| named_or_folder(all, text)),
        _ => ValueParser::new(move |text: &str| (row.parse)(text).map(|()| text.to_string())),
    }
}

fn named_or_folder(all: &[Choice], text: &str) -> std::result::Result<String, String> {
    let names: Vec<_> = all.iter().map(|choice| choice.name).collect();
    match names.contains(&text) || Path::new(text).is_dir() {
        true => Ok(text.into()),
        false => Err(format!(
            "expected {} or a folder of pictures of strokes",
            names.join(", ")
        )),
    }
}
