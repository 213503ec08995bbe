//! `exp`, `ln` and `tanh`, from one reduction by powers of two.

use super::{polynomial, power_of_two, select};

/// `e^x`; 1.03 ulp, subnormal results included. 0 from -104 down, infinite from 88.73 up; NaN gives NaN.
#[inline(always)]
pub(crate) fn exp(x: f32) -> f32 {
    let (n, p) = split_exp(select(x > 89.0, 89.0, select(x < -104.0, -104.0, x)));
    // In two factors, since 2^n alone leaves the range of f32 before the result does.
    let half = n >> 1;
    (1.0 + p) * power_of_two(half) * power_of_two(n - half)
}

/// The natural logarithm of `x`; 1 ulp, subnormal arguments included. Minus infinity at 0; NaN for negative and NaN
/// arguments.
#[inline(always)]
pub(crate) fn ln(x: f32) -> f32 {
    let tiny = x < f32::MIN_POSITIVE;
    let finite = ln_over_power_of_two(select(tiny, x * TWO_TO_23, x), select(tiny, 23.0, 0.0));
    let of_no_number = select(x == 0.0, f32::NEG_INFINITY, select(x > 0.0, x, f32::NAN));
    // Tests the bits for positive and finite: float comparisons are a fifth slower here.
    let bits = x.to_bits() as i32;
    select(
        (bits > 0) & (bits < f32::INFINITY.to_bits() as i32),
        finite,
        of_no_number,
    )
}

/// The natural logarithm of a positive, finite, normal `x`, as [`ln`] gives it, in two thirds of its time.
#[inline(always)]
pub(crate) fn ln_of_normal(x: f32) -> f32 {
    ln_over_power_of_two(x, 0.0)
}

/// The natural logarithm of a positive, finite, normal `x` over 2^`power`.
#[inline(always)]
fn ln_over_power_of_two(x: f32, power: f32) -> f32 {
    let bits = x.to_bits();
    // x = 2^e m with m between sqrt(1/2) and sqrt(2).
    let e = (bits.wrapping_sub(std::f32::consts::FRAC_1_SQRT_2.to_bits()) as i32) >> 23;
    let f = f32::from_bits(bits.wrapping_sub((e << 23) as u32)) - 1.0;
    let e = e as f32 - power;
    let square = f * f;
    let small = square * f * polynomial(f, LN) + e * LN2_LOW - 0.5 * square;
    (f + small) + e * LN2_HIGH
}

/// `e^x` for `x` from -87 to 88, where it is normal, as [`exp`] gives it; undefined outside.
#[inline(always)]
pub(crate) fn exp_to_normal(x: f32) -> f32 {
    let (n, p) = split_exp(x);
    (1.0 + p) * power_of_two(n)
}

/// The hyperbolic tangent of `x`; 2.5 ulp, also for small x. Exactly 1 and -1 from 8.5 on; keeps the sign of 0; NaN
/// gives NaN.
#[inline(always)]
pub(crate) fn tanh(x: f32) -> f32 {
    // With q = e^-2|x| - 1, tanh |x| is -q / (q + 2), without cancellation near 0. At 10 it is 1.
    let size = x.abs();
    let (n, p) = split_exp(-2.0 * select(size > 10.0, 10.0, size));
    let scale = power_of_two(n);
    let q = scale * p + (scale - 1.0);
    (q / (q + 2.0)).copysign(x)
}

/// `e^x = 2^n (1 + p)` for x from -104 to 89: returns n and p.
///
/// x = n ln 2 + r with |r| at most half of ln 2, and p = e^r - 1 = r + r^2 q(r).
#[inline(always)]
pub(crate) fn split_exp(x: f32) -> (i32, f32) {
    // Adding 1.5 * 2^23 rounds to an integer, which is then in the lowest bits.
    let shifted = x * std::f32::consts::LOG2_E + ROUNDING;
    let n = shifted - ROUNDING;
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    let p = r + r * r * polynomial(r, EXP);
    let n = (shifted.to_bits() as i32).wrapping_sub(ROUNDING.to_bits() as i32);
    (n, p)
}

const ROUNDING: f32 = 12_582_912.0;
const TWO_TO_23: f32 = 8_388_608.0;

/// ln 2 in two parts; products of the first with integers up to 2^14 are exact.
pub(crate) const LN2_HIGH: f32 = 355.0 / 512.0;
pub(crate) const LN2_LOW: f32 = -2.121_944_4e-4;

/// Coefficients of (e^r - 1 - r) / r^2 for |r| up to half of ln 2; 2^-26 relative to e^r - 1.
pub(crate) const EXP: [f32; 5] = [
    0.499_999_97,
    0.166_665_43,
    0.041_667_2,
    0.008_366_58,
    0.001_388_251,
];

/// Coefficients of (ln(1 + f) - f + f^2/2) / f^3 for 1 + f from sqrt(1/2) to sqrt(2); 2^-27 relative to ln(1 + f).
pub(crate) const LN: [f32; 8] = [
    0.333_333_3,
    -0.250_008_2,
    0.200_012_27,
    -0.166_233_57,
    0.142_017_57,
    -0.131_601_83,
    0.127_615_78,
    -0.076_344_974,
];

#[cfg(test)]
mod tests {
    use super::super::accuracy::{assert_within, sweep};
    use super::*;

    #[test]
    fn exp_is_within_its_error_everywhere() {
        // The last argument whose exponential is below f32::MAX.
        let largest = f32::MAX.ln().next_down();
        assert_within(1.03, sweep(0.0, largest), exp, f64::exp);
        assert_within(1.03, sweep(-0.0, -104.0), exp, f64::exp);
    }

    #[test]
    fn exp_ends_where_f32_does() {
        assert_eq!([exp(0.0), exp(-0.0), exp(1e-40)], [1.0; 3]);
        for x in [-104.0, -1e3, -f32::MAX, f32::NEG_INFINITY] {
            assert_eq!(exp(x), 0.0, "{x}");
        }
        for x in [88.73, 89.0, 1e3, f32::MAX, f32::INFINITY] {
            assert_eq!(exp(x), f32::INFINITY, "{x}");
        }
        assert!(exp(88.72).is_finite() && exp(-103.0) > 0.0);
        assert!(exp(f32::NAN).is_nan());
    }

    #[test]
    fn ln_is_within_its_error_everywhere() {
        let least = f32::from_bits(1);
        assert_within(1.0, sweep(least, f32::MAX), ln, f64::ln);
        // Near 1 the result is near 0, where cancellation would lose digits.
        let around = (0..100_000).map(|i| f32::from_bits(1.0_f32.to_bits() - 50_000 + i));
        assert_within(1.0, around, ln, f64::ln);
    }

    #[test]
    fn shorter_forms_give_the_same_bits_where_all_is_normal() {
        for x in sweep(f32::MIN_POSITIVE, f32::MAX) {
            assert_eq!(ln_of_normal(x), ln(x), "{x:e}");
        }
        for x in sweep(0.0, 88.0).chain(sweep(-0.0, -87.0)) {
            assert_eq!(exp_to_normal(x), exp(x), "{x}");
        }
    }

    #[test]
    fn ln_outside_its_range() {
        assert_eq!(ln(1.0), 0.0);
        assert_eq!([ln(0.0), ln(-0.0)], [f32::NEG_INFINITY; 2]);
        assert_eq!(ln(f32::INFINITY), f32::INFINITY);
        for x in [-1e-45, -1.0, f32::NEG_INFINITY, f32::NAN] {
            assert!(ln(x).is_nan(), "{x}");
        }
    }

    #[test]
    fn tanh_is_within_its_error_everywhere() {
        assert_within(2.5, sweep(0.0, 12.0), tanh, f64::tanh);
        assert_within(2.5, sweep(-0.0, -12.0), tanh, f64::tanh);
    }

    #[test]
    fn tanh_saturates_exactly_and_keeps_signs() {
        for x in [8.5, 10.0, 1e3, f32::MAX, f32::INFINITY] {
            assert_eq!([tanh(x), tanh(-x)], [1.0, -1.0], "{x}");
        }
        assert_eq!(tanh(0.0).to_bits(), 0.0_f32.to_bits());
        assert_eq!(tanh(-0.0).to_bits(), (-0.0_f32).to_bits());
        // Arguments so small that the result equals the argument.
        for x in [f32::from_bits(1), 1e-40, f32::MIN_POSITIVE, 1e-10] {
            assert_eq!([tanh(x), tanh(-x)], [x, -x]);
        }
        assert!(tanh(f32::NAN).is_nan());
    }
}
