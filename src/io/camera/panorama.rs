//! Viewpoint and orientation of a panorama, from its world-space positions.

use super::file::dmat3;
use super::model::wahba;
use super::samples::quantile;
use crate::frame::{Plane, Vector3Planes, map_direction};
use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Vector3};

/// The viewpoint of an equirectangular panorama in world space, and the turn from world space to the map's own: x right,
/// y up, -z in the middle of the picture.
pub(crate) type PanoramaPose = (DVec3, DMat3);

/// Median angle, in pixels, between directions of pixels and those of their positions, above which these are none of an
/// equirectangular panorama.
const WORST_RESIDUAL_PX: f64 = 1.0;

/// Approximate number of pixels used.
const SAMPLES: usize = 4000;

/// Fewer decide nothing.
const FEWEST: usize = 16;

/// Rounds of alternating rotation and centre; each reduces the error by a constant factor.
const ROUNDS: usize = 400;

/// A round that moves the centre by less, as a share of the distances, is the last.
const SETTLED: f64 = 1e-13;

/// A pixel: its direction in the map's own space, and its position.
struct Sighting {
    direction: DVec3,
    position: DVec3,
}

/// The pose recovered from the `positions` of a panorama, where `seen` is true. `None` with too few positions, or for
/// anything but a panorama of these proportions: its mirror image, a cube, a fisheye.
///
/// Alternates between rotating the positions onto the directions of their pixels (Wahba's problem), and moving the
/// centre to the point closest to the lines through the positions along those directions.
pub(crate) fn recover_panorama(
    positions: &Vector3Planes,
    seen: &Plane<bool>,
) -> Option<PanoramaPose> {
    let sightings = sightings(positions, seen);
    if sightings.len() < FEWEST {
        return None;
    }
    let count = sightings.len() as f64;
    let mut center = sightings.iter().map(|s| s.position).sum::<DVec3>() / count;
    let distances = sightings.iter().map(|s| s.position.distance(center));
    let size = distances.sum::<f64>() / count;
    let mut turn = turned(&sightings, center)?;
    for _ in 0..ROUNDS {
        let moved = nearest_point(&sightings, turn)?;
        let step = moved.distance(center);
        center = moved;
        turn = turned(&sightings, center)?;
        if step < SETTLED * size {
            break;
        }
    }
    let per_pixel = std::f64::consts::PI / positions.x.height() as f64;
    let off = |s: &Sighting| {
        let to = (turn * (s.position - center)).normalize_or_zero();
        to.cross(s.direction).length().atan2(to.dot(s.direction)) / per_pixel
    };
    let mut residuals: Vec<f64> = sightings.iter().map(off).collect();
    let residual_px = quantile(&mut residuals, 0.5);
    (residual_px < WORST_RESIDUAL_PX).then_some((center, turn))
}

/// Pixels spread over the map, thinned out near the poles in proportion to solid angle.
fn sightings(positions: &Vector3Planes, seen: &Plane<bool>) -> Vec<Sighting> {
    let (width, height) = (seen.width(), seen.height());
    let step = ((width * height) as f64 / SAMPLES as f64).sqrt().max(1.0) as usize;
    let mut found = Vec::new();
    for y in (step / 2..height).step_by(step) {
        let cosine = ((0.5 - (y as f64 + 0.5) / height as f64) * std::f64::consts::PI).cos();
        let across = ((step as f64 / cosine.max(0.05)) as usize).max(1);
        for x in (0..width).step_by(across).filter(|&x| seen.at(x, y)) {
            let at = |plane: &Plane| f64::from(plane.at(x, y));
            found.push(Sighting {
                direction: map_direction(x, y, width, height),
                position: DVec3::new(at(&positions.x), at(&positions.y), at(&positions.z)),
            });
        }
    }
    found
}

/// The rotation that best maps directions from the centre onto those of the map.
fn turned(sightings: &[Sighting], center: DVec3) -> Option<DMat3> {
    let mut sum = Matrix3::zeros();
    for s in sightings {
        let from = (s.position - center).normalize_or_zero();
        sum += vector(s.direction) * vector(from).transpose();
    }
    wahba(&sum, false).map(|turn| dmat3(&turn))
}

/// The point nearest to all lines through the positions along the directions: least squares.
fn nearest_point(sightings: &[Sighting], turn: DMat3) -> Option<DVec3> {
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for s in sightings {
        let along = vector(turn.transpose() * s.direction);
        let across = Matrix3::identity() - along * along.transpose();
        matrix += across;
        right += across * vector(s.position);
    }
    let found = matrix.lu().solve(&right)?;
    Some(DVec3::new(found.x, found.y, found.z))
}

fn vector(v: DVec3) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A panorama of a box seen from a point inside.
    fn box_seen(turn: DMat3, center: DVec3) -> Vector3Planes {
        let at = |x, y| {
            let direction = turn.transpose() * map_direction(x, y, 128, 64);
            let sides = DVec3::new(3.0, 2.0, 1.5).to_array();
            let t = (0..3)
                .map(|k| (sides[k].copysign(direction[k]) - center[k]) / direction[k])
                .fold(f64::INFINITY, f64::min);
            center + t * direction
        };
        let plane = |k: usize| Plane::from_fn(128, 64, |x, y| at(x, y)[k] as f32);
        Vector3Planes {
            x: plane(0),
            y: plane(1),
            z: plane(2),
        }
    }

    #[test]
    fn the_pose_of_a_panorama_is_found_again() {
        let turns = [
            DMat3::IDENTITY,
            DMat3::from_rotation_x(-1.6) * DMat3::from_rotation_z(2.9),
        ];
        for turn in turns {
            let center = DVec3::new(0.9, -0.8, 0.4);
            let found = recover_panorama(&box_seen(turn, center), &Plane::filled(128, 64, true));
            let (place, turned) = found.unwrap();
            // Positions are rounded to f32: 1e-7 of a few units.
            assert!(place.distance(center) < 1e-5, "{place}");
            assert!(
                (turned - turn)
                    .to_cols_array()
                    .iter()
                    .all(|e| e.abs() < 1e-5)
            );
        }
    }

    #[test]
    fn what_is_no_panorama_has_no_pose() {
        let mut mirrored = box_seen(DMat3::IDENTITY, DVec3::new(0.5, 0.2, 0.1));
        mirrored.x = mirrored.x.map(|x| -x);
        for seen in [true, false] {
            let seen = Plane::filled(128, 64, seen);
            assert_eq!(recover_panorama(&mirrored, &seen), None);
        }
    }
}
