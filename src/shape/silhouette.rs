//! Silhouettes: where the surface ends or one part occludes another.
//!
//! Theory: [LW] section 4.4 takes the Sobel magnitude of depth. Changes: with depth, silhouettes are the gaps between
//! surfaces, see [`super::gap`]; the border of coverage is always a silhouette. Practice: supply depth if available,
//! else an occlusion map or alpha, whose jumps are found by Sobel's kernel.

use crate::frame::gap::pair::{larger, smaller};
use crate::params::SoftThreshold;
use crate::shape::{Rows, Shifted, inner_columns, outer_columns, sobel};
use std::ops::Range;

/// The weight, 0..1, of the jump of an occlusion map across the centre of `around`: twice the Sobel slope, the difference
/// between the two sides. Source: [LW] algorithm 1, step 1.
#[inline(always)]
pub(crate) fn jump_weight(around: [[f32; 3]; 3], threshold: SoftThreshold) -> f32 {
    let [dx, dy] = sobel(around);
    threshold.weight(2.0 * (dx * dx + dy * dy).sqrt())
}

/// [`jump_weight`] of the pixels of a row in `columns`.
#[inline(always)]
pub(crate) fn jumps_row(
    weight: &mut [f32],
    map: &Rows,
    columns: Range<usize>,
    threshold: SoftThreshold,
) {
    let inner = inner_columns(&columns, weight.len());
    for x in outer_columns(&columns, &inner) {
        weight[x] = jump_weight(map.neighbourhood(x), threshold);
    }
    if inner.is_empty() {
        return;
    }
    let [above, at, below] = [map.above, map.at, map.below].map(|row| Shifted::new(row, &inner));
    for (i, out) in weight[inner].iter_mut().enumerate() {
        *out = jump_weight([above.around(i), at.around(i), below.around(i)], threshold);
    }
}

/// The weights of the silhouettes that a pixel is in front of, and that it is beside, from the signed strengths of gaps along
/// rows and columns: to the pixel before it from the one before that, from the pixel before it, to the next, and beyond.
///
/// Of several gaps in a row the largest is drawn: a filter spreads an edge over pixels, which is one silhouette.
#[inline(always)]
pub(crate) fn silhouettes_of_gaps(across: [f32; 4], down: [f32; 4]) -> [f32; 2] {
    let ([front_x, beside_x], [front_y, beside_y]) = (along_gaps(across), along_gaps(down));
    let (front, beside) = (larger(front_x, front_y), larger(beside_x, beside_y));
    [smaller(front, 1.0), smaller(beside, 1.0)]
}

/// The strengths of the gaps that a pixel is in front of, and that it is beside, along one axis.
#[inline(always)]
pub(crate) fn along_gaps([past_before, before, after, past_after]: [f32; 4]) -> [f32; 2] {
    let from_before = drawn(-before, -past_before, -after);
    let front = larger(drawn(after, past_after, before), from_before);
    [front, larger(after.abs(), before.abs())]
}

/// The strength of a gap where it is the largest of a row: no smaller than the one past it, and larger than the nearer one.
#[inline(always)]
pub(crate) fn drawn(own: f32, past: f32, nearer: f32) -> f32 {
    let is_largest = (own >= past) & (own > nearer);
    if is_largest { larger(own, 0.0) } else { 0.0 }
}

/// [`silhouettes_of_gaps`] of the pixels of a row: those drawn, of pixels in front of a gap, and those that close, of pixels on
/// both sides of one. `across` are the gaps between neighbours from two before the first pixel to two behind the last; `down`
/// those between rows, from two above to one below.
#[inline(always)]
pub(crate) fn silhouettes_of_gaps_row(
    [line, barrier]: [&mut [f32]; 2],
    across: &[f32],
    down: [&[f32]; 4],
) {
    let n = line.len();
    let (across, barrier) = (&across[..n + 3], &mut barrier[..n]);
    let down = down.map(|row| &row[..n]);
    for i in 0..n {
        let across = [across[i], across[i + 1], across[i + 2], across[i + 3]];
        let down = [down[0][i], down[1][i], down[2][i], down[3][i]];
        [line[i], barrier[i]] = silhouettes_of_gaps(across, down);
    }
}

/// Gives the pixels of a row in `columns` weight 1 that have an uncovered one among their eight neighbours.
#[inline(always)]
pub(crate) fn close_border_row<const N: usize>(
    mut weights: [&mut [f32]; N],
    covered: &Rows<bool>,
    columns: Range<usize>,
) {
    let inner = inner_columns(&columns, covered.at.len());
    for x in outer_columns(&columns, &inner) {
        if covered.neighbourhood(x).iter().flatten().any(|&c| !c) {
            weights.iter_mut().for_each(|row| row[x] = 1.0);
        }
    }
    if inner.is_empty() {
        return;
    }
    let rows = [covered.above, covered.at, covered.below].map(|row| Shifted::new(row, &inner));
    for weights in weights {
        for (i, weight) in weights[inner.clone()].iter_mut().enumerate() {
            let seen = |r: usize| rows[r].left[i] & rows[r].at[i] & rows[r].right[i];
            *weight = if seen(0) & seen(1) & seen(2) {
                *weight
            } else {
                1.0
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn a_step_of_occlusion_weighs_by_its_size() {
        let weight_of_step = |step: f32| {
            let map = Plane::from_fn(4, 3, |x, _| if x < 2 { 0.1 } else { 0.1 + step });
            let threshold = SoftThreshold { lo: 0.2, hi: 0.4 };
            jump_weight(Rows::around(&map, 1).neighbourhood(1), threshold)
        };
        // Half-way from 0.2 to 0.4.
        assert!((weight_of_step(0.3) - 0.5).abs() < 1e-6);
        assert_eq!([0.19, 0.5].map(weight_of_step), [0.0, 1.0]);
    }

    #[test]
    fn the_border_of_coverage_is_a_silhouette() {
        let covered = Plane::from_fn(4, 4, |x, y| (x, y) != (0, 0));
        let weights = |y| {
            let mut row = [0.5; 4];
            close_border_row([&mut row[..]], &Rows::around(&covered, y), 0..4);
            row
        };
        assert_eq!(weights(1), [1.0, 1.0, 0.5, 0.5]);
        assert_eq!(weights(2), [0.5; 4]);
    }

    #[test]
    fn of_gaps_in_a_row_the_largest_is_drawn_once() {
        // Depth falls back in three steps to the right; the second is the largest.
        let steps = [0.0, 0.0, 3.0, 9.0, 4.0, 0.0, 0.0];
        let fronts = |gaps: [f32; 7]| {
            let mut rows = [[0.0; 4]; 2];
            let [line, barrier] = &mut rows;
            silhouettes_of_gaps_row([line, barrier], &gaps, [&[0.0; 4]; 4]);
            rows
        };
        // The pixel before that step; all four are beside a step.
        assert_eq!(fronts(steps), [[0.0, 1.0, 0.0, 0.0], [1.0; 4]]);
        // The mirror image; and equal steps, of which the first is drawn.
        let mirrored = std::array::from_fn(|i| -steps[6 - i]);
        assert_eq!(fronts(mirrored)[0], [0.0, 0.0, 1.0, 0.0]);
        assert_eq!(
            fronts([0.0, 0.0, 3.0, 3.0, 0.0, 0.0, 0.5])[0],
            [1.0, 0.0, 0.0, 0.0]
        );
    }
}
