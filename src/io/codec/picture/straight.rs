//! Colours divided by the alpha that is stored with them.

use crate::frame::Plane;

/// A number within 0..1, which codes can hold; 0 for NaN.
pub(super) fn clipped(v: f64) -> f64 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }
}

/// The colour at a pixel divided by alpha, and the alpha to be stored as a code up to `max`.
#[inline(always)]
pub(super) fn straight(
    [r, g, b]: [&Plane; 3],
    alpha: Option<&Plane>,
    [x, y]: [usize; 2],
    max: u32,
) -> ([f64; 3], f64) {
    let at = |plane: &Plane| f64::from(plane.at(x, y));
    let color = [at(r), at(g), at(b)];
    let stored = stored_alpha(color, alpha.map_or(1.0, at), 0.5 / f64::from(max));
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
    let divided = |v: f64| if alpha == 0.0 { 0.0 } else { v / alpha };
    [divided(r), divided(g), divided(b)]
}

/// The largest channel, at least 0.
#[inline(always)]
pub(super) fn largest([r, g, b]: [f64; 3]) -> f64 {
    0.0_f64.max(r).max(g).max(b)
}
