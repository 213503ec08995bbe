//! The parameter table. Each row is written once, where [`params!`] defines its struct, and yields the field, its
//! default, its range check, the flag with its help, the recipe key and schema, and the viewer's control.

use crate::error::{Error, Result, short};
use std::ops::RangeInclusive;

/// One parameter, described for any user interface: a command line, a window, a plugin.
#[derive(Debug, Clone)]
pub struct Param {
    /// The command-line flag, `--stroke-width`; the field name for library-only parameters.
    pub flag: &'static str,
    /// A more descriptive name, without dashes, where the flag resembles another.
    pub alias: Option<&'static str>,
    /// Whether most users want to know of it: short lists show it, long ones all.
    pub common: bool,
    /// The group in help and in the viewer.
    pub group: Group,
    /// The kind of value.
    pub kind: Kind,
    /// Whether it takes several values.
    pub many: Many,
    /// The unit of its values.
    pub unit: Unit,
    /// The form of a value in help: `PX`, `LO,HI`, `K|auto`.
    pub form: &'static str,
    /// Values outside are refused.
    pub valid: RangeInclusive<f32>,
    /// The reason for the limit, quoted in error messages.
    pub why: Option<&'static str>,
    /// Range of a slider; values beyond can be typed.
    pub useful: Option<Useful>,
    /// A parameter that cannot be combined with it.
    pub rival: Option<&'static str>,
    /// Lines of documentation: a paragraph for users, then paragraphs for engineers.
    pub doc: &'static [&'static str],
    /// The default as typed; `None` where omission means something that no value expresses.
    pub default: fn() -> Option<String>,
    /// Validates a text as a value.
    pub parse: fn(&str) -> std::result::Result<(), String>,
}

/// The kind of value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// On or off.
    Switch,
    /// One of these words.
    Choice(&'static [Choice]),
    /// One of these words, or a folder.
    ChoiceOrFolder(&'static [Choice]),
    /// A number, or a word accepted in its place.
    Number {
        /// Whether it must be a whole number.
        whole: bool,
        /// The accepted word, such as `auto`.
        word: Option<&'static str>,
    },
    /// Two numbers separated by a comma.
    Pair,
    /// Any other text, in the form given by its row.
    Text,
}

/// One of the words a parameter accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The word as typed.
    pub name: &'static str,
    /// Lines of documentation.
    pub doc: &'static [&'static str],
}

/// Whether a parameter takes several values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Many {
    /// One value.
    One,
    /// Several, separated by commas.
    Listed,
    /// The flag may be given several times.
    Repeated,
}

/// The unit of a parameter's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Dimensionless: factors, shares, exponents, counts.
    One,
    /// Pixels.
    Pixels,
    /// Degrees.
    Degrees,
    /// Pixels per inch.
    PerInch,
    /// Millimetres.
    Millimetres,
}

impl Unit {
    /// The suffix of a number.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Pixels => "px",
            Self::Degrees => "\u{b0}",
            Self::PerInch => "per inch",
            Self::Millimetres => "mm",
        }
    }
}

/// The range of a slider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Useful {
    /// Its lower end.
    pub from: f64,
    /// Its upper end.
    pub to: f64,
    /// Whether equal distances on the slider are equal factors.
    pub logarithmic: bool,
}

/// Groups of parameters, as headings in help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Shape analysis.
    Shape,
    /// Height and occlusion.
    Relief,
    /// Layers of light that are scaled separately.
    LightLayers,
    /// Lights.
    Light,
    /// Light warping.
    Warping,
    /// Radiance scaling.
    Scaling,
    /// White levels of radiance scaling.
    WhiteLevels,
    /// Mapping to a display.
    Display,
    /// Size on paper.
    Print,
    /// Material.
    Material,
    /// Mirrors and lenses.
    Specular,
    /// Tone.
    Tone,
    /// Stroke directions.
    Directions,
    /// Stroke style and size.
    Strokes,
    /// Contours and interior lines.
    Contours,
}

impl Group {
    /// Its heading in help.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shape => "Shape",
            Self::Relief => "Height and occlusion",
            Self::LightLayers => "Light layers",
            Self::Light => "Light",
            Self::Warping => "Light warping",
            Self::Scaling | Self::WhiteLevels => "Radiance scaling",
            Self::Display => "Display",
            Self::Print => "Output",
            Self::Material => "Material",
            Self::Specular => "Mirrors and lenses",
            Self::Tone => "Tone",
            Self::Directions => "Directions",
            Self::Strokes => "Strokes",
            Self::Contours => "Contours",
        }
    }
}

/// A slider with a linear scale.
pub(super) const fn even(from: f64, to: f64) -> Option<Useful> {
    Some(Useful {
        from,
        to,
        logarithmic: false,
    })
}

/// A slider with a logarithmic scale.
pub(super) const fn by_factors(from: f64, to: f64) -> Option<Useful> {
    Some(Useful {
        from,
        to,
        logarithmic: true,
    })
}

impl Param {
    /// A row with these columns and defaults for all others.
    pub(super) const fn new(
        field: &'static str,
        group: Group,
        kind: Kind,
        doc: &'static [&'static str],
        default: fn() -> Option<String>,
        parse: fn(&str) -> std::result::Result<(), String>,
    ) -> Self {
        Self {
            flag: field,
            alias: None,
            common: false,
            group,
            kind,
            many: Many::One,
            unit: Unit::One,
            form: "",
            valid: f32::NEG_INFINITY..=f32::INFINITY,
            why: None,
            useful: None,
            rival: None,
            doc,
            default,
            parse,
        }
    }

    /// The recipe key: the flag without its dashes.
    pub fn name(&self) -> &'static str {
        self.flag.trim_start_matches("--")
    }

    /// Whether it is available on the command line and in recipes.
    pub fn has_flag(&self) -> bool {
        self.flag.starts_with("--")
    }

    /// One line of help without a full stop.
    pub fn help(&self) -> String {
        let lines = self.doc.iter().map(|line| line.trim());
        let first: Vec<_> = lines.take_while(|line| !line.is_empty()).collect();
        let text = first.join(" ");
        text.strip_suffix('.').unwrap_or(&text).into()
    }

    /// The word accepted in place of a number.
    pub fn word(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Number { word, .. } => word,
            _ => None,
        }
    }

    /// Whether its values are whole numbers.
    pub fn is_whole(&self) -> bool {
        matches!(self.kind, Kind::Number { whole: true, .. })
    }

    /// Refuses a value with a number `outside` the range.
    pub(super) fn check(&self, outside: Option<String>) -> Result<()> {
        outside.map_or(Ok(()), |number| Err(self.out_of_range(&number)))
    }

    fn out_of_range(&self, number: &str) -> Error {
        let (from, to) = (short(*self.valid.start()), *self.valid.end());
        let remedy = match self.kind {
            _ if to.is_infinite() => format!("give {from} or more"),
            Kind::Number {
                whole: true,
                word: Some(word),
            } => format!(
                "give a whole number from {from} to {}, or {word}",
                short(to)
            ),
            _ => format!("give {from} to {}", short(to)),
        };
        let why = self.why.map_or(String::new(), |why| format!(": {why}"));
        Error::BadParameter {
            name: self.flag,
            found: format!("is {number}"),
            remedy: remedy + &why,
        }
    }
}

/// A struct of parameters, or a value composed of several parameters.
pub trait Parameters: Sized {
    /// The default values.
    fn usual() -> Self;

    /// Appends its rows in order.
    fn rows(table: &mut Vec<&'static Param>);

    /// Sets the parameter `name` from `text`, several values separated by commas. `false` if there is no such
    /// parameter.
    ///
    /// # Errors
    /// The accepted values, if `text` is not one.
    fn set(&mut self, name: &str, text: &str) -> std::result::Result<bool, String>;

    /// Refuses values outside their ranges, and contradictions between values.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    fn check(&self) -> Result<()>;
}

/// Defines a struct of parameters. A field with a default is a row; the columns after it override the defaults of
/// [`Param`], and the first paragraph of its doc comment is its help. A field without a default is a nested struct of
/// rows. `relations` checks constraints between parameters.
macro_rules! params {
    (
        $(#[$meta:meta])*
        pub struct $name:ident in $group:ident {
            $(
                $(#[doc = $doc:literal])*
                $field:ident: $type:ty $(= $default:expr $(, $key:ident: $value:expr)*)?;
            )*
        }
        $(relations $relations:path;)?
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: params!(@default $type $(= $default)?),)* }
            }
        }

        impl $name {
            /// Refuses values outside their ranges, and contradictions between values.
            ///
            /// # Errors
            /// [`crate::Error::BadParameter`] naming the first one.
            pub fn validate(&self) -> crate::error::Result<()> {
                $crate::params::Parameters::check(self)
            }
        }

        const _: () = {
            use $crate::params::{Param, Parameters};

            $(params!(@row $group $field [$($doc)*] $type $(= $default $(, $key: $value)*)?);)*

            impl Parameters for $name {
                fn usual() -> Self {
                    Self::default()
                }

                fn rows(table: &mut Vec<&'static Param>) {
                    $(params!(@list table $field $type $(= $default)?);)*
                }

                fn set(&mut self, name: &str, text: &str) -> std::result::Result<bool, String> {
                    $(params!(@set self name text $field $(= $default)?);)*
                    Ok(false)
                }

                fn check(&self) -> crate::error::Result<()> {
                    $(params!(@check self $field $(= $default)?);)*
                    $($relations(self)?;)?
                    Ok(())
                }
            }
        };
    };

    (@default $type:ty = $default:expr) => { $default };
    (@default $type:ty) => { <$type as $crate::params::Parameters>::usual() };

    (@row $group:ident $field:ident [$($doc:literal)*] $type:ty = $default:expr $(, $key:ident: $value:expr)*) => {
        #[allow(non_upper_case_globals, reason = "a row is called after its field")]
        static $field: $crate::params::Param = $crate::params::Param {
            $($key: $value,)*
            ..$crate::params::Param::new(
                stringify!($field),
                $crate::params::Group::$group,
                <$type as $crate::params::value::Value>::KIND,
                &[$($doc),*],
                || <$type as $crate::params::value::Value>::text(&$default, &$field),
                |text| <$type as $crate::params::value::Value>::parse(text, &$field).map(drop),
            )
        };
    };
    (@row $group:ident $field:ident [$($doc:literal)*] $type:ty) => {};

    (@list $table:ident $field:ident $type:ty = $default:expr) => { $table.push(&$field) };
    (@list $table:ident $field:ident $type:ty) => { <$type as Parameters>::rows($table) };

    (@set $this:ident $name:ident $text:ident $field:ident = $default:expr) => {
        if $name == $field.name() {
            $this.$field = $crate::params::value::Value::parse($text, &$field)?;
            return Ok(true);
        }
    };
    (@set $this:ident $name:ident $text:ident $field:ident) => {
        if Parameters::set(&mut $this.$field, $name, $text)? {
            return Ok(true);
        }
    };

    (@check $this:ident $field:ident = $default:expr) => {
        $field.check($crate::params::value::Value::outside(&$this.$field, &$field))?
    };
    (@check $this:ident $field:ident) => { Parameters::check(&$this.$field)? };
}

/// Defines a struct of inputs, outputs or other flags that are no parameters: a row is a field with its help and, in
/// brackets, what the command line has to know of it; a group of further rows stands `as flatten`.
macro_rules! rows {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident {
            $($(#[$attribute:meta])* $field_vis:vis $field:ident: $type:ty $(as $flatten:ident)? $(= [$($arg:tt)*])?;)*
        }
    ) => {
        #[cfg_attr(feature = "cli", derive(clap::Args))]
        $(#[$meta])*
        $vis struct $name {
            $(
                $(#[$attribute])*
                $(#[cfg_attr(feature = "cli", command($flatten))])?
                $(#[cfg_attr(feature = "cli", arg($($arg)*))])?
                $field_vis $field: $type,
            )*
        }
    };
}
pub(crate) use rows;

/// Defines an enum of parameter values, each with its word. An enum that derives [`Default`] marks one as `[default]`.
macro_rules! choices {
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident {
            $($(#[doc = $doc:literal])* $variant:ident = $word:literal $([$default:ident])?,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
        $vis enum $name {
            $($(#[doc = $doc])* $(#[$default])? #[serde(rename = $word)] $variant,)*
        }

        impl $name {
            /// All values, as offered to users.
            pub(crate) const CHOICES: &[$crate::params::Choice] = &[
                $($crate::params::Choice { name: $word, doc: &[$($doc),*] },)*
            ];

            /// Its word.
            $vis fn name(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }

            /// The value of a word.
            pub(crate) fn named(word: &str) -> Option<Self> {
                match word { $($word => Some(Self::$variant),)* _ => None }
            }
        }

        impl $crate::params::value::Value for $name {
            const KIND: $crate::params::Kind = $crate::params::Kind::Choice(Self::CHOICES);

            fn parse(text: &str, _: &$crate::params::Param) -> std::result::Result<Self, String> {
                let words = || Self::CHOICES.iter().map(|choice| choice.name).collect::<Vec<_>>();
                Self::named(text).ok_or_else(|| format!("expected one of {}", words().join(", ")))
            }

            fn text(&self, _: &$crate::params::Param) -> Option<String> {
                Some(self.name().into())
            }
        }
    };
}
