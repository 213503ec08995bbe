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
    /// The sweeps that `params` ask for; the fewer ones where both solvers give the same answer.
    pub(super) fn new(params: &ShapeParams) -> Self {
        let explicit = explicit_steps(params);
        if params.solver == Solver::Explicit {
            return explicit;
        }
        let spread = match params.scale {
            Scale::Sigma(_) => Spread::Time(params.diffusion_time()),
            Scale::Iterations(count) => Spread::Steps {
                count,
                time_step: f64::from(params.time_step),
            },
        };
        let relative = f64::from(params.tolerance) / params.largest_slope();
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

/// Steps of at most the time step asked for, of equal length, that add up to the time.
fn explicit_steps(params: &ShapeParams) -> Sweeps {
    match params.scale {
        Scale::Iterations(count) => Sweeps::Explicit {
            count,
            time_step: params.time_step,
        },
        Scale::Sigma(_) => {
            let time = params.diffusion_time();
            let count = (time / f64::from(params.time_step)).ceil();
            let time_step = if count > 0.0 { time / count } else { 0.0 };
            Sweeps::Explicit {
                count: count as u32,
                time_step: time_step as f32,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweeps(scale: Scale, solver: Solver) -> Sweeps {
        Sweeps::new(&ShapeParams {
            scale,
            solver,
            ..ShapeParams::default()
        })
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
    fn steep_slopes_take_a_higher_degree() {
        let degree = |foreshortening| {
            let scale = Scale::Sigma(10.0);
            Sweeps::new(&ShapeParams {
                scale,
                foreshortening,
                ..ShapeParams::default()
            })
            .count()
        };
        assert!(degree(0.0) < degree(1.0));
    }
}
