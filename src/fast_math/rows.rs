//! Elementary functions over a row of numbers.

use crate::engine::cpu::simd::widened;

use super::{atan, exp, ln, pow, tanh};

/// A function of this module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Function {
    /// [`exp`].
    Exp,
    /// [`ln`].
    Ln,
    /// [`tanh`].
    Tanh,
    /// [`atan`].
    Atan,
    /// [`pow`] with this exponent.
    Pow(f32),
}

/// Applies the function to each number of `x`, up to the shorter length.
#[inline(always)]
pub(crate) fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    match function {
        Function::Exp => map(out, x, exp),
        Function::Ln => map(out, x, ln),
        Function::Tanh => map(out, x, tanh),
        Function::Atan => map(out, x, atan),
        Function::Pow(exponent) => map(out, x, |x| pow(x, exponent)),
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
