//! The cheapest setting within a given error, in words.

use super::Report;
use super::light::LightReport;
use super::light::lit::LitMaterial;
use super::light::samples::Sweep;
use super::mirrors::MirrorReport;
use super::mirrors::bench::MirrorRow;
use super::numbers::{milliseconds, rounded, scientific};
use super::sweeps::solver::{ScaleSweep, SolverRow};
use crate::params::{Method, Solver};

/// Error budgets to recommend settings for, relative to the largest |g|.
pub(crate) const BUDGETS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// The cheapest row of `sweep` that flags can select and whose largest gradient error is within `budget`.
pub(crate) fn cheapest(sweep: &ScaleSweep, budget: f64) -> Option<&SolverRow> {
    let good = sweep
        .rows
        .iter()
        .filter(|row| row.flags.is_some() && row.gradient.max <= budget);
    good.min_by(|a, b| a.diffusion.min.total_cmp(&b.diffusion.min))
}

/// One sentence on the cost and error of the given settings, and on a cheaper one that suffices.
pub(crate) fn sentence(report: &Report) -> String {
    let sweep = &report.frame.scales[0];
    let Some(asked) = sweep.rows.iter().find(|row| row.asked_for) else {
        return format!("At {} nothing is diffused.", sweep.scale);
    };
    let start = format!(
        "At {} the settings asked for (by {}, {}) diffuse in {} and all stages take {}, with a largest error of {} \
         of the steepest slope, {} grey levels of 255 in the curvature picture",
        sweep.scale,
        match asked.solver {
            Solver::Explicit => "explicit steps",
            Solver::Chebyshev => "expansion",
        },
        asked.setting,
        milliseconds(asked.diffusion.min),
        milliseconds(asked.whole.min),
        scientific(asked.gradient.max),
        rounded(asked.grey_levels),
    );
    // Errors below half a grey level are invisible; only a setting that saves time is recommended.
    let enough = |row: &&SolverRow| row.flags.is_some() && row.grey_levels < 0.5;
    let best = sweep
        .rows
        .iter()
        .filter(enough)
        .min_by(|a, b| a.diffusion.min.total_cmp(&b.diffusion.min));
    match best {
        Some(best) if best.diffusion.min < 0.95 * asked.diffusion.min && !best.asked_for => {
            format!(
                "{start}; `{}` is enough for half a grey level ({}) and saves {}.",
                best.flags.as_deref().unwrap_or_default(),
                rounded(best.grey_levels),
                milliseconds(asked.diffusion.min - best.diffusion.min),
            )
        }
        Some(_) => {
            format!("{start}; nothing tried is faster by 5 % and right to half a grey level.")
        }
        None => format!("{start}; nothing tried is right to half a grey level."),
    }
}

/// The number of environment samples that suffices for the frame, and whether prefiltered maps do.
pub(crate) fn of_light(light: &LightReport) -> String {
    let subject = &light.subjects[0];
    if subject.on.covered == 0 {
        return "Nothing is covered that light could fall on.".into();
    }
    let enough = |sweep: &Sweep| {
        let number = match sweep.enough {
            Some(count) => format!("{count} lights"),
            None => "more than were tried".into(),
        };
        format!(
            "{number} for {} {}",
            altered(sweep.method),
            noun(sweep.surface)
        )
    };
    let numbers: Vec<_> = subject.samples.iter().map(enough).collect();
    let plain = |surface| {
        let mut rows = subject.prefiltered.iter();
        rows.find(|row| row.surface == surface && !row.method.warps())
    };
    let prefiltered = LitMaterial::ALL.into_iter().filter_map(plain).map(|row| {
        let serves = if row.serves { "serves" } else { "does not" };
        let off = scientific(row.difference.errors.p99);
        format!("for {} {serves} ({off})", noun(row.surface))
    });
    let prefiltered: Vec<_> = prefiltered.collect();
    format!(
        "Of the report's environment, 99 pixels in 100 are within 1/255 of white by {}; a prefiltered map, unwarped, {}.",
        numbers.join(", "),
        prefiltered.join(" and "),
    )
}

/// Share of sight lines that a setting may miss beyond those missed by the most expensive one: one in 200.
pub(crate) const ASTRAY: f64 = 0.005;

/// The first of `rows`, cheapest first, with hardly more stray sight lines than the last.
pub(crate) fn enough_of(rows: &[MirrorRow]) -> Option<&MirrorRow> {
    let best = rows.last()?.astray();
    rows.iter().find(|row| row.astray() <= best + ASTRAY)
}

/// The numbers of steps, refinements and map rows that suffice for mirrors.
pub(crate) fn of_mirrors(mirrors: &MirrorReport) -> String {
    let MirrorReport {
        steps,
        refinements,
        map_heights,
        ..
    } = mirrors;
    let all = [steps, refinements, map_heights].map(|rows| enough_of(rows));
    let ([Some(step), Some(refined), Some(map)], Some(fewest), Some(most)) =
        (all, steps.first(), steps.last())
    else {
        return "No mirror was traced.".into();
    };
    let missed = |row: &MirrorRow| {
        let share = 100.0 * row.columns_missed;
        format!(
            "{} steps miss {} %",
            row.setting.search.steps,
            rounded(share)
        )
    };
    format!(
        "In the report's mirror ball {} steps of the search, {} refinements and a map of {} rows are each enough to find what \
         the most tried do, to one pixel in {:.0}; of the pixels that show columns {} and {}.",
        step.setting.search.steps,
        refined.setting.search.refinements,
        map.setting.map_height,
        1.0 / ASTRAY,
        missed(fewest),
        missed(most),
    )
}

/// The lighting method in words.
pub(crate) fn altered(method: Method) -> &'static str {
    if method.warps() { "warped" } else { "plain" }
}

/// The lobe in words.
pub(crate) fn noun(surface: LitMaterial) -> &'static str {
    match surface {
        LitMaterial::Lambert => "diffuse light",
        LitMaterial::Glossy => "highlights",
    }
}
