//! How often the diffusion operator is applied, and to what end.

use crate::params::{Scale, ShapeParams, Solver};
use crate::shape::chebyshev::{Spread, coefficients};

/// The sweeps over the frame that diffuse its gradient.
#[derive(Debug, Clone, PartialEq)]
pub enum Sweeps {
    /// Explicit steps.
    Explicit {
        /// Number of steps.
        count: u32,
        /// Length of each.
        time_step: f32,
    },
    /// A Chebyshev recurrence with these coefficients, a_0 first.
    Chebyshev(Vec<f32>),
}

impl Sweeps {
    /// The sweeps that `params` ask for where `factor` pixels stand for one of the reference; the fewer
    /// ones where both solvers give the same answer.
    pub(super) fn new(params: &ShapeParams, factor: f64) -> Self {
        let time = params.diffusion_time() * factor * factor;
        let (count, time_step) = steps(params, factor, time);
        let explicit = Self::Explicit {
            count,
            time_step: time_step as f32,
        };
        if params.solver == Solver::Explicit {
            return explicit;
        }
        let spread = match params.scale {
            Scale::Sigma(_) => Spread::Time(time),
            Scale::Iterations(_) => Spread::Steps { count, time_step },
        };
        // Curvature is the difference of slopes times the factor, and so is its error.
        let relative = f64::from(params.tolerance) / (params.largest_slope() * factor.max(1.0));
        let expansion = coefficients(spread, relative);
        let same_answer = matches!(params.scale, Scale::Iterations(_));
        if same_answer && explicit.count() < expansion.len() {
            return explicit;
        }
        Self::Chebyshev(expansion.into_iter().map(|a| a as f32).collect())
    }

    /// How often the operator is applied.
    pub fn count(&self) -> usize {
        match self {
            Self::Explicit { count, .. } => *count as usize,
            Self::Chebyshev(coefficients) => coefficients.len() - 1,
        }
    }

    /// The sweeps in words.
    pub(super) fn described(&self) -> String {
        match self {
            Self::Explicit { count, time_step } => format!("{count} explicit steps of {time_step}"),
            Self::Chebyshev(_) => format!("Chebyshev expansion of degree {}", self.count()),
        }
    }
}

/// Number and length of equal steps, none longer than the time step asked for, that add up to `time`.
fn steps(params: &ShapeParams, factor: f64, time: f64) -> (u32, f64) {
    let longest = f64::from(params.time_step);
    match params.scale {
        Scale::Iterations(count) if factor == 1.0 => (count, longest),
        _ => {
            // Rounding in the factor must not add a step.
            let count = (time / longest * (1.0 - 1e-12)).ceil();
            (count as u32, if count > 0.0 { time / count } else { 0.0 })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweeps(scale: Scale, solver: Solver) -> Sweeps {
        Sweeps::new(
            &ShapeParams {
                scale,
                solver,
                ..ShapeParams::default()
            },
            1.0,
        )
    }

    #[test]
    fn the_solver_with_fewer_sweeps_is_taken() {
        // Ten steps expand to a polynomial of degree 10: stepping is as good and exact.
        let ten = sweeps(Scale::Iterations(10), Solver::Chebyshev);
        assert_eq!(ten, sweeps(Scale::Iterations(10), Solver::Explicit));
        assert_eq!(sweeps(Scale::Iterations(0), Solver::Chebyshev).count(), 0);
        let many = sweeps(Scale::Iterations(200), Solver::Chebyshev);
        assert!(
            matches!(many, Sweeps::Chebyshev(_)) && many.count() < 60,
            "{}",
            many.count()
        );
    }

    #[test]
    fn explicit_steps_add_up_to_the_scale() {
        // Sigma 3 is a time of 4.5: 23 steps of 0.1957, not 22.5 of 0.2.
        let steps = sweeps(Scale::Sigma(3.0), Solver::Explicit);
        let Sweeps::Explicit { count, time_step } = steps else {
            panic!("{steps:?}")
        };
        assert_eq!(count, 23);
        assert!((count as f32 * time_step - 4.5).abs() < 1e-5 && time_step <= 0.2);
    }

    #[test]
    fn a_reference_multiplies_time_by_the_square_of_the_factor() {
        let stepped = ShapeParams {
            scale: Scale::Iterations(10),
            solver: Solver::Explicit,
            ..ShapeParams::default()
        };
        // 10 steps of 0.2 are a time of 2: times 4, 1/4 (2.5 steps), 1/9 and 1.44 (14.4 steps).
        for (factor, expected) in [(2.0, 40), (0.5, 3), (1.0 / 3.0, 2), (1.2, 15)] {
            let Sweeps::Explicit { count, time_step } = Sweeps::new(&stepped, factor) else {
                panic!("stepping was asked for")
            };
            assert_eq!(count, expected, "factor {factor}");
            let time = f64::from(time_step) * f64::from(count);
            assert!((time - 2.0 * factor * factor).abs() < 1e-6 && time_step <= 0.2);
        }
        let sigma = ShapeParams {
            scale: Scale::Sigma(3.0),
            ..stepped
        };
        let six = ShapeParams {
            scale: Scale::Sigma(6.0),
            ..stepped
        };
        assert_eq!(Sweeps::new(&sigma, 2.0), Sweeps::new(&six, 1.0));
    }

    #[test]
    fn steep_slopes_take_a_higher_degree() {
        let degree = |foreshortening| {
            let scale = Scale::Sigma(10.0);
            Sweeps::new(
                &ShapeParams {
                    scale,
                    foreshortening,
                    ..ShapeParams::default()
                },
                1.0,
            )
            .count()
        };
        assert!(degree(0.0) < degree(1.0));
    }
}
