//! Messages on stderr, and exit codes.

use super::exit;
use crate::command::error_line::{line_of, misuse_line};
use crate::error::{Error, Result};
use crate::io::Finding;
use crate::io::picture::Whites;
use crate::params::Highlights;
use crate::untrusted::{bounded, printable};
use clap::error::ErrorKind;
use serde::Serialize;
use std::io::Write;
use std::path::Path;

/// Percentage of white from which it is reported.
const LEAST_SAID_PERCENT: f64 = 0.05;

/// Share of the surface whose turning white is warned about.
const BURNT: f64 = 0.01;

/// Prints an error as one line.
pub(super) fn error(error: &Error) {
    say(&format!("error: {}", line_of(error)));
}

/// The exit code of an error.
pub(super) fn exit_code(error: &Error) -> i32 {
    match error {
        Error::BadParameter { .. } | Error::Recipe { .. } => exit::MISUSED,
        _ => exit::FAILED,
    }
}

/// Reports an error in the command line, as one line, or prints the requested help. Returns the exit code.
pub(super) fn misuse(error: &clap::Error) -> i32 {
    let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if is_help || !error.use_stderr() {
        let printed = error.print().and_then(|()| std::io::stdout().flush());
        if let Err(failed) = written(printed) {
            self::error(&failed);
            return exit::FAILED;
        }
    } else {
        say(&format!("{}; see --help", misuse_line(error)));
    }
    error.exit_code()
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

/// Share of the picture that is white, if worth reporting.
pub(super) fn whites(whites: Whites) -> String {
    let percent = |count: usize| 100.0 * count as f64 / whites.of.max(1) as f64;
    let [after, before] = [whites.count, whites.before].map(percent);
    match after.max(before) < LEAST_SAID_PERCENT {
        true => String::new(),
        false if whites.before == 0 => format!("{after:.1} % white"),
        false => format!("{after:.1} % white ({before:.1} % before)"),
    }
}

/// Warning about a picture in which too much of the surface has become plain white.
pub(super) fn burnt(whites: Whites, highlights: Highlights) -> Option<String> {
    let made = whites.count.saturating_sub(whites.before);
    let is_burnt = made as f64 > BURNT * whites.of as f64;
    let compress = match highlights {
        Highlights::Clip => ", or --highlights compress",
        Highlights::Compress => "",
    };
    is_burnt.then(|| {
        format!(
            "more than 1 % of the surface turned white, without any shape: try --exposure -1 or lower{compress}"
        )
    })
}

/// Writes one line to stderr; a failure to do so cannot be reported.
pub(super) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", bounded(line));
}

/// Writes an event to stderr as a line of JSON.
pub(super) fn event(event: &serde_json::Value) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&event.to_string()));
}

/// Writes results to stdout, line by line; a closed pipe is not an error, a full disk is.
pub(super) fn result(lines: impl IntoIterator<Item = String>) -> Result<()> {
    let lines = lines.into_iter();
    print(
        &lines
            .map(|line| format!("{}\n", printable(&line)))
            .collect::<String>(),
    )
}

/// Writes a result to stdout as JSON, as [`result`] does.
pub(super) fn json(value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value).expect("names and numbers are JSON");
    result(text.lines().map(String::from))
}

/// Writes a text to stdout; a closed pipe is no error.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    written(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// The outcome of writing to stdout; a closed pipe is no error.
fn written(outcome: std::io::Result<()>) -> Result<()> {
    match outcome {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("stdout"), "write")(error))
        }
        _ => Ok(()),
    }
}
