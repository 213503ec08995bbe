//! The report as a page of Markdown: prose, and tables declared column by column.

mod drawing;
mod light;
mod mirrors;
mod relief;
mod sequence;
mod stability;

use super::Report;
use super::advice::{BUDGETS, cheapest, sentence};
use super::compare::Errors;
use super::numbers::{milliseconds, rounded, scientific};
use super::plots::{self, DIRECTIONS, RIM};
use super::sweeps::directions::Sweep;
use super::sweeps::rim::{BANDS, FORESHORTENINGS};
use super::sweeps::solver::{ScaleSweep, SceneSweep, SolverRow};
use super::timing::Utilisation;
use crate::untrusted::Untrusted;
use std::fmt::{self, Display};

/// Stages named on the first page.
const LONGEST: usize = 6;

/// The pictures of the first page, side by side.
pub(crate) const SHEET: &str = "sheet.png";

/// The whole page. Its pictures are expected next to it.
pub(crate) fn page(report: &Report) -> String {
    let of = |section: Option<String>| section.unwrap_or_default();
    let sections = [
        first_page(report),
        "# Appendix: every number".into(),
        head(report),
        solvers(&report.frame, "The frame", plots::FRAME),
        exact_scenes(report),
        stages(report),
        if_any(&report.runs, || runs(report)),
        precision(report),
        of(report.directions.as_ref().map(directions)),
        if_any(&report.rim_of_ball, || rim(report)),
        of(report.light.as_ref().map(light::section)),
        of(report.drawing.as_ref().map(drawing::section)),
        of(report.mirrors.as_ref().map(mirrors::section)),
        of(report.relief.as_ref().map(relief::section)),
        sequence::section(report.coherence.as_ref()),
        if_any(&report.stability, || stability::section(&report.stability)),
    ];
    let sections = sections.iter().map(|section| section.trim_end());
    let sections: Vec<_> = sections.filter(|section| !section.is_empty()).collect();
    sections.join("\n\n") + "\n"
}

/// A section of rows, if there are any.
fn if_any<T>(rows: &[T], section: impl FnOnce() -> String) -> String {
    match rows {
        [] => String::new(),
        _ => section(),
    }
}

/// What most readers want to know: two screens.
pub(crate) fn first_page(report: &Report) -> String {
    let Report { machine, frame, .. } = report;
    let unoptimised = match report.optimised {
        true => "",
        false => " **Built without optimisation: the times mean little.**",
    };
    let sheet = match &report.answers.sheet {
        Some(_) => format!("\n![Before, enhanced, and the curvature]({SHEET})\n"),
        None => String::new(),
    };
    let warnings = match &report.answers.warnings[..] {
        [] => "- nothing: no clipping, no coarse or blended samples, nothing unstable\n".into(),
        some => some
            .iter()
            .map(|text| format!("- {text}\n"))
            .collect::<String>(),
    };
    format!(
        "# relievo report: {}\n\n{}x{}, {} pixels of surface; relievo {} on {} threads.{unoptimised}\n{sheet}\n{}\n\n\
         ![Error against time]({})\n\n{}\n\n## Warnings\n\n{warnings}\n{}",
        Untrusted(&frame.on.name).markdown(),
        frame.on.width,
        frame.on.height,
        frame.on.covered,
        report.version,
        machine.threads,
        enough(report).trim_end(),
        plots::FRAME,
        not_needed(report).trim_end(),
        longest(report),
    )
}

/// The stages that take most of the time.
fn longest(report: &Report) -> String {
    let all = report.stages.iter().find(|row| row.stage == "all");
    let whole = all.map_or(0.0, |row| row.times.min);
    let mut stages: Vec<_> = report
        .stages
        .iter()
        .filter(|row| row.stage != "all")
        .collect();
    stages.sort_by(|a, b| b.times.min.total_cmp(&a.times.min));
    stages.truncate(LONGEST);
    let table = table!(stages, row => {
        "stage": row.stage,
        "least of several": milliseconds(row.times.min),
        "of all": percent(row.times.min / whole.max(f64::MIN_POSITIVE)),
    });
    format!(
        "## Where the time of all layers goes\n\nAll stages take {}, without reading and writing.\n\n{table}",
        milliseconds(whole)
    )
}

/// A table: the names of its columns, and one cell per column in every row.
struct Table {
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn new(head: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> Self {
        let rows = rows.collect();
        Self { head, rows }
    }

    /// Drops columns that are blank in every row.
    fn without_blank_columns(mut self) -> Self {
        let is_blank = |i: usize| self.rows.iter().all(|row| row[i].is_empty());
        for i in (0..self.head.len())
            .rev()
            .filter(|&i| is_blank(i))
            .collect::<Vec<_>>()
        {
            self.head.remove(i);
            self.rows.iter_mut().for_each(|row| drop(row.remove(i)));
        }
        self
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Escapes bars, which would end a cell; names have none.
        let line = |cells: &[String]| cells.join("\0").replace('|', "\\|").replace('\0', " | ");
        writeln!(
            f,
            "| {} |\n|{}",
            line(&self.head),
            "---|".repeat(self.head.len())
        )?;
        for row in &self.rows {
            writeln!(f, "| {} |", line(row))?;
        }
        writeln!(f)
    }
}

/// A [`Table`] with `"name": cell` for each column, where each cell is computed from a row.
macro_rules! table {
    ($rows:expr, $row:pat_param => { $($name:literal: $cell:expr),+ $(,)? }) => {
        $crate::report::markdown::Table::new(
            vec![$($name.to_string()),+],
            $rows.into_iter().map(|$row| vec![$($cell.to_string()),+]),
        )
    };
}
use table;

/// The value, or nothing.
fn or_blank(value: Option<impl Display>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn bold_if(holds: bool, text: impl Display) -> String {
    if holds {
        format!("**{text}**")
    } else {
        text.to_string()
    }
}

fn yes_or(no: &'static str, holds: bool) -> &'static str {
    if holds { "yes" } else { no }
}

/// Column and row of the largest error.
fn place(errors: &Errors) -> String {
    or_blank(errors.worst.map(|[x, y]| format!("{x}, {y}")))
}

fn mean_and_max(errors: &Errors) -> String {
    [errors.mean, errors.max].map(scientific).join(" / ")
}

fn percent(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

fn percent_to_a_tenth(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

fn head(report: &Report) -> String {
    let Report { machine, frame, .. } = report;
    format!(
        "The machine: memory {} GB/s (triad over 3 x 64 MiB), arithmetic {} Gop/s ({}, single precision, as this build is \
         vectorised). Steepest slope of the frame: {}.\n\n\
         Errors of slopes, and of the curvature (the trace of the Hessian, per pixel), are relative to the \
         steepest slope, max |g| before diffusion. The reference is double precision from the same input; where rounding \
         before a threshold can move a conductance, it takes the one found within that range. \
         Times are without reading and writing, in the memory of earlier runs, as for the second \
         and later frames of a sequence; `min` is the least of several runs.",
        rounded(machine.bytes_per_second / 1e9),
        rounded(machine.operations_per_second / 1e9),
        machine.multiply_add,
        rounded(frame.steepest),
    )
}

fn enough(report: &Report) -> String {
    let sweep = &report.frame.scales[0];
    let flags = |row: &SolverRow| {
        format!(
            "`{} {}`",
            sweep.flag,
            row.flags.as_deref().unwrap_or_default()
        )
    };
    // A setting that serves several budgets stands once, with the tightest.
    let mut rows: Vec<(f64, Option<&SolverRow>)> = Vec::new();
    for budget in BUDGETS {
        let row = cheapest(sweep, budget);
        match rows.last_mut() {
            Some((tightest, last)) if last.map(flags) == row.map(flags) => *tightest = budget,
            _ => rows.push((budget, row)),
        }
    }
    let table = table!(rows, (budget, row) => {
        "largest error within": scientific(budget),
        "cheapest": row.map_or("nothing tried".into(), flags),
        "sweeps": or_blank(row.map(|row| row.applications)),
        "diffusion": or_blank(row.map(|row| milliseconds(row.diffusion.min))),
        "all stages": or_blank(row.map(|row| milliseconds(row.whole.min))),
        "largest error": or_blank(row.map(|row| scientific(row.gradient.max))),
        "grey levels of 255": or_blank(row.map(|row| rounded(row.grey_levels))),
    });
    format!("## What is enough\n\n{}\n\n{table}", sentence(report))
}

/// Stages that are left out, by reason.
fn not_needed(report: &Report) -> String {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for skipped in report.decisions.iter().filter(|d| !d.kept) {
        let (reason, step) = (skipped.reason.as_str(), skipped.step);
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, steps)) => steps.push(step),
            None => reasons.push((reason, vec![step])),
        }
    }
    let lines = reasons
        .iter()
        .map(|(reason, steps)| format!("- {reason}: {}\n", steps.join(", ")));
    format!(
        "## What a picture of this frame's curvature does not need\n\n{}",
        lines.collect::<String>()
    )
}

fn solvers(sweep: &SceneSweep, title: &str, plot: &str) -> String {
    let edges = &sweep.edges;
    let [silhouette, crease, conductance] =
        [&edges.silhouette, &edges.crease, &edges.conductance].map(|e| scientific(e.max));
    let scale = |scale: &ScaleSweep| {
        let sigma = match scale.scale.starts_with("sigma") {
            true => String::new(),
            false => format!(", sigma {} px", rounded(scale.sigma_px)),
        };
        format!("\n### {}{sigma}\n\n{}", scale.scale, solver_table(scale))
    };
    format!(
        "## {title}\n\n{}, {} pixels covered: {}. Largest errors of edge weights, 0 to 1: silhouettes {silhouette}, creases \
         {crease}, conductance {conductance}.\n\n![Error against time]({plot})\n{}",
        sweep.on.markdown(),
        sweep.on.covered,
        sweep.about,
        sweep.scales.iter().map(scale).collect::<String>()
    )
}

fn solver_table(scale: &ScaleSweep) -> String {
    // A star inside the bold text would break its markup.
    let mark = |row: &SolverRow| if row.asked_for { " \\*" } else { "" };
    let table = table!(&scale.rows, row => {
        "solver": format!("{:?}", row.solver),
        "setting": bold_if(row.on_front, &row.setting) + mark(row),
        "sweeps": row.applications,
        "allowed": or_blank(row.allowed.map(scientific)),
        "mean": scientific(row.gradient.mean),
        "99 %": scientific(row.gradient.p99),
        "max": scientific(row.gradient.max),
        "worst at": place(&row.gradient),
        "overshoot": scientific(row.overshoot),
        "not finite": row.gradient.non_finite + row.trace.non_finite,
        "curvature max": scientific(row.trace.max),
        "diffusion min / median": row.diffusion,
        "all min / median": row.whole,
        "Mpix/s": rounded(row.megapixels_per_second),
        "bandwidth": percent(row.utilisation.of_bandwidth),
        "arithmetic": percent(row.utilisation.of_arithmetic),
        "curvature against closed form, mean / max": or_blank(row.against_closed_form.as_ref().map(mean_and_max)),
    });
    let left_out = match scale.left_out.as_slice() {
        [] => String::new(),
        settings => format!(" Left out for their time: {}.", settings.join(", ")),
    };
    format!(
        "{}Bold: on the Pareto front. \\*: what was asked for.{left_out}\n",
        table.without_blank_columns()
    )
}

fn exact_scenes(report: &Report) -> String {
    let section = |scene: &SceneSweep| {
        let title = format!("Exact scene: {}", scene.on.name);
        solvers(scene, &title, &plots::of_scene(scene)) + "\n"
    };
    report.scenes.iter().map(section).collect()
}

fn stages(report: &Report) -> String {
    let used =
        |row: &super::StageRow, of: fn(Utilisation) -> String| or_blank(row.utilisation.map(of));
    let table = table!(&report.stages, row => {
        "stage": row.stage,
        "min / median": row.times,
        "Mpix/s": rounded(row.megapixels_per_second),
        "GB/s": used(row, |u| rounded(u.bytes_per_second / 1e9)),
        "of bandwidth": used(row, |u| percent(u.of_bandwidth)),
        "Gop/s": used(row, |u| rounded(u.operations_per_second / 1e9)),
        "of arithmetic": used(row, |u| percent(u.of_arithmetic)),
    });
    format!(
        "## Stages of the whole descriptor\n\nBytes and operations are what an ideal pass would move and \
         compute: every plane in and out once, a logarithm or power as 20 operations. Above 100 % a frame stays in a cache.\n\n{table}"
    )
}

fn runs(report: &Report) -> String {
    let table = table!(&report.runs, row => {
        "varied": row.dimension,
        "value": row.value,
        "scale": row.scale,
        "all stages min / median": row.whole,
        "speed-up": format!("{:.2}", row.speedup),
        "same bits": yes_or("**no**", row.same_bits),
    });
    format!(
        "## Ways of running\n\nSpeed-ups are over the first row of each kind. Tiles are of this size at most, and evened \
         out so that every thread gets as many: a whole frame is cut into one for each.\n\n{table}"
    )
}

fn precision(report: &Report) -> String {
    let table = table!(&report.precision, row => {
        "frame": Untrusted(&row.frame).markdown(),
        "stored as": format!("{:?}", row.stored).to_lowercase(),
        "scale": row.scale,
        "gradient mean / 99 % / max": row.gradient,
        "curvature mean / 99 % / max": row.trace,
        "worst at": place(&row.trace),
        "edge pixels moved": row.edges_moved,
    });
    format!(
        "## Half and byte input against float\n\nNormals (and depth, for half) rounded, renormalised as on reading, and \
         analysed; compared with the reference of the input as it came. Pixels whose conductance changed by more than one \
         half are counted as moved edges and left out of the errors.\n\n{table}"
    )
}

fn directions(sweep: &Sweep) -> String {
    let table = table!(&sweep.rows, row => {
        "normals": format!("{:?}", row.stored).to_lowercase(),
        "step px": match (row.step_px, row.steps_px) {
            (Some(step), _) => step.to_string(),
            (None, [least, most]) if least == most => format!("auto: {least}"),
            (None, [least, most]) => format!("auto: {least} to {most}"),
        },
        "mean degrees": rounded(row.error.mean),
        "95 %": rounded(row.error.p95),
        "max": rounded(row.error.max),
        "normal-rays min / median": row.stage,
        "Mpix/s": rounded(row.megapixels_per_second),
    });
    format!(
        "## Directions of the surface's curvature\n\nOn {}, seen along parallel lines, {}x{}, from normals alone: the angle \
         between the directions found and those of its implicit form, in {} pixels whose n_z is above 0.35 and whose \
         curvatures differ by more than a tenth. Twice the step is four times the error of the surface's own change, and half \
         that of rounding; `auto` takes its wider step only where the narrow one tells nothing.\n\n\
         ![Error against step]({DIRECTIONS})\n\n{table}",
        sweep.about, sweep.on.width, sweep.on.height, sweep.pixels,
    )
}

fn rim(report: &Report) -> String {
    let bands = BANDS
        .windows(2)
        .map(|b| format!("n_z {} to {}", b[0], b[1]));
    let names = ["foreshortening", "min_nz"].map(String::from);
    let rows = report.rim_of_ball.iter().map(|row| {
        let setting = [row.foreshortening, row.min_nz].map(|v| v.to_string());
        setting
            .into_iter()
            .chain(row.bands.iter().map(mean_and_max))
            .collect()
    });
    let on_ball = Table::new(names.into_iter().chain(bands).collect(), rows);
    let on_frame = table!(&report.rim_of_frame, row => {
        "foreshortening": row.foreshortening,
        "min_nz": row.min_nz,
        "max |g|": rounded(row.steepest),
        "sweeps": row.applications,
        "mean": scientific(row.gradient.mean),
        "max": scientific(row.gradient.max),
        "worst at": place(&row.gradient),
        "overshoot": scientific(row.overshoot),
    });
    format!(
        "## Near silhouettes: foreshortening and min_nz\n\nOn a ball of 4000 px radius, undiffused, the error of the curvature \
         relative to its closed form, mean / max by n_z, for foreshortenings {}. Under the floor the slope grows \
         like n_xy alone; without foreshortening there is no floor.\n\n![Error by n_z]({RIM})\n\n{on_ball}\n\
         On the frame, by expansion at the tolerance asked for, relative to the max |g| of each row:\n\n{on_frame}",
        FORESHORTENINGS.map(|f| f.to_string()).join(", "),
    )
}
