//! Cosines between directions. Clamped by comparisons, which vectorise, and which turn NaN into the bound.

/// Scalar product of two vectors.
#[inline(always)]
pub(crate) fn scalar_product(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The number, or 0 below it.
#[inline(always)]
pub(crate) fn positive(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The number, or 1 above it.
#[inline(always)]
pub(crate) fn at_most_1(x: f32) -> f32 {
    if x < 1.0 { x } else { 1.0 }
}
