//! Diffusion without stepping: the same linear operator, exponentiated by a Chebyshev expansion.
//!
//! Theory: conductances stay fixed while the gradient diffuses ([LW] section 4.3), so diffusion for a time t is exp(tL)
//! with one symmetric operator L, whose spectrum lies in [-8, 0]. With X = -L/4 - 1, whose spectrum lies in [-1, 1],
//! exp(tL) = sum a_k(t) T_k(X). Changes: the paper takes N explicit steps, (1 + dt L)^N; that too is a polynomial of L,
//! reproduced by other coefficients of the same recurrence with fewer applications of L. Practice: the sum of the |a_k|
//! left out bounds the root mean square error; the largest error is that sum weighted by how waves add up in a focus. So
//! the degree follows from the tolerance before any pixel is touched.
//!
//! Alternatives were tried for long times (t = 5000 and 20,000, 550 and 1100 applications at 1e-4), on 512x512 among
//! thin closed lines, gaps and mixed conductances. A grid of half the size, with the connected parts of 2x2 as pixels,
//! errs by 1e-3 to 4e-3 beside thin lines however long the fine grid smooths first (in the open by 1e-5, at a quarter
//! of the work); rational expansions, solved by algebraic multigrid, cost 360 to 960 applications at 2e-4, without
//! their setup; Lanczos saves 0 to 14 % and must keep every vector.

use crate::params::MAX_MIXED;

/// Amount of diffusion of the gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Spread {
    /// Exact diffusion for this time: a Gaussian of sigma `sqrt(2 t)` pixels away from edges.
    Time(f64),
    /// The result of N explicit steps of this length.
    Steps {
        /// Number of steps.
        count: u32,
        /// Length of a step, at most 1/4.
        time_step: f64,
    },
    /// The sum of exact diffusion for these times, with these weights, whose magnitudes add up to 1.
    Mixed {
        /// The times.
        times: [f64; MAX_MIXED],
        /// The weight of each.
        weights: [f64; MAX_MIXED],
    },
}

impl Spread {
    /// A share of it, 0..1, in time; the number of steps stays an integer.
    pub(crate) fn share(self, importance: f64) -> Self {
        match self {
            Self::Time(t) => Self::Time(importance * t),
            Self::Mixed { times, weights } => Self::Mixed {
                times: times.map(|t| importance * t),
                weights,
            },
            Self::Steps { count, time_step } => Self::Steps {
                count: (importance * f64::from(count)).round() as u32,
                time_step,
            },
        }
    }

    /// The factor of an eigenvector of L with the eigenvalue `x` of X, in [-1, 1].
    fn factor(self, x: f64) -> f64 {
        let eigenvalue = -4.0 * (1.0 + x);
        match self {
            Self::Time(t) => (t * eigenvalue).exp(),
            Self::Mixed { times, weights } => {
                let all = weights.iter().zip(times);
                all.map(|(weight, time)| weight * (time * eigenvalue).exp())
                    .sum()
            }
            Self::Steps { count, time_step } => {
                (1.0 + time_step * eigenvalue).powi(count.min(i32::MAX as u32) as i32)
            }
        }
    }

    /// The factor of a constant.
    fn of_constant(self) -> f64 {
        match self {
            Self::Mixed { weights, .. } if weights.iter().any(|weight| *weight < 0.0) => {
                weights.iter().sum()
            }
            _ => 1.0,
        }
    }

    /// An upper bound of the degree needed for any tolerance. The expansion of N steps ends at N; the coefficients of a
    /// time t, or of the equivalent steps, fall as exp(-k^2 / 8t), which is 1e-17 at k = 18 sqrt(t).
    fn largest_degree(self) -> usize {
        match self {
            Self::Time(t) => 32 + (18.0 * t.max(0.0).sqrt()) as usize,
            Self::Mixed { times, .. } => {
                Self::Time(times.into_iter().fold(0.0, f64::max)).largest_degree()
            }
            Self::Steps { count, time_step } => {
                let as_time = Self::Time(f64::from(count) * time_step).largest_degree();
                as_time.min(count as usize)
            }
        }
    }
}

/// Coefficients a_0..a_n of the expansion, with the smallest degree n for which the result is within `tolerance` of the
/// exact one, relative to the largest value diffused.
///
/// The tolerance bounds the sum of all |a_k| beyond n, each weighted by 1 + [`focus`]: the term left out can add up in a
/// focus, and a_0 changes by as much as it adds to a constant, so that the mean is preserved at any tolerance.
pub(crate) fn coefficients(spread: Spread, tolerance: f64) -> Vec<f64> {
    Expansion::up_to(spread).coefficients(spread, tolerance)
}

/// Assumed bound of T_k(X) g relative to the largest |g|.
///
/// T_k(X) g solves a wave equation after k steps. Its root mean square never grows, but waves emitted by edges meet in
/// foci: of discs and rings of slopes 1 in others of -1, the worst of some hundred fields tried, barriers, noise and
/// closed rooms among them, T_k(X) g reaches 1.3 sqrt(k) at k = 30 and 1.1 sqrt(k) at 150. (The worst g, the signs of the
/// kernel, gives 0.58 k.) With this weight the largest error in all of them was 0.92 of the tolerance, at times from 5
/// to 200, 50 and 200 steps, and tolerances from 1e-2 to 1e-5. With none it is 3 to 8 times the tolerance, for 6 to 23 %
/// fewer sweeps.
fn focus(k: usize) -> f64 {
    1.1 * (k as f64).sqrt()
}

/// Factors smaller than this add nothing to a coefficient in double precision.
const NEGLIGIBLE: f64 = 1e-18;

/// Computes coefficients for many spreads, none larger than the one it was created for.
///
/// They are a cosine transform of the factor, sampled finely enough for aliases below 1e-15; for long times nearly all
/// samples are negligible.
#[derive(Debug)]
pub(crate) struct Expansion {
    degree: usize,
    /// Angles of the samples.
    angles: Vec<f64>,
}

impl Expansion {
    /// Supports spreads up to `farthest`.
    pub(crate) fn up_to(farthest: Spread) -> Self {
        let degree = farthest.largest_degree();
        let samples = 2 * (degree + 16);
        let angle = |j: usize| std::f64::consts::PI * (j as f64 + 0.5) / samples as f64;
        Self {
            degree,
            angles: (0..samples).map(angle).collect(),
        }
    }

    /// [`coefficients`] of a spread.
    pub(crate) fn coefficients(&self, spread: Spread, tolerance: f64) -> Vec<f64> {
        let mut kept = self.truncated(spread, tolerance, |k| 1.0 + focus(k));
        // A constant has the eigenvalue X = -1, where T_k is (-1)^k.
        let signs = [1.0, -1.0].into_iter().cycle();
        let constant: f64 = kept.iter().zip(signs).map(|(a, sign)| sign * a).sum();
        kept[0] += spread.of_constant() - constant;
        kept
    }

    /// The expansion up to the smallest degree whose remainder, the sum of omitted |a_k| times `weight(k)`, is at most
    /// `tolerance`.
    fn truncated(&self, spread: Spread, tolerance: f64, weight: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut all = self.all(spread);
        let mut remainder = 0.0;
        while all.len() > 1 {
            let last = all.len() - 1;
            remainder += weight(last) * all[last].abs();
            if remainder > tolerance {
                break;
            }
            all.pop();
        }
        all
    }

    fn all(&self, spread: Spread) -> Vec<f64> {
        let degree = self.degree.min(spread.largest_degree());
        let mut sums = vec![0.0; degree + 1];
        for &angle in &self.angles {
            let cosine = angle.cos();
            let factor = spread.factor(cosine);
            if factor.abs() <= NEGLIGIBLE {
                continue;
            }
            // cos(k angle), by repeated rotation.
            let sine = angle.sin();
            let (mut x, mut y) = (1.0, 0.0);
            for sum in &mut sums {
                *sum += factor * x;
                (x, y) = (cosine * x - sine * y, sine * x + cosine * y);
            }
        }
        let scale = |k: usize| if k == 0 { 1.0 } else { 2.0 } / self.angles.len() as f64;
        sums.iter()
            .enumerate()
            .map(|(k, sum)| sum * scale(k))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degree(spread: Spread, tolerance: f64) -> usize {
        Expansion::up_to(spread)
            .truncated(spread, tolerance, |_| 1.0)
            .len()
            - 1
    }

    #[test]
    fn the_degree_follows_the_square_root_of_time() {
        // Degrees at 1e-4 and 1e-6 from scaled Bessel functions, summed in double precision.
        for (t, coarse, fine) in [
            (5.0, 18, 23),
            (10.0, 25, 32),
            (50.0, 55, 69),
            (400.0, 156, 196),
        ] {
            assert_eq!(degree(Spread::Time(t), 1e-4), coarse, "t {t}");
            assert_eq!(degree(Spread::Time(t), 1e-6), fine, "t {t}");
        }
    }

    #[test]
    fn explicit_steps_take_fewer_applications() {
        for (count, coarse, fine) in [(10, 10, 10), (50, 24, 30), (200, 49, 61)] {
            let spread = Spread::Steps {
                count,
                time_step: 0.2,
            };
            assert_eq!(degree(spread, 1e-4), coarse, "{count} steps");
            assert_eq!(degree(spread, 1e-6), fine, "{count} steps");
        }
    }

    #[test]
    fn the_expansion_is_the_factor_to_the_tolerance() {
        for spread in [
            Spread::Time(0.0),
            Spread::Time(0.3),
            Spread::Time(50.0),
            Spread::Time(1e5),
            Spread::Steps {
                count: 1,
                time_step: 0.2,
            },
            Spread::Steps {
                count: 37,
                time_step: 0.25,
            },
            Spread::Steps {
                count: 1000,
                time_step: 0.25,
            },
        ] {
            for tolerance in [1e-2, 1e-5, 1e-9] {
                let a = coefficients(spread, tolerance);
                let alternating = a
                    .iter()
                    .enumerate()
                    .map(|(k, a)| a * (-1.0f64).powi(k as i32));
                assert!((alternating.sum::<f64>() - 1.0).abs() < 1e-13, "{spread:?}");
                for i in 0..=200 {
                    let theta = std::f64::consts::PI * f64::from(i) / 200.0;
                    let sum: f64 = a
                        .iter()
                        .enumerate()
                        .map(|(k, a)| a * (k as f64 * theta).cos())
                        .sum();
                    let error = (sum - spread.factor(theta.cos())).abs();
                    assert!(error <= tolerance + 1e-13, "{spread:?} at {theta}: {error}");
                }
            }
        }
    }

    /// An application of X on an open grid of this width.
    fn applied(g: &[f64], width: usize) -> Vec<f64> {
        let height = g.len() / width;
        let at = |x: usize, y: usize| g[y * width + x];
        let of_pixel = |i: usize| {
            let (x, y) = (i % width, i / width);
            let beside = [
                (x > 0).then(|| at(x - 1, y)),
                (x + 1 < width).then(|| at(x + 1, y)),
                (y > 0).then(|| at(x, y - 1)),
                (y + 1 < height).then(|| at(x, y + 1)),
            ];
            let flux: f64 = beside.into_iter().flatten().map(|g| g - at(x, y)).sum();
            -0.25 * flux - at(x, y)
        };
        (0..g.len()).map(of_pixel).collect()
    }

    /// The largest omitted sum over a disc of 1 in a plane of -1, from which waves meet in the centre.
    fn error_of_disc(radius: f64, exact: &[f64], kept: &[f64]) -> f64 {
        let width = 2 * radius as usize + 81;
        let middle = (width / 2) as f64;
        let disc = |i: usize| {
            let (x, y) = ((i % width) as f64 - middle, (i / width) as f64 - middle);
            if x.hypot(y) < radius { 1.0 } else { -1.0 }
        };
        let mut earlier: Vec<f64> = (0..width * width).map(disc).collect();
        let mut term = applied(&earlier, width);
        let mut error: Vec<f64> = earlier.iter().map(|g| (exact[0] - kept[0]) * g).collect();
        for (k, exact) in exact.iter().enumerate().skip(1) {
            let left_out = exact - kept.get(k).unwrap_or(&0.0);
            for (error, term) in error.iter_mut().zip(&term) {
                *error += left_out * term;
            }
            let next = applied(&term, width);
            let next = next.iter().zip(&earlier).map(|(x, e)| 2.0 * x - e);
            (earlier, term) = (term.clone(), next.collect());
        }
        error.iter().fold(0.0, |most, e| e.abs().max(most))
    }

    #[test]
    fn foci_stay_within_the_tolerance() {
        let fifty = Spread::Steps {
            count: 50,
            time_step: 0.2,
        };
        // A wave from a circle meets in its centre after sqrt(2) steps a pixel: where the degree ends, it is largest.
        for (spread, tolerance) in [(Spread::Time(10.0), 1e-4), (fifty, 1e-5)] {
            let (exact, kept) = (coefficients(spread, 1e-13), coefficients(spread, tolerance));
            let radius = kept.len() as f64 / 2.0f64.sqrt();
            let worst = (-3..=3)
                .map(|off| error_of_disc(radius.round() + f64::from(off), &exact, &kept))
                .fold(0.0, f64::max);
            println!("{spread:?}: {:.2} of the tolerance", worst / tolerance);
            assert!(worst <= tolerance, "{spread:?}: {worst}");
            // Far fewer terms would not do.
            let fewer = coefficients(spread, 4.0 * tolerance);
            let worst = (-3..=3)
                .map(|off| error_of_disc(radius.round() + f64::from(off), &exact, &fewer))
                .fold(0.0, f64::max);
            assert!(worst > tolerance, "{spread:?}: {worst}");
        }
    }
}
