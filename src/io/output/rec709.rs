//! Conversion of colours to Rec. 709, for a display: by the matrix from their chromaticities, adapted to its white
//! (Bradford).

use crate::frame::ColorPlanes;
use crate::io::colorspace::{Chromaticities, REC709, is_moderate, xyz_from};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// XYZ to the cone responses scaled by Bradford's adaptation.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// Matrix from linear colours with these chromaticities to Rec. 709; `None` for Rec. 709 itself and unusable numbers.
pub(crate) fn rec709_from(chromaticities: Chromaticities) -> Option<DMat3> {
    let near = |(a, b): (f32, f32)| (a - b).abs() < 1e-4;
    if chromaticities.into_iter().zip(REC709).all(near) {
        return None;
    }
    let (from, to) = (xyz_from(chromaticities)?, xyz_from(REC709)?);
    let cones = |xyz_from: DMat3| BRADFORD * (xyz_from * DVec3::ONE);
    let adapted = DMat3::from_diagonal(cones(to) / cones(from));
    let matrix = to.inverse() * BRADFORD.inverse() * adapted * BRADFORD * from;
    is_moderate(matrix).then_some(matrix)
}

/// Colours transformed by a matrix.
pub(crate) fn converted(color: &ColorPlanes, matrix: DMat3) -> ColorPlanes {
    let matrix = matrix.as_mat3();
    let mut made = color.clone();
    let planes = [&mut made.r, &mut made.g, &mut made.b].map(|plane| plane.samples_mut());
    let [r, g, b] = planes;
    r.par_iter_mut().zip(g).zip(b).for_each(|((r, g), b)| {
        let turned = matrix * glam::Vec3::new(*r, *g, *b);
        (*r, *g, *b) = (turned.x, turned.y, turned.z);
    });
    made
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;
    use crate::io::colorspace::ColorSpace;

    #[test]
    fn impossible_primaries_have_no_matrix() {
        // Impossible primaries, and a white that needs 1e5 times the primaries.
        for (index, value) in [(0, 1e30), (3, f32::INFINITY), (6, -1e20), (7, 2e-6)] {
            let mut bad = REC709;
            bad[index] = value;
            assert_eq!(rec709_from(bad), None, "{bad:?}");
        }
    }

    #[test]
    fn acescg_turns_to_rec709_as_published() {
        // The matrix from ACEScg to linear Rec. 709 with Bradford's adaptation that the ACES distribution lists.
        let expected = [
            [1.705_05, -0.621_79, -0.083_26],
            [-0.130_26, 1.140_80, -0.010_55],
            [-0.024_00, -0.128_97, 1.152_97],
        ];
        let matrix = rec709_from(ColorSpace::AP1).unwrap();
        for (row, expected) in expected.into_iter().enumerate() {
            for (found, expected) in matrix.row(row).to_array().into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
            }
        }
        // White stays white.
        let one = Plane::filled(1, 1, 1.0);
        let white = ColorPlanes {
            r: one.clone(),
            g: one.clone(),
            b: one,
        };
        let white = converted(&white, matrix);
        assert!(
            [&white.r, &white.g, &white.b]
                .iter()
                .all(|p| (p.at(0, 0) - 1.0).abs() < 1e-5)
        );
        assert_eq!(rec709_from(REC709), None);
        assert_eq!(rec709_from([0.3; 8]), None);
    }
}
