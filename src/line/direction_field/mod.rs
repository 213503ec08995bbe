//! The field of stroke directions: confidence of directions, and their average over a surface.
//!
//! Theory: [LA] section 6.1. Directions are averaged over a cross-shaped kernel whose weights fall linearly with
//! distance, several times, at a quarter of the picture's size; nothing is averaged across a silhouette or crease.
//! Changes: a direction is represented by a vector of twice its angle, whose length is its confidence, and these
//! vectors are averaged. Equation 7 multiplies the sum of t t^T by the direction of the pixel itself; here its main
//! axis is taken, so that a patch perpendicular to all around it, as occurs where the two curvatures swap, does not
//! stay so. Where curvature is uncertain the surrounding directions lead, and far from all of them the fallback does,
//! continuously. Practice: [`crate::line::patches`] determines which pixels may be averaged. The diffusion of the
//! gradient keeps one value per pixel; a cell here has a patch, and a value, for each surface in it.

pub(crate) mod between_patches;
pub(crate) mod chains;
pub(crate) mod cpu;
pub(crate) mod directions;
pub(crate) mod patches;
pub(crate) mod setting;
pub(crate) mod stage;

use glam::{DVec2, Vec2};
use std::ops::Range;

/// Twice the angle of a direction: opposites are equal, and perpendicular directions cancel.
#[inline(always)]
pub(crate) fn doubled(t: Vec2) -> Vec2 {
    Vec2::new(t.x * t.x - t.y * t.y, 2.0 * t.x * t.y)
}

/// The unit direction, of the two, at half the angle of `doubled`; 0 for 0.
#[inline(always)]
pub(crate) fn halved(doubled: [f32; 2]) -> [f32; 2] {
    let [x, y] = doubled;
    let length = (x * x + y * y).sqrt();
    // cos^2 = (1 + cos 2a) / 2, whichever of sine and cosine is the larger; the other by sin 2a.
    let twice = 2.0 * length;
    let larger = ((length + x.abs()) / twice).sqrt();
    let lesser = y / (twice * larger);
    let found = if x >= 0.0 {
        [larger, lesser]
    } else {
        [lesser.abs(), larger.copysign(y)]
    };
    if length > LEAST_LENGTH {
        found
    } else {
        [0.0; 2]
    }
}

/// A shorter vector counts as 0: its square lacks full precision.
const LEAST_LENGTH: f32 = 1e-18;

/// Directions of a row, halved in place.
#[inline(always)]
pub(crate) fn halve_row(x: &mut [f32], y: &mut [f32]) {
    for (x, y) in x.iter_mut().zip(y) {
        [*x, *y] = halved([*x, *y]);
    }
}

/// Largest ratio of the difference of the curvatures to their sum on a round surface: a ball's mesh is no rounder.
const ROUND: f64 = 0.1;

/// A tensor of curvature averaged over a surface, per pixel: half the difference of the curvatures toward twice
/// the angle of the algebraically larger one, and their mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CurvatureTensor {
    /// Half the difference.
    pub deviator: DVec2,
    /// The mean.
    pub mean: f64,
}

impl CurvatureTensor {
    /// The unit direction, in the frame of the tensor, of the curvature larger in magnitude, and whether there is one.
    #[inline(always)]
    pub(crate) fn larger(&self) -> (bool, DVec2) {
        let d = if self.mean >= 0.0 {
            self.deviator
        } else {
            -self.deviator
        };
        let length = d.length();
        let axis = if d.x >= 0.0 {
            DVec2::new(d.x + length, d.y)
        } else {
            DVec2::new(d.y, length - d.x)
        };
        let over_length = axis.length_recip();
        let has_length = (over_length > 0.0) & (over_length < f64::INFINITY);
        (has_length, axis * over_length)
    }

    /// Confidence of the directions, 0..1: 1 on a cylinder, 0 if the curvatures are equal in magnitude, or differ by no
    /// more than `doubt` (both per pixel).
    ///
    /// The first factor, the square of the excess of `(|k1| - |k2|) / (|k1| + |k2|)` over a tenth, has no unit; the
    /// second compares `|k1| - |k2|` with the difference that noise, or a plane, would show.
    #[inline(always)]
    pub(crate) fn confidence(&self, doubt: f64) -> f64 {
        let (difference, mean) = (self.deviator.length(), self.mean.abs());
        let (lesser, larger) = (difference.min(mean), difference.max(mean));
        let apart = 4.0 * lesser * lesser;
        let share = ((lesser / larger - ROUND) / (1.0 - ROUND)).max(0.0);
        let confidence = share * share * apart / (apart + doubt * doubt);
        if apart > 0.0 { confidence } else { 0.0 }
    }

    /// Flatness of the surface, 0..1; a quarter at a curvature of `doubt`.
    #[inline(always)]
    pub(crate) fn flatness(&self, doubt: f64) -> f64 {
        let larger = self.deviator.length() + self.mean.abs();
        let square = doubt * doubt;
        let root = square / (square + larger * larger);
        if square > 0.0 { root * root } else { 0.0 }
    }
}

/// The direction of strokes, as twice an angle: the mean of `own` directions, or, the more those disagree, the mean of
/// the directions `around`, which come from farther away.
///
/// The vectors of agreeing directions add up to a length of their summed confidence, the third of `own`; where
/// differently oriented shapes meet, or in noise, they cancel, so a shape too small for the radius does not cause a
/// swirl.
#[inline(always)]
pub(crate) fn calm([x, y, sure, _]: Weighted, around: Weighted) -> [f32; 2] {
    let length = (x * x + y * y).sqrt();
    let share = length / sure;
    let agreement = if sure > 0.0 { share } else { 0.0 };
    let share = ((agreement - AGREE.start) / (AGREE.end - AGREE.start)).clamp(0.0, 1.0);
    let agreement = share * share * (3.0 - 2.0 * share);
    let lead = |own: f32, around: f32| agreement * own + (1.0 - agreement) * around;
    [lead(x, around[0]), lead(y, around[1])]
}

/// Length of a mean direction relative to that for full agreement, from which it counts, and from which it leads alone:
/// 0.8 for directions spread evenly over 65 degrees, 0.2 over 150.
const AGREE: Range<f32> = 0.2..0.8;

/// Three components and a weight of 1.
pub(crate) type Weighted = [f32; 4];

/// Sums along a chain of values around each one, weighted by `1 - distance / reach` (Eq. 7's w_s), including the value
/// itself with weight 1. A value is of `N` fields; `reach` is more than 0.
///
/// With G(t) the sum of the values before place t, each times its distance from there, the sum around place i up to r is
/// (G(i + r) - 2 G(i) + G(i - r)) / r. Between places G is linear, so that any reach takes the same time.
#[inline(always)]
pub(crate) fn sums_along<const N: usize>(
    sums: &mut [[Weighted; N]],
    chain: &[[Weighted; N]],
    reach: &[f32],
    scratch: &mut Vec<[[f64; 4]; N]>,
) {
    let end = chain.len();
    if scratch.len() <= end {
        scratch.resize(end + 1, [[0.0; 4]; N]);
    }
    let moments = &mut scratch[..=end];
    moments[0] = [[0.0; 4]; N];
    let [mut sum, mut moment] = [[[0.0; 4]; N]; 2];
    for (next, value) in moments[1..].iter_mut().zip(chain) {
        for f in 0..N {
            for c in 0..4 {
                sum[f][c] += f64::from(value[f][c]);
                moment[f][c] += sum[f][c];
            }
        }
        *next = moment;
    }
    let moments = &*moments;
    // Counted, so that the compiler widens the loops over components, not this one, which would gather.
    let mut to_end = end as f64;
    for (i, ((out, &reach), here)) in sums.iter_mut().zip(reach).zip(moments).enumerate() {
        let reach = f64::from(reach);
        let whole = (reach as u32) as usize;
        let [before, after] = [i.saturating_sub(whole), i + whole].map(|at| at.min(end));
        let (near, near_end) = (&moments[before], &moments[after]);
        let (far, far_end) = (
            &moments[before.saturating_sub(1)],
            &moments[(after + 1).min(end)],
        );
        // Before the chain G is 0, and beyond its end it rises by the sum of all values.
        let beyond = (reach - to_end).max(0.0);
        to_end -= 1.0;
        let (slope, rest) = (reach.recip(), reach - whole as f64);
        for f in 0..N {
            for c in 0..4 {
                let both = near[f][c] + near_end[f][c];
                let further = far[f][c] + far_end[f][c] - both;
                let curve = both + rest * further + beyond * sum[f][c] - 2.0 * here[f][c];
                out[f][c] = (slope * curve) as f32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_twice_an_angle_is_the_direction() {
        for degrees in -180..180 {
            let t = Vec2::from_angle((degrees as f32 + 0.25).to_radians());
            for length in [1e-12, 1.0, 3e4] {
                let found = Vec2::from(halved((length * doubled(t)).into()));
                assert!(found.perp_dot(t).abs() < 1e-6, "{degrees}: {found} for {t}");
                assert!((found.length() - 1.0).abs() < 1e-6);
            }
        }
        assert_eq!(halved([0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(halved([-0.0, -0.0]), [0.0, 0.0]);
        assert_eq!(halved([-1.0, 0.0]), [0.0, 1.0]);
    }

    fn form(k1: f64, k2: f64) -> CurvatureTensor {
        // For two curvatures, with the algebraically larger one along x.
        CurvatureTensor {
            deviator: DVec2::new(0.5 * (k1 - k2), 0.0),
            mean: 0.5 * (k1 + k2),
        }
    }

    #[test]
    fn the_larger_in_size_leads() {
        // A convex cylinder around y bends along x by -k: the larger of (0, -k) is along y.
        assert_eq!(form(0.0, -0.1).larger(), (true, DVec2::Y));
        assert_eq!(form(0.1, 0.0).larger(), (true, DVec2::X));
        assert_eq!(form(0.1, -0.3).larger(), (true, DVec2::Y));
        assert!(!form(0.2, 0.2).larger().0);
    }

    #[test]
    fn confidence_is_the_squared_share_by_which_curvatures_differ() {
        let certain = |k1, k2| form(k1, k2).confidence(0.0);
        assert!((certain(0.0, -0.1) - 1.0).abs() < 1e-12);
        // (3 - 1) / (3 + 1) = 0.5, for any signs; less 0.1, over 0.9: 4/9, squared.
        for (k1, k2) in [(0.3, 0.1), (0.3, -0.1), (0.1, -0.3), (-0.1, -0.3)] {
            assert!((certain(k1, k2) - 16.0 / 81.0).abs() < 1e-12, "{k1} {k2}");
        }
        assert_eq!(certain(0.1, 0.1), 0.0);
        assert_eq!(certain(-0.1, -0.085), 0.0);
        assert_eq!(certain(0.1, -0.1), 0.0);
        assert_eq!(certain(0.0, 0.0), 0.0);
        // A difference as large as the doubt counts half, a tenth of it a hundredth.
        assert!((form(0.1, 0.0).confidence(0.1) - 0.5).abs() < 1e-12);
        assert!((form(0.01, 0.0).confidence(0.1) - 0.01 / 1.01).abs() < 1e-12);
    }

    #[test]
    fn surroundings_lead_where_directions_disagree() {
        const AROUND: Weighted = [0.0, 1.0, 1.0, 1.0];
        let own = |x, y, sure| [x, y, sure, 1.0];
        assert_eq!(calm(own(0.3, 0.0, 0.3), AROUND), [0.3, 0.0]);
        assert_eq!(calm(own(0.0, 0.0, 0.3), AROUND), [0.0, 1.0]);
        assert_eq!(calm(own(0.0, 0.0, 0.0), AROUND), [0.0, 1.0]);
        assert_eq!(calm(own(0.85, 0.0, 1.0), AROUND), [0.85, 0.0]);
        // A length of half the confidence is midway between 0.2 and 0.8: half of both.
        let [x, y] = calm(own(0.5, 0.0, 1.0), AROUND);
        assert!((x - 0.25).abs() < 1e-6 && (y - 0.5).abs() < 1e-6);
    }

    #[test]
    fn planes_are_flat_and_balls_are_not() {
        // (1 / (1 + 1))^2 where the larger curvature is the doubt.
        assert_eq!(form(0.0, 0.0).flatness(0.1), 1.0);
        assert!((form(0.0, -0.1).flatness(0.1) - 0.25).abs() < 1e-12);
        assert!(form(-1.0, -1.0).flatness(0.01) < 1e-7);
    }

    #[test]
    fn sums_are_those_of_the_weights() {
        let values: Vec<f32> = (0..40).map(|i| ((i * i) % 17) as f32 - 8.0).collect();
        for reach in [0.5, 1.0, 1.5, 2.0, 6.0, 7.3, 100.0_f32] {
            let chain: Vec<[Weighted; 2]> = values
                .iter()
                .map(|&v| [[v, 2.0 * v, 0.0, 1.0], [0.0, 0.0, -v, 1.0]])
                .collect();
            let mut sums = vec![[[0.0; 4]; 2]; 40];
            sums_along(&mut sums, &chain, &[reach; 40], &mut Vec::new());
            for (i, [sum, other]) in sums.iter().enumerate() {
                let weight = |j: usize| (1.0 - i.abs_diff(j) as f32 / reach).max(0.0);
                let expected: f32 = (0..40).map(|j| weight(j) * values[j]).sum();
                let expected_weights: f32 = (0..40).map(weight).sum();
                assert!(
                    (sum[0] - expected).abs() < 1e-3,
                    "{i} {reach}: {sum:?} {expected}"
                );
                assert!((sum[1] - 2.0 * expected).abs() < 2e-3);
                assert!((sum[3] - expected_weights).abs() < 1e-4);
                assert!((other[2] + expected).abs() < 1e-3);
            }
        }
    }
}
