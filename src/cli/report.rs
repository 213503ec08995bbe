//! `relievo report`.

use super::message;
use super::motion::Steps;
use super::panics::caught;
use super::report_device::ReportDevice;
use super::threads::on_threads;
use crate::command::commands::ReportArgs;
use crate::command::sequence::inputs_of_frame;
use crate::error::{Error, Result};
use crate::io::inputs::Inputs;
use crate::io::output::{Files, Replace, remove_leftovers, write_text};
use crate::io::{self, Loaded, Needs};
use crate::params::ShapeParams;
use crate::report::coherence::{self, MovingFrame};
use crate::report::{Asked, Extent, Report, advice, markdown, plots, run as measure};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;

pub(super) fn run(args: &ReportArgs) -> Result<()> {
    on_threads(args.compute.threads, || {
        caught(&args.input, || report(args))
    })
}

fn report(args: &ReportArgs) -> Result<()> {
    let started = Instant::now();
    args.flags.refuse_more_scales()?;
    args.flags.validate()?;
    let shape = args.flags.params.shape;
    let device = ReportDevice::of(args.compute.backend)?;
    refuse_collisions(args)?;
    let frames = args.frames.of(&args.input, None)?;
    let first = match frames {
        Some(frames) => inputs_of_frame(&args.roles, &args.input, frames[0]),
        None => args.roles.inputs(&args.input),
    };
    let loaded = load(args, &first)?;
    if loaded.frame.importance.is_some() {
        return Err(Error::BadParameter {
            name: "--importance",
            found: "gives every pixel a scale of its own, which the reference has not".into(),
            remedy: "leave it out".into(),
        });
    }
    // Made only for what can be read, and before any long work.
    std::fs::create_dir_all(&args.output).map_err(Error::io(&args.output, "make"))?;
    remove_leftovers(&args.output);
    let extent = if args.quick {
        Extent::Quick
    } else {
        Extent::Full
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
    let asked = Asked {
        name: &name,
        frame: &loaded.frame,
        shape,
        extent,
        progress: &progress,
    };
    let mut report = device.measured(|device| measure(asked, device))?;
    if let Some(frames) = frames {
        progress("drawings of the sequence");
        report.coherence = coherence(args, frames, shape)?;
    }
    for (file, text) in files(&report) {
        write_text(&args.output.join(file), Replace::IfWritable, &text)?;
    }
    message::result(summary(&report, &args.output))
}

fn load(args: &ReportArgs, inputs: &Inputs) -> Result<Loaded> {
    // Foreshortened gradients are part of the report whatever was asked for.
    let needs = Needs {
        color: false,
        projection: true,
        ..Needs::default()
    };
    let loaded = io::load(inputs, needs)?;
    for warning in &loaded.warnings {
        let picture = inputs.picture.display();
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
    let directory = &args.output;
    if directory.exists() && !directory.is_dir() {
        return Err(Error::BadParameter {
            name: "-o",
            found: format!("{} is not a directory", directory.display()),
            remedy: "name a directory for the report's files".into(),
        });
    }
    let mut files = Files::default();
    for input in args.roles.files(&args.input) {
        files.reads(&input);
    }
    [PAGE, NUMBERS]
        .iter()
        .try_for_each(|file| files.writes("-o", &directory.join(file)))
}

const PAGE: &str = "report.md";
const NUMBERS: &str = "report.json";

/// Every file of the report; the page last, so that its pictures are there when it is.
fn files(report: &Report) -> Vec<(String, String)> {
    let mut files = plots::all(report);
    files.push((NUMBERS.into(), json(report)));
    files.push((PAGE.into(), markdown::page(report)));
    files
}

fn json(report: &Report) -> String {
    let text = serde_json::to_string_pretty(report).expect("names and numbers are JSON");
    text + "\n"
}

fn summary(report: &Report, directory: &Path) -> [String; 5] {
    let wrong = report
        .stability
        .iter()
        .filter(|case| !case.as_expected)
        .count();
    let cases = report.stability.len();
    let stability = match wrong {
        0 => format!("{cases} stiff and extreme cases: all as declared."),
        _ => format!("{wrong} of {cases} stiff and extreme cases did not end as declared."),
    };
    let path = directory.join(PAGE);
    [
        advice::sentence(report),
        advice::of_light(&report.light),
        advice::of_mirrors(&report.mirrors),
        stability,
        path.display().to_string(),
    ]
}
