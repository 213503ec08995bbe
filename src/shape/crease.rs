//! Creases: where the surface turns sharply.
//!
//! Theory: [LW] section 4.4 takes the dihedral angle between neighbouring normals. Changes: the
//! angle is `atan2(|a x b|, a . b)`, right to 1e-7 where acos loses 4e-4 rad; it is also taken across
//! the pixel, from one neighbour to the opposite one, for a filter may spread an edge over a pixel;
//! and a pixel whose filtered normal came out short holds a crease within itself, for the mean of two
//! unit normals at an angle t has the length cos(t/2).

use crate::params::SoftThreshold;
use glam::Vec3;

/// Turns angles between unit normals into crease weights.
#[derive(Debug, Clone, Copy)]
pub struct CreaseDetector {
    threshold_rad: SoftThreshold,
    /// Above this cosine the angle is surely below the threshold.
    flat_cosine: f32,
    /// Above this length a filtered normal surely hides no crease.
    flat_length: f32,
}

impl CreaseDetector {
    /// A detector with thresholds in degrees.
    pub fn new(threshold_deg: SoftThreshold) -> Self {
        let (lo, hi) = (threshold_deg.lo.to_radians(), threshold_deg.hi.to_radians());
        // Rounding of unit vectors and cosines stays far below this margin.
        let margin = 1e-5;
        Self {
            threshold_rad: SoftThreshold { lo, hi },
            flat_cosine: lo.min(std::f32::consts::PI).cos() + margin,
            flat_length: (0.5 * lo).min(std::f32::consts::FRAC_PI_2).cos() + margin,
        }
    }

    /// Crease weight, 0..1, of a pixel with unit normal `n`, whose filtered normal had the length
    /// `length`, among the unit normals of its neighbours left, right, above and below, where covered.
    ///
    /// The largest angle counts: to a neighbour, and across the pixel from one side to the other. The
    /// latter is the whole dihedral angle even where a filter has spread the edge over a pixel.
    /// Source: [LW] algorithm 1, step 2.
    #[inline(always)]
    pub fn weight(&self, n: Vec3, length: f32, neighbours: [Option<Vec3>; 4]) -> f32 {
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

/// Angle between two unit vectors, in radians.
#[inline(always)]
pub fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Angle in radians between two unit normals whose mean has the given length.
#[inline(always)]
pub fn angle_within(length: f32) -> f32 {
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
        // Half floats leave lengths of 0.999.
        assert_eq!(detector.weight(Vec3::Z, 0.999, [Some(Vec3::Z); 4]), 0.0);
    }

    #[test]
    fn small_angles_are_not_lost() {
        // 0.02 degrees: the cosine differs from 1 by 6e-8, one unit in the last place.
        let angle = angle_between(Vec3::Z, at_degrees(0.02)).to_degrees();
        assert!((angle - 0.02).abs() < 1e-5, "{angle}");
    }
}
