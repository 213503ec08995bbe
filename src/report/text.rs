//! A report for the terminal, on one screen.

use super::{HARDLY, LeftOut, Report, StoredReport, Tried};
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
    let (on, command) = (&report.frame, &report.command);
    let name = Untrusted(&on.name);
    let mut lines = vec![
        format!("{name}, {}x{}: {command}", on.width, on.height),
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
        let rows = report.settings.iter().map(|setting| {
            let star = if setting.is_on_front { "*" } else { " " };
            (star, cells_of_setting(setting))
        });
        lines.extend(table(SETTING, rows.collect()));
        lines.push(
            "  * nothing else is both quicker and more exact; errors in levels of 255".into(),
        );
    }
    lines.push(String::new());
    let (hardly, needed): (Vec<_>, Vec<_>) = can_be_left_out(report);
    if !hardly.is_empty() {
        let rows = hardly.iter().map(|part| (" ", cells_of_part(part)));
        lines.extend(table(LEFT_OUT, rows.collect()));
    }
    if !needed.is_empty() {
        let of = |part: &&LeftOut| format!("{} ({})", part.name, percent(part.change.beyond_2));
        let needed: Vec<_> = needed.iter().map(of).collect();
        lines.push(format!(
            "needed (share of pixels that change by more than 2 levels without): {}",
            needed.join(", ")
        ));
    }
    if report.files.len() > 1 {
        let rows = report.files.iter().map(|file| (" ", cells_of_file(file)));
        lines.extend(table(FILE, rows.collect()));
    }
    let warnings = report.warnings.iter();
    lines.extend(warnings.map(|warning| format!("beware: {warning}")));
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

/// Heads of the table of what can be left out.
pub(super) const LEFT_OUT: [&str; 5] = ["can be left out", "pixels > 2", "max", "saves ms", FLAGS];

/// A row of that table.
pub(super) fn cells_of_part(part: &LeftOut) -> [String; 5] {
    let saved = match part.cost.saved_ms {
        0.0 => "no difference".to_string(),
        saved => format!("{}{}", if saved < 0.0 { "-" } else { "" }, ms(saved.abs())),
    };
    let (changed, largest) = (percent(part.change.beyond_2), part.change.largest);
    [
        part.name.into(),
        changed,
        format!("{largest:.2}"),
        saved,
        part.flags.clone(),
    ]
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

/// Heads of the table of settings.
pub(super) const SETTING: [&str; 8] = [
    "setting", "p50", "p99", "max", "> 1", "> 2", "CPU ms", "wall ms",
];

/// A row of that table.
pub(super) fn cells_of_setting(setting: &Tried) -> [String; 8] {
    let (error, cost) = (&setting.error, &setting.cost);
    let [p50, p99, max] = [error.p50, error.p99, error.largest].map(|e| format!("{e:.2}"));
    let [beyond_1, beyond_2] = [error.beyond_1, error.beyond_2].map(percent);
    let once = if cost.is_in_rounds { "" } else { "~" };
    let cpu = format!("{once}{}", ms(cost.cpu_ms));
    let wall = ms(cost.wall_ms);
    [name(setting), p50, p99, max, beyond_1, beyond_2, cpu, wall]
}

/// Heads of the table of files of the picture.
pub(super) const FILE: [&str; 5] = ["file of the picture", "MB", "CPU ms", "p99", "max"];

/// A row of that table.
pub(super) fn cells_of_file(file: &StoredReport) -> [String; 5] {
    let megabytes = file.bytes as f64 / 1e6;
    let [size, p99, max] =
        [megabytes, file.error.p99, file.error.largest].map(|v| format!("{v:.2}"));
    [file.flags.clone(), size, ms(file.used.cpu_ms), p99, max]
}

/// The head of a column of flags.
const FLAGS: &str = "by";

/// A table: its heads, and rows with their mark. Numbers end alike; the first column and flags begin alike.
fn table<const N: usize>(heads: [&str; N], rows: Vec<(&str, [String; N])>) -> Vec<String> {
    let rows = std::iter::once((" ", heads.map(String::from))).chain(rows);
    let rows: Vec<_> = rows.collect();
    let widths: [usize; N] = std::array::from_fn(|i| {
        let cells = rows.iter().map(|(_, cells)| cells[i].chars().count());
        cells.max().unwrap_or(0)
    });
    let line = |(mark, cells): &(&str, [String; N])| {
        let cells = cells.iter().zip(widths).enumerate();
        let cells = cells.map(|(i, (cell, width))| match i == 0 || heads[i] == FLAGS {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        format!("{mark} {}", cells.collect::<Vec<_>>().join("  "))
            .trim_end()
            .to_string()
    };
    rows.iter().map(line).collect()
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
