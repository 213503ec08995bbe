//! Parsers of the command line for words that stand for values.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::str::FromStr;

/// Parser for the words of `all`.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<_> = all.into_iter().collect();
    let names = PossibleValuesParser::new(all.iter().map(|(_, name)| *name));
    names.map(move |word| {
        let named = all.iter().find(|(_, name)| *name == word);
        named.expect("other words are refused").0
    })
}

/// Parser for `auto`, which is none, and the words of `all`.
pub(crate) fn auto_or<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str)>,
) -> impl TypedValueParser<Value = Option<T>> {
    let all = all.into_iter().map(|(value, name)| (Some(value), name));
    one_of(std::iter::once((None, "auto")).chain(all))
}

/// A parser for a value, or a `word` in its place.
pub(crate) fn word_or<T: FromStr<Err = String>>(
    word: &'static str,
) -> impl Fn(&str) -> Result<Option<T>, String> + Clone {
    move |text| match text == word {
        true => Ok(None),
        false => text.parse().map(Some),
    }
}
