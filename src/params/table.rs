//! The table of parameters. A row is written once, where its struct is defined by [`params!`]: from it come the field,
//! its default, the check of its range, the flag with its help, the recipe's key and schema, and the viewer's control.

use crate::error::{Error, Result, short};
use std::ops::RangeInclusive;

/// One parameter, described for any interface that offers it: a command line, a window, a plugin.
#[derive(Debug, Clone)]
pub struct Param {
    /// The flag of the command line, `--stroke-width`; of parameters that only the library has, the field.
    pub flag: &'static str,
    /// A name that says more, where the flag is like that of something else: without dashes.
    pub alias: Option<&'static str>,
    /// The group it belongs to.
    pub group: Group,
    /// How it is chosen.
    pub kind: Kind,
    /// Whether several values can be given.
    pub many: Many,
    /// The unit of its numbers.
    pub unit: Unit,
    /// The form of a value in help: `PX`, `LO,HI`, `K|auto`.
    pub form: &'static str,
    /// Numbers outside are refused.
    pub valid: RangeInclusive<f32>,
    /// Why the range ends where it does, where a refusal says so.
    pub why: Option<&'static str>,
    /// How far a slider reaches; values beyond can be typed.
    pub useful: Option<Useful>,
    /// The parameter that cannot be given beside it.
    pub rival: Option<&'static str>,
    /// Lines of documentation: a paragraph for users, then paragraphs for engineers.
    pub doc: &'static [&'static str],
    /// The default as it would be typed; `None` where leaving it out says something that no value does.
    pub default: fn() -> Option<String>,
    /// Refuses a text that is no value.
    pub parse: fn(&str) -> std::result::Result<(), String>,
}

/// How a parameter is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// On or off.
    Switch,
    /// One of these.
    Choice(&'static [Choice]),
    /// One of these, or a folder.
    ChoiceOrFolder(&'static [Choice]),
    /// A number, or the word that may stand in its place.
    Number {
        /// Whether only whole numbers will do.
        whole: bool,
        /// `auto`, where that is a value.
        word: Option<&'static str>,
    },
    /// Two numbers with a comma between.
    Pair,
    /// Anything else, in the form of its row.
    Text,
}

/// One of several words that a parameter can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// As it is typed.
    pub name: &'static str,
    /// Lines of documentation.
    pub doc: &'static [&'static str],
}

/// Whether a parameter takes several values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Many {
    /// It takes one.
    One,
    /// Several, with commas between.
    Listed,
    /// It can be given again.
    Repeated,
}

/// The unit of a parameter's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Nothing: factors, shares, exponents, counts.
    One,
    /// Pixels.
    Pixels,
    /// Degrees.
    Degrees,
    /// Pixels per inch.
    PerInch,
}

impl Unit {
    /// The suffix of a number.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Pixels => "px",
            Self::Degrees => "\u{b0}",
            Self::PerInch => "per inch",
        }
    }
}

/// The reach of a slider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Useful {
    /// Its lower end.
    pub from: f64,
    /// Its upper end.
    pub to: f64,
    /// Whether equal ways on it are equal factors.
    pub logarithmic: bool,
}

/// Parameters that stand together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// How shape is found.
    Shape,
    /// Layers of light that are scaled one by one.
    LightLayers,
    /// Light.
    Light,
    /// How light is bent.
    Warping,
    /// How shading is scaled.
    Scaling,
    /// Which luminance is white, where a picture is scaled.
    WhiteLevels,
    /// How pictures are brought to a display.
    Display,
    /// How large a picture is on paper.
    Print,
    /// Material.
    Material,
    /// Mirrors and lenses.
    Specular,
    /// Tone.
    Tone,
    /// Where strokes go.
    Directions,
    /// How strokes are drawn.
    Strokes,
    /// How lines along edges are drawn.
    Contours,
}

impl Group {
    /// Its heading.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shape => "Shape",
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

/// A slider on which equal ways are equal differences.
pub(super) const fn even(from: f64, to: f64) -> Option<Useful> {
    Some(Useful {
        from,
        to,
        logarithmic: false,
    })
}

/// A slider on which equal ways are equal factors.
pub(super) const fn by_factors(from: f64, to: f64) -> Option<Useful> {
    Some(Useful {
        from,
        to,
        logarithmic: true,
    })
}

impl Param {
    /// A row of which all but these is usual.
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

    /// The key in recipes: the flag without its dashes.
    pub fn name(&self) -> &'static str {
        self.flag.trim_start_matches("--")
    }

    /// Whether command lines and recipes have it.
    pub fn has_flag(&self) -> bool {
        self.flag.starts_with("--")
    }

    /// Its effect, in a line without a full stop.
    pub fn help(&self) -> String {
        let lines = self.doc.iter().map(|line| line.trim());
        let first: Vec<_> = lines.take_while(|line| !line.is_empty()).collect();
        let text = first.join(" ");
        text.strip_suffix('.').unwrap_or(&text).into()
    }

    /// The word that may stand in place of a number.
    pub fn word(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Number { word, .. } => word,
            _ => None,
        }
    }

    /// Whether its numbers are whole.
    pub fn is_whole(&self) -> bool {
        matches!(self.kind, Kind::Number { whole: true, .. })
    }

    /// Refuses a value of which a number lies `outside` the range.
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

/// A struct of parameters, or what parameters make up together.
pub trait Parameters: Sized {
    /// Where nothing is given.
    fn usual() -> Self;

    /// Appends its rows, in their order.
    fn rows(table: &mut Vec<&'static Param>);

    /// Gives the parameter called `name` the value that `text` is, several with commas between. `false` where there is
    /// no such parameter.
    ///
    /// # Errors
    /// The values expected, where `text` is not one.
    fn set(&mut self, name: &str, text: &str) -> std::result::Result<bool, String>;

    /// Refuses values outside their ranges, and values that contradict each other.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    fn check(&self) -> Result<()>;
}

/// Defines a struct of parameters. A field with a default is a row, its further columns those of [`Param`] that are not
/// usual; the first paragraph of its documentation is its help. A field without is a struct of further rows. `relations`
/// checks what a range does not say.
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
            /// Refuses values outside their ranges, and values that contradict each other.
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

/// Defines an enum that a parameter can be, each value with its word. One that derives [`Default`] marks it `[default]`.
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
            /// All of them, as they are offered.
            pub(crate) const CHOICES: &[$crate::params::Choice] = &[
                $($crate::params::Choice { name: $word, doc: &[$($doc),*] },)*
            ];

            /// The word for it.
            $vis fn name(self) -> &'static str {
                match self { $(Self::$variant => $word,)* }
            }

            /// The value that a word stands for.
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
