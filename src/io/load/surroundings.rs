//! Reading distance maps: equirectangular panoramas with positions or distances.

use super::frame_sources::ReadPlanes;
use super::opened::Opened;
use super::role_planes::RolePlanes;
use super::sources::{RoleSource, missing};
use crate::error::{Error, Result};
use crate::frame::depth::is_distance;
use crate::frame::normals::{decode, normalise};
use crate::frame::{Plane, Surroundings, Vector3Planes, map_direction, step_between};
use crate::io::camera::{read_pose, recover_panorama};
use crate::io::inputs::Flip;
use crate::io::judge::normal_encoding::judge_encoding;
use crate::io::roles::Role;
use glam::{DMat3, DVec3};
use std::path::Path;
use std::rc::Rc;

/// Error of normals computed from points, mostly due to facets.
const MADE_ROUNDING: f32 = 1e-3;

/// The layer of points: positions, or else distances.
pub(crate) fn place_in(file: &Rc<Opened>) -> Result<RoleSource> {
    let find = |role| RoleSource::by_role(role, file);
    let place = find(Role::Position).or_else(|| find(Role::Depth));
    place.ok_or_else(|| {
        missing(
            file,
            Role::Position,
            "another file: a panorama with positions",
        )
    })
}

/// The surroundings in the panorama at `path`: world-space positions, from which the viewpoint is recovered, or
/// distances together with a `pose` file; normals, or else normals computed from the points; colour if any.
///
/// # Errors
/// Any [`Error`] of reading; [`Error::MissingAov`] without positions or distances; [`Error::Unsupported`] for a map
/// that is not equirectangular, or distances without a pose.
pub(crate) fn read_surroundings(path: &Path, pose: Option<&Path>) -> Result<Surroundings> {
    let file = Opened::open(path)?;
    let find = |role| RoleSource::by_role(role, &file);
    let place = place_in(&file)?;
    let has_positions = place.role == Role::Position;
    let window = place.window();
    let unsupported = |found: String, remedy: &str| Error::Unsupported {
        path: path.to_path_buf(),
        found,
        remedy: remedy.into(),
    };
    if window.width() != 2 * window.height() {
        return Err(unsupported(
            format!("is {window}, and no equirectangular map, which is twice as wide as high"),
            "render a panorama of all directions",
        ));
    }
    let mut sources = vec![place];
    sources.extend(find(Role::Normal));
    sources.extend(find(Role::Color));
    sources.retain(|source| source.window() == window);
    let pose = pose.map(read_pose).transpose()?;
    let mut planes = ReadPlanes::read(&sources)?;
    let (points, center, map_from_world) = if has_positions {
        let positions = planes.vector(Role::Position).expect("found above");
        let seen = seen(&positions);
        let pose = pose.or_else(|| recover_panorama(&positions, &seen));
        let (center, map_from_world) = pose.ok_or_else(|| {
            unsupported(
                "its positions are not those of an equirectangular panorama".into(),
                "give one with positions in world space, or say where it was seen from with --surroundings-camera FILE",
            )
        })?;
        (points_of(&positions, &seen, center), center, map_from_world)
    } else {
        let Some((center, map_from_world)) = pose else {
            return Err(unsupported(
                "holds distances, but not where it was seen from".into(),
                "give --surroundings-camera FILE, or a panorama with positions",
            ));
        };
        let depth = planes.scalar(Role::Depth).expect("found above");
        (points_at(&depth, map_from_world), center, map_from_world)
    };
    let normal_rounding = sources
        .iter()
        .find(|source| source.role == Role::Normal)
        .map_or(MADE_ROUNDING, RoleSource::rounding);
    let normal = match planes.vector(Role::Normal) {
        Some(normal) => unit(normal, &points),
        None => made_normals(&points),
    };
    let (color, _) = planes.color(Role::Color);
    Ok(Surroundings {
        center,
        map_from_world,
        points,
        normal,
        normal_rounding,
        color: color.map(RolePlanes::into_color),
    })
}

/// Positions that are not finite, out of all reach, or exactly 0 are no surface.
fn seen(positions: &Vector3Planes) -> Plane<bool> {
    Plane::from_fn(positions.x.width(), positions.x.height(), |x, y| {
        let p = positions.at(x, y);
        p != DVec3::ZERO && is_distance(p.length() as f32)
    })
}

/// Positions from the centre; 0 where nothing is.
fn points_of(positions: &Vector3Planes, seen: &Plane<bool>, center: DVec3) -> Vector3Planes {
    Vector3Planes::from_fn(seen.width(), seen.height(), |x, y| match seen.at(x, y) {
        true => positions.at(x, y) - center,
        false => DVec3::ZERO,
    })
}

/// The same from distances.
fn points_at(distance: &Plane, map_from_world: DMat3) -> Vector3Planes {
    let (width, height) = (distance.width(), distance.height());
    let world_from_map = map_from_world.transpose();
    Vector3Planes::from_fn(width, height, |x, y| {
        let distance = distance.at(x, y);
        match is_distance(distance) {
            true => world_from_map * (f64::from(distance) * map_direction(x, y, width, height)),
            false => DVec3::ZERO,
        }
    })
}

/// Unit normals; 0 where nothing is, or a normal has no direction.
fn unit(mut normal: Vector3Planes, points: &Vector3Planes) -> Vector3Planes {
    let encoding = judge_encoding(&normal);
    decode(&mut normal, encoding, Flip::default());
    let covered = Plane::from_fn(points.x.width(), points.x.height(), |x, y| {
        points.at(x, y) != DVec3::ZERO && normal.at(x, y).is_finite()
    });
    normalise(&mut normal, &covered);
    normal
}

/// Unit normals of the surface through points, facing the centre; 0 where nothing is, or a point has no neighbour along one
/// axis.
fn made_normals(points: &Vector3Planes) -> Vector3Planes {
    let (width, height) = (points.x.width(), points.x.height());
    let point = |x: usize, y: usize| Some(points.at(x, y)).filter(|&p| p != DVec3::ZERO);
    let normal = |x: usize, y: usize| {
        let here = point(x, y)?;
        let row = |y: Option<usize>| point(x, y.filter(|&y| y < height)?);
        // The left and right borders are one.
        let [left, right] = [x + width - 1, x + 1].map(|x| point(x % width, y));
        let across = step_between(left, here, right)?;
        let down = step_between(row(y.checked_sub(1)), here, row(Some(y + 1)))?;
        let normal = across.cross(down).try_normalize()?;
        Some(if normal.dot(here) > 0.0 {
            -normal
        } else {
            normal
        })
    };
    Vector3Planes::from_fn(width, height, |x, y| normal(x, y).unwrap_or(DVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_seen_from_its_middle_has_its_normals_at_every_edge() {
        let (width, height) = (64, 32);
        let point = |x, y| 2.0 * map_direction(x, y, width, height);
        let found = made_normals(&Vector3Planes::from_fn(width, height, point));
        for (x, y) in [(0, 16), (63, 16), (20, 3), (40, 30), (0, 0)] {
            let expected = -map_direction(x, y, width, height);
            // Central steps along a circle are exact; at the first and last row they are one-sided, off by half a
            // step of 5.6 degrees.
            let limit = if (1..31).contains(&y) { 1e-3 } else { 0.06 };
            let n = found.at(x, y);
            assert!(n.distance(expected) < limit, "{x} {y} {n:?}");
        }
    }

    #[test]
    fn a_step_between_surfaces_is_not_a_slope() {
        // Two walls, at 1 and 3: square to z up to the last pixel.
        let point = |x: usize, y: usize| {
            let z = if x < 4 { -1.0 } else { -3.0 };
            match y {
                0 => DVec3::ZERO,
                _ => DVec3::new(x as f64 * 0.1, y as f64 * -0.1, z),
            }
        };
        let found = made_normals(&Vector3Planes::from_fn(8, 4, point));
        for x in 0..8 {
            assert_eq!(found.at(x, 2), DVec3::Z);
            assert_eq!(found.at(x, 0), DVec3::ZERO);
        }
    }
}
