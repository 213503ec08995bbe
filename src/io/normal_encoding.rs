//! Whether the components of normals were stored signed or unsigned.

use super::inputs::NormalEncoding;
use crate::frame::Vector3Planes;
use crate::frame::normals::MIN_LENGTH;
use glam::Vec3;

/// Distinguishes signed from unsigned components: unsigned ones hold no negatives, and have unit length only once decoded.
pub(super) fn judge_encoding(stored: &Vector3Planes) -> NormalEncoding {
    let (mut decoded, mut as_stored) = (0_usize, 0_usize);
    for n in stored.vectors().filter(|n| n.length() > MIN_LENGTH) {
        if n.min_element() < -0.01 {
            return NormalEncoding::Signed;
        }
        let near_unit = |n: Vec3| (n.length() - 1.0).abs() < 0.05;
        decoded += usize::from(near_unit(2.0 * n - Vec3::ONE));
        as_stored += usize::from(near_unit(n));
    }
    match decoded > as_stored {
        true => NormalEncoding::Unsigned,
        false => NormalEncoding::Signed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(normals: &[Vec3]) -> Vector3Planes {
        Vector3Planes::from_fn(normals.len(), 1, |x, _| normals[x].as_dvec3())
    }

    fn slopes() -> Vec<Vec3> {
        (-4..=4)
            .map(|i| Vec3::new(0.2 * i as f32, 0.1, 1.0).normalize())
            .collect()
    }

    #[test]
    fn encodings_are_told_apart() {
        assert_eq!(judge_encoding(&planes(&slopes())), NormalEncoding::Signed);
        let encoded: Vec<_> = slopes()
            .iter()
            .map(|n| 0.5 * *n + Vec3::splat(0.5))
            .collect();
        assert_eq!(judge_encoding(&planes(&encoded)), NormalEncoding::Unsigned);
        // A wall facing the viewer: (0, 0, 1) is unit as it is; (0.5, 0.5, 1) only once decoded.
        assert_eq!(
            judge_encoding(&planes(&[Vec3::Z; 4])),
            NormalEncoding::Signed
        );
        let wall = [Vec3::new(0.5, 0.5, 1.0); 4];
        assert_eq!(judge_encoding(&planes(&wall)), NormalEncoding::Unsigned);
    }
}
