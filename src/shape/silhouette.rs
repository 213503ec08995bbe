//! Silhouettes: where the surface ends or one part occludes another.
//!
//! Theory: [LW] section 4.4 takes the Sobel magnitude of depth. Changes: with depth, silhouettes are the gaps between
//! surfaces, see [`super::gap`]; the border of coverage is always a silhouette. Practice: supply depth if available,
//! else an occlusion map or alpha, whose jumps are found by Sobel's kernel.

use crate::frame::gap::pair::larger;
use crate::params::SoftThreshold;
use crate::shape::{Rows, Shifted, inner_columns, outer_columns, sobel};
use std::ops::Range;

/// Silhouette weight, 0..1, of the pixel at column `x` from `map`, an occlusion map.
///
/// A pixel with an uncovered pixel among its eight neighbours is on the border, weight 1.
/// Source: [LW] algorithm 1, step 1.
#[inline(always)]
pub(crate) fn silhouette_weight(
    map: &Rows,
    covered: &Rows<bool>,
    x: usize,
    threshold: SoftThreshold,
) -> f32 {
    if on_border(covered, x) {
        return 1.0;
    }
    jump_weight(map.neighbourhood(x), threshold)
}

/// The weight of the jump across the centre of `around`: twice the Sobel slope, the difference between the two sides.
#[inline(always)]
pub(crate) fn jump_weight(around: [[f32; 3]; 3], threshold: SoftThreshold) -> f32 {
    let [dx, dy] = sobel(around);
    threshold.weight(2.0 * (dx * dx + dy * dy).sqrt())
}

/// [`silhouette_weight`] of the pixels of a row in `columns`; undefined where uncovered.
#[inline(always)]
pub(crate) fn silhouette_row(
    weight: &mut [f32],
    map: &Rows,
    covered: &Rows<bool>,
    columns: Range<usize>,
    threshold: SoftThreshold,
) {
    let inner = inner_columns(&columns, weight.len());
    for x in outer_columns(&columns, &inner) {
        weight[x] = silhouette_weight(map, covered, x, threshold);
    }
    if inner.is_empty() {
        return;
    }
    let out = &mut weight[inner.clone()];
    let [above, at, below] = [map.above, map.at, map.below].map(|row| Shifted::new(row, &inner));
    let seen = [covered.above, covered.at, covered.below].map(|row| Shifted::new(row, &inner));
    for (i, out) in out.iter_mut().enumerate() {
        let jump = jump_weight([above.around(i), at.around(i), below.around(i)], threshold);
        *out = if all_seen(&seen, i) { jump } else { 1.0 };
    }
}

/// Whether the nine pixels around the `i`-th column are covered.
#[inline(always)]
fn all_seen(rows: &[Shifted<bool>; 3], i: usize) -> bool {
    let seen = |r: usize| rows[r].left[i] & rows[r].at[i] & rows[r].right[i];
    seen(0) & seen(1) & seen(2)
}

/// The weights of the silhouettes that a pixel is in front of, and that it is beside, from the signed weights of the gaps
/// from the pixel before it and to the next one, and to the row below and from the row above.
#[inline(always)]
pub(crate) fn silhouettes_of_gaps([before, after]: [f32; 2], [below, above]: [f32; 2]) -> [f32; 2] {
    let front = larger(larger(after, -before), larger(below, -above));
    let across = larger(after.abs(), before.abs());
    [
        larger(front, 0.0),
        larger(across, larger(below.abs(), above.abs())),
    ]
}

/// Silhouettes of the pixels of a row in `columns`, from the signed weights of the gaps to each pixel from the one before
/// it, to the row below, and from the row above: those drawn, of pixels in front of a gap, and those that close, of pixels
/// on both sides of one. Undefined where uncovered.
#[inline(always)]
pub(crate) fn silhouettes_of_gaps_row(
    [line, barrier]: [&mut [f32]; 2],
    [across, below, above]: [&[f32]; 3],
    covered: &Rows<bool>,
    columns: Range<usize>,
) {
    let inner = inner_columns(&columns, line.len());
    let weights = |x: usize| silhouettes_of_gaps([across[x], across[x + 1]], [below[x], above[x]]);
    for x in outer_columns(&columns, &inner) {
        let of_gaps = if on_border(covered, x) {
            [1.0; 2]
        } else {
            weights(x)
        };
        [line[x], barrier[x]] = of_gaps;
    }
    if inner.is_empty() {
        return;
    }
    let seen = [covered.above, covered.at, covered.below].map(|row| Shifted::new(row, &inner));
    let n = inner.len();
    let (before, after) = (&across[inner.start..][..n], &across[inner.start + 1..][..n]);
    let (below, above) = (&below[inner.start..][..n], &above[inner.start..][..n]);
    let (line, barrier) = (&mut line[inner.clone()], &mut barrier[inner]);
    for i in 0..n {
        let [front, beside] = silhouettes_of_gaps([before[i], after[i]], [below[i], above[i]]);
        let inside = all_seen(&seen, i);
        line[i] = if inside { front } else { 1.0 };
        barrier[i] = if inside { beside } else { 1.0 };
    }
}

/// 1 for the pixels of a row in `columns` that are [`on_border`], 0 for the others.
#[inline(always)]
pub(crate) fn border_row(weight: &mut [f32], covered: &Rows<bool>, columns: Range<usize>) {
    for x in columns {
        weight[x] = f32::from(on_border(covered, x));
    }
}

/// Whether the pixel at column `x` has an uncovered pixel among its eight neighbours.
#[inline(always)]
pub(crate) fn on_border(covered: &Rows<bool>, x: usize) -> bool {
    covered.neighbourhood(x).iter().flatten().any(|&c| !c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    const THRESHOLD: SoftThreshold = SoftThreshold { lo: 0.2, hi: 0.4 };

    #[test]
    fn a_step_of_occlusion_weighs_by_its_size() {
        let weight_of_step = |step: f32| {
            let map = Plane::from_fn(4, 3, |x, _| if x < 2 { 0.1 } else { 0.1 + step });
            let covered = Plane::filled(4, 3, true);
            let (map, covered) = (Rows::around(&map, 1), Rows::around(&covered, 1));
            silhouette_weight(&map, &covered, 1, THRESHOLD)
        };
        // Half-way from 0.2 to 0.4.
        assert!((weight_of_step(0.3) - 0.5).abs() < 1e-6);
        assert_eq!([0.19, 0.5].map(weight_of_step), [0.0, 1.0]);
    }

    #[test]
    fn the_border_of_coverage_is_a_silhouette() {
        let flat = Plane::filled(4, 4, 0.0);
        let covered = Plane::from_fn(4, 4, |x, y| (x, y) != (0, 0));
        let weight = |x, y| {
            silhouette_weight(
                &Rows::around(&flat, y),
                &Rows::around(&covered, y),
                x,
                THRESHOLD,
            )
        };
        assert_eq!(weight(1, 1), 1.0);
        assert_eq!(weight(2, 2), 0.0);
    }
}
