//! From stored components to unit normals: encoding, flipped axes, length.

use super::inputs::{Flip, NormalEncoding};
use crate::frame::{Plane, Vector3Planes};
use glam::Vec3;

/// Normals shorter than this before renormalisation tell no direction.
pub(super) const MIN_LENGTH: f32 = 0.05;

/// Tells signed from unsigned components: unsigned ones hold no negatives, and turn to unit length
/// only once decoded.
pub(super) fn judge_encoding(stored: &Vector3Planes) -> NormalEncoding {
    let samples = stored
        .x
        .samples()
        .iter()
        .zip(stored.y.samples())
        .zip(stored.z.samples());
    let (mut decoded, mut as_stored) = (0_usize, 0_usize);
    for n in samples
        .map(|((&x, &y), &z)| Vec3::new(x, y, z))
        .filter(|n| n.length() > MIN_LENGTH)
    {
        if n.min_element() < -0.01 {
            return NormalEncoding::Signed;
        }
        let near_unit = |n: Vec3| (n.length() - 1.0).abs() < 0.05;
        decoded += usize::from(near_unit(2.0 * n - Vec3::ONE));
        as_stored += usize::from(near_unit(n));
    }
    if decoded > as_stored {
        NormalEncoding::Unsigned
    } else {
        NormalEncoding::Signed
    }
}

/// Decodes components and turns flipped axes round, in place.
pub(super) fn decode(stored: &mut Vector3Planes, encoding: NormalEncoding, flip: Flip) {
    if encoding == NormalEncoding::Unsigned {
        let components = stored
            .x
            .samples_mut()
            .iter_mut()
            .zip(stored.y.samples_mut())
            .zip(stored.z.samples_mut());
        for ((x, y), z) in components {
            // Black is what was never written, and no corner of the cube.
            let unwritten = (*x, *y, *z) == (0.0, 0.0, 0.0);
            for v in [x, y, z].into_iter().filter(|_| !unwritten) {
                *v = 2.0 * *v - 1.0;
            }
        }
    }
    flip_axes(stored, flip);
}

/// Turns axes round, in place.
pub(super) fn flip_axes(normal: &mut Vector3Planes, flip: Flip) {
    let axes = [
        (&mut normal.x, flip.x),
        (&mut normal.y, flip.y),
        (&mut normal.z, flip.z),
    ];
    for (plane, _) in axes.into_iter().filter(|(_, flipped)| *flipped) {
        // Not by the sign: nothing stays 0, and does not become -0.
        plane.samples_mut().iter_mut().for_each(|v| *v = 0.0 - *v);
    }
}

/// Makes every covered normal a unit vector, every other one zero, and returns the lengths that the
/// covered ones had.
pub(super) fn normalise(normal: &mut Vector3Planes, covered: &Plane<bool>) -> Plane {
    let mut lengths = Plane::filled(covered.width(), covered.height(), 0.0);
    let components = normal
        .x
        .samples_mut()
        .iter_mut()
        .zip(normal.y.samples_mut())
        .zip(normal.z.samples_mut())
        .map(|((x, y), z)| [x, y, z]);
    for ((n, length), &covered) in components.zip(lengths.samples_mut()).zip(covered.samples()) {
        let stored = Vec3::new(*n[0], *n[1], *n[2]);
        let unit = if covered {
            stored.normalize_or_zero()
        } else {
            Vec3::ZERO
        };
        *length = if covered { stored.length() } else { 0.0 };
        for (component, value) in n.into_iter().zip(unit.to_array()) {
            *component = value;
        }
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes(normals: &[Vec3]) -> Vector3Planes {
        let plane = |f: fn(&Vec3) -> f32| {
            Plane::from_samples(normals.len(), 1, normals.iter().map(f).collect())
        };
        Vector3Planes {
            x: plane(|n| n.x),
            y: plane(|n| n.y),
            z: plane(|n| n.z),
        }
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

    #[test]
    fn decoding_flips_and_normalises() {
        let mut stored = planes(&[Vec3::new(0.5, 0.75, 0.9), Vec3::ZERO, Vec3::splat(f32::NAN)]);
        decode(
            &mut stored,
            NormalEncoding::Unsigned,
            Flip {
                y: true,
                ..Flip::default()
            },
        );
        let covered = Plane::from_samples(3, 1, vec![true, false, false]);
        let length = normalise(&mut stored, &covered);
        // (0, 0.5, 0.8) with y turned round, of length 0.9434.
        assert!((length.at(0, 0) - 0.943_4).abs() < 1e-4);
        assert!((stored.y.at(0, 0) + 0.53).abs() < 1e-3 && stored.x.at(0, 0).abs() < 1e-6);
        for x in 1..3 {
            assert_eq!((stored.x.at(x, 0), length.at(x, 0)), (0.0, 0.0));
        }
    }
}
