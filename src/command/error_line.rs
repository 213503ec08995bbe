//! What is wrong, as one line.

use crate::error::Error;

/// An error as one line.
pub(crate) fn line_of(error: &Error) -> String {
    error.to_string().replace('\n', " ")
}

/// What is wrong with a command line, as one line: `error: ...`.
pub(crate) fn misuse_line(error: &clap::Error) -> String {
    // Usage and the pointer to the help follow the message as paragraphs of their own.
    let text = error.to_string();
    let message: Vec<_> = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"))
        .filter(|line| !line.is_empty())
        .collect();
    message.join(" ").replace(" tip:", "; tip:")
}
