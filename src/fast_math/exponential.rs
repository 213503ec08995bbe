//! `exp`, `ln`, `tanh` and `pow`, from one reduction by powers of two.

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

/// `x^y` for `x` of 0 or more; 1.03 ulp for every exponent, subnormal results included.
///
/// `x^0` and `1^y` are 1 for any other argument; `0^y` is 0, or infinite for negative y, and the reverse for infinite
/// x. NaN for negative `x`, and if either is NaN.
#[inline(always)]
pub(crate) fn pow(x: f32, y: f32) -> f32 {
    // In f64, since the product takes up to 7 bits off the logarithm. Beyond both limits the result is 0 or infinite;
    // comparisons leave a NaN, from 0 times infinity, to the cases below.
    let logarithm = f64::from(y) * log2(x);
    let logarithm = if logarithm < -160.0 {
        -160.0
    } else {
        logarithm
    };
    let logarithm = if logarithm > 130.0 { 130.0 } else { logarithm };
    let shifted = logarithm + ROUNDING_F64;
    let r = ((logarithm - (shifted - ROUNDING_F64)) * std::f64::consts::LN_2) as f32;
    let p = r + r * r * polynomial(r, EXP);
    let n = shifted.to_bits() as i32;
    let half = n >> 1;
    // Underflowing products are slow on CPUs, so results that underflow to 0 are 0 from the start.
    let finite = (1.0 + p) * select(n < -150, 0.0, power_of_two(half)) * power_of_two(n - half);
    let (least, most) = if y > 0.0 {
        (0.0, f32::INFINITY)
    } else {
        (f32::INFINITY, 0.0)
    };
    let power = select(x == 0.0, least, finite);
    let power = select(x == f32::INFINITY, most, power);
    let power = select((y == 0.0) | (x == 1.0), 1.0, power);
    select((x >= 0.0) & !y.is_nan(), power, f32::NAN)
}

/// The logarithm to base 2 of a positive finite `x`, to a relative 2^-37; undefined for others.
#[inline(always)]
fn log2(x: f32) -> f64 {
    let tiny = x < f32::MIN_POSITIVE;
    let bits = select(tiny, x * TWO_TO_23, x).to_bits();
    // As in `ln`.
    let e = (bits.wrapping_sub(std::f32::consts::FRAC_1_SQRT_2.to_bits()) as i32) >> 23;
    let f = f64::from(f32::from_bits(bits.wrapping_sub((e << 23) as u32)) - 1.0);
    let e = f64::from(e as f32 - select(tiny, 23.0, 0.0));
    // ln(1 + f) is twice the inverse hyperbolic tangent of f / (2 + f).
    let s = f / (2.0 + f);
    let square = s * s;
    let mut sum = 0.0;
    for c in ATANH.into_iter().rev() {
        sum = sum * square + c;
    }
    e + (s + s * square * sum) * (2.0 * std::f64::consts::LOG2_E)
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
/// The f64 counterpart, 1.5 * 2^52.
const ROUNDING_F64: f64 = 6_755_399_441_055_744.0;
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

/// Coefficients of (atanh(s) - s) / s^3 in powers of s^2, for (1 + s) / (1 - s) from sqrt(1/2) to sqrt(2); 2^-37
/// relative to atanh(s).
const ATANH: [f64; 4] = [
    0.333_333_328_201_685_06,
    0.200_001_682_943_379_8,
    0.142_686_033_231_750_3,
    0.117_921_528_051_004_82,
];

#[cfg(test)]
mod tests {
    use super::super::accuracy::{assert_within, sweep, ulps};
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

    /// Bases whose power y stays within f32, from smallest to largest.
    fn bases(y: f32) -> impl Iterator<Item = f32> {
        let ends = [-148.0, 127.9].map(|l| (l / f64::from(y)).clamp(-148.0, 127.9).exp2() as f32);
        let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let steps = 20_000;
        (0..=steps).map(move |i| {
            let t = f64::from(i) / f64::from(steps);
            ((1.0 - t) * f64::from(from).ln() + t * f64::from(to).ln()).exp() as f32
        })
    }

    #[test]
    fn pow_is_within_its_error_for_every_exponent() {
        let mut worst = (0.0, 0.0, 0.0);
        for size in [
            1e-30, 1e-3, 0.1, 0.45, 0.5, 1.0, 2.0, 2.2, 5.0, 17.3, 100.0, 1e3, 1e5, 1e7,
        ] {
            for y in [size, -size] {
                for x in bases(y) {
                    let exact = f64::from(x).powf(f64::from(y));
                    let error = ulps(pow(x, y), exact);
                    if exact < f64::from(f32::MAX) && (error > worst.0 || error.is_nan()) {
                        worst = (error, x, y);
                    }
                }
            }
        }
        assert!(
            worst.0 <= 1.03,
            "{} ulp at {:e}^{:e}",
            worst.0,
            worst.1,
            worst.2
        );
    }

    #[test]
    fn pow_where_the_exponent_is_large_and_the_base_near_one() {
        for i in 1..200_u32 {
            for x in [1.0 + i as f32 * f32::EPSILON, 1.0 - i as f32 * f32::EPSILON] {
                for y in [1e4, 1e5, 3e5] {
                    let exact = f64::from(x).powf(f64::from(y));
                    let found = pow(x, y);
                    assert!(ulps(found, exact) <= 1.03, "{found:e} at {x:e}^{y:e}");
                }
            }
        }
    }

    #[test]
    fn pow_ends_as_powers_do() {
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        for y in [0.0, -0.0, 1.0, -1.0, 1e5, -1e30, inf, -inf] {
            assert_eq!(pow(1.0, y), 1.0, "{y}");
            for x in [0.0, 1e-45, 1e-10, 0.5, 1.0, 2.0, 1e30, inf] {
                // The standard library's result to within rounding, exact at both ends.
                let exact = f64::from(x).powf(f64::from(y));
                let found = pow(x, y);
                assert!(
                    found == exact as f32 || ulps(found, exact) <= 1.03,
                    "{found:e} at {x:e}^{y:e}"
                );
            }
            assert!(pow(nan, y).is_nan() && pow(-1.0, y).is_nan());
        }
        assert_eq!([pow(0.0, 0.0), pow(-0.0, 0.0), pow(inf, 0.0)], [1.0; 3]);
        assert_eq!([pow(0.0, 3.0), pow(-0.0, 3.0), pow(0.5, 1e5)], [0.0; 3]);
        assert_eq!([pow(0.0, -3.0), pow(1.5, 1e5), pow(inf, 1e-3)], [inf; 3]);
        assert_eq!([pow(0.5, -inf), pow(0.5, inf)], [inf, 0.0]);
        for x in [0.0, 0.5, 1.0, inf, nan] {
            assert!(pow(x, nan).is_nan());
        }
        // Integer powers of powers of two are exact.
        assert_eq!(
            [pow(2.0, 127.0), pow(2.0, -149.0)],
            [2.0_f32.powi(127), 1e-45]
        );
    }
}
