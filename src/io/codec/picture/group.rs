//! Some pixels of a row at a time, so that the compiler computes several in one instruction.

use crate::frame::Plane;
use std::ops::Range;

/// A number within 0..1, which codes can hold; 0 for NaN.
pub(super) fn clipped(v: f64) -> f64 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }
}

/// Pixels that are converted together.
pub(super) const GROUP: usize = 16;

/// A number of each pixel.
pub(super) type PixelNumbers = [f64; GROUP];

/// Red, green and blue of each pixel.
pub(super) type Colors = [PixelNumbers; 3];

/// The colours made of each pixel's place and colour. If `make` has no branches or calls, the compiler takes several pixels
/// at a time.
#[inline(always)]
pub(super) fn each(colors: &Colors, make: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Colors {
    let mut made = [[0.0; GROUP]; 3];
    let [r, g, b] = &mut made;
    for (x, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
        [*r, *g, *b] = make(x, color_at(colors, x));
    }
    made
}

/// The colour of one pixel.
#[inline(always)]
pub(super) fn color_at([r, g, b]: &Colors, x: usize) -> [f64; 3] {
    [r[x], g[x], b[x]]
}

/// Colours divided by alpha, and the alpha to be stored, of these columns of a row: black and opaque past their end.
pub(super) fn straight(
    color: [&Plane; 3],
    alpha: Option<&Plane>,
    y: usize,
    columns: Range<usize>,
    max: u32,
) -> (Colors, PixelNumbers) {
    let rows = color.map(|plane| &plane.row(y)[columns.clone()]);
    let mut color = [[0.0; GROUP]; 3];
    for (numbers, samples) in color.iter_mut().zip(rows) {
        put(numbers, samples);
    }
    let mut opacity = [1.0; GROUP];
    if let Some(alpha) = alpha {
        put(&mut opacity, &alpha.row(y)[columns]);
    }
    let least = 0.5 / f64::from(max);
    let mut stored = [0.0; GROUP];
    for (x, stored) in stored.iter_mut().enumerate() {
        *stored = stored_alpha(color_at(&color, x), opacity[x], least);
    }
    (each(&color, |x, color| divided(color, stored[x])), stored)
}

/// Puts samples in the first places.
#[inline(always)]
fn put(numbers: &mut PixelNumbers, samples: &[f32]) {
    for (number, &sample) in numbers.iter_mut().zip(samples) {
        *number = sample.into();
    }
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
