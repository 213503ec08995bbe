//! Colours divided by the alpha that is stored with them.

use crate::frame::ColorPlanes;

/// A number within 0..1, which codes can hold; 0 for NaN.
pub(super) fn clipped(v: f64) -> f64 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }
}

/// The rows `y` of red, green and blue.
pub(super) fn rows_of(ColorPlanes { r, g, b }: &ColorPlanes, y: usize) -> [&[f32]; 3] {
    [r.row(y), g.row(y), b.row(y)]
}

/// The colour in column `x` of these rows divided by alpha, and the alpha to be stored as a code up to `max`.
#[inline(always)]
pub(super) fn straight(
    [r, g, b]: [&[f32]; 3],
    alpha: Option<&[f32]>,
    x: usize,
    max: u32,
) -> ([f64; 3], f64) {
    // An array that is mapped is not always inlined.
    let color = [r[x].into(), g[x].into(), b[x].into()];
    let alpha = alpha.map_or(1.0, |row| row[x].into());
    let stored = stored_alpha(color, alpha, 0.5 / f64::from(max));
    (divided(color, stored), stored)
}

/// The alpha to be stored with a colour multiplied by `alpha`: for alpha below `least`, which is stored as 0, the smallest
/// that holds the colour.
#[inline(always)]
fn stored_alpha(color: [f64; 3], alpha: f64, least: f64) -> f64 {
    let alpha = clipped(alpha);
    let strongest = largest(color).min(1.0);
    let alpha = if alpha < least { strongest } else { alpha };
    if alpha < least { 0.0 } else { alpha }
}

/// A colour divided by the alpha that is stored with it.
#[inline(always)]
fn divided([r, g, b]: [f64; 3], alpha: f64) -> [f64; 3] {
    match alpha {
        0.0 => [0.0; 3],
        // Most pixels are opaque.
        1.0 => [r, g, b],
        _ => [r / alpha, g / alpha, b / alpha],
    }
}

/// The largest channel, at least 0.
#[inline(always)]
pub(super) fn largest([r, g, b]: [f64; 3]) -> f64 {
    0.0_f64.max(r).max(g).max(b)
}
