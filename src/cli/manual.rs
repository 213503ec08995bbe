//! `relievo man`: manual pages, generated from the table of commands and flags.

use super::{PROGRAM, command, message};
use crate::command::commands::ManArgs;
use crate::error::{Error, Result, bad};
use crate::untrusted::Untrusted;
use clap_mangen::Man;
use std::path::Path;

/// Prints a manual page.
pub(super) fn man(args: &ManArgs) -> Result<()> {
    let mut program = command();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name).cloned();
            let found = found.ok_or_else(|| {
                bad(
                    "COMMAND",
                    format!("is {}, which {PROGRAM} does not have", Untrusted(name)),
                    format!("see {PROGRAM} --help"),
                )
            })?;
            found.name(format!("{PROGRAM}-{name}"))
        }
    };
    let mut text = Vec::new();
    let rendered = Man::new(page).render(&mut text);
    rendered.map_err(Error::io(Path::new("stdout"), "write"))?;
    message::print(&String::from_utf8_lossy(&text))
}
