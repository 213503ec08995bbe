//! Paper: its grain under a pencil, and ink on it.

use crate::frame::{ColorPlanes, Plane};

/// Black layers, given by their coverage of the paper, 0..1, over one another on white paper.
pub fn on_paper(layers: &[&Plane]) -> ColorPlanes {
    let (first, rest) = layers.split_first().expect("a drawing has a layer");
    let mut white = first.map(|ink| 1.0 - ink);
    for layer in rest {
        white.each_with(layer, |white, ink| *white *= 1.0 - ink);
    }
    ColorPlanes::grey(white)
}

/// Height of the paper at a pixel, 0..1: noise of about two pixels' size, fixed by the seed and the position.
#[inline]
pub(crate) fn grain(x: i32, y: i32, seed: u64) -> f32 {
    let at = |dx: i32, dy: i32| unit(hash(x.wrapping_add(dx), y.wrapping_add(dy), seed));
    rough(at, SPREAD)
}

/// Roughness of about two pixels of noise `at` a place and beside it, 0..1, times `spread`: averaging draws the
/// values together.
#[inline]
pub(super) fn rough(at: impl Fn(i32, i32) -> f32, spread: f32) -> f32 {
    let beside = at(1, 0) + at(-1, 0) + at(0, 1) + at(0, -1);
    let mean = HERE * at(0, 0) + BESIDE * beside;
    (0.5 + spread * (mean - 0.5)).clamp(0.0, 1.0)
}

/// Shares of a pixel's own noise and of that of each of the four beside it.
const HERE: f32 = 0.4;
const BESIDE: f32 = 0.15;

const SPREAD: f32 = 1.8;

/// Ink of a pencil line of this `coverage` on paper of the height `grain`: graphite sticks to the raised parts, and a
/// soft edge breaks up before its middle does.
#[inline]
pub(crate) fn graphite(coverage: f32, grain: f32) -> f32 {
    let reach = coverage * (1.0 + GRIP) - GRIP * (1.0 - grain);
    LIGHTEST_BLACK * reach.clamp(0.0, 1.0)
}

/// Depth of the paper's valleys relative to the pressure of a line.
const GRIP: f32 = 0.7;

/// The coverage of graphite that is pressed hard.
const LIGHTEST_BLACK: f32 = 0.9;

/// Mixes the bits of a place and a seed.
fn hash(x: i32, y: i32, seed: u64) -> u64 {
    let place = u64::from(x as u32) << 32 | u64::from(y as u32);
    // A seed by all of its bits: neighbours among seeds have nothing in common.
    let mut mixed = place ^ seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for _ in 0..HASH_ROUNDS {
        mixed = (mixed ^ (mixed >> 32)).wrapping_mul(HASH_FACTOR);
    }
    mixed ^ (mixed >> 32)
}

const HASH_ROUNDS: u32 = 2;
const HASH_FACTOR: u64 = 0xd6e8_feb8_6659_fd93;

fn unit(bits: u64) -> f32 {
    (bits >> 40) as f32 / (1 << 24) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grain_is_even_and_its_neighbours_alike() {
        let all: Vec<f32> = (0..10_000).map(|i| grain(i % 100, i / 100, 3)).collect();
        let mean = all.iter().sum::<f32>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        // Weights .4 and .15 four times share .4 * .15 * 2 of .4^2 + 4 * .15^2 with the next: half.
        let product = |step: usize| {
            let pairs = all.iter().zip(&all[step..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f32>()
        };
        let next = product(1) / product(0);
        assert!((next - 0.48).abs() < 0.06, "{next}");
    }

    #[test]
    fn graphite_covers_what_stands_out_first() {
        assert_eq!(graphite(0.0, 1.0), 0.0);
        assert_eq!(graphite(1.0, 1.0), LIGHTEST_BLACK);
        assert!(graphite(0.5, 0.9) > graphite(0.5, 0.3));
        assert_eq!(graphite(0.3, 0.0), 0.0);
    }
}
