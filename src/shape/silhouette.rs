//! Silhouettes: where the surface ends or one part occludes another.
//!
//! Theory: [LW] section 4.4 takes the Sobel magnitude of depth. Changes: the logarithm of depth is differentiated, so
//! that the weight is the same for a coin and for a cathedral, and for z, distance and 1/z alike; the border of
//! coverage is always a silhouette. Practice: supply depth if available, else an occlusion map or alpha.

use crate::engine::cpu::simd::widened;
use crate::fast_math::ln;
use crate::params::SoftThreshold;
use crate::shape::{Rows, Shifted, inner_columns, outer_columns, sobel};
use std::ops::Range;

/// Silhouette weight, 0..1, of the pixel at column `x` from `map`: the logarithm of depth, or an
/// occlusion map.
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

/// The logarithm of depth where covered, 0 elsewhere: the map for silhouettes.
#[inline(always)]
pub(crate) fn log_depth_row(out: &mut [f32], depth: &[f32], covered: &[bool]) {
    let n = out.len();
    let (depth, covered) = (&depth[..n], &covered[..n]);
    for x in 0..n {
        let log = ln(depth[x]);
        out[x] = if covered[x] { log } else { 0.0 };
    }
}

widened! {
    fn log_depth_row(out: &mut [f32], depth: &[f32], covered: &[bool]);
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
        let seen = |r: usize| seen[r].left[i] & seen[r].at[i] & seen[r].right[i];
        *out = if seen(0) & seen(1) & seen(2) {
            jump
        } else {
            1.0
        };
    }
}

widened! {
    fn silhouette_row(
        weight: &mut [f32],
        map: &Rows,
        covered: &Rows<bool>,
        columns: Range<usize>,
        threshold: SoftThreshold,
    );
}

/// 1 for the pixels of a row in `columns` that are [`on_border`], 0 for the others.
#[inline(always)]
pub(crate) fn border_row(weight: &mut [f32], covered: &Rows<bool>, columns: Range<usize>) {
    for x in columns {
        weight[x] = f32::from(on_border(covered, x));
    }
}

widened! {
    fn border_row(weight: &mut [f32], covered: &Rows<bool>, columns: Range<usize>);
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

    const THRESHOLD: SoftThreshold = SoftThreshold { lo: 0.03, hi: 0.04 };

    fn weight_of_step(near: f32, far: f32) -> f32 {
        let log_depth = Plane::from_fn(4, 3, |x, _| if x < 2 { near.ln() } else { far.ln() });
        let covered = Plane::filled(4, 3, true);
        silhouette_weight(
            &Rows::around(&log_depth, 1),
            &Rows::around(&covered, 1),
            1,
            THRESHOLD,
        )
    }

    #[test]
    fn a_step_of_three_and_a_half_percent_weighs_one_half() {
        // ln(1.035) = 0.0344, 44 % of the way from 0.03 to 0.04.
        let expected = (1.035_f32.ln() - 0.03) / 0.01;
        assert!((weight_of_step(1.0, 1.035) - expected).abs() < 1e-4);
        assert_eq!(weight_of_step(1.0, 1.02), 0.0);
        assert_eq!(weight_of_step(1.0, 1.05), 1.0);
    }

    #[test]
    fn the_weight_depends_on_neither_scale_nor_kind_of_depth() {
        let reference = weight_of_step(1.0, 1.036);
        for scale in [1e-6, 1e-3, 1e3, 1e6] {
            assert!((weight_of_step(scale, 1.036 * scale) - reference).abs() < 1e-3);
        }
        // Inverse depth.
        assert!((weight_of_step(1.0, 1.0 / 1.036) - reference).abs() < 1e-4);
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
