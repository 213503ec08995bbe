//! Directions of curvature on the surroundings, texel by texel.

use crate::frame::{Plane, Surroundings, Vector3Planes};
use crate::line::normal_rays::{Noise, NormalRay, Sides, principal_curvatures};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// The directions on the surroundings of the last run, since a sequence has the same ones throughout.
#[derive(Debug, Default)]
pub(crate) struct DirectionCache(Mutex<Option<LastDirections>>);

#[derive(Debug)]
struct LastDirections {
    surroundings: Arc<Surroundings>,
    directions: Arc<Vector3Planes>,
}

impl DirectionCache {
    /// The directions on these surroundings, computed unless cached.
    pub(crate) fn of(&self, surroundings: &Arc<Surroundings>) -> Arc<Vector3Planes> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = kept.as_ref()
            && Arc::ptr_eq(&kept.surroundings, surroundings)
        {
            return kept.directions.clone();
        }
        let directions = Arc::new(directions(surroundings));
        *kept = Some(LastDirections {
            surroundings: surroundings.clone(),
            directions: directions.clone(),
        });
        directions
    }
}

/// Largest sine of the angle between the step from one texel to another and the tangent plane, by the mean of their
/// normals, for both to lie on one surface.
const OFF_SURFACE: f64 = 0.2;

/// Cosine of the angle between the normals of two texels on one surface.
const ALIKE: f64 = 0.5;

/// Rounding of an f32 of size 1, as a deviation.
const ROUNDING: f64 = 0.577 * f32::EPSILON as f64 / 2.0;

/// Unit tangents of the curvature larger in size; 0 on planes, on balls and where nothing is.
fn directions(surroundings: &Surroundings) -> Vector3Planes {
    let (width, height) = (surroundings.width(), surroundings.height());
    let rows: Vec<Vec<DVec3>> = (0..height)
        .into_par_iter()
        .map(|y| {
            (0..width)
                .map(|x| direction(surroundings, x, y).unwrap_or(DVec3::ZERO))
                .collect()
        })
        .collect();
    let plane = |k: usize| Plane::from_fn(width, height, |x, y| rows[y][x][k] as f32);
    Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    }
}

fn direction(map: &Surroundings, x: usize, y: usize) -> Option<DVec3> {
    let here = texel(map, x, y)?;
    let noise = Noise {
        normal: f64::from(map.normal_rounding).max(ROUNDING),
        offset: ROUNDING * here.0.length(),
    };
    let (width, height) = (map.width(), map.height());
    let ray = |to: Option<(usize, usize)>| {
        let (x, y) = to?;
        beside(here, texel(map, x, y)?)
    };
    let sides = |before, after| Sides {
        before: ray(before).unwrap_or(NormalRay::NONE),
        after: ray(after).unwrap_or(NormalRay::NONE),
        step_px: 1.0,
    };
    let across = sides(
        Some(((x + width - 1) % width, y)),
        Some(((x + 1) % width, y)),
    );
    let below = Some((x, y + 1)).filter(|p| p.1 < height);
    let up = sides(below, y.checked_sub(1).map(|y| (x, y)));
    principal_curvatures(here.1, [across, up], noise).direction()
}

/// The point, from the centre, and the normal of a texel.
fn texel(map: &Surroundings, x: usize, y: usize) -> Option<(DVec3, DVec3)> {
    let (point, normal) = (map.point_at(x, y), map.normal_at(x, y));
    let is_there = point != DVec3::ZERO && normal != DVec3::ZERO;
    is_there.then_some((point, normal))
}

/// The normal ray of a neighbour, if it is on the same surface.
fn beside(here: (DVec3, DVec3), there: (DVec3, DVec3)) -> Option<NormalRay> {
    let offset = there.0 - here.0;
    let both = here.1 + there.1;
    let goes_on = both.dot(offset).abs() < OFF_SURFACE * both.length() * offset.length()
        && here.1.dot(there.1) > ALIKE;
    goes_on.then_some(NormalRay::new(offset, there.1))
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
