//! The command line: arguments in, files and messages out.

mod args;
mod enhance;
mod hatch;
mod inspect;
mod job;
mod light_layers;
mod line_args;
mod message;
mod output;
mod relight;
mod relight_args;
mod report;
mod role_args;
mod sequence;
mod shape;
mod specular_args;

use args::{Cli, Command};
use clap::Parser;

/// Runs the command line of this process and returns its exit code: 0 done, 1 failed, 2 misused.
pub fn run() -> i32 {
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        Err(error) => return message::misuse(&error),
    };
    let result = match &command {
        Command::Inspect(args) => inspect::run(args),
        Command::Shape(args) => shape::run(args),
        Command::Enhance(args) => enhance::run(args),
        Command::Relight(args) => relight::run(args),
        Command::Hatch(args) => hatch::run(args),
        Command::Report(args) => report::run(args),
    };
    match result {
        Ok(()) => 0,
        Err(error) => {
            message::error(&error);
            message::exit_code(&error)
        }
    }
}
