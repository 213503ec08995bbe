//! Domains of functions: each maps arbitrary inputs into one.

/// Applies a function to words that are floats.
pub(super) fn each(words: &mut [u32], f: impl Fn(f32) -> f32) {
    for word in words {
        *word = f(f32::from_bits(*word)).to_bits();
    }
}

/// Anything but NaN, infinities included: loading leaves no NaN in a plane, and NaN parameters are refused.
pub(super) fn no_nan(words: &mut [u32]) {
    each(words, |v| if v.is_nan() { 0.5 } else { v });
}

/// Finite numbers up to 1e9 in magnitude, whose products and sums stay finite: the result of an overflow depends on the
/// order of operations, which the shading language leaves open.
pub(super) fn bounded(words: &mut [u32]) {
    within_range(words, -1e9, 1e9);
}

pub(super) fn within_range(words: &mut [u32], from: f32, to: f32) {
    let middle = 0.5 * from + 0.5 * to;
    each(words, |v| {
        if v.is_nan() {
            middle
        } else {
            v.clamp(from, to)
        }
    });
}

/// Multiples of 1/16 up to `most` in magnitude: sums and products of a few are exact, so that both precisions fall on
/// the same side of every threshold.
pub(super) fn coarse(words: &mut [u32], most: f32) {
    within_range(words, -most, most);
    each(words, |v| (16.0 * v).round() / 16.0);
}

/// Three floats.
pub(super) fn vector(words: &[u32]) -> [f32; 3] {
    [0, 1, 2].map(|i| f32::from_bits(words[i]))
}

pub(super) fn set(words: &mut [u32], values: &[f32]) {
    for (word, value) in words.iter_mut().zip(values) {
        *word = value.to_bits();
    }
}

/// A unit vector, like every normal after loading: one of a few thousand, the axes included.
pub(super) fn unit_vector(words: &mut [u32]) {
    let size = vector(words).map(f32::abs).into_iter().fold(0.0, f32::max);
    if size <= 1.0 || size.is_nan() {
        coarse(words, 1.0);
    } else {
        coarse(words, 4.0);
    }
    let v = glam::Vec3::from(vector(words));
    set(
        words,
        &v.try_normalize().unwrap_or(glam::Vec3::Z).to_array(),
    );
}

/// The direction of a sight line, scaled to z = -1, at most 65 degrees from the axis.
pub(super) fn sight_line(words: &mut [u32]) {
    coarse(&mut words[..2], 1.5);
    words[2] = (-1.0_f32).to_bits();
}
