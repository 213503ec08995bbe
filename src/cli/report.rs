//! `relievo report`.

use super::exit;
use super::message;
use super::panics::caught;
use super::threads::on_threads;
use crate::command::commands::ReportArgs;
use crate::command::flags::Flag;
use crate::command::named::Named;
use crate::error::{Error, Result, bad};
use crate::io::output::{Files, Replace, check_folder, remove_leftovers, write_atomically};
use crate::report::{Asked, all_cases, lines, lines_of_cases, measured, page};
use crate::untrusted::shown;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

const PAGE: &str = "report.html";
const NUMBERS: &str = "report.json";

pub(super) fn run(args: &ReportArgs, typed: &[Flag]) -> Result<i32> {
    on_threads(args.threads, || caught(&args.input, || report(args, typed)))
}

fn report(args: &ReportArgs, typed: &[Flag]) -> Result<i32> {
    let started = Instant::now();
    let progress = |doing: &str| {
        if !args.quiet {
            let seconds = started.elapsed().as_secs_f64();
            message::say(&format!("{seconds:>6.1} s  {doing}"));
        }
    };
    let note = |text: &str| {
        if !args.quiet {
            message::say(&format!("note: {text}"));
        }
    };
    if args.full || args.quick {
        note("reports are on one command now, and quick: --full and --quick change nothing");
    }
    if args.cases {
        let results = all_cases(&progress);
        let failed = results.iter().filter(|case| !case.is_as_declared).count();
        message::result(lines_of_cases(&results))?;
        return Ok(match failed {
            0 => exit::DONE,
            _ => exit::FAILED,
        });
    }
    refuse_collisions(args)?;
    if let Some(output) = &args.output {
        check_folder(output)?;
    }
    let frames = args.frames.of(&args.input, None)?;
    let number = frames.map(|frames| frames[0]);
    if let Some([first, _, ..]) = frames {
        note(&format!("a report is on one frame: {first}"));
    }
    let report = measured(&Asked {
        args,
        typed,
        number,
        progress: &progress,
    })?;
    let Some(output) = &args.output else {
        return message::result(lines(&report)).map(|()| exit::DONE);
    };
    std::fs::create_dir_all(output).map_err(Error::io(output, "make"))?;
    remove_leftovers(output);
    let json = serde_json::to_string_pretty(&report).expect("names and numbers are JSON") + "\n";
    for (file, text) in [(NUMBERS, json), (PAGE, page(&report))] {
        let path = output.join(file);
        write_atomically(&path, Replace::IfWritable, |w| {
            w.write_all(text.as_bytes())
                .map_err(Error::io(&path, "write"))
        })?;
    }
    let page = output.join(PAGE).display().to_string();
    message::result(lines(&report).into_iter().chain([page]))?;
    Ok(exit::DONE)
}

/// No file may stand where the directory goes, no input where a file of the report does.
fn refuse_collisions(args: &ReportArgs) -> Result<()> {
    let Some(directory) = &args.output else {
        return Ok(());
    };
    if directory.exists() && !directory.is_dir() {
        return Err(bad(
            "-o",
            format!("{} is not a directory", shown(directory)),
            "name a directory for the report's files",
        ));
    }
    let mut files = Files::default();
    let recipe: Option<&PathBuf> = args.recipe.as_ref();
    let mut roles = args.roles.clone();
    let inputs = roles.names().into_iter().filter_map(Named::file);
    let inputs = inputs.chain(recipe.cloned()).chain([args.input.clone()]);
    inputs.for_each(|input| files.reads(&input));
    let mut own = [PAGE, NUMBERS].iter();
    own.try_for_each(|file| files.writes("-o", &directory.join(file)))
}
