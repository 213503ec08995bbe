//! `relievo inspect`.

use super::args::InspectArgs;
use super::enhance::dark_rims;
use super::message;
use crate::error::{Error, Result};
use crate::io::inputs::{Inputs, LightInputs};
use crate::io::{self, Finding, InputFiles, Loaded, Needs, PartSurvey, Survey, frame_bytes};
use crate::params::ScalingParams;
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The camera is worth knowing even where the normals need none.
const EVERYTHING: Needs = Needs {
    color: false,
    color_if_any: false,
    albedo: false,
    projection: true,
    motion: false,
};

/// Most memory that is taken to look into a file.
const MOST_BYTES: u64 = 1 << 30;

/// Most of it that the samples of one photo take; of larger ones rows are decoded alone.
const MOST_OF_A_PHOTO: u64 = 256 << 20;

/// What is known of one file; the JSON form of `inspect`, documented in the README.
#[derive(Debug, Serialize)]
struct Inspection {
    file: PathBuf,
    #[serde(flatten)]
    survey: Survey,
    findings: Vec<Finding>,
    warnings: Vec<String>,
    /// Why no frame can be made of the file as it stands.
    problem: Option<String>,
}

pub(super) fn run(args: &InspectArgs) -> Result<()> {
    let mut inspections = Vec::new();
    let mut failed = None;
    for file in &args.files {
        match inspect(args, file) {
            Ok(inspection) => inspections.push(inspection),
            Err(error) => {
                // The other files are still looked into; the last error is reported by the caller.
                if let Some(earlier) = failed.replace(error) {
                    message::error(&earlier);
                }
            }
        }
    }
    if args.json {
        let json = serde_json::to_string_pretty(&inspections).expect("plain data serialises");
        message::result(&format!("{json}\n"))?;
    } else {
        message::result(&inspections.iter().map(text).collect::<String>())?;
    }
    failed.map_or(Ok(()), Err)
}

fn inspect(args: &InspectArgs, file: &Path) -> Result<Inspection> {
    let mut inputs = args.roles.inputs(file);
    let survey = io::survey(file, inputs.view.as_deref())?;
    inputs.light = Some(LightInputs::default());
    let (findings, mut warnings, problem) = match look(inputs) {
        Ok((loaded, note)) => {
            let warnings = loaded.warnings.into_iter().chain(note);
            (loaded.findings, warnings.collect(), None)
        }
        Err(Error::Damaged { path, found }) => return Err(Error::Damaged { path, found }),
        Err(error) => (Vec::new(), Vec::new(), Some(error.to_string())),
    };
    warnings.extend(planned_dark_rims(args));
    Ok(Inspection {
        file: file.to_path_buf(),
        survey,
        findings,
        warnings,
        problem,
    })
}

/// Reads the frame, or as many rows in its middle as fit; then that is said.
fn look(mut inputs: Inputs) -> Result<(Loaded, Option<String>)> {
    let files = InputFiles::open_within(&inputs, MOST_OF_A_PHOTO)?;
    let height = files.extent(&inputs, EVERYTHING)?.window.height();
    let bytes = frame_bytes(&inputs.picture, 0);
    let mut note = None;
    if bytes > MOST_BYTES {
        let row = bytes.div_ceil(height.max(1) as u64);
        let rows = ((MOST_BYTES - MOST_OF_A_PHOTO) / row).clamp(1, height as u64) as usize;
        let first = (height - rows) / 2;
        inputs.rows = Some(first..first + rows);
        note = Some(format!(
            "conclusions are drawn from the {rows} rows in the middle, of {height}: the whole takes more than {} MiB",
            MOST_BYTES >> 20
        ));
    }
    Ok((files.load(&inputs, EVERYTHING)?, note))
}

/// What the magnitude that is planned would do to concavities; nothing where none was told.
fn planned_dark_rims(args: &InspectArgs) -> Vec<String> {
    let usual = ScalingParams::default();
    if args.scaling.or(args.invariant_point).is_none() {
        return Vec::new();
    }
    dark_rims(&ScalingParams {
        scaling: args.scaling.unwrap_or(usual.scaling),
        invariant_point: args.invariant_point.unwrap_or(usual.invariant_point),
        ..usual
    })
}

fn text(inspection: &Inspection) -> String {
    let mut out = String::new();
    let Inspection {
        file,
        survey,
        findings,
        warnings,
        problem,
    } = inspection;
    // Writing to a string cannot fail.
    let _ = writeln!(out, "{}", file.display());
    let _ = writeln!(
        out,
        "  display {}, pixel aspect {}",
        survey.display_window, survey.pixel_aspect
    );
    if let Some(view) = &survey.view {
        let views = survey.views.join(", ");
        let _ = writeln!(out, "  view {view} of {views}; force with --view {view}");
    }
    for part in &survey.parts {
        let _ = writeln!(out, "  {}", part_text(part));
        for layer in &part.layers {
            let components = layer.components.join(" ");
            let name = if layer.name.is_empty() {
                "(bare)"
            } else {
                &layer.name
            };
            let _ = writeln!(out, "    {name:<32} {components:<8} {}", layer.sample_type);
        }
    }
    let _ = writeln!(out, "  roles");
    for role in &survey.roles {
        let _ = writeln!(
            out,
            "    {:<20} {}",
            role.role.name(),
            role.channels.join(" ")
        );
    }
    let _ = writeln!(out, "  conclusions");
    for finding in findings {
        let _ = writeln!(out, "    {:<20} {}", finding.subject, finding.conclusion);
        let _ = writeln!(
            out,
            "      {}; force with {}",
            finding.evidence, finding.flag
        );
    }
    for warning in warnings {
        let _ = writeln!(out, "    warning: {warning}");
    }
    if let Some(problem) = problem {
        let _ = writeln!(out, "    cannot be used as it stands: {problem}");
    }
    out
}

fn part_text(part: &PartSurvey) -> String {
    let name = part
        .name
        .as_deref()
        .map_or(String::new(), |name| format!(" \"{name}\""));
    format!("part{name}: {}, {}", part.data_window, part.compression)
}
