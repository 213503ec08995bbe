//! The crate's elementary functions compared with the standard library's: errors over a dense sweep, and time per
//! number in a loop over a row.
//!
//! The crate's functions run in the widest vectors of the machine, as in the stages; those of the standard library are
//! scalar calls on any machine.

use crate::engine::cpu::simd::{Simd, widened};
use crate::fast_math::{atan, exp, ln, tanh};
use crate::report::asked::Extent;
use crate::report::compare::larger;
use serde::Serialize;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Errors of one function and its time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Measured {
    /// Largest error relative to the exact value, where that is a normal number.
    pub relative: f64,
    /// Largest error in units of the distance between neighbouring f32.
    pub ulp: f64,
    /// Nanoseconds per number, minimum of several runs.
    pub nanoseconds: f64,
}

/// One function, of the crate and of the standard library.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct FunctionRow {
    pub name: &'static str,
    pub domain: [f32; 2],
    /// Number of arguments tried: f32 evenly spaced in their order.
    pub arguments: usize,
    pub fast: Measured,
    pub std: Measured,
}

/// The vectors used by the crate's functions.
pub(crate) fn vectors() -> String {
    format!("{} bits", Simd::widest().bits())
}

/// Length of the timed row, within the first-level cache.
const ROW: usize = 2048;

/// A function of [`crate::fast_math`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Function {
    Exp,
    Ln,
    Tanh,
    Atan,
}

/// Applies the function to each number of `x`.
#[inline(always)]
fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    match function {
        Function::Exp => map(out, x, exp),
        Function::Ln => map(out, x, ln),
        Function::Tanh => map(out, x, tanh),
        Function::Atan => map(out, x, atan),
    }
}

widened! {
    fn map_row(function: Function, out: &mut [f32], x: &[f32]);
}

#[inline(always)]
fn map(out: &mut [f32], x: &[f32], function: impl Fn(f32) -> f32) {
    for (out, &x) in out.iter_mut().zip(x) {
        *out = function(x);
    }
}

/// Every function.
pub(crate) fn measured(extent: Extent) -> Vec<FunctionRow> {
    let effort = match extent {
        Extent::Full => (4_000_000, Duration::from_millis(60)),
        Extent::Quick => (120_000, Duration::from_millis(4)),
    };
    let row = |name, domain, function, std: fn(f32) -> f32, exact: fn(f64) -> f64| {
        measure(name, domain, effort, function, std, exact)
    };
    vec![
        row("exp", [-87.0, 88.0], Function::Exp, f32::exp, f64::exp),
        row("ln", [1e-37, 1e38], Function::Ln, f32::ln, f64::ln),
        row("tanh", [-10.0, 10.0], Function::Tanh, f32::tanh, f64::tanh),
        row("atan", [-1e9, 1e9], Function::Atan, f32::atan, f64::atan),
    ]
}

fn measure(
    name: &'static str,
    domain: [f32; 2],
    (arguments, limit): (usize, Duration),
    function: Function,
    std: fn(f32) -> f32,
    exact: fn(f64) -> f64,
) -> FunctionRow {
    let ours = |out: &mut [f32], x: &[f32]| Simd::widest().map_row(function, out, x);
    let theirs = |out: &mut [f32], x: &[f32]| map(out, x, std);
    let all = sweep(domain, arguments);
    let inputs = sweep(domain, ROW);
    FunctionRow {
        name,
        domain,
        arguments: all.len(),
        fast: measured_of(&all, &inputs, limit, ours, exact),
        std: measured_of(&all, &inputs, limit, theirs, exact),
    }
}

fn measured_of(
    all: &[f32],
    inputs: &[f32],
    limit: Duration,
    map: impl Fn(&mut [f32], &[f32]),
    exact: fn(f64) -> f64,
) -> Measured {
    let mut found = vec![0.0; all.len()];
    map(&mut found, all);
    let (relative, ulp) = errors(all, &found, exact);
    Measured {
        relative,
        ulp,
        nanoseconds: time(inputs, limit, map),
    }
}

/// About `count` numbers of `domain`, both ends included, evenly spaced in the order of f32.
fn sweep([from, to]: [f32; 2], count: usize) -> Vec<f32> {
    let [first, last] = [from, to].map(ordered);
    let steps = count.max(2) as i64 - 1;
    let at = |i: i64| unordered(first + (last - first) * i / steps);
    (0..=steps).map(at).collect()
}

/// The rank of `x` among all f32.
fn ordered(x: f32) -> i64 {
    let size = i64::from(x.abs().to_bits());
    if x.is_sign_negative() { -size } else { size }
}

fn unordered(place: i64) -> f32 {
    let size = f32::from_bits(place.unsigned_abs() as u32);
    if place < 0 { -size } else { size }
}

/// Largest relative error, and largest in ulp.
fn errors(arguments: &[f32], found: &[f32], exact: impl Fn(f64) -> f64) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for (&x, &found) in arguments.iter().zip(found) {
        let exact = exact(x.into());
        let error = (f64::from(found) - exact).abs();
        let size = exact.abs() as f32;
        if size >= f32::MIN_POSITIVE {
            worst.0 = larger(error / exact.abs(), worst.0);
        }
        let size = size.clamp(f32::MIN_POSITIVE, f32::MAX);
        let ulp = f64::from(size) - f64::from(size.next_down());
        worst.1 = larger(error / ulp, worst.1);
    }
    worst
}

/// Nanoseconds per number: the minimum over as many rounds as fit into `limit`, at least three.
fn time(inputs: &[f32], limit: Duration, map: impl Fn(&mut [f32], &[f32])) -> f64 {
    let mut out = vec![0.0; inputs.len()];
    let start = Instant::now();
    let (mut least, mut rounds) = (Duration::MAX, 0);
    while rounds < 3 || start.elapsed() < limit {
        let begun = Instant::now();
        map(black_box(&mut out), black_box(inputs));
        black_box(&mut out);
        least = least.min(begun.elapsed());
        rounds += 1;
    }
    1e9 * least.as_secs_f64() / inputs.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_reaches_both_ends_in_order() {
        for domain in [[-1.0, 2.0], [1e-37, 1e38], [-1e9, 1e9]] {
            let numbers = sweep(domain, 1000);
            assert_eq!([numbers[0], numbers[999]], domain);
            assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn errors_of_known_functions() {
        // One ulp off, 2^-23 between 1 and 2.
        let off = [1.5_f32, 1.75].map(|x| f32::from_bits(x.to_bits() + 1));
        let (relative, ulp) = errors(&[1.5, 1.75], &off, |x| x);
        assert!((ulp - 1.0).abs() < 1e-9, "{ulp}");
        assert!((relative - 2.0_f64.powi(-23) / 1.5).abs() < 1e-12);
        assert!(errors(&[1.0, 2.0], &[f32::NAN, 2.0], |x| x).1.is_nan());
    }
}
