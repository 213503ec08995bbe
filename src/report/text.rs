//! A report for the terminal, on one screen.

use super::{HARDLY, LeftOut, Report, Stored, Tried};
use crate::untrusted::Untrusted;

/// Milliseconds to three digits.
pub(super) fn ms(ms: f64) -> String {
    match ms {
        100.0.. => format!("{ms:.0}"),
        10.0.. => format!("{ms:.1}"),
        _ => format!("{ms:.2}"),
    }
}

/// A number of any size to two digits.
pub(super) fn scientific(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        0.01..1000.0 => format!("{value:.2}"),
        _ => format!("{value:.1e}"),
    }
}

/// A share of the pixels.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.0 => "0 %".into(),
        10.0.. => format!("{percent:.0} %"),
        0.1.. => format!("{percent:.1} %"),
        _ => "< 0.1 %".into(),
    }
}

/// The report, line by line.
pub(crate) fn lines(report: &Report) -> Vec<String> {
    let mut lines = vec![
        format!(
            "{}, {}x{}: {}",
            Untrusted(&report.frame.name),
            report.frame.width,
            report.frame.height,
            report.command
        ),
        report.verdict.sentence.clone(),
    ];
    lines.extend(hardly_shows(report));
    if let Some(reference) = &report.reference {
        let given = &report.settings[0].error;
        lines.push(format!(
            "as given {} of the pixels are off by more than 2 levels; the truth is {}, itself within {:.2} (99 % of pixels)",
            percent(given.beyond_2),
            reference.flags,
            reference.own.p99
        ));
        lines.push(String::new());
        let names = report.settings.iter().map(|s| name(s).chars().count());
        let width = names.max().unwrap_or(0);
        lines.push(format!(
            "  {:<width$} {:>6} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8}",
            "setting", "p50", "p99", "max", "> 1", "> 2", "CPU ms", "wall ms"
        ));
        lines.extend(report.settings.iter().map(|setting| row(setting, width)));
        lines.push(
            "  * nothing else is both quicker and more exact; errors in levels of 255".into(),
        );
    }
    lines.push(String::new());
    let (hardly, needed): (Vec<_>, Vec<_>) = can_be_left_out(report);
    if !hardly.is_empty() {
        lines.push("can be left out:".into());
        lines.extend(hardly.iter().map(|part| format!("  {}", without(part))));
    }
    if !needed.is_empty() {
        let of = |part: &&LeftOut| format!("{} ({})", part.name, percent(part.change.beyond_2));
        let needed: Vec<_> = needed.iter().map(of).collect();
        lines.push(format!(
            "needed (share of pixels that change by more than 2 levels without): {}",
            needed.join(", ")
        ));
    }
    lines.extend(files(report));
    lines.extend(
        report
            .warnings
            .iter()
            .map(|warning| format!("beware: {warning}")),
    );
    lines.push(trust(report));
    lines
}

/// That the command is hardly worth its while, where that is so.
pub(super) fn hardly_shows(report: &Report) -> Option<String> {
    let shows = report.verdict.shows.filter(|&shows| shows < HARDLY)?;
    Some(format!(
        "this command hardly shows here: it changes {} of the pixels by more than 2 levels",
        percent(shows)
    ))
}

/// Settings that change nothing, if there are any.
pub(super) fn same_stages(report: &Report) -> Option<String> {
    let same = &report.same_stages;
    (!same.is_empty()).then(|| format!("same stages as given: {}", same.join(", ")))
}

/// The parts that hardly change the picture, those that save most first, and those that do; the command itself is neither.
pub(super) fn can_be_left_out(report: &Report) -> (Vec<&LeftOut>, Vec<&LeftOut>) {
    let parts = report.parts.iter().filter(|part| !is_command(report, part));
    let (mut hardly, mut needed): (Vec<_>, Vec<_>) =
        parts.partition(|part| part.change.beyond_2 < HARDLY);
    hardly.sort_by(|a, b| b.cost.saved_ms.total_cmp(&a.cost.saved_ms));
    needed.sort_by(|a, b| b.change.beyond_2.total_cmp(&a.change.beyond_2));
    (hardly, needed)
}

fn is_command(report: &Report, part: &LeftOut) -> bool {
    report.verdict.shows.is_some() && part.name == report.parts[0].name
}

/// A part, what changes without it, and what that saves.
pub(super) fn without(part: &LeftOut) -> String {
    let changes = match part.change.largest {
        0.0 => "same picture".to_string(),
        _ => format!("{} of pixels", percent(part.change.beyond_2)),
    };
    let saves = match part.cost.saved_ms {
        0.0 => "no difference in time".to_string(),
        saved if saved > 0.0 => format!("saves {} ms", ms(saved)),
        longer => format!("takes {} ms longer", ms(-longer)),
    };
    format!("{:<26} {changes:<18} {saves:<24} {}", part.name, part.flags)
}

/// The name of a setting in tables.
pub(super) fn name(setting: &Tried) -> String {
    let name = match &setting.flags[..] {
        "" => "given",
        flags => flags,
    };
    match &setting.chosen {
        Some(chosen) => format!("{name} ({chosen})"),
        None => name.into(),
    }
}

fn row(setting: &Tried, width: usize) -> String {
    let error = &setting.error;
    let star = if setting.is_on_front { "*" } else { " " };
    let time = match setting.cost.is_in_rounds {
        true => ms(setting.cost.cpu_ms),
        false => format!("~{}", ms(setting.cost.cpu_ms)),
    };
    format!(
        "{star} {:<width$} {:>6.2} {:>6.2} {:>6.1} {:>8} {:>8} {:>8} {:>8}",
        name(setting),
        error.p50,
        error.p99,
        error.largest,
        percent(error.beyond_1),
        percent(error.beyond_2),
        time,
        ms(setting.cost.wall_ms)
    )
}

/// Kinds of files of the picture, where it makes one.
fn files(report: &Report) -> Vec<String> {
    let [_, _, ..] = report.files[..] else {
        return Vec::new();
    };
    let names = report.files.iter().map(|file| file.flags.len());
    let width = names.max().unwrap_or(0);
    let head = format!(
        "  {:<width$} {:>8} {:>8} {:>6} {:>6}",
        "file of the picture", "MB", "CPU ms", "p99", "max"
    );
    let row = |file: &Stored| {
        let (error, used) = (&file.error, ms(file.used.cpu_ms));
        format!(
            "  {:<width$} {:>8.2} {used:>8} {:>6.2} {:>6.2}",
            file.flags,
            megabytes(file),
            error.p99,
            error.largest
        )
    };
    std::iter::once(head)
        .chain(report.files.iter().map(row))
        .collect()
}

/// The size of a file.
pub(super) fn megabytes(file: &Stored) -> f64 {
    file.bytes as f64 / 1e6
}

/// How far to trust the times.
pub(super) fn trust(report: &Report) -> String {
    let given = report.settings[0].cost.cpu_ms;
    let trust = &report.trust;
    let share = 100.0 * trust.disagreement_ms / given.max(1e-9);
    let load = match trust.other_cores {
        Some(cores) if cores >= 0.2 => format!(
            "; other programs took {cores:.1} cores meanwhile, so times on the wall are upper bounds: run it again on a \
             quieter machine"
        ),
        _ => String::new(),
    };
    let build = match report.is_optimised {
        true => "",
        false => "; this is no optimised build, and its times mean little",
    };
    format!(
        "times: medians of {} rounds, good to {share:.0} % ({} ms){load}{build}; reading took {} ms and writing a PNG {} ms",
        trust.rounds,
        ms(trust.disagreement_ms),
        ms(report.read.wall_ms),
        ms(report.files[0].used.wall_ms)
    )
}
