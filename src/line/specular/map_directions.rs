//! Directions of curvature on the surroundings, texel by texel.

use crate::frame::{Plane, Surroundings, Vector3Planes, parallel_rows};
use crate::kernel::last::Last;
use crate::line::normal_rays::{Noise, NormalRay, Sides, principal_curvatures};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// The directions on the surroundings of the last run, since a sequence has the same ones throughout.
pub(crate) type DirectionCache = Last<Surroundings, Arc<Vector3Planes>>;

/// Largest sine of the angle between the step from one texel to another and the tangent plane, by the mean of their
/// normals, for both to lie on one surface.
const OFF_SURFACE: f64 = 0.2;

/// Cosine of the angle between the normals of two texels on one surface.
const ALIKE: f64 = 0.5;

/// Rounding of an f32 of size 1, as a deviation.
const ROUNDING: f64 = 0.577 * f32::EPSILON as f64 / 2.0;

/// Unit tangents of the curvature larger in size; 0 on planes, on balls and where nothing is.
pub(super) fn directions(surroundings: &Surroundings) -> Vector3Planes {
    let (width, height) = (surroundings.width(), surroundings.height());
    let [mut x, mut y, mut z] = [(); 3].map(|()| Plane::filled(width, height, 0.0));
    parallel_rows([&mut x, &mut y, &mut z]).for_each(|(row, [x, y, z])| {
        for column in 0..width {
            let tangent = larger_curvature_tangent(surroundings, column, row);
            let tangent = tangent.unwrap_or(DVec3::ZERO).as_vec3();
            [x[column], y[column], z[column]] = tangent.to_array();
        }
    });
    Vector3Planes { x, y, z }
}

/// The point and the normal of a texel, where there is something. A row goes on around the map; beyond both ends of a
/// column there is nothing.
fn texel(map: &Surroundings, x: usize, y: usize) -> Option<(DVec3, DVec3)> {
    if y >= map.height() {
        return None;
    }
    let x = x % map.width();
    let (point, normal) = (map.point_at(x, y), map.normal_at(x, y));
    (point != DVec3::ZERO && normal != DVec3::ZERO).then_some((point, normal))
}

fn larger_curvature_tangent(map: &Surroundings, x: usize, y: usize) -> Option<DVec3> {
    let (point, normal) = texel(map, x, y)?;
    let ray = |x: usize, y: usize| {
        let there = texel(map, x, y)?;
        let offset = there.0 - point;
        let both = normal + there.1;
        let is_beside = both.dot(offset).abs() < OFF_SURFACE * both.length() * offset.length();
        let goes_on = is_beside && normal.dot(there.1) > ALIKE;
        goes_on.then(|| NormalRay::new(offset, there.1))
    };
    let sides = [
        Sides::of([ray(x + map.width() - 1, y), ray(x + 1, y)], 1.0),
        Sides::of([ray(x, y + 1), ray(x, y.wrapping_sub(1))], 1.0),
    ];
    let noise = Noise {
        normal: f64::from(map.normal_rounding).max(ROUNDING),
        offset: ROUNDING * point.length(),
    };
    principal_curvatures(normal, sides, noise).direction()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::map_direction;
    use glam::DMat3;

    #[test]
    fn a_tube_around_the_viewer_bends_around_its_axis() {
        // From inside a tube of radius 2 along y, with the normal toward the axis: the curvature larger in magnitude
        // runs around it, perpendicular to y.
        let (width, height) = (64, 32);
        let toward = |x, y| map_direction(x, y, width, height);
        let normal = |x, y| -DVec3::new(toward(x, y).x, 0.0, toward(x, y).z).normalize();
        // Distance 2 / cos(elevation).
        let point = |x, y| toward(x, y) * 2.0 / toward(x, y).x.hypot(toward(x, y).z);
        let planes = |at: &dyn Fn(usize, usize) -> DVec3| {
            let plane = |k: usize| Plane::from_fn(width, height, |x, y| at(x, y)[k] as f32);
            Vector3Planes {
                x: plane(0),
                y: plane(1),
                z: plane(2),
            }
        };
        let map = Surroundings {
            center: DVec3::ZERO,
            map_from_world: DMat3::IDENTITY,
            points: planes(&point),
            normal: planes(&normal),
            normal_rounding: 0.0,
            color: None,
        };
        let found = directions(&map);
        for (x, y) in [(0, 16), (63, 16), (20, 8), (40, 22)] {
            let n = normal(x, y);
            let around = DVec3::new(n.z, 0.0, -n.x);
            let t = DVec3::new(
                found.x.at(x, y).into(),
                found.y.at(x, y).into(),
                found.z.at(x, y).into(),
            );
            assert!((t.dot(around).abs() - 1.0).abs() < 1e-6, "{x} {y}: {t}");
        }
    }
}
