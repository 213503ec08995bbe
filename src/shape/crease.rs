//! Creases: where the surface turns sharply.
//!
//! Theory: [LW] section 4.4 takes the dihedral angle between neighbouring normals. Changes: the angle is `atan2(|a x
//! b|, a . b)`, accurate to 1e-7 where acos loses 4e-4 rad; it is also taken across the pixel, from one neighbour to
//! the opposite one, since a filter may spread an edge over a pixel; and a pixel with a short filtered normal contains
//! a crease, since the mean of two unit normals at an angle t has length cos(t/2).

use crate::frame::Vector3Planes;
use crate::params::SoftThreshold;
use crate::shape::{Rows, Shifted, inner_columns, outer_columns};
use glam::Vec3;
use std::ops::Range;

/// Maps angles between unit normals to crease weights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CreaseDetector {
    pub(crate) threshold_rad: SoftThreshold,
    /// Above this cosine the angle is certainly below the threshold.
    pub(crate) flat_cosine: f32,
    /// Above this length a filtered normal certainly hides no crease.
    pub(crate) flat_length: f32,
}

impl CreaseDetector {
    /// A detector with thresholds in degrees.
    pub(crate) fn new(threshold_deg: SoftThreshold) -> Self {
        let (lo, hi) = (threshold_deg.lo.to_radians(), threshold_deg.hi.to_radians());
        // Rounding of unit vectors and cosines stays far below this margin.
        let margin = 1e-5;
        Self {
            threshold_rad: SoftThreshold { lo, hi },
            flat_cosine: lo.min(std::f32::consts::PI).cos() + margin,
            flat_length: (0.5 * lo).min(std::f32::consts::FRAC_PI_2).cos() + margin,
        }
    }

    /// Whether none of the pixels can be a crease, given their smallest cosines and, for filtered normals, lengths.
    #[inline(always)]
    pub(crate) fn all_flat(&self, least_cosines: &[f32], lengths: Option<&[f32]>) -> bool {
        let all_above = |values: &[f32], limit: f32| {
            values
                .iter()
                .fold(true, |all, &value| all & (value >= limit))
        };
        all_above(least_cosines, self.flat_cosine)
            && lengths.is_none_or(|lengths| all_above(lengths, self.flat_length))
    }

    /// Crease weight, 0..1, of a pixel with unit normal `n`, of length `length` after filtering, and unit normals of
    /// its covered neighbours left, right, above and below.
    ///
    /// The largest angle counts: to a neighbour, and across the pixel from one side to the other. The latter is the
    /// full dihedral angle even if a filter has spread the edge over a pixel. Source: [LW] algorithm 1, step 2.
    #[inline(always)]
    pub(crate) fn weight(&self, n: Vec3, length: f32, neighbours: [Option<Vec3>; 4]) -> f32 {
        let [left, right, above, below] = neighbours;
        let centre = Some(n);
        let pairs = [
            (centre, left),
            (centre, right),
            (centre, above),
            (centre, below),
            (left, right),
            (above, below),
        ];
        let mut angle = 0.0_f32;
        for (a, b) in pairs {
            if let (Some(a), Some(b)) = (a, b)
                && a.dot(b) < self.flat_cosine
            {
                angle = angle.max(angle_between(a, b));
            }
        }
        if length < self.flat_length {
            angle = angle.max(angle_within(length));
        }
        self.threshold_rad.weight(angle)
    }
}

/// The normals of a row and of the rows above and below it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalRows<'a> {
    /// First components.
    pub x: Rows<'a>,
    /// Second components.
    pub y: Rows<'a>,
    /// Third components.
    pub z: Rows<'a>,
}

impl<'a> NormalRows<'a> {
    /// The normals around row `y`.
    pub(crate) fn around(normal: &'a Vector3Planes, y: usize) -> Self {
        Self {
            x: Rows::around(&normal.x, y),
            y: Rows::around(&normal.y, y),
            z: Rows::around(&normal.z, y),
        }
    }

    /// The normal at column `x`.
    #[inline(always)]
    pub(crate) fn at(&self, x: usize) -> Vec3 {
        Vec3::new(self.x.at[x], self.y.at[x], self.z.at[x])
    }

    /// The normals left, right, above and below column `x`, where covered.
    #[inline(always)]
    pub(crate) fn beside(&self, x: usize, covered: &Rows<bool>) -> [Option<Vec3>; 4] {
        let (left, right) = (x.saturating_sub(1), (x + 1).min(covered.at.len() - 1));
        let above = Vec3::new(self.x.above[x], self.y.above[x], self.z.above[x]);
        let below = Vec3::new(self.x.below[x], self.y.below[x], self.z.below[x]);
        [
            covered.at[left].then_some(self.at(left)),
            covered.at[right].then_some(self.at(right)),
            covered.above[x].then_some(above),
            covered.below[x].then_some(below),
        ]
    }
}

/// For each pixel of a row in `columns` the smallest cosine of the angles that [`CreaseDetector::weight`] considers;
/// undefined where uncovered. It rules out creases for whole vectors of pixels at a time.
#[inline(always)]
pub(crate) fn least_cosine_row(
    out: &mut [f32],
    normals: &NormalRows,
    covered: &Rows<bool>,
    columns: Range<usize>,
) {
    let inner = inner_columns(&columns, out.len());
    for x in outer_columns(&columns, &inner) {
        // Too few for the shortcut: below every threshold, so that they are examined one by one.
        out[x] = -1.0;
    }
    if inner.is_empty() {
        return;
    }
    let components = [normals.x, normals.y, normals.z];
    let at = components.map(|rows| Shifted::new(rows.at, &inner));
    let seen = Shifted::new(covered.at, &inner);
    let out = &mut out[inner.clone()];
    let n = out.len();
    let above = components.map(|rows| &rows.above[inner.clone()][..n]);
    let below = components.map(|rows| &rows.below[inner.clone()][..n]);
    let seen_above = &covered.above[inner.clone()][..n];
    let seen_below = &covered.below[inner.clone()][..n];
    for i in 0..n {
        // Written out: `map` over an array is not always inlined, and this is the innermost loop.
        let [x, y, z] = &at;
        let centre = [x.at[i], y.at[i], z.at[i]];
        let (left, right) = (
            [x.left[i], y.left[i], z.left[i]],
            [x.right[i], y.right[i], z.right[i]],
        );
        let up = [above[0][i], above[1][i], above[2][i]];
        let down = [below[0][i], below[1][i], below[2][i]];
        let pairs = [
            (seen.left[i], dot(centre, left)),
            (seen.right[i], dot(centre, right)),
            (seen_above[i], dot(centre, up)),
            (seen_below[i], dot(centre, down)),
            (seen.left[i] & seen.right[i], dot(left, right)),
            (seen_above[i] & seen_below[i], dot(up, down)),
        ];
        let mut least = 1.0;
        for (both_seen, cosine) in pairs {
            least = if both_seen & (cosine < least) {
                cosine
            } else {
                least
            };
        }
        out[i] = least;
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Angle between two unit vectors, in radians.
#[inline(always)]
pub fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Angle in radians between two unit normals whose mean has the given length.
#[inline(always)]
pub(crate) fn angle_within(length: f32) -> f32 {
    let cosine = length.clamp(0.0, 1.0);
    2.0 * (1.0 - cosine * cosine).sqrt().atan2(cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DETECTOR: SoftThreshold = SoftThreshold { lo: 30.0, hi: 60.0 };

    fn at_degrees(angle: f32) -> Vec3 {
        Vec3::new(angle.to_radians().sin(), 0.0, angle.to_radians().cos())
    }

    #[test]
    fn the_weight_follows_the_dihedral_angle() {
        let detector = CreaseDetector::new(DETECTOR);
        for (angle, expected) in [
            (0.0, 0.0),
            (29.0, 0.0),
            (45.0, 0.5),
            (60.5, 1.0),
            (180.0, 1.0),
        ] {
            let weight = detector.weight(Vec3::Z, 1.0, [Some(at_degrees(angle)), None, None, None]);
            assert!(
                (weight - expected).abs() < 1e-5,
                "{angle} degrees weigh {weight}"
            );
        }
    }

    #[test]
    fn an_edge_spread_over_a_pixel_counts_whole() {
        let detector = CreaseDetector::new(DETECTOR);
        // Faces at 0 and 62 degrees, the pixel between them at 31 from both.
        let sides = [Some(at_degrees(0.0)), Some(at_degrees(62.0)), None, None];
        assert_eq!(detector.weight(at_degrees(31.0), 1.0, sides), 1.0);
    }

    #[test]
    fn a_short_filtered_normal_is_a_crease() {
        let detector = CreaseDetector::new(DETECTOR);
        // Two faces at 45 degrees mixed half and half: length cos(22.5 deg), weight 1/2.
        let mixed = 22.5_f32.to_radians().cos();
        assert!((detector.weight(Vec3::Z, mixed, [Some(Vec3::Z); 4]) - 0.5).abs() < 1e-5);
        // Half floats give lengths of 0.999.
        assert_eq!(detector.weight(Vec3::Z, 0.999, [Some(Vec3::Z); 4]), 0.0);
    }

    #[test]
    fn small_angles_are_not_lost() {
        // 0.02 degrees: the cosine differs from 1 by 6e-8, one unit in the last place.
        let angle = angle_between(Vec3::Z, at_degrees(0.02)).to_degrees();
        assert!((angle - 0.02).abs() < 1e-5, "{angle}");
    }
}
