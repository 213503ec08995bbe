//! A detail laid over normals.

use super::normals::changed;
use super::{Mask, Vector3Planes};
use glam::DVec3;

/// Normals with those of `detail` turned onto them: reoriented normal mapping (Barre-Brisebois and Hill, "Blending in
/// Detail", 2012). With t = n + (0, 0, 1) and u = (-x, -y, z) of the detail, t (t . u) / t_z - u. Detail outside its mask is
/// flat, and so is what would be turned onto a normal that faces away.
pub(crate) fn with_detail(
    normal: &Vector3Planes,
    detail: &Vector3Planes,
    covered: &Mask,
) -> Vector3Planes {
    /// Of t_z: below it the detail would be turned by all but half a circle.
    const LEAST_Z: f64 = 0.05;
    changed(normal, |x, y, n| {
        let t = n + DVec3::Z;
        if !covered.at(x, y) || t.z < LEAST_Z {
            return n;
        }
        let u = detail.at(x, y) * DVec3::new(-1.0, -1.0, 1.0);
        t * (t.dot(u) / t.z) - u
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat one of either leaves the other as it is. On a slope of 45 degrees toward x a detail that leans by the angle
    /// t toward x leans by 45 degrees and t, and one that leans toward y keeps its part along y.
    #[test]
    fn detail_is_turned_onto_the_normals() {
        let of = |n: DVec3| Vector3Planes::from_fn(1, 1, |_, _| n);
        let blend =
            |n: DVec3, detail: DVec3| with_detail(&of(n), &of(detail), &Mask::full(1, 1)).at(0, 0);
        let lean = |degrees: f64| {
            let angle = degrees.to_radians();
            DVec3::new(angle.sin(), 0.0, angle.cos())
        };
        let tilted = DVec3::new(0.36, -0.48, 0.8);
        for (n, detail, expected) in [
            (tilted, DVec3::Z, tilted),
            (DVec3::Z, tilted, tilted),
            (lean(45.0), lean(20.0), lean(65.0)),
            (lean(45.0), lean(-45.0), DVec3::Z),
            (DVec3::NEG_Z, tilted, DVec3::NEG_Z),
        ] {
            let found = blend(n, detail);
            assert!(found.distance(expected) < 1e-6, "{n} {detail}: {found}");
        }
        let across = blend(lean(45.0), DVec3::new(0.0, 0.6, 0.8));
        assert!((across.y - 0.6).abs() < 1e-6, "{across}");
        let nowhere = Mask::new(crate::frame::Plane::filled(1, 1, false));
        let kept = with_detail(&of(lean(45.0)), &of(tilted), &nowhere);
        assert!(kept.at(0, 0).distance(lean(45.0)) < 1e-6);
    }
}
