//! Run times of plans, and the share of the machine they use.
//!
//! Runs reuse the memory of earlier ones, so times are those of the second and later frames of a sequence. The first
//! run of a program takes longer, since the system has to provide its memory.

use super::machine::Machine;
use super::numbers::milliseconds;
use super::work::Work;
use crate::Result;
use crate::engine::{Engine, Inputs, Outcome, Run};
use crate::frame::Frame;
use crate::params::{RunOptions, ScalingParams, ShapeParams};
use crate::plan::{Available, Goal, Plan};
use crate::quantile::quantile;
use serde::Serialize;
use std::fmt::{self, Display};
use std::time::{Duration, Instant};

/// Minimum and median of several runs, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    /// Minimum.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Number of runs.
    pub runs: usize,
}

impl Times {
    /// From the seconds of each run.
    ///
    /// # Panics
    /// If there are none.
    pub fn of(mut seconds: Vec<f64>) -> Self {
        let mut of = |share| quantile(&mut seconds, share, f64::total_cmp).expect("there are runs");
        Self {
            min: of(0.0),
            median: of(0.5),
            runs: seconds.len(),
        }
    }

    /// Megapixels per second at the median.
    pub fn megapixels_per_second(&self, pixels: usize) -> f64 {
        pixels as f64 / 1e6 / self.median
    }
}

impl Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [min, median] = [self.min, self.median].map(milliseconds);
        write!(f, "{min} / {median}")
    }
}

/// Effort per measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Maximum number of runs, without the warm-up.
    pub runs: usize,
    /// Time per plan after which no further run starts; there are always at least two.
    pub limit: Duration,
}

impl Effort {
    /// At most this many runs, or about this many milliseconds.
    pub fn new(runs: usize, limit_ms: u64) -> Self {
        Self {
            runs,
            limit: Duration::from_millis(limit_ms),
        }
    }
}

/// Times of a plan over several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// Time of each stage, in order.
    pub stages: Vec<(&'static str, Times)>,
    /// Time of all stages together.
    pub whole: Times,
}

impl Timed {
    /// From runs of the same stages.
    ///
    /// # Panics
    /// If there are none.
    pub(super) fn of(runs: &[Timings]) -> Self {
        let seconds = |run: &Timings, i: usize| run[i].1.as_secs_f64();
        let stage = |i: usize| Times::of(runs.iter().map(|run| seconds(run, i)).collect());
        let whole = runs
            .iter()
            .map(|run| run.iter().map(|(_, time)| time.as_secs_f64()).sum());
        Self {
            stages: runs[0]
                .iter()
                .enumerate()
                .map(|(i, (name, _))| (*name, stage(i)))
                .collect(),
            whole: Times::of(whole.collect()),
        }
    }

    /// Time of the stage `name`, if it ran.
    pub fn stage(&self, name: &str) -> Option<Times> {
        self.stages
            .iter()
            .find(|(stage, _)| *stage == name)
            .map(|(_, times)| *times)
    }
}

/// Times of the stages of one run.
pub(super) type Timings = Vec<(&'static str, Duration)>;

/// The plan for `goal`, from the shape of `frame`.
///
/// # Errors
/// [`crate::Error::BadParameter`] for a parameter outside its range.
pub(crate) fn plan(goal: Goal, frame: &Frame, shape: ShapeParams) -> Result<Plan> {
    Plan::new(
        goal,
        Available::in_frame(frame),
        shape,
        ScalingParams::default(),
    )
}

/// Runs a shape `plan` once to warm up, then the number of times given by `effort`.
pub fn measure(plan: &Plan, frame: &Frame, effort: Effort) -> (Outcome, Timed) {
    measure_with(RunOptions::default(), plan, frame, effort)
}

/// [`measure`] with these options.
pub(super) fn measure_with(
    options: RunOptions,
    plan: &Plan,
    frame: &Frame,
    effort: Effort,
) -> (Outcome, Timed) {
    let engine = Engine::cpu().with_options(options);
    measure_runs(&engine, effort, || of_shape(&engine, plan, frame))
}

/// The outcome of a plan without inputs beside the frame.
fn of_shape(engine: &Engine, plan: &Plan, frame: &Frame) -> Outcome {
    let outcome = engine.execute(plan, frame, Inputs::default(), &Run::new());
    outcome.expect("plans of reports are made for what they are run on")
}

/// Runs `plans` in turn, round after round, so that load on the machine slows all of them alike.
pub(super) fn measure_in_turn(plans: &[Plan], frame: &Frame, effort: Effort) -> Vec<Timed> {
    let engine = Engine::cpu();
    let run = |plan| of_shape(&engine, plan, frame);
    plans
        .first()
        .into_iter()
        .for_each(|plan| engine.recycle(run(plan)));
    let mut runs: Vec<Vec<Timings>> = vec![Vec::new(); plans.len()];
    let mut spent = vec![Duration::ZERO; plans.len()];
    for round in 0..effort.runs.max(2) {
        for (i, plan) in plans.iter().enumerate() {
            if round < 2 || spent[i] < effort.limit {
                let start = Instant::now();
                let mut outcome = run(plan);
                spent[i] += start.elapsed();
                runs[i].push(std::mem::take(&mut outcome.timings));
                engine.recycle(outcome);
            }
        }
    }
    runs.iter().map(|runs| Timed::of(runs)).collect()
}

/// Calls `run` once to warm up, then the number of times given by `effort`; the memory of all outcomes but the last is
/// recycled to `engine`.
pub fn measure_runs(
    engine: &Engine,
    effort: Effort,
    run: impl Fn() -> Outcome,
) -> (Outcome, Timed) {
    engine.recycle(run());
    let mut runs: Vec<Timings> = Vec::new();
    let start = Instant::now();
    loop {
        let mut outcome = run();
        runs.push(std::mem::take(&mut outcome.timings));
        let enough = runs.len() >= effort.runs || start.elapsed() > effort.limit;
        if enough && runs.len() >= 2 {
            return (outcome, Timed::of(&runs));
        }
        engine.recycle(outcome);
    }
}

/// Utilisation of the machine by a stage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Utilisation {
    /// Bytes per second that an ideal pass would move.
    pub bytes_per_second: f64,
    /// The same as a share of the measured bandwidth. Above 1 if a frame, or a tile of it, stays in a cache.
    pub of_bandwidth: f64,
    /// Operations per second.
    pub operations_per_second: f64,
    /// The same as a share of the measured rate.
    pub of_arithmetic: f64,
}

impl Utilisation {
    /// `work` over `pixels` covered pixels in the minimum of `times`.
    pub(crate) fn of(work: Work, pixels: usize, times: Times, machine: &Machine) -> Self {
        let per_second = |each: f64| each * pixels as f64 / times.min;
        let (bytes, operations) = (per_second(work.bytes), per_second(work.operations));
        Self {
            bytes_per_second: bytes,
            of_bandwidth: bytes / machine.bytes_per_second,
            operations_per_second: operations,
            of_arithmetic: operations / machine.operations_per_second,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn least_and_median() {
        let times = Times::of(vec![0.5, 0.1, 0.3]);
        assert_eq!((times.min, times.median, times.runs), (0.1, 0.3, 3));
        assert!((times.megapixels_per_second(600_000) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn shares_of_the_machine() {
        let machine = Machine {
            threads: 1,
            bytes_per_second: 1e9,
            operations_per_second: 4e9,
            multiply_add: "",
        };
        let times = Times {
            min: 0.01,
            median: 0.02,
            runs: 2,
        };
        let work = Work {
            bytes: 20.0,
            operations: 100.0,
        };
        // 20 bytes times 1e5 pixels in 10 ms: 2e8 per second; 100 operations: 1e9.
        let used = Utilisation::of(work, 100_000, times, &machine);
        assert!(
            (used.of_bandwidth - 0.2).abs() < 1e-12 && (used.of_arithmetic - 0.25).abs() < 1e-12
        );
    }
}
