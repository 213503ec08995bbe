//! Reading distance maps: equirectangular panoramas with positions or distances.

use super::frame_sources::ReadPlanes;
use super::normals_of_points::normals_of_points;
use super::opened::Opened;
use super::role_planes::RolePlanes;
use super::sources::{RoleSource, missing};
use crate::error::{Error, Result};
use crate::frame::depth::is_distance;
use crate::frame::normals::{decode, normalise};
use crate::frame::{Plane, Surroundings, Vector3Planes, map_direction};
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

fn made_normals(points: &Vector3Planes) -> Vector3Planes {
    let point = |x: usize, y: usize| Some(points.at(x, y)).filter(|&p| p != DVec3::ZERO);
    let size = [points.x.width(), points.x.height()];
    normals_of_points(size, true, point, |from_center| -from_center)
}
