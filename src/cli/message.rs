//! What is said on stderr, and the exit codes.

use crate::error::{Error, Result};
use crate::io::Finding;
use clap::error::ErrorKind;
use std::io::Write;
use std::path::Path;

/// Prints an error as one line.
pub(super) fn error(error: &Error) {
    say(&format!("error: {}", line_of(error)));
}

/// An error as one line.
pub(super) fn line_of(error: &Error) -> String {
    error.to_string().replace('\n', " ")
}

/// 2 for what the user can mend on the command line, 1 for everything else.
pub(super) fn exit_code(error: &Error) -> i32 {
    match error {
        Error::BadParameter { .. } | Error::Recipe { .. } => 2,
        _ => 1,
    }
}

/// Says what is wrong with the command line, as one line, or prints the help that was asked for.
/// Returns the exit code.
pub(super) fn misuse(error: &clap::Error) -> i32 {
    let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if is_help || !error.use_stderr() {
        // A reader that has gone away is no error.
        let _ = error.print();
    } else {
        say(&format!("{}; see --help", misuse_line(error)));
    }
    error.exit_code()
}

/// What is wrong with a command line, as one line: `error: ...`.
pub(super) fn misuse_line(error: &clap::Error) -> String {
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

/// Prints a warning, unless told to be quiet.
pub(super) fn warning(quiet: bool, text: &str) {
    if !quiet {
        say(&format!("warning: {text}"));
    }
}

/// A conclusion as one line.
pub(super) fn finding_line(finding: &Finding) -> String {
    let Finding {
        subject,
        conclusion,
        evidence,
        flag,
    } = finding;
    format!("{subject:<16} {conclusion} ({evidence}; force with {flag})")
}

/// Writes one line to stderr. Where even that fails there is nobody left to tell.
pub(super) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Writes results to stdout; a reader that has gone away is no error, a full disk is.
pub(super) fn result(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("stdout"), "write")(error))
        }
        _ => Ok(()),
    }
}
