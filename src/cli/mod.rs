//! The command line: arguments in, files and messages out.

mod batch;
mod cells;
mod complete;
mod exit;
mod explained;
mod files;
mod frames;
mod guard;
mod inspect;
mod inspect_motion;
mod job;
mod kit;
mod make;
mod manual;
mod message;
mod motion;
mod output;
pub(crate) mod panics;
mod progress;
#[cfg(test)]
mod reference;
mod report;
mod run_log;
mod sheet;
mod stop;
mod strip_memory;
mod strips;
mod threads;
mod timings;
#[cfg(feature = "view")]
mod window;

pub use crate::command::recipe;

use crate::command::commands::{Cli, Command};
#[cfg(not(feature = "view"))]
use crate::command::flags::Flag;
use crate::command::invocation::Invocation;
use crate::command::recipe::Recipe;
use crate::error::Result;
use std::ffi::OsString;
#[cfg(feature = "view")]
use window::view;

/// The name of the program.
const PROGRAM: &str = "relievo";

/// Runs the command line of this process, or completes it if a shell asks for that, and returns its exit code: 0 done,
/// 1 failed, 2 misused, 3 some frames of a sequence, or some of several pictures, failed, 130 and 143 stopped by a
/// signal.
pub fn run() -> i32 {
    run_words(std::env::args_os())
}

/// Runs a command line, with the program's name first, and returns its exit code as [`run`] does. From then on panics
/// in this process print nothing by themselves: those of the command line are reported in one line.
pub fn run_words(words: impl IntoIterator<Item = OsString>) -> i32 {
    let words: Vec<_> = words.into_iter().collect();
    if let Some(code) = complete::answered(&words) {
        return code;
    }
    panics::keep_quiet();
    stop::outlive_full_files();
    run_typed(Invocation::of(words)).unwrap_or_else(|error| {
        message::error(&error);
        message::exit_code(&error)
    })
}

/// The commands and their flags, in clap's form: for completions, manual pages, and exhaustive tests.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

fn run_typed(typed: Invocation) -> Result<i32> {
    if let Some(help) = typed.help_on_all() {
        return message::result(help.trim_end().lines().map(String::from)).map(|()| exit::DONE);
    }
    let task = match typed.parse() {
        Ok(task) => task,
        Err(error) => return Ok(message::misuse(&error)),
    };
    let typed = &task.typed;
    match &task.command {
        Command::Inspect(args) => inspect::run(args).map(|()| exit::DONE),
        Command::Report(args) => report::run(args, task.recipe.settings()),
        Command::Schema => message::json(&recipe::schema()).map(|()| exit::DONE),
        Command::Completions(args) => complete::script(args).map(|()| exit::DONE),
        Command::Man(args) => manual::man(args).map(|()| exit::DONE),
        Command::View(args) => view(args, task.recipe.settings()),
        Command::Run(args) => {
            let recipe = Recipe::read(&args.recipe)?;
            let typed = typed.of_recipe(&recipe, &args.rest)?;
            typed.note().into_iter().for_each(message::say);
            run_typed(typed)
        }
        _ => batch::run(&task),
    }
}

/// Reports that this build has no window, and how to get one.
#[cfg(not(feature = "view"))]
fn view(_: &crate::command::commands::ViewArgs, _: &[Flag]) -> Result<i32> {
    Err(crate::Error::Window {
        found: "this build has no window".into(),
        remedy: "build one with cargo build --release --features view".into(),
    })
}
