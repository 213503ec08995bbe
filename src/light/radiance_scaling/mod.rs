//! Radiance scaling: reflected light scaled by curvature.
//!
//! Theory: [RS] section 4 multiplies a reflected intensity d by a function of d and of the mapped curvature, which
//! leaves one intensity alpha unchanged. Changes: the printed `e^(gamma kappa)` darkens bright convexities, contrary to
//! the text beside it; the exponent is negative here. And the printed fraction loses 5 % in f32 at gamma 14 and
//! everything at 20; the form below is accurate to 1e-7.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod stage;

use crate::kernel::fast_math::exp;

/// Invariant points are clamped this far inside (0, 1), where the function is defined.
pub(crate) const INVARIANT_MARGIN: f32 = 1e-4;

/// |gamma kappa| is clamped to this: e^60 is far above any picture, and its square still finite.
pub(crate) const MAX_EXPONENT: f32 = 60.0;

/// `value` between 0 and `most`; 0 for NaN.
#[inline(always)]
pub(crate) fn limited(value: f32, most: f32) -> f32 {
    if value > 0.0 { value.min(most) } else { 0.0 }
}

/// The scaling sigma(d) of intensity `d` (clamped to 0..1), for the exponent `x = gamma * kappa` and
/// the invariant point `alpha`.
///
/// sigma(alpha) = 1, sigma(0) = e^-x, sigma(1) = e^x: a convexity (x > 0) brightens intensities above alpha and darkens
/// those below. Source: [RS] equation 2, with the correction derived above.
#[inline(always)]
pub fn scaling(d: f32, x: f32, alpha: f32) -> f32 {
    ScalingCurve::of(x).at(d, alpha)
}

/// sigma as a function of intensity only, shared by many lights at one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalingCurve {
    /// Weight of the darkest intensity: e^-|x| for a convexity, else 1.
    pub dark: f32,
    /// Weight of the brightest: 1 for a convexity, else e^-|x|.
    pub bright: f32,
}

impl ScalingCurve {
    /// The curve of the exponent `x = gamma * kappa`.
    #[inline(always)]
    pub fn of(x: f32) -> Self {
        let e = exp(-x.abs().min(MAX_EXPONENT));
        let convex = x >= 0.0;
        Self {
            dark: if convex { e } else { 1.0 },
            bright: if convex { 1.0 } else { e },
        }
    }

    /// sigma(d) for the invariant point `alpha`.
    #[inline(always)]
    pub fn at(self, d: f32, alpha: f32) -> f32 {
        let d = d.clamp(0.0, 1.0);
        let alpha = alpha.clamp(INVARIANT_MARGIN, 1.0 - INVARIANT_MARGIN);
        let (low, high) = (alpha * (1.0 - d), d * (1.0 - alpha));
        (self.dark * low + self.bright * high) / (self.bright * low + self.dark * high)
    }
}

/// A channel times its scaling, finite unless it is NaN.
#[inline(always)]
pub(crate) fn scaled(c: f32, sigma: f32) -> f32 {
    (c * sigma).clamp(-f32::MAX, f32::MAX)
}

/// The largest gamma |kappa| for which `d * sigma(d)` still increases with d on concavities: beyond it a concavity can
/// show a dark rim that the shading did not have.
///
/// Derived from the derivative of `d sigma(d)` at its flattest point: it reaches 0 at `ln{[(1-a) + sqrt((1-a)^2 +
/// 4a^2)] / 2a}`.
pub fn monotone_limit(alpha: f32) -> f32 {
    let a = alpha.clamp(INVARIANT_MARGIN, 1.0 - INVARIANT_MARGIN);
    let b = 1.0 - a;
    ((b + (b * b + 4.0 * a * a).sqrt()) / (2.0 * a)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fraction of the paper in f64, with the exponent corrected.
    fn printed(d: f64, x: f64, a: f64) -> f64 {
        let e = (-x).exp();
        (a * e + d * (1.0 - a - a * e)) / (a + d * (e - a - a * e))
    }

    const MAGNITUDES: [f32; 9] = [-20.0, -10.0, -3.0, -0.5, 0.0, 0.5, 3.0, 10.0, 20.0];

    #[test]
    fn fixed_points_hold_for_every_magnitude() {
        for x in MAGNITUDES {
            for alpha in [0.01, 0.2, 0.5, 0.8, 0.99] {
                let e = f64::from(x).exp();
                let off =
                    |d, expected: f64| (f64::from(scaling(d, x, alpha)) / expected - 1.0).abs();
                assert!(off(alpha, 1.0) < 1e-6);
                assert!(off(0.0, 1.0 / e) < 1e-6, "{}", off(0.0, 1.0 / e));
                assert!(off(1.0, e) < 1e-6);
            }
        }
    }

    #[test]
    fn convex_and_concave_are_reciprocal_and_dark_and_bright_are_mirrored() {
        // sigma(kappa, d) = 1 / sigma(-kappa, d), and for alpha: sigma_a(1 - d) = 1 / sigma_(1-a)(d).
        for x in MAGNITUDES {
            for d in [0.0, 0.125, 0.5, 0.75, 1.0] {
                for alpha in [0.125, 0.25, 0.5, 0.75] {
                    let there = scaling(d, x, alpha);
                    assert!((there * scaling(d, -x, alpha) - 1.0).abs() < 1e-6);
                    let mirrored = scaling(1.0 - d, x, 1.0 - alpha);
                    assert!((there * mirrored - 1.0).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn it_agrees_with_the_fraction_of_the_paper_in_f64() {
        for x in MAGNITUDES {
            for d in [0.0_f32, 0.01, 0.2, 0.6, 1.0] {
                let expected = printed(d.into(), x.into(), 0.2_f32.into());
                let ours = f64::from(scaling(d, x, 0.2));
                assert!(
                    (ours / expected - 1.0).abs() < 1e-6,
                    "d {d}, x {x}: {ours}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn convexities_brighten_what_is_bright() {
        assert!(scaling(0.8, 1.0, 0.2) > 1.0);
        assert!(scaling(0.05, 1.0, 0.2) < 1.0);
        assert!(scaling(0.8, -1.0, 0.2) < 1.0);
    }

    #[test]
    fn extreme_settings_stay_finite() {
        for x in [-1e3, 0.0, 1e3, f32::MAX] {
            for alpha in [0.0, 1e-9, 1.0] {
                for d in [0.0, 1.0, 50.0, f32::INFINITY] {
                    let sigma = scaling(d, x, alpha);
                    assert!(
                        sigma.is_finite() && sigma >= 0.0,
                        "d {d}, x {x}, alpha {alpha}"
                    );
                }
            }
        }
    }

    #[test]
    fn concavities_lose_monotony_where_the_limit_says() {
        // The scaled intensity increases everywhere just below the limit, and decreases somewhere above it.
        let rises = |x: f32, a: f32| {
            let scaled = |i: u32| {
                let d = f64::from(i) / 20_000.0;
                let e = f64::from(-x).exp();
                let a = f64::from(a);
                d * (a * (1.0 - d) + e * d * (1.0 - a)) / (e * a * (1.0 - d) + d * (1.0 - a))
            };
            (0..20_000).all(|i| scaled(i) <= scaled(i + 1))
        };
        for alpha in [0.05, 0.1, 0.2, 0.5] {
            let limit = monotone_limit(alpha);
            assert!(rises(0.98 * limit, alpha), "alpha {alpha} below {limit}");
            assert!(!rises(1.05 * limit, alpha), "alpha {alpha} above {limit}");
        }
    }
}
