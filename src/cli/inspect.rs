//! `relievo inspect`.

use super::inspect_motion;
use super::message;
use super::panics::caught;
use super::threads::on_threads;
use crate::command::commands::InspectArgs;
use crate::error::{Error, Result};
use crate::io::inputs::{Inputs, LightInputs};
use crate::io::{
    self, Finding, Holding, InputFiles, Loaded, Needs, ObjectSurvey, PartSurvey, Survey,
    frame_bytes,
};
use crate::params::ScalingParams;
use crate::untrusted::{Untrusted, bounded, listed};
use crate::work::dark_rims;
use serde::Serialize;
use std::path::Path;

/// Most characters of a line.
const WIDTH: usize = 100;

/// Most memory that is taken to look into a file.
const MOST_BYTES: u64 = 1 << 30;

/// Most of it that the samples of one photo take; of larger ones rows are decoded alone.
const MOST_OF_A_PHOTO: u64 = 256 << 20;

/// Findings on one file; the JSON form of `inspect`, documented in docs/guide/files.md.
#[derive(Debug, Serialize)]
struct Inspection {
    /// Its path, with anything not UTF-8 replaced.
    file: String,
    #[serde(flatten)]
    survey: Survey,
    findings: Vec<Finding>,
    warnings: Vec<String>,
    /// Why no frame can be made of the file as it stands.
    problem: Option<String>,
}

pub(super) fn run(args: &InspectArgs) -> Result<()> {
    on_threads(None, || inspect_all(args))
}

fn inspect_all(args: &InspectArgs) -> Result<()> {
    let mut inspections = Vec::new();
    let mut failed = None;
    for file in &args.files {
        match caught(file, || inspect(args, file)) {
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
        message::json(&inspections)?;
    } else {
        message::result(inspections.iter().flat_map(lines))?;
    }
    failed.map_or(Ok(()), Err)
}

fn inspect(args: &InspectArgs, file: &Path) -> Result<Inspection> {
    let mut inputs = args.roles.inputs(file);
    let survey = io::survey(&inputs)?;
    inputs.light = Some(LightInputs::default());
    let (findings, mut warnings, problem) = match look(inputs.clone()) {
        Ok((loaded, note)) => {
            let motion = match note {
                None => inspect_motion::finding(&inputs)?,
                Some(_) => None,
            };
            let warnings = loaded.warnings.into_iter().chain(note);
            let findings = loaded.findings.into_iter().chain(motion);
            (findings.collect(), warnings.collect(), None)
        }
        Err(Error::Damaged { path, found }) => return Err(Error::Damaged { path, found }),
        Err(error) => (Vec::new(), Vec::new(), Some(error.to_string())),
    };
    warnings.extend(planned_dark_rims(args));
    Ok(Inspection {
        file: file.display().to_string(),
        survey,
        findings,
        warnings,
        problem,
    })
}

/// Reads the frame, or as many rows in its middle as fit; then that is said.
fn look(mut inputs: Inputs) -> Result<(Loaded, Option<String>)> {
    let files = InputFiles::open(&inputs, Holding::within(MOST_OF_A_PHOTO))?;
    // The camera is worth knowing even where the normals need none.
    let needs = Needs {
        projection: true,
        ..Needs::default()
    };
    let bytes = frame_bytes(&inputs.picture, 0, false);
    let mut note = None;
    if bytes > MOST_BYTES {
        let height = files.extent(&inputs, needs)?.window.height();
        let row = bytes.div_ceil(height.max(1) as u64);
        let rows = ((MOST_BYTES - MOST_OF_A_PHOTO) / row).clamp(1, height as u64) as usize;
        let first = (height - rows) / 2;
        inputs.rows = Some(first..first + rows);
        note = Some(format!(
            "conclusions are drawn from the {rows} rows in the middle, of {height}: the whole takes more than {} MiB",
            MOST_BYTES >> 20
        ));
    }
    Ok((files.load(&inputs, needs)?, note))
}

/// Warnings of dark rims in concavities at the planned magnitude; none if neither magnitude nor invariant point is given.
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

fn lines(inspection: &Inspection) -> Vec<String> {
    let Inspection {
        file,
        survey,
        findings,
        warnings,
        problem,
    } = inspection;
    let mut lines = vec![
        Untrusted(file).to_string(),
        format!(
            "  display {}, pixel aspect {}",
            survey.display_window, survey.pixel_aspect
        ),
    ];
    if let Some(view) = &survey.view {
        let (view, views) = (Untrusted(view), listed(&survey.views));
        let flag = view.word();
        lines.push(format!(
            "  view {view} of {views}; force with --view {flag}"
        ));
    }
    if !survey.groups.is_empty() {
        let groups = listed(&survey.groups);
        lines.push(match &survey.group {
            Some(group) => {
                let (group, flag) = (Untrusted(group), Untrusted(group).word());
                format!("  group {group} of {groups}; force with --layer {flag}")
            }
            None => format!("  groups {groups}"),
        });
    }
    lines.extend(survey.parts.iter().flat_map(part_lines));
    lines.push("  roles".into());
    lines.extend(survey.roles.iter().map(|role| {
        let channels = role.channels.join(" ");
        format!("    {:<20} {channels}", role.role.name())
    }));
    if !survey.objects.is_empty() {
        lines.push("  objects".into());
        lines.extend(survey.objects.iter().flat_map(object_lines));
    }
    lines.push("  conclusions".into());
    for finding in findings {
        let Finding {
            subject,
            conclusion,
            evidence,
            flag,
        } = finding;
        lines.push(format!("    {subject:<20} {conclusion}"));
        lines.push(format!("      {evidence}; force with {flag}"));
    }
    let warnings = warnings.iter();
    lines.extend(warnings.map(|warning| format!("    warning: {warning}")));
    let problem = problem.iter();
    lines.extend(problem.map(|problem| format!("    cannot be used as it stands: {problem}")));
    lines
        .iter()
        .flat_map(|line| wrapped(&bounded(line)))
        .collect()
}

/// A line as several of at most [`WIDTH`] characters, those after the first further to the right; words stay whole.
fn wrapped(line: &str) -> Vec<String> {
    let margin = line.len() - line.trim_start().len();
    let mut lines = vec![" ".repeat(margin)];
    let mut spaces = 0;
    for word in line[margin..].split(' ') {
        if word.is_empty() {
            spaces += 1;
            continue;
        }
        let last = lines.last_mut().expect("begins with one");
        let used = last.chars().count();
        match used > margin && used + spaces + word.chars().count() > WIDTH {
            true => lines.push(format!("{}{word}", " ".repeat(margin + 2))),
            false => *last += &(" ".repeat(spaces) + word),
        }
        spaces = 1;
    }
    lines
}

/// The names in one layer of Cryptomatte, as many in a line as fit.
fn object_lines(survey: &ObjectSurvey) -> Vec<String> {
    let unnamed = match survey.shares.is_empty() {
        true => "",
        false => " without a manifest, the largest by their hashes",
    };
    let mut lines = vec![format!("    {}{unnamed}", Untrusted(&survey.layer))];
    let mut line = String::new();
    for (i, name) in survey.names.iter().enumerate() {
        let name = Untrusted(name);
        let name = &match survey.shares.get(i) {
            Some(share) => format!("{name} ({:.1} %)", 100.0 * share),
            None => name.to_string(),
        };
        if !line.is_empty() && line.len() + name.len() + 2 > WIDTH - 6 {
            lines.push(format!("      {line},"));
            line.clear();
        }
        let space = if line.is_empty() { "" } else { ", " };
        line += space;
        line += name;
    }
    let last = match survey.names.is_empty() {
        true => "(no manifest names them, and their samples cannot be read)",
        false => &line,
    };
    lines.push(format!("      {last}"));
    lines
}

fn part_lines(part: &PartSurvey) -> Vec<String> {
    let name = part.name.as_deref();
    let name = name.map_or(String::new(), |name| format!(" \"{}\"", Untrusted(name)));
    let head = format!("  part{name}: {}, {}", part.data_window, part.compression);
    let layers = part.layers.iter().map(|layer| {
        let name = match layer.name.as_str() {
            "" => Untrusted("(bare)"),
            name => Untrusted(name),
        };
        let components = layer.components.join(" ");
        format!("    {name:<32} {components:<8} {}", layer.sample_type)
    });
    std::iter::once(head).chain(layers).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_wrapped_and_short_ones_stay() {
        let short = "    normal               ViewLayer.Normal  x";
        assert_eq!(wrapped(short), [short]);
        assert_eq!(wrapped(""), [""]);
        // 4 + 16 words of 5 letters and 15 spaces are 99; the next word begins a line.
        let long = format!("    {}", ["words"; 20].join(" "));
        let [first, second] = &wrapped(&long)[..] else {
            panic!("two lines of {long}");
        };
        assert_eq!(
            (first.len(), second.as_str()),
            (99, "      words words words words")
        );
        let whole = "x".repeat(150);
        assert_eq!(
            wrapped(&format!("  {whole} y")),
            [format!("  {whole}"), "    y".into()]
        );
    }
}
