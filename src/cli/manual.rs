//! `relievo completions` and `relievo man`: generated from the table of commands and flags.

use super::{command, message};
use crate::command::commands::{CompletionsArgs, ManArgs};
use crate::error::{Error, Result};
use clap_mangen::Man;
use std::path::Path;

const PROGRAM: &str = "relievo";

/// Prints completions for a shell.
pub(super) fn completions(args: &CompletionsArgs) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command(), PROGRAM, &mut text);
    message::print(&String::from_utf8_lossy(&text))
}

/// Prints a manual page.
pub(super) fn man(args: &ManArgs) -> Result<()> {
    let mut program = command();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name).cloned();
            let found = found.ok_or_else(|| Error::BadParameter {
                name: "COMMAND",
                found: format!("is {name}, which {PROGRAM} does not have"),
                remedy: format!("see {PROGRAM} --help"),
            })?;
            found.name(format!("{PROGRAM}-{name}"))
        }
    };
    let mut text = Vec::new();
    let rendered = Man::new(page).render(&mut text);
    rendered.map_err(Error::io(Path::new("stdout"), "write"))?;
    message::print(&String::from_utf8_lossy(&text))
}
