//! Value types: printing, parsing and range checks.

use super::table::{Kind, Param, Unit};
use crate::error::short;

/// A type of parameter values.
pub(crate) trait Value: Sized {
    /// The kind of value in the table.
    const KIND: Kind;

    /// Parses `text` as a value of the parameter `row`.
    ///
    /// # Errors
    /// The accepted values.
    fn parse(text: &str, row: &Param) -> Result<Self, String>;

    /// The value as typed; `None` if it cannot be typed.
    fn text(&self, row: &Param) -> Option<String>;

    /// The first of its numbers outside a range.
    fn outside(&self, _: &Param) -> Option<String> {
        None
    }
}

impl Value for f32 {
    const KIND: Kind = Kind::Number {
        whole: false,
        word: None,
    };

    /// A number, with its unit or without.
    fn parse(text: &str, row: &Param) -> Result<Self, String> {
        let number = text.strip_suffix(row.unit.suffix()).unwrap_or(text);
        number.parse().map_err(|_| no_number(text))
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(self.to_string())
    }

    fn outside(&self, row: &Param) -> Option<String> {
        let is_one = row.valid.contains(self) && (!row.is_whole() || self.fract() == 0.0);
        (!is_one).then(|| short(*self))
    }
}

/// A whole number without a word in its place.
const COUNT: Kind = Kind::Number {
    whole: true,
    word: None,
};

impl Value for u32 {
    const KIND: Kind = COUNT;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        let number: i64 = text.parse().map_err(|_| NO_COUNT)?;
        Self::try_from(number).map_err(|_| format!("{number} is not in 0..={}", Self::MAX))
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(self.to_string())
    }

    fn outside(&self, row: &Param) -> Option<String> {
        (!row.valid.contains(&(*self as f32))).then(|| self.to_string())
    }
}

impl Value for u64 {
    const KIND: Kind = COUNT;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        text.parse().map_err(|_| NO_COUNT.into())
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(self.to_string())
    }
}

impl Value for bool {
    const KIND: Kind = Kind::Switch;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        text.parse().map_err(|_| "expected true or false".into())
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(self.to_string())
    }
}

/// The word for no value, unless it is a value itself.
fn word_for_none<T: Value>(row: &Param) -> Option<&'static str> {
    row.word().filter(|word| T::parse(word, row).is_err())
}

/// An optional number, or one with a word for none.
impl<T: Value> Value for Option<T> {
    const KIND: Kind = T::KIND;

    fn parse(text: &str, row: &Param) -> Result<Self, String> {
        let Some(word) = word_for_none::<T>(row) else {
            return T::parse(text, row).map(Some);
        };
        if text == word {
            return Ok(None);
        }
        let whole = if row.is_whole() { "whole " } else { "" };
        let unit = if row.unit == Unit::Pixels {
            " of pixels"
        } else {
            ""
        };
        let parsed = T::parse(text, row).map(Some);
        parsed.map_err(|_| format!("expected {word} or a {whole}number{unit}"))
    }

    fn text(&self, row: &Param) -> Option<String> {
        match self {
            Some(value) => value.text(row),
            None => word_for_none::<T>(row).map(String::from),
        }
    }

    fn outside(&self, row: &Param) -> Option<String> {
        self.as_ref()?.outside(row)
    }
}

impl Value for [f32; 2] {
    const KIND: Kind = Kind::Pair;

    fn parse(text: &str, _: &Param) -> Result<Self, String> {
        let numbers = text.split(',').map(finite).collect::<Option<Vec<_>>>();
        let pair = numbers.and_then(|numbers| numbers.try_into().ok());
        pair.ok_or("expected 2 numbers".into())
    }

    fn text(&self, _: &Param) -> Option<String> {
        let [a, b] = self;
        Some(format!("{a},{b}"))
    }

    fn outside(&self, row: &Param) -> Option<String> {
        self.iter().find_map(|number| number.outside(row))
    }
}

/// A finite number; surrounding spaces are ignored.
pub(super) fn finite(text: &str) -> Option<f32> {
    let number: f32 = text.trim().parse().ok()?;
    number.is_finite().then_some(number)
}

const NO_COUNT: &str = "expected a whole number";

/// Error message for a text that is not a number.
fn no_number(text: &str) -> String {
    let percentage = text
        .strip_suffix('%')
        .map(|number| number.trim().parse::<f32>());
    match percentage {
        Some(Ok(percent)) => format!("expected a number: {} for {text}", percent / 100.0),
        _ => "expected a number".into(),
    }
}

/// Defines an enum of a number and a word accepted in its place.
macro_rules! number_or_word {
    (
        $(#[$meta:meta])*
        pub enum $name:ident {
            $(#[$word_meta:meta])* $word_variant:ident = $word:literal,
            $(#[$number_meta:meta])* $variant:ident($number:ty),
        }
        whole: $whole:literal,
        numbers: $is_one:expr,
        expected: $expected:expr,
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
        #[serde(rename_all = "lowercase")]
        pub enum $name {
            $(#[$word_meta])* $word_variant,
            $(#[$number_meta])* $variant($number),
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    Self::$word_variant => f.write_str($word),
                    Self::$variant(number) => write!(f, "{number}"),
                }
            }
        }

        impl $crate::params::value::Value for $name {
            const KIND: $crate::params::Kind = $crate::params::Kind::Number { whole: $whole, word: Some($word) };

            fn parse(text: &str, _: &$crate::params::Param) -> std::result::Result<Self, String> {
                let is_one: fn(&$number) -> bool = $is_one;
                let number = || text.parse().ok().filter(is_one).map(Self::$variant);
                match text {
                    $word => Ok(Self::$word_variant),
                    _ => number().ok_or($expected.into()),
                }
            }

            fn text(&self, _: &$crate::params::Param) -> Option<String> {
                Some(self.to_string())
            }

            fn outside(&self, row: &$crate::params::Param) -> Option<String> {
                match self {
                    Self::$word_variant => None,
                    Self::$variant(number) => number.outside(row),
                }
            }
        }
    };
}
