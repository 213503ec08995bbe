//! How the work is run: what changes the time and must not change a bit of the answer.

use crate::Result;
use crate::backend::cpu::Outcome;
use crate::frame::Frame;
use crate::params::ShapeParams;
use crate::plan::{Goal, Plan};
use crate::report::timing::{self, Effort, Timed, Times, measure};
use serde::Serialize;

/// One way of running.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// What is varied.
    pub dimension: &'static str,
    /// Its value.
    pub value: String,
    /// Time of all stages up to a picture of the curvature.
    pub whole: Times,
    /// How often faster than the first row of the dimension.
    pub speedup: f64,
    /// Whether the answer is, bit for bit, that of the first row.
    pub same_bits: bool,
}

/// Runs `frame` as `shape` asks with 1, 2, 4.. threads, up to those of the caller's pool.
///
/// # Errors
/// [`crate::Error::BadParameter`] for a parameter outside its range.
pub fn threads(frame: &Frame, shape: ShapeParams, effort: Effort) -> Result<Vec<Row>> {
    let plan = timing::plan(Goal::Display, frame, shape)?;
    let counts = thread_counts(rayon::current_num_threads());
    let measured = counts
        .iter()
        .map(|&count| (count.to_string(), with_threads(count, &plan, frame, effort)));
    Ok(rows("threads", measured.collect()))
}

/// What a way of running gave.
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
    // A system that grants no more threads leaves the row out.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .ok()?;
    Some(pool.install(|| measure(plan, frame, effort)))
}

/// The table of one dimension from what its values gave.
fn rows(dimension: &'static str, measured: Vec<(String, Option<Measured>)>) -> Vec<Row> {
    let measured: Vec<_> = measured
        .into_iter()
        .filter_map(|(value, m)| Some((value, m?)))
        .collect();
    let Some((_, (outcome, timed))) = measured.first() else {
        return Vec::new();
    };
    let (time, expected) = (timed.whole.min, bits(outcome));
    let row = |(value, (outcome, timed)): &(String, Measured)| Row {
        dimension,
        value: value.clone(),
        whole: timed.whole,
        speedup: time / timed.whole.min,
        same_bits: expected == bits(outcome),
    };
    measured.iter().map(row).collect()
}

/// The bits of the picture that was made.
fn bits(outcome: &Outcome) -> Vec<u32> {
    let planes = outcome
        .color
        .as_ref()
        .map(|color| [&color.r, &color.g, &color.b]);
    let samples = planes
        .into_iter()
        .flatten()
        .flat_map(|plane| plane.samples());
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
}
