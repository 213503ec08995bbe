//! Run options: they change the time and must not change a bit of the result.

use crate::Result;
use crate::frame::Frame;
use crate::params::{RunOptions, Scale, ShapeParams, TileSize};
use crate::plan::{Goal, Plan};
use crate::report::engine::Outcome;
use crate::report::sweeps::{named, solver};
use crate::report::timing::{self, Effort, Timed, Times, measure, measure_with};
use serde::Serialize;
use std::num::NonZeroUsize;

/// Results of one set of run options.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct RunRow {
    pub dimension: &'static str,
    pub value: String,
    pub scale: String,
    /// Time of all stages of a curvature picture.
    pub whole: Times,
    /// Speed relative to the first row of the table.
    pub speedup: f64,
    /// Whether the result equals that of the first row, bit for bit.
    pub same_bits: bool,
}

/// Runs `frame` with `shape` on 1, 2, 4.. threads, up to those of the caller's pool.
pub(crate) fn threads(frame: &Frame, shape: ShapeParams, effort: Effort) -> Result<Vec<RunRow>> {
    let plan = timing::plan(Goal::Display, frame, shape)?;
    let counts = thread_counts(rayon::current_num_threads());
    let measured = counts
        .iter()
        .map(|&count| (count.to_string(), with_threads(count, &plan, frame, effort)));
    Ok(rows("threads", shape.scale, measured.collect()))
}

/// Sides in pixels of the square tiles tried besides the default and the whole frame.
const TILE_SIDES: [usize; 3] = [64, 256, 512];
/// Sweeps per pass tried besides the default.
const SWEEPS_PER_PASS: [usize; 3] = [8, 16, 32];

/// Runs `frame` with tiles of several sizes, then with several numbers of sweeps per pass, at the largest of `scales`
/// within the limit on sweeps: a few sweeps take only one pass. The default comes first.
pub(crate) fn tiles_and_passes(
    frame: &Frame,
    shape: ShapeParams,
    scales: &[Scale],
    effort: Effort,
) -> Result<Vec<RunRow>> {
    let (scale, plan) = most_sweeps(frame, shape, scales)?;
    let measured = |(value, options): (String, RunOptions)| {
        (value, Some(measure_with(options, &plan, frame, effort)))
    };
    let tiles = tile_options(frame.mask.width(), frame.mask.height());
    let mut all = rows("tile", scale, tiles.into_iter().map(measured).collect());
    let passes = pass_options().into_iter().map(measured);
    all.extend(rows("sweeps per pass", scale, passes.collect()));
    Ok(all)
}

/// The scale with most sweeps within the limit, and its plan; that of `shape` if there is none.
fn most_sweeps(frame: &Frame, shape: ShapeParams, scales: &[Scale]) -> Result<(Scale, Plan)> {
    let plan = |scale| timing::plan(Goal::Display, frame, ShapeParams { scale, ..shape });
    let mut most = (shape.scale, plan(shape.scale)?);
    for &scale in scales {
        let plan = plan(scale)?;
        let is_more = plan.sweeps.count() > most.1.sweeps.count();
        if is_more && solver::is_affordable(&plan, frame) {
            most = (scale, plan);
        }
    }
    Ok(most)
}

/// The default tile, squares smaller than the frame, and the whole frame.
fn tile_options(width: usize, height: usize) -> Vec<(String, RunOptions)> {
    let default = RunOptions::default();
    let part = TILE_SIDES
        .into_iter()
        .filter(|&side| side < width.max(height));
    let sizes = part.map(|side| [side, side]).chain([[width, height]]);
    let tile = |[width, height]: [usize; 2]| {
        let [width, height] = [width, height].map(NonZeroUsize::new);
        Some(TileSize {
            width: width?,
            height: height?,
        })
    };
    let tiles = std::iter::once(default.tile).chain(sizes.filter_map(tile));
    let named = |(i, tile): (usize, TileSize)| {
        let mark = if i == 0 { ", default" } else { "" };
        let name = format!("{}x{}{mark}", tile.width, tile.height);
        (name, RunOptions { tile, ..default })
    };
    tiles.enumerate().map(named).collect()
}

/// The default number of sweeps per pass, and others.
fn pass_options() -> Vec<(String, RunOptions)> {
    let default = RunOptions::default();
    let others = SWEEPS_PER_PASS.into_iter().filter_map(NonZeroUsize::new);
    let options = |sweeps_per_pass: NonZeroUsize| RunOptions {
        sweeps_per_pass,
        ..default
    };
    let others = others.map(|count| (count.to_string(), options(count)));
    std::iter::once((format!("{}, default", default.sweeps_per_pass), default))
        .chain(others)
        .collect()
}

/// Results of a run.
type Measured = (Outcome, Timed);

/// Powers of two below `available`, and `available` itself.
fn thread_counts(available: usize) -> Vec<usize> {
    let powers = std::iter::successors(Some(1_usize), |n| n.checked_mul(2));
    powers
        .take_while(|&n| n < available)
        .chain([available])
        .collect()
}

fn with_threads(count: usize, plan: &Plan, frame: &Frame, effort: Effort) -> Option<Measured> {
    // If the system grants no more threads the row is left out.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .ok()?;
    Some(pool.install(|| measure(plan, frame, effort)))
}

/// The table of one option, from the results of its values.
fn rows(
    dimension: &'static str,
    scale: Scale,
    measured: Vec<(String, Option<Measured>)>,
) -> Vec<RunRow> {
    let measured: Vec<_> = measured
        .into_iter()
        .filter_map(|(value, m)| Some((value, m?)))
        .collect();
    let Some((_, (outcome, timed))) = measured.first() else {
        return Vec::new();
    };
    let (time, expected) = (timed.whole.min, bits(outcome));
    let row = |(value, (outcome, timed)): &(String, Measured)| RunRow {
        dimension,
        value: value.clone(),
        scale: named(scale),
        whole: timed.whole,
        speedup: time / timed.whole.min,
        same_bits: expected == bits(outcome),
    };
    measured.iter().map(row).collect()
}

/// The bits of the resulting picture and of the gradient it is based on.
fn bits(outcome: &Outcome) -> Vec<u32> {
    let color = outcome.color.iter().flat_map(|c| [&c.r, &c.g, &c.b]);
    let gradient = outcome.shape.gradient.iter().flat_map(|g| [&g.x, &g.y]);
    let samples = color.chain(gradient).flat_map(|plane| plane.samples());
    samples.map(|v| v.to_bits()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thread_counts_double_up_to_what_there_is() {
        assert_eq!(thread_counts(1), [1]);
        assert_eq!(thread_counts(2), [1, 2]);
        assert_eq!(thread_counts(12), [1, 2, 4, 8, 12]);
    }

    #[test]
    fn the_default_comes_first_and_is_not_tried_twice() {
        let tiles = tile_options(300, 200);
        let names: Vec<_> = tiles.iter().map(|(name, _)| name.as_str()).collect();
        assert!(names[0].ends_with(", default"), "{names:?}");
        assert_eq!(names[1..], ["64x64", "256x256", "300x200"]);
        for options in [tiles, pass_options()] {
            assert_eq!(options[0].1, RunOptions::default());
            assert!(options[1..].iter().all(|(_, o)| *o != options[0].1));
        }
    }

    #[test]
    fn the_scale_of_most_sweeps_is_chosen() {
        let frame = crate::report::scenes::Scene::waves(16, 16).frame;
        let scales = [2.0, 6.0, 3.0].map(Scale::Sigma);
        let chosen = most_sweeps(&frame, ShapeParams::default(), &scales).unwrap();
        assert_eq!(chosen.0, Scale::Sigma(6.0));
    }
}
