//! Branch-free elementary functions in f32, so that a loop over a row of samples vectorises.
//!
//! The standard library calls the C library for one number at a time. These functions are polynomials between selects:
//! each argument is reduced to a small interval, where a polynomial of our own fit (weighted minimax, computed with 40
//! digits) is within a fifth of a rounding, and the result is reconstructed exactly or with its rounding compensated.
//! Products and sums are deliberately separate: a fused multiply-add is a library call on processors not known to have
//! one, and gives other bits on those that do.
//!
//! The stated errors were measured over every f32, against double precision; an ulp is the distance between neighbouring
//! f32.

pub(crate) mod circular;
pub(crate) mod exponential;

pub(crate) use circular::{atan, atan2};
pub(crate) use exponential::{exp, exp_to_normal, ln, ln_of_normal, tanh};

/// The polynomial with these coefficients, the constant first.
#[inline(always)]
pub(crate) fn polynomial<const N: usize>(x: f32, coefficients: [f32; N]) -> f32 {
    let mut sum = 0.0;
    for i in (0..N).rev() {
        sum = sum * x + coefficients[i];
    }
    sum
}

/// 2^n for n from -126 to 127; undefined outside.
#[inline(always)]
pub(crate) fn power_of_two(n: i32) -> f32 {
    f32::from_bits((n.wrapping_add(127) << 23) as u32)
}

/// One of two values: both are computed, so that no branch is needed.
#[inline(always)]
pub(crate) fn select(condition: bool, yes: f32, no: f32) -> f32 {
    if condition { yes } else { no }
}

/// Measures the error of a function.
#[cfg(test)]
mod accuracy {
    /// Every 499th f32 between `from` and `to`, of equal sign, both ends included.
    pub(super) fn sweep(from: f32, to: f32) -> impl Iterator<Item = f32> {
        let (a, b) = (from.to_bits(), to.to_bits());
        (a.min(b)..=a.max(b))
            .step_by(499)
            .chain([a, b])
            .map(f32::from_bits)
    }

    /// The error of `found` in units of the distance between f32 near `exact`.
    fn ulps(found: f32, exact: f64) -> f64 {
        let size = (exact.abs() as f32).clamp(f32::MIN_POSITIVE, f32::MAX);
        let ulp = f64::from(size) - f64::from(size.next_down());
        (f64::from(found) - exact).abs() / ulp
    }

    pub(super) fn assert_within(
        limit: f64,
        arguments: impl Iterator<Item = f32>,
        f: fn(f32) -> f32,
        exact: fn(f64) -> f64,
    ) {
        let mut worst = (0.0, 0.0);
        for x in arguments {
            let error = ulps(f(x), exact(f64::from(x)));
            if error > worst.0 || error.is_nan() {
                worst = (error, x);
            }
        }
        let (error, x) = worst;
        assert!(error <= limit, "{error} ulp at {x:e}: {:e}", f(x));
    }
}
