//! The rows, and the inputs that occur where random ones do not.

mod light;
mod line;
mod shape;

use super::{Twin, twin};
use glam::Vec3;

/// All rows.
pub(super) fn twins() -> Vec<Twin> {
    let rooms = [shape::twins(), light::twins(), line::twins()];
    rooms.into_iter().flatten().collect()
}

fn each(words: &mut [u32], f: impl Fn(f32) -> f32) {
    for word in words {
        *word = f(f32::from_bits(*word)).to_bits();
    }
}

/// Multiples of 1/16 up to `most` in magnitude: sums and products of a few are exact, so that both precisions fall on
/// the same side of every threshold.
fn coarse(words: &mut [u32], most: f32) {
    each(words, |v| (16.0 * v.clamp(-most, most)).round() / 16.0);
}

/// Three floats.
fn vector(words: &[u32]) -> Vec3 {
    Vec3::from([0, 1, 2].map(|i| f32::from_bits(words[i])))
}

fn set(words: &mut [u32], values: &[f32]) {
    for (word, value) in words.iter_mut().zip(values) {
        *word = value.to_bits();
    }
}

/// A unit vector, one of a few thousand, the axes included.
fn unit_vector(words: &mut [u32]) {
    coarse(&mut words[..3], 4.0);
    set(
        words,
        &vector(words).try_normalize().unwrap_or(Vec3::Z).to_array(),
    );
}

/// The direction of a sight line, scaled to z = -1, at most 65 degrees from the axis.
fn sight_line(words: &mut [u32]) {
    coarse(&mut words[..2], 1.5);
    words[2] = (-1.0_f32).to_bits();
}
