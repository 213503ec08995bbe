//! Errors as one line.

use super::output::Kind;
use crate::error::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::path::Path;

/// The error's message with line breaks as spaces.
pub(crate) fn line_of(error: &Error) -> String {
    error.to_string().replace('\n', " ")
}

/// One line for a misused command line: `error: ...`.
pub(crate) fn misuse_line(error: &clap::Error) -> String {
    if let Some(line) = stray_file(error) {
        return line;
    }
    // Usage and the pointer to the help follow the message as separate paragraphs.
    let text = error.to_string();
    let message: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        // Clap's tip for passing a flag as a value never applies here.
        .filter(|line| !line.is_empty() && !line.starts_with("tip: to pass"))
        .collect();
    message.join(" ").replace(" tip:", "; tip:")
}

/// Message for a stray word that is not a flag.
fn stray_file(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidArg) else {
        return None;
    };
    let is_stray = error.kind() == ErrorKind::UnknownArgument && !word.starts_with('-');
    let remedy = match Kind::of(Path::new(word)) {
        Ok(_) => format!("to write it, give -o {word}"),
        Err(_) => "only one input is taken; in front of a value goes its flag".into(),
    };
    is_stray.then(|| format!("error: unexpected '{word}'; {remedy}"))
}
