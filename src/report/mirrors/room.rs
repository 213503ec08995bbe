//! An exact room with columns: where rays end, and its map.
//!
//! View space equals world space. The room is a box with walls perpendicular to the axes; columns stand in it from
//! floor to ceiling. All surfaces are planes and circular cylinders, intersected by formula in double precision.

use crate::frame::{Plane, Surroundings, Vector3Planes, map_direction};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles};

/// The centre of the ball and of the room, from the eye; the map of the room is seen from here.
pub(super) const CENTER: DVec3 = DVec3::new(0.05, -0.1, -4.0);

/// Distances from the centre of the room to its walls: x, y, z.
const ROOM: DVec3 = DVec3::new(5.0, 2.0, 6.0);

/// A column: position of its axis, x and z from the centre of the room, and radius.
struct Column {
    at: DVec2,
    radius: f64,
}

/// Seen from the centre of the room they are 23, 11, 4.6 and 2.3 degrees wide.
const COLUMNS: [Column; 4] = [
    Column {
        at: DVec2::new(1.8, 1.8),
        radius: 0.5,
    },
    Column {
        at: DVec2::new(-2.4, 1.8),
        radius: 0.3,
    },
    Column {
        at: DVec2::new(-0.9, 2.8),
        radius: 0.12,
    },
    Column {
        at: DVec2::new(2.95, 0.5),
        radius: 0.06,
    },
];

/// The scene in words.
pub(crate) const ABOUT: &str = "a mirror ball of radius 1 in a room of 10 x 4 x 12 with four columns, of radius 0.5, 0.3, 0.12 and 0.06, \
     seen from its middle 23, 11, 4.6 and 2.3 degrees wide";

/// A surface of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RoomSurface {
    /// The two walls perpendicular to an axis.
    Wall(usize),
    /// A column.
    Column(usize),
}

/// The end of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hit {
    pub(super) point: DVec3,
    pub(super) surface: RoomSurface,
}

impl Hit {
    /// The unit normal, into the room.
    fn normal(&self) -> DVec3 {
        let from = self.point - CENTER;
        match self.surface {
            RoomSurface::Wall(axis) => {
                let mut normal = DVec3::ZERO;
                normal[axis] = -from[axis].signum();
                normal
            }
            RoomSurface::Column(i) => {
                let across = (from.xz() - COLUMNS[i].at) / COLUMNS[i].radius;
                DVec3::new(across.x, 0.0, across.y)
            }
        }
    }

    /// The stroke direction: around columns, by their curvature; on walls the cross product of x, or of y for walls
    /// perpendicular to x, with the normal ([`crate::params::Fallback::Surface`]).
    pub(super) fn tangent(&self) -> DVec3 {
        let normal = self.normal();
        match self.surface {
            RoomSurface::Wall(0) | RoomSurface::Column(_) => DVec3::Y.cross(normal),
            RoomSurface::Wall(_) => DVec3::X.cross(normal),
        }
    }
}

/// Distance of a point from the centre of the room.
pub(super) fn from_center(point: DVec3) -> f64 {
    point.distance(CENTER)
}

/// The surface nearest to a point.
pub(super) fn nearest_surface(point: DVec3) -> RoomSurface {
    let from = point - CENTER;
    let wall = |axis: usize| {
        (
            (ROOM[axis] - from[axis].abs()).abs(),
            RoomSurface::Wall(axis),
        )
    };
    let column = |i: usize| {
        let Column { at, radius } = COLUMNS[i];
        (
            (from.xz().distance(at) - radius).abs(),
            RoomSurface::Column(i),
        )
    };
    let all = (0..3).map(wall).chain((0..COLUMNS.len()).map(column));
    let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.expect("a room has walls").1
}

/// The end of a ray from inside the room, outside the columns: on the nearest surface ahead.
pub(super) fn hit(start: DVec3, direction: DVec3) -> Hit {
    let from = start - CENTER;
    // side = start + t direction along each axis, toward the wall ahead.
    let wall = |axis: usize| {
        let side = ROOM[axis].copysign(direction[axis]);
        (
            (side - from[axis]) / direction[axis],
            RoomSurface::Wall(axis),
        )
    };
    // |f + t d|^2 = r^2 across the axis, smaller root: with a = d.d, b = f.d and c = f.f - r^2, t = c / (-b + root).
    let column = |i: usize| {
        let Column { at, radius } = COLUMNS[i];
        let (f, d) = (from.xz() - at, direction.xz());
        let (a, b, c) = (
            d.length_squared(),
            f.dot(d),
            f.length_squared() - radius * radius,
        );
        let square = b * b - a * c;
        let ahead = square > 0.0 && b < 0.0;
        ahead.then(|| (c / (square.sqrt() - b), RoomSurface::Column(i)))
    };
    let all = (0..3)
        .map(wall)
        .chain((0..COLUMNS.len()).filter_map(column));
    let (t, surface) = all
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a room has walls");
    Hit {
        point: start + t * direction,
        surface,
    }
}

/// The map of the room from its centre, with `height` rows.
pub(super) fn surroundings(height: usize) -> Surroundings {
    let width = 2 * height;
    let all = Plane::from_fn(width, height, |x, y| {
        hit(CENTER, map_direction(x, y, width, height))
    });
    let planes = |value: &dyn Fn(&Hit) -> DVec3| {
        let plane = |k: usize| all.map(|hit| value(&hit)[k] as f32);
        Vector3Planes {
            x: plane(0),
            y: plane(1),
            z: plane(2),
        }
    };
    Surroundings {
        center: CENTER,
        map_from_world: DMat3::IDENTITY,
        points: planes(&|hit| hit.point - CENTER),
        normal: planes(&Hit::normal),
        normal_rounding: 0.0,
        color: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_end_at_the_nearest_surface() {
        // From the centre along x: the wall at 5. Toward the first column, 1.8 root 2 = 2.5456 away: its radius less.
        let wall = hit(CENTER, DVec3::X);
        assert_eq!(wall.surface, RoomSurface::Wall(0));
        assert!((from_center(wall.point) - 5.0).abs() < 1e-12);
        let column = hit(CENTER, DVec3::new(1.0, 0.0, 1.0).normalize());
        assert_eq!(column.surface, RoomSurface::Column(0));
        assert!((from_center(column.point) - (1.8 * 2.0_f64.sqrt() - 0.5)).abs() < 1e-12);
        // Its normal points back to the centre; strokes run around it horizontally.
        let back = -DVec3::new(0.5, 0.0, 0.5).normalize();
        assert!(column.normal().distance(back) < 1e-12);
        assert!(column.tangent().cross(DVec3::new(1.0, 0.0, -1.0)).length() < 1e-12);
        for hit in [wall, column] {
            assert_eq!(nearest_surface(hit.point), hit.surface);
        }
    }
}
