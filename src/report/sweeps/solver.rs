//! Solver against tolerance and step length, at several scales.

use super::{EdgeErrors, Measuring, named};
use crate::Result;
use crate::frame::{Frame, Plane};
use crate::params::{Scale, ShapeParams, Solver};
use crate::plan::{Goal, Plan};
use crate::report::asked::On;
use crate::report::compare::{Errors, Tally, compare, pixels};
use crate::report::engine;
use crate::report::machine::Machine;
use crate::report::pareto;
use crate::report::surface::Surface;
use crate::report::timing::{self, Effort, Timed, Times, Utilisation, measure_in_turn};
use crate::report::work;
use crate::shape::diffusion::sweeps::{DiffusionSchedule, Recurrence};
use serde::Serialize;

/// Tolerances tried.
const TOLERANCES: [f32; 6] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
/// Lengths of explicit steps tried for scales given in pixels, which all reach the same time.
const TIME_STEPS: [f32; 3] = [0.25, 0.2, 0.1];

/// Pixels times sweeps above which a setting is skipped unless requested: 580 sweeps at 1080p.
const MOST_UPDATES: usize = 1_200_000_000;

/// Results of one setting.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct SolverRow {
    /// The solver that ran: explicit steps take over where fewer of them give the same result.
    pub solver: Solver,
    /// Its tolerance or step length, in words.
    pub setting: String,
    /// The flags that select it; `None` if none do.
    pub flags: Option<String>,
    /// Whether it was requested.
    pub asked_for: bool,
    /// Number of applications of the operator.
    pub applications: usize,
    /// The largest error allowed, relative to the largest |g|; `None` for explicit steps.
    pub allowed: Option<f64>,
    /// Error of the diffused gradient, relative to the largest |g| before diffusion.
    pub gradient: Errors,
    /// Error of the trace per pixel, relative to the same.
    pub trace: Errors,
    /// How far the gradient exceeds its range before diffusion, relative to the same.
    pub overshoot: f64,
    /// Largest resulting error of the curvature picture, in 8-bit steps.
    pub grey_levels: f64,
    /// Largest and mean difference of the trace from the closed form, relative to the same, if there is one.
    pub against_closed_form: Option<Errors>,
    pub diffusion: Times,
    /// Time of all stages of a curvature picture.
    pub whole: Times,
    /// Megapixels of the frame per second, all stages.
    pub megapixels_per_second: f64,
    /// Share of the machine used by the diffusion.
    pub utilisation: Utilisation,
    /// Whether no other row of the scale is both faster and more accurate.
    pub on_front: bool,
}

/// All settings at one scale.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ScaleSweep {
    pub scale: String,
    pub flag: String,
    pub sigma_px: f64,
    pub rows: Vec<SolverRow>,
    /// Settings skipped for their run time.
    pub left_out: Vec<String>,
}

/// All scales of one frame.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct SceneSweep {
    #[serde(flatten)]
    pub on: On,
    pub about: String,
    pub steepest: f64,
    pub edges: EdgeErrors,
    pub scales: Vec<ScaleSweep>,
}

/// A closed form of the trace: column, row and time to value.
pub(crate) type ClosedForm<'a> = &'a dyn Fn(usize, usize, f64) -> Option<f64>;

/// The frame of a sweep.
pub(crate) struct Subject<'a> {
    pub name: &'a str,
    /// Its contents in words.
    pub about: &'a str,
    pub frame: &'a Frame,
    /// The surface that the reference starts from.
    pub surface: &'a Surface,
    pub shape: ShapeParams,
    /// The closed form of its trace.
    pub closed_form: Option<ClosedForm<'a>>,
}

/// Measures every solver and setting at each of `scales`.
pub(crate) fn sweep(
    subject: &Subject,
    scales: &[Scale],
    effort: Effort,
    machine: &Machine,
    progress: &dyn Fn(&str),
) -> Result<SceneSweep> {
    let measuring = Measuring::from(subject.frame, subject.surface, subject.shape)?;
    let mut swept = Vec::new();
    for &scale in scales {
        progress(&format!(
            "{}, {}: solvers and tolerances",
            subject.name,
            named(scale)
        ));
        swept.push(sweep_scale(subject, &measuring, scale, effort, machine)?);
    }
    Ok(SceneSweep {
        on: On::new(subject.name, &subject.frame.mask),
        about: subject.about.into(),
        steepest: measuring.steepest,
        edges: measuring.edges,
        scales: swept,
    })
}

fn sweep_scale(
    subject: &Subject,
    measuring: &Measuring,
    scale: Scale,
    effort: Effort,
    machine: &Machine,
) -> Result<ScaleSweep> {
    let exact = measuring.diffused(scale);
    let truth = Truth {
        measuring,
        trace: measuring.trace(&exact),
        gradient: exact,
        closed_form: subject.closed_form,
    };
    let shape = ShapeParams {
        scale,
        ..subject.shape
    };
    let asked_for = timing::plan(Goal::Layers, subject.frame, shape)?.sweeps;
    let mut tried: Vec<(ShapeParams, Plan)> = Vec::new();
    let mut left_out = Vec::new();
    for shape in settings(&shape) {
        let plan = timing::plan(Goal::Display, subject.frame, shape)?;
        // Coarse tolerances can give the same degree, fine ones the steps themselves.
        if tried.iter().any(|(_, other)| other.sweeps == plan.sweeps) {
            continue;
        }
        if is_affordable(&plan, subject.frame) || plan.sweeps == asked_for {
            tried.push((shape, plan));
        } else {
            left_out.push(described(&shape, &plan.sweeps));
        }
    }
    let (shapes, plans): (Vec<_>, Vec<_>) = tried.into_iter().unzip();
    let times = measure_in_turn(&plans, subject.frame, effort);
    let rows = shapes
        .iter()
        .zip(times)
        .map(|(shape, times)| truth.row(shape, times, machine));
    let mut rows = rows.collect::<Result<Vec<SolverRow>>>()?;
    for (row, plan) in rows.iter_mut().zip(&plans) {
        row.asked_for = plan.sweeps == asked_for;
    }
    let place = |row: &SolverRow| [row.diffusion.min, row.gradient.max];
    pareto::mark(&mut rows, place, |row| &mut row.on_front);
    Ok(ScaleSweep {
        scale: named(scale),
        flag: match scale {
            Scale::Iterations(count) => format!("--iterations {count}"),
            Scale::Sigma(sigma) => format!("--scale {sigma}"),
            Scale::Mixed([a, b]) => format!("--scale {a},{b}"),
        },
        sigma_px: shape.scale_px(),
        rows,
        left_out,
    })
}

/// Whether `plan` is short enough for a sweep.
pub(crate) fn is_affordable(plan: &Plan, frame: &Frame) -> bool {
    plan.sweeps.count() * frame.mask.count() <= MOST_UPDATES
}

/// The settings tried at the scale of `shape`, including the requested one.
fn settings(shape: &ShapeParams) -> Vec<ShapeParams> {
    let asked_for = [shape.time_step];
    let time_steps: &[f32] = match shape.scale {
        // A number of steps implies their length: another length would give another result.
        Scale::Iterations(_) => &asked_for,
        Scale::Sigma(_) | Scale::Mixed(_) => &TIME_STEPS,
    };
    let explicit = time_steps.iter().map(|&time_step| ShapeParams {
        solver: Solver::Explicit,
        time_step,
        ..*shape
    });
    let expanded = TOLERANCES.iter().map(|&tolerance| ShapeParams {
        solver: Solver::Chebyshev,
        tolerance,
        ..*shape
    });
    let mut all: Vec<_> = explicit.chain(expanded).collect();
    if !all.contains(shape) {
        all.push(*shape);
    }
    all
}

/// The reference for all settings of one scale.
struct Truth<'a> {
    measuring: &'a Measuring<'a>,
    gradient: super::Field,
    trace: Plane<f64>,
    closed_form: Option<ClosedForm<'a>>,
}

impl Truth<'_> {
    fn row(&self, shape: &ShapeParams, timed: Timed, machine: &Machine) -> Result<SolverRow> {
        let Measuring {
            frame, steepest, ..
        } = *self.measuring;
        let mask = &frame.mask;
        let layers = timing::plan(Goal::Layers, frame, *shape)?;
        let found = engine::layers(frame, *shape)?;
        let work =
            work::of_stage("diffusion", shape, &layers.sweeps).expect("diffusion has a model");
        let diffusion = timed.stage("diffusion").unwrap_or(timed.whole);
        let whole = timed.whole;
        let found_trace = found.trace();
        let trace = compare([&found_trace], [&self.trace], mask, steepest);
        let explicit = matches!(layers.sweeps.recurrence, Recurrence::Explicit(_));
        Ok(SolverRow {
            solver: if explicit {
                Solver::Explicit
            } else {
                Solver::Chebyshev
            },
            setting: described(shape, &layers.sweeps),
            flags: flags(shape),
            asked_for: false,
            applications: layers.sweeps.count(),
            allowed: (!explicit).then(|| f64::from(shape.tolerance) / shape.largest_slope()),
            gradient: self
                .measuring
                .gradient_errors(&found.gradient, &self.gradient),
            trace: trace.in_window(frame.data_window),
            overshoot: self.measuring.overshoot(&found.gradient),
            // The mapped curvature, -1..1 over 255 steps, changes by at most the gain times the trace.
            grey_levels: 127.5 * f64::from(found.gain) * trace.max * steepest,
            against_closed_form: self.closed_form.and_then(|exact| {
                let errors = self.against(exact, &found_trace, shape.diffusion_time());
                (errors.pixels > 0).then_some(errors)
            }),
            megapixels_per_second: whole.megapixels_per_second(mask.width() * mask.height()),
            utilisation: Utilisation::of(work, mask.count(), diffusion, machine),
            diffusion,
            whole,
            on_front: false,
        })
    }

    fn against(&self, exact: ClosedForm, found: &Plane, time: f64) -> Errors {
        let mut tally = Tally::default();
        for [x, y] in pixels(found) {
            if let Some(exact) = exact(x, y, time) {
                let error = f64::from(found.at(x, y)) - exact;
                tally.add([x, y], error / self.measuring.steepest);
            }
        }
        tally.errors()
    }
}

fn described(shape: &ShapeParams, sweeps: &DiffusionSchedule) -> String {
    match sweeps.recurrence {
        Recurrence::Explicit(time_step) => {
            format!("step {}", (f64::from(time_step) * 1e4).round() / 1e4)
        }
        Recurrence::Chebyshev => format!("tolerance {:.0e}", shape.tolerance),
    }
}

fn flags(shape: &ShapeParams) -> Option<String> {
    let default = ShapeParams::default();
    match shape.solver {
        Solver::Explicit if shape.time_step != default.time_step => None,
        Solver::Explicit => Some("--solver explicit".into()),
        Solver::Chebyshev => Some(format!("--tolerance {}", shape.tolerance)),
    }
}
