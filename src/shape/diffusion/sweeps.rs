//! Number of applications of the diffusion operator, and their combination.

use crate::params::{MAX_MIXED, Scale, ShapeParams, Solver};
use crate::plan::Plan;
use crate::shape::auto_levels::SIGMA_OF_DIFFERENCE_PX;
use crate::shape::chebyshev::{Expansion, Spread, coefficients};
use rayon::prelude::*;

/// The sweeps that diffuse a frame's gradient, and their readout.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DiffusionSchedule {
    /// How a sweep computes the next term.
    pub recurrence: Recurrence,
    /// How terms are combined into the result.
    pub readout: Readout,
    count: usize,
}

impl Plan {
    /// The sweeps that diffuse the gradient.
    pub(crate) fn sweeps(&self) -> &DiffusionSchedule {
        let sweeps = self.settings.get();
        sweeps.expect("every plan has them")
    }
}

/// How a sweep computes the next term from the previous ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Recurrence {
    /// An explicit step of this length.
    Explicit(f32),
    /// The recurrence of the Chebyshev polynomials of the diffusion operator.
    Chebyshev,
}

/// How the terms of the sweeps are combined into results, with the gradient as the first term.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Readout {
    /// The last term.
    Last,
    /// One weighted sum of all terms per scale.
    Sums(Vec<Vec<f32>>),
    /// A weighted sum whose weights depend on the importance of each pixel.
    ByImportance(Importance),
}

/// Diffusion by importance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Importance {
    /// Diffusion of pixels with importance 1.
    pub spread: Spread,
    /// Largest relative error of an expansion.
    tolerance: f64,
}

impl DiffusionSchedule {
    /// The sweeps for `params`, where `factor` pixels correspond to one of the reference; the solver with fewer sweeps
    /// if both give the same result.
    ///
    /// `more_px` are the sigmas of further scales; with `by_importance` each pixel has its own spread.
    pub(crate) fn new(
        params: &ShapeParams,
        factor: f64,
        more_px: &[f32],
        by_importance: bool,
    ) -> Self {
        let time = params.diffusion_time() * factor * factor;
        let (count, time_step) = steps(params, factor, time);
        let spread = match params.scale {
            Scale::Sigma(_) => Spread::Time(time),
            Scale::Mixed(scales) => mixed(scales, factor),
            Scale::Iterations(_) => Spread::Steps { count, time_step },
        };
        // Curvature is the difference of slopes times the factor, and its error scales likewise.
        let allowed = f64::from(params.tolerance) / (params.largest_slope() * factor.max(1.0));
        let tolerance = match spread {
            Spread::Time(_) | Spread::Mixed { .. } => allowed,
            Spread::Steps { .. } => allowed * CLOSER_TO_STEPS,
        };
        let explicit = || Self {
            recurrence: Recurrence::Explicit(time_step as f32),
            count: count as usize,
            readout: match by_importance {
                true => Readout::ByImportance(Importance {
                    spread: Spread::Steps { count, time_step },
                    tolerance,
                }),
                false => Readout::Last,
            },
        };
        if params.solver == Solver::Explicit {
            return explicit();
        }
        let more = more_px.iter().map(|&sigma| {
            let time = ShapeParams::time_of(sigma) * factor * factor;
            coefficients(Spread::Time(time), allowed)
        });
        let expansions: Vec<_> = std::iter::once(coefficients(spread, tolerance))
            .chain(more)
            .map(|expansion| expansion.into_iter().map(|a| a as f32).collect())
            .collect();
        let degree = expansions.iter().map(|e: &Vec<f32>| e.len() - 1).max();
        let degree = degree.expect("there is a first scale");
        let same_answer = matches!(params.scale, Scale::Iterations(_)) && more_px.is_empty();
        if same_answer && count as usize <= degree {
            return explicit();
        }
        Self {
            recurrence: Recurrence::Chebyshev,
            count: degree,
            readout: match by_importance {
                true => Readout::ByImportance(Importance { spread, tolerance }),
                false => Readout::Sums(expansions),
            },
        }
    }

    /// The sweeps of an expansion to each of these sigmas, in pixels, within `tolerance` relative to the largest value.
    pub(crate) fn to_sigmas(sigmas: &[f32], tolerance: f64) -> Self {
        let expansions = sigmas.iter().map(|&sigma| {
            let spread = Spread::Time(ShapeParams::time_of(sigma));
            let coefficients = coefficients(spread, tolerance);
            coefficients.into_iter().map(|a| a as f32).collect()
        });
        let expansions: Vec<Vec<f32>> = expansions.collect();
        let degree = expansions.iter().map(|expansion| expansion.len() - 1);
        Self {
            recurrence: Recurrence::Chebyshev,
            count: degree.max().unwrap_or(0),
            readout: Readout::Sums(expansions),
        }
    }

    /// Number of applications of the operator.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The sweeps in words.
    pub(crate) fn described(&self) -> String {
        let sweeps = match self.recurrence {
            Recurrence::Explicit(time_step) => {
                format!("{} explicit steps of {time_step}", self.count)
            }
            Recurrence::Chebyshev => format!("Chebyshev expansion of degree {}", self.count),
        };
        match &self.readout {
            Readout::ByImportance(_) => format!("{sweeps}, read out by importance"),
            Readout::Sums(sums) if sums.len() > 1 => {
                format!("{sweeps}, read out at {} scales", sums.len())
            }
            _ => sweeps,
        }
    }

    /// The weights of all terms for pixels of each of these importances, 0..1.
    ///
    /// # Panics
    /// If the readout does not depend on importance.
    pub(crate) fn weights_by_importance(&self, importances: &[f64]) -> Vec<Vec<f32>> {
        let Readout::ByImportance(Importance { spread, tolerance }) = self.readout else {
            panic!("the sweeps are not read out by importance");
        };
        let expansion = Expansion::up_to(spread);
        let weights = |&importance: &f64| {
            let share = spread.share(importance);
            let mut weights = match (self.recurrence, share) {
                (Recurrence::Explicit(_), Spread::Steps { count, .. }) => {
                    let mut alone = vec![0.0; count as usize];
                    alone.push(1.0);
                    alone
                }
                _ => expansion.coefficients(share, tolerance),
            };
            // Rounding can give a smaller share a higher degree only where both are tiny.
            weights.resize(self.count + 1, 0.0);
            weights.into_iter().map(|a| a as f32).collect()
        };
        importances.par_iter().map(weights).collect()
    }
}

/// Several scales, sigmas in pixels of the reference with their weights, added up in proportion to both. Curvature times its sigma measures relief
/// against its own size, so that fine relief counts as little as it is beside the form. Differences over two pixels are no
/// finer than those of the finest sigma.
///
/// All that follows is linear in slopes up to the mapping, which has one gain and one saturation. Pictures scaled at each
/// and multiplied would differ: sigma(x) sigma(y) is sigma(x + y) only in black, at the invariant point and in white. A
/// sum of mapped curvatures of gains g_s with weights in proportion to s / g_s, as small curvatures take it to be the
/// same, correlates with it by .998 and more in twelve renders, and takes an analysis of the frame for its weights.
fn mixed(scales: [(f32, f32); MAX_MIXED], factor: f64) -> Spread {
    let finest = f64::from(SIGMA_OF_DIFFERENCE_PX);
    let scales = scales.map(|(sigma, weight)| (factor * f64::from(sigma), f64::from(weight)));
    let weights = scales.map(|(sigma, weight)| weight * sigma.max(finest));
    let total: f64 = weights.iter().map(|weight| weight.abs()).sum();
    Spread::Mixed {
        // What counts for nothing takes no sweeps.
        times: scales.map(|(sigma, weight)| {
            if weight == 0.0 {
                0.0
            } else {
                0.5 * sigma * sigma
            }
        }),
        weights: weights.map(|weight| weight / total),
    }
}

/// A number of steps has one exact result, which explicit stepping gives: an expansion of it keeps to this share of the
/// tolerance, so that the solvers are interchangeable, for a tenth more sweeps.
const CLOSER_TO_STEPS: f64 = 0.1;

/// Number and length of equal steps, none longer than the given time step, that add up to `time`.
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

    fn sweeps(scale: Scale, solver: Solver) -> DiffusionSchedule {
        let params = ShapeParams {
            scale,
            solver,
            ..ShapeParams::default()
        };
        of(&params, 1.0)
    }

    fn of(params: &ShapeParams, factor: f64) -> DiffusionSchedule {
        DiffusionSchedule::new(params, factor, &[], false)
    }

    #[test]
    fn the_solver_with_fewer_sweeps_is_taken() {
        // Ten steps expand to a polynomial of degree 10: explicit steps cost the same and are exact.
        let ten = sweeps(Scale::Iterations(10), Solver::Chebyshev);
        assert_eq!(ten, sweeps(Scale::Iterations(10), Solver::Explicit));
        assert_eq!(sweeps(Scale::Iterations(0), Solver::Chebyshev).count(), 0);
        let many = sweeps(Scale::Iterations(200), Solver::Chebyshev);
        assert!(
            many.recurrence == Recurrence::Chebyshev && many.count() < 200 / 3,
            "{}",
            many.count()
        );
    }

    #[test]
    fn explicit_steps_add_up_to_the_scale() {
        // Sigma 3 is a time of 4.5: 23 steps of 0.1957, not 22.5 of 0.2.
        let steps = sweeps(Scale::Sigma(3.0), Solver::Explicit);
        let Recurrence::Explicit(time_step) = steps.recurrence else {
            panic!("{steps:?}")
        };
        assert_eq!(steps.count(), 23);
        assert!((steps.count() as f32 * time_step - 4.5).abs() < 1e-5 && time_step <= 0.2);
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
            let sweeps = of(&stepped, factor);
            let Recurrence::Explicit(time_step) = sweeps.recurrence else {
                panic!("stepping was asked for")
            };
            assert_eq!(sweeps.count(), expected, "factor {factor}");
            let time = f64::from(time_step) * sweeps.count() as f64;
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
        assert_eq!(of(&sigma, 2.0), of(&six, 1.0));
    }

    #[test]
    fn scales_are_mixed_by_their_size() {
        // Weights of .2 and .8 for 2 and 8 px; a wave that the finer keeps a share a of, and the coarser a share b, is left
        // with .2 a + .8 b.
        let of = |scales: &[(f32, f32)]| Scale::mixed(scales).unwrap();
        let both = of(&[(2.0, 1.0), (8.0, 1.0)]);
        let Scale::Mixed(scales) = both else {
            panic!("two are mixed")
        };
        let Spread::Mixed { times, weights } = mixed(scales, 1.0) else {
            panic!("two are mixed")
        };
        assert_eq!(times, [2.0, 32.0, 0.0, 0.0]);
        assert!((weights[0] - 0.2).abs() < 1e-15 && (weights[1] - 0.8).abs() < 1e-15);
        let kept = |sweeps: &DiffusionSchedule, x: f64| {
            let Readout::Sums(sums) = &sweeps.readout else {
                panic!("{sweeps:?}")
            };
            let term = |k: usize| (k as f64 * x.acos()).cos();
            let terms = sums[0].iter().enumerate();
            terms.map(|(k, &a)| f64::from(a) * term(k)).sum::<f64>()
        };
        let [fine, coarse, both] = [Scale::Sigma(2.0), Scale::Sigma(8.0), both]
            .map(|scale| sweeps(scale, Solver::Chebyshev));
        // No more sweeps than the coarser takes alone.
        assert!(both.count() <= coarse.count() && both.count() > fine.count());
        for x in [-1.0, -0.99, -0.9, -0.5, 0.0, 1.0] {
            let expected = 0.2 * kept(&fine, x) + 0.8 * kept(&coarse, x);
            assert!((kept(&both, x) - expected).abs() < 2e-4, "{x}");
        }
        // Of twice the same nothing is new, and of two that are finer than a difference both count the same.
        let twice = sweeps(of(&[(2.0, 1.0); 2]), Solver::Chebyshev);
        assert!((kept(&twice, -0.9) - kept(&fine, -0.9)).abs() < 1e-6);
        let even = [(0.0, 1.0), (0.5, 1.0), (0.0, 0.0), (0.0, 0.0)];
        let Spread::Mixed { weights, .. } = mixed(even, 1.0) else {
            panic!("two are mixed")
        };
        assert_eq!(weights, [0.5, 0.5, 0.0, 0.0]);
        // Weights of 1, 2 and -1 beside sizes of 2, 4 and 8: 2, 8 and -8 of 18.
        let given = sweeps(
            of(&[(2.0, 1.0), (4.0, 2.0), (8.0, -1.0)]),
            Solver::Chebyshev,
        );
        let middle = sweeps(Scale::Sigma(4.0), Solver::Chebyshev);
        for x in [-0.99, -0.9, 0.0] {
            let [a, b, c] = [&fine, &middle, &coarse].map(|alone| kept(alone, x));
            let expected = (2.0 * a + 8.0 * b - 8.0 * c) / 18.0;
            assert!((kept(&given, x) - expected).abs() < 3e-4, "{x}");
        }
        assert!(Scale::mixed(&[(2.0, 0.0)]).is_none() && Scale::mixed(&[(1.0, 1.0); 5]).is_none());
    }

    #[test]
    fn steep_slopes_take_a_higher_degree() {
        let degree = |foreshortening| {
            let scale = Scale::Sigma(10.0);
            let params = ShapeParams {
                scale,
                foreshortening,
                ..ShapeParams::default()
            };
            of(&params, 1.0).count()
        };
        assert!(degree(0.0) < degree(1.0));
    }
}
