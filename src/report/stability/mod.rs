//! Stiff and extreme cases, run live: each is bounded, warned about or refused, as declared, and none gives a NaN or a
//! panic.

mod case;
mod cases;
mod drawing_cases;
#[cfg(test)]
mod every_case;
mod frames;
mod light_cases;
mod lit;

pub(crate) use cases::all;

use super::timing;
use crate::engine::Inputs;
use crate::error::{Error, Result};
use crate::frame::{Frame, Plane};
use crate::params::ShapeParams;
use crate::plan::Goal;
use crate::report::engine;
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The expected result of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Expected {
    /// A result within its bounds, without a message.
    Bounded,
    /// A relit picture within its bound, without a message.
    Lit,
    /// A drawing with the ink that its tone requires, without a message.
    Drawn,
    /// A result within its bounds, and a warning.
    Warned,
    /// No result, but a reason.
    Refused,
}

/// The largest values of a result, and their upper bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Bounds {
    /// Largest |g_x| or |g_y| after diffusion.
    pub slope: f64,
    /// The largest before diffusion, which makes no new extremum, plus the solver's tolerance.
    pub slope_bound: f64,
    /// Largest |trace| per pixel.
    pub trace: f64,
    /// Eight times the bound of the slope: see [`Verdict`].
    pub trace_bound: f64,
}

/// The result of a case.
///
/// The bound of the trace: a fitted plane is a weighted mean of planes through the pixel and two neighbours. Such a
/// plane solves two equations in offsets of -1, 0 and 1 whose determinant is at least 1, so each derivative is at most
/// the sum of two differences, four times the largest slope; the trace is the sum of two derivatives.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "outcome", rename_all = "lowercase")]
pub(crate) enum Verdict {
    /// Every value is finite and within its bounds.
    Bounded(Bounds),
    /// Every value of a picture is finite and between 0 and its bound.
    Lit {
        /// The largest value.
        largest: f64,
        /// The upper bound for all light together.
        bound: f64,
    },
    /// Every value of a drawing is a share of ink, 0 to 1, and their mean is within its bounds.
    Drawn {
        /// The mean over the covered pixels.
        ink: f64,
        /// The range allowed.
        bounds: [f64; 2],
    },
    /// A picture within its bound, with a warning.
    #[serde(rename = "warned")]
    WarnedPicture {
        /// The warning.
        message: String,
        /// The largest value.
        largest: f64,
        /// The largest value allowed.
        bound: f64,
    },
    /// Every value of a descriptor is finite and within its bounds, with a warning.
    Warned {
        /// The warning.
        message: String,
        /// The values.
        bounds: Bounds,
    },
    /// No result.
    Refused {
        /// The reason.
        message: String,
    },
    /// A bug: a NaN, a value out of bounds, a panic.
    Failed {
        /// Description of the failure.
        what: String,
    },
}

impl Verdict {
    /// Whether it matches the expected result.
    pub(crate) fn is(&self, expected: Expected) -> bool {
        match self {
            Self::Bounded(_) => expected == Expected::Bounded,
            Self::Lit { .. } => expected == Expected::Lit,
            Self::Drawn { .. } => expected == Expected::Drawn,
            Self::WarnedPicture { .. } | Self::Warned { .. } => expected == Expected::Warned,
            Self::Refused { .. } => expected == Expected::Refused,
            Self::Failed { .. } => false,
        }
    }
}

/// A case.
pub(crate) struct Case {
    /// Its name.
    pub name: &'static str,
    /// Description of the case.
    pub done: &'static str,
    /// The expected result.
    pub expected: Expected,
    run: Box<dyn Fn() -> Result<Verdict>>,
}

/// A case with its outcome.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct CaseResult {
    /// Its name.
    pub name: &'static str,
    /// Description of the case.
    pub done: &'static str,
    /// The expected result.
    pub expected: Expected,
    /// The result.
    pub verdict: Verdict,
    /// Whether it matches the expected result.
    pub as_expected: bool,
}

impl Case {
    /// Runs the case; a panic fails only this case.
    pub(crate) fn run(&self) -> CaseResult {
        let verdict = match catch_unwind(AssertUnwindSafe(&self.run)) {
            Ok(Ok(verdict)) => verdict,
            Ok(Err(error)) => refusal(error),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text = text
                    .or(panic.downcast_ref::<&str>().copied())
                    .unwrap_or("no message");
                Verdict::Failed {
                    what: format!("panicked: {text}"),
                }
            }
        };
        CaseResult {
            name: self.name,
            done: self.done,
            expected: self.expected,
            as_expected: verdict.is(self.expected),
            verdict,
        }
    }
}

/// A rejected parameter or input is a refusal; a failing disk is a failure.
fn refusal(error: Error) -> Verdict {
    match error {
        Error::Io { .. } => Verdict::Failed {
            what: error.to_string(),
        },
        _ => Verdict::Refused {
            message: error.to_string(),
        },
    }
}

/// Rounding of single precision over thousands of sweeps, relative to the largest slope.
const ROUNDING: f64 = 1e-4;

/// Runs every goal of shape analysis over `frame`, and checks all planes against their bounds.
fn judged(frame: &Frame, shape: ShapeParams, warnings: &[String]) -> Result<Verdict> {
    let display = engine::run(
        &timing::plan(Goal::Display, frame, shape)?,
        frame,
        Inputs::default(),
    )?;
    let layers = engine::run(
        &timing::plan(Goal::Layers, frame, shape)?,
        frame,
        Inputs::default(),
    )?;
    let color = display.color.as_ref().expect("a display has colours");
    let found = &layers.shape;
    let gradient = found.gradient.as_ref().expect("layers hold the gradient");
    let hessian = found.hessian.as_ref().expect("layers hold the hessian");
    let curvatures = found
        .curvatures
        .as_ref()
        .expect("layers hold the curvatures");
    let direction = found
        .direction
        .as_ref()
        .expect("layers hold the directions");
    let slope_bound = steepest_start(frame, &shape) * (1.0 + relative_tolerance(&shape) + ROUNDING);
    let bounds = Bounds {
        slope: largest(&gradient.x).max(largest(&gradient.y)),
        slope_bound,
        trace: 2.0 * largest(&curvatures.mean),
        trace_bound: 8.0 * slope_bound,
    };
    let unit = [
        ("silhouette", found.silhouette.as_ref()),
        ("crease", found.crease.as_ref()),
        ("conductance", found.conductance.as_ref()),
        ("kappa", found.kappa.as_ref()),
        ("direction", Some(&direction.x)),
        ("direction", Some(&direction.y)),
        ("display", Some(&color.r)),
        ("display", Some(&color.g)),
        ("display", Some(&color.b)),
    ];
    let unit = unit
        .into_iter()
        .filter_map(|(name, plane)| Some((name, largest(plane?), 1.0 + 1e-6)));
    let twice = 2.0 * bounds.trace_bound;
    let entries = [
        &hessian.xx,
        &hessian.xy,
        &hessian.yy,
        &curvatures.u,
        &curvatures.v,
    ];
    let curved = entries.map(|plane| ("hessian", largest(plane), twice));
    let limits = [
        ("slope", bounds.slope, bounds.slope_bound),
        ("trace", bounds.trace, bounds.trace_bound),
    ];
    // NaN is within no bound.
    let within = |value: f64, bound: f64| value <= bound && bound.is_finite();
    let wrong = unit
        .chain(curved)
        .chain(limits)
        .find(|&(_, value, bound)| !within(value, bound));
    Ok(match (wrong, warnings) {
        (Some((name, value, bound)), _) => Verdict::Failed {
            what: format!("{name} is {value}, which should be at most {bound}"),
        },
        (None, []) => Verdict::Bounded(bounds),
        (None, warnings) => Verdict::Warned {
            message: warnings.join("; "),
            bounds,
        },
    })
}

fn relative_tolerance(shape: &ShapeParams) -> f64 {
    f64::from(shape.tolerance) / shape.largest_slope()
}

/// The largest component of the gradient before diffusion that the covered normals allow.
fn steepest_start(frame: &Frame, shape: &ShapeParams) -> f64 {
    let covered = frame.mask.plane().samples();
    let components = [&frame.normal.x, &frame.normal.y];
    let samples = components
        .into_iter()
        .flat_map(|plane| plane.samples().iter().zip(covered));
    let leaning = samples.filter(|&(_, &covered)| covered);
    leaning.fold(0.0, |m: f64, (n, _)| m.max(f64::from(n.abs()))) * shape.largest_slope()
}

/// The largest magnitude of a sample; NaN or infinite if one is.
fn largest(plane: &Plane) -> f64 {
    let sizes = plane.samples().iter().map(|v| f64::from(v.abs()));
    sizes.fold(0.0, |m, v| {
        if v.is_nan() || m.is_nan() {
            f64::NAN
        } else {
            m.max(v)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scenes::frames::relief;

    fn case(expected: Expected, run: impl Fn() -> Result<Verdict> + 'static) -> Case {
        Case {
            name: "a case",
            done: "something",
            expected,
            run: Box::new(run),
        }
    }

    #[test]
    fn a_nan_is_a_failure_and_no_size() {
        assert!(largest(&Plane::from_samples(3, 1, vec![1.0, f32::NAN, 2.0])).is_nan());
        assert_eq!(
            largest(&Plane::from_samples(3, 1, vec![1.0, -3.0, 2.0])),
            3.0
        );
        // Normals that `io` would never let through, passed directly to the backend.
        let mut frame = relief(9, 9);
        frame.normal.x.row_mut(4)[4] = f32::NAN;
        let verdict = judged(&frame, ShapeParams::default(), &[]).unwrap();
        assert!(matches!(verdict, Verdict::Failed { .. }), "{verdict:?}");
    }

    #[test]
    fn a_panic_stays_inside_its_case() {
        let result = case(Expected::Bounded, || panic!("on purpose")).run();
        assert!(!result.as_expected);
        assert_eq!(
            result.verdict,
            Verdict::Failed {
                what: "panicked: on purpose".into()
            }
        );
    }

    #[test]
    fn another_outcome_than_declared_is_seen() {
        let refused = |expected| {
            case(expected, || {
                judged(
                    &relief(4, 4),
                    ShapeParams {
                        time_step: 0.3,
                        ..ShapeParams::default()
                    },
                    &[],
                )
            })
            .run()
        };
        assert!(refused(Expected::Refused).as_expected);
        assert!(!refused(Expected::Bounded).as_expected);
    }
}
