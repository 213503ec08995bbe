//! Errors as one line.

use crate::error::Error;
use crate::io::output::OutputKind;
use crate::untrusted::{Untrusted, bounded};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::path::Path;

/// The error's message with line breaks as spaces.
pub(crate) fn line_of(error: &Error) -> String {
    bounded(&error.to_string().replace('\n', " "))
}

/// One line for a misused command line: `error: ...`.
pub(crate) fn misuse_line(error: &clap::Error) -> String {
    if let Some(line) = stray_file(error) {
        return line;
    }
    // Usage and the pointer to the help follow the message as separate paragraphs.
    let mut text = error.to_string();
    for typed in typed_in(error) {
        text = text.replace(typed, &Untrusted(typed).to_string());
    }
    let message: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        // Clap's tip for passing a flag as a value never applies here.
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    bounded(&message.join(" ").replace(" tip:", "; tip:"))
}

/// The words of the command line that the message repeats.
fn typed_in(error: &clap::Error) -> impl Iterator<Item = &str> {
    let words = error.context().flat_map(|(_, value)| match value {
        ContextValue::String(word) => std::slice::from_ref(word),
        ContextValue::Strings(words) => words,
        _ => &[],
    });
    words.map(String::as_str).filter(|word| !word.is_empty())
}

/// Message for a stray word that is not a flag.
fn stray_file(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let is_stray = error.kind() == ErrorKind::UnknownArgument && !word.starts_with('-');
    let kind = OutputKind::of(Path::new(word));
    let word = Untrusted(word);
    let remedy = match kind {
        Ok(_) => format!("to write it, give -o {}", word.word()),
        Err(_) => "only one input is taken; in front of a value goes its flag".into(),
    };
    is_stray.then(|| bounded(&format!("error: unexpected '{word}'; {remedy}")))
}
