//! `relievo report`.

use super::message;
use super::motion::Steps;
use super::panics::caught;
use super::threads::on_threads;
use crate::command::commands::ReportArgs;
use crate::command::sequence::inputs_of_frame;
use crate::error::{Error, Result};
use crate::io::inputs::Inputs;
use crate::io::output::{Files, Replace, check_folder, remove_leftovers, write_atomically};
use crate::io::{self, Loaded, Needs};
use crate::params::ShapeParams;
use crate::report::coherence::{self, MovingFrame};
use crate::report::surface::Surface;
use crate::report::{Asked, Extent, Report, advice, html, markdown, plots, run as measure};
use crate::untrusted::shown;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

pub(super) fn run(args: &ReportArgs) -> Result<()> {
    on_threads(args.threads, || caught(&args.input, || report(args)))
}

fn report(args: &ReportArgs) -> Result<()> {
    let started = Instant::now();
    args.flags.refuse_more_scales()?;
    args.flags.validate()?;
    let shape = args.flags.params.shape;
    refuse_collisions(args)?;
    let frames = args.frames.of(&args.input, None)?;
    let first = match frames {
        Some(frames) => inputs_of_frame(&args.roles, &args.input, frames[0]),
        None => args.roles.inputs(&args.input),
    };
    args.output
        .iter()
        .try_for_each(|folder| check_folder(folder))?;
    let loaded = load(args, &first)?;
    if loaded.frame.importance.is_some() {
        return Err(Error::BadParameter {
            name: "--importance",
            found: "gives every pixel a scale of its own, which the reference has not".into(),
            remedy: "leave it out".into(),
        });
    }
    if let Some(output) = &args.output {
        // Made only for what can be read, and before any long work.
        std::fs::create_dir_all(output).map_err(Error::io(output, "make"))?;
        remove_leftovers(output);
    }
    let extent = match args.full {
        true => Extent::Full,
        false => Extent::Quick,
    };
    let name = first.picture.file_name().map_or_else(
        || first.picture.display().to_string(),
        |n| n.to_string_lossy().into(),
    );
    let progress = |doing: &str| {
        if !args.quiet {
            message::say(&format!(
                "{:>6.1} s  {doing}",
                started.elapsed().as_secs_f64()
            ));
        }
    };
    let surface = Surface::stored(&loaded.stored_surface(&first)?, &loaded);
    let asked = Asked {
        name: &name,
        frame: &loaded.frame,
        surface: &surface,
        shape,
        extent,
        beyond: args.full || args.quick,
        progress: &progress,
    };
    let mut report = measure(asked)?;
    if let Some(frames) = frames {
        progress("drawings of the sequence");
        report.coherence = coherence(args, frames, shape)?;
    }
    let Some(output) = &args.output else {
        return message::result(markdown::first_page(&report).lines().map(String::from));
    };
    for (file, data) in files(&report) {
        let path = output.join(file);
        write_atomically(&path, Replace::IfWritable, |w| {
            w.write_all(&data).map_err(Error::io(&path, "write"))
        })?;
    }
    message::result(summary(&report, output))
}

fn load(args: &ReportArgs, inputs: &Inputs) -> Result<Loaded> {
    // Foreshortened gradients are part of the report whatever was asked for.
    let needs = Needs {
        color_if_any: true,
        projection: true,
        ..Needs::default()
    };
    let loaded = io::load(inputs, needs)?;
    for warning in &loaded.warnings {
        let picture = shown(&inputs.picture);
        message::warning(args.quiet, &format!("{picture}: {warning}"));
    }
    Ok(loaded)
}

/// How well drawings of the frames follow each other.
fn coherence(
    args: &ReportArgs,
    frames: &[i32],
    shape: ShapeParams,
) -> Result<Option<coherence::Coherence>> {
    let mut steps = Steps::new(args.motion.convention());
    let said = RefCell::new(BTreeSet::new());
    let say_once = |text: &str| {
        if said.borrow_mut().insert(text.to_string()) {
            message::warning(args.quiet, text);
        }
    };
    let moving = frames.iter().map(|&number| {
        let mut inputs = inputs_of_frame(&args.roles, &args.input, number);
        let needs = Needs {
            color_if_any: true,
            projection: true,
            motion: steps.has_begun(),
            ..Needs::default()
        };
        inputs.motion = args.motion.of_frame(number).filter(|_| needs.motion);
        let mut loaded = io::load(&inputs, needs)?;
        let motion = steps.motion(number, &mut loaded, say_once);
        Ok(MovingFrame {
            number,
            motion: motion.filter(|_| args.motion.moves()),
            frame: loaded.frame,
        })
    });
    coherence::measure(moving, shape)
}

/// No file may stand where the directory goes, no input where a file of the report does. Plots are never
/// inputs: none of them ends like one.
fn refuse_collisions(args: &ReportArgs) -> Result<()> {
    let Some(directory) = &args.output else {
        return Ok(());
    };
    if directory.exists() && !directory.is_dir() {
        return Err(Error::BadParameter {
            name: "-o",
            found: format!("{} is not a directory", shown(directory)),
            remedy: "name a directory for the report's files".into(),
        });
    }
    let mut files = Files::default();
    for input in args.roles.files(&args.input) {
        files.reads(&input);
    }
    [PAGE, TEXT, NUMBERS]
        .iter()
        .try_for_each(|file| files.writes("-o", &directory.join(file)))
}

const PAGE: &str = "report.html";
const TEXT: &str = "report.md";
const NUMBERS: &str = "report.json";

/// Every file of the report; the pages last, so that the pictures of the text are there when it is.
fn files(report: &Report) -> Vec<(String, Vec<u8>)> {
    let plots = plots::all(report).into_iter();
    let mut files: Vec<_> = plots.map(|(name, svg)| (name, svg.into_bytes())).collect();
    let sheet = report.answers.sheet.iter().cloned();
    files.extend(sheet.map(|png| (markdown::SHEET.into(), png)));
    let text = markdown::page(report);
    let title = format!("relievo report: {}", report.frame.on.name);
    let page = html::page(&title, &text, &files);
    let last = [(NUMBERS, json(report)), (TEXT, text), (PAGE, page)];
    files.extend(last.map(|(name, text)| (name.into(), text.into_bytes())));
    files
}

fn json(report: &Report) -> String {
    let text = serde_json::to_string_pretty(report).expect("names and numbers are JSON");
    text + "\n"
}

fn summary(report: &Report, directory: &Path) -> Vec<String> {
    let wrong = report
        .stability
        .iter()
        .filter(|case| !case.as_expected)
        .count();
    let stability = match (report.stability.len(), wrong) {
        (0, _) => None,
        (cases, 0) => Some(format!("{cases} stiff and extreme cases: all as declared.")),
        (cases, _) => Some(format!(
            "{wrong} of {cases} stiff and extreme cases did not end as declared."
        )),
    };
    let mut lines = vec![advice::sentence(report)];
    lines.extend(report.answers.warnings.iter().cloned());
    lines.extend(report.light.as_ref().map(advice::of_light));
    lines.extend(report.mirrors.as_ref().map(advice::of_mirrors));
    lines.extend(stability);
    lines.push(directory.join(PAGE).display().to_string());
    lines
}
