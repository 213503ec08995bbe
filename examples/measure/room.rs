//! A mirror ball in a room with columns: what its pixels show, in double precision.
//!
//! The ball has a radius of 1. It and the room have the origin as their centre. Walls are planes and columns circular
//! cylinders from floor to ceiling.

use glam::{DMat2, DVec2, DVec3};
use relievo::frame::{Projection, SightLines};
use std::f64::consts::FRAC_PI_4;

/// Pixels on each side of the picture.
pub(crate) const SIZE: usize = 160;
pub(crate) const EYE: DVec3 = DVec3::new(-0.05, 0.1, 4.0);
/// The ball fills three quarters of the picture.
pub(crate) const PROJECTION: Projection = Projection::Perspective {
    fx: 1.5 * SIZE as f64,
    fy: 1.5 * SIZE as f64,
    cx: 0.5 * SIZE as f64,
    cy: 0.5 * SIZE as f64,
};

/// Distances of the walls along x, y, z.
const ROOM: [f64; 3] = [5.0, 2.0, 6.0];
/// Columns: x and z of the axis, and the radius. From the origin they are 23, 11, 4.6 and 2.3 degrees wide.
const COLUMNS: [[f64; 3]; 4] = [
    [1.8, 1.8, 0.5],
    [-2.4, 1.8, 0.3],
    [-0.9, 2.8, 0.12],
    [2.95, 0.5, 0.06],
];
const WALLS: usize = ROOM.len();
/// Surfaces are counted: walls by their axis, then columns.
const SURFACES: usize = WALLS + COLUMNS.len();

/// Least cosine between the normal and the sight line of the pixels that count. Near the rim neighbouring pixels show
/// distant points.
const FACING: f64 = 0.3;
/// Directions count where everything this near shows the same surface: pixels at edges take their neighbours'.
const EDGE_PX: f64 = 2.0;
/// Step of differences: their error is below 1e-8 of the distances in the room.
const STEP_PX: f64 = 1e-4;

/// Where a ray ends.
pub(crate) struct End {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) surface: usize,
}

impl End {
    /// Of a ray from inside the room and outside its columns: on the nearest surface ahead.
    pub(crate) fn of(start: DVec3, direction: DVec3) -> Self {
        let ahead = |surface| Some((along(surface, start, direction)?, surface));
        let nearest = (0..SURFACES).filter_map(ahead);
        let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0));
        let (t, surface) = nearest.expect("a room has walls");
        let point = start + t * direction;
        let normal = match surface {
            0..WALLS => -point[surface].signum() * DVec3::AXES[surface],
            _ => {
                let [x, z, radius] = COLUMNS[surface - WALLS];
                DVec3::new(point.x - x, 0.0, point.z - z) / radius
            }
        };
        Self {
            point,
            normal,
            surface,
        }
    }

    /// Of the sight line through a position in the picture, mirrored by the ball.
    fn mirrored(at: DVec2) -> Option<Self> {
        let (sight, normal) = on_ball(at)?;
        Some(Self::of(normal, sight.reflect(normal)))
    }

    /// The direction of strokes: around columns, by their curvature; on walls that of [`Fallback::Surface`].
    fn tangent(&self) -> DVec3 {
        match self.surface {
            1 | 2 => DVec3::X.cross(self.normal),
            _ => DVec3::Y.cross(self.normal),
        }
    }

    pub(crate) fn is_on_column(&self) -> bool {
        self.surface >= WALLS
    }
}

/// The place of a surface along a ray, if it is ahead.
fn along(surface: usize, start: DVec3, direction: DVec3) -> Option<f64> {
    if surface < WALLS {
        let wall = ROOM[surface].copysign(direction[surface]);
        return Some((wall - start[surface]) / direction[surface]);
    }
    // |f + t d| = r across the axis, at the smaller t: with a = d.d, b = f.d and c = f.f - r^2, t = c / (-b + root).
    let [x, z, radius] = COLUMNS[surface - WALLS];
    let (f, d) = (start - DVec3::new(x, start.y, z), direction.with_y(0.0));
    let (b, c) = (f.dot(d), f.length_squared() - radius * radius);
    let square = b * b - d.length_squared() * c;
    (square > 0.0 && b < 0.0).then(|| c / (square.sqrt() - b))
}

/// The surface nearest to a point.
pub(crate) fn nearest(point: DVec3) -> usize {
    let away = |surface: usize| match surface {
        0..WALLS => (ROOM[surface] - point[surface].abs()).abs(),
        _ => {
            let [x, z, radius] = COLUMNS[surface - WALLS];
            ((point.x - x).hypot(point.z - z) - radius).abs()
        }
    };
    let nearest = (0..SURFACES).min_by(|&a, &b| away(a).total_cmp(&away(b)));
    nearest.expect("a room has walls")
}

/// The unit sight line through a position in the picture, and where it meets the ball: the normal there, too.
pub(crate) fn on_ball(at: DVec2) -> Option<(DVec3, DVec3)> {
    let sight = SightLines::new(PROJECTION).line(at.x, at.y).1.normalize();
    let along = EYE.dot(sight);
    let square = along * along - EYE.length_squared() + 1.0;
    (square > 0.0).then(|| (sight, EYE - (along + square.sqrt()) * sight))
}

pub(crate) fn middle(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64, y as f64) + 0.5
}

/// What a pixel shows.
pub(crate) struct Shown {
    pub(crate) at: [usize; 2],
    pub(crate) end: End,
    /// The direction of strokes in the picture, y up; `None` near edges.
    pub(crate) direction: Option<DVec2>,
}

/// The pixels that count: those that face the eye and show points seen from the origin, as on the map.
pub(crate) fn shown() -> Vec<Shown> {
    let pixels = (0..SIZE * SIZE).map(|i| [i % SIZE, i / SIZE]);
    let shown = pixels.filter_map(|[x, y]| {
        let at = middle(x, y);
        let (sight, normal) = on_ball(at)?;
        let end = End::mirrored(at)?;
        let on_map = End::of(DVec3::ZERO, end.point).point;
        let counts = -sight.dot(normal) >= FACING && on_map.distance(end.point) < 1e-9;
        counts.then(|| Shown {
            at: [x, y],
            direction: direction(at, &end),
            end,
        })
    });
    shown.collect()
}

/// The w that moves the end along its tangent: with J = (dP/dx, dP/dy), w = (J^T J)^-1 J^T tangent, up to its length.
fn direction(at: DVec2, end: &End) -> Option<DVec2> {
    let mut around = (0..8).map(|k| at + EDGE_PX * DVec2::from_angle(f64::from(k) * FRAC_PI_4));
    let is_same = |at| End::mirrored(at).is_some_and(|near| near.surface == end.surface);
    if !around.all(is_same) {
        return None;
    }
    let slope = |step| Some(End::mirrored(at + step)?.point - End::mirrored(at - step)?.point);
    // Rows run down, y up.
    let (right, up) = (slope(STEP_PX * DVec2::X)?, slope(-STEP_PX * DVec2::Y)?);
    let both = |of: DVec3| DVec2::new(right.dot(of), up.dot(of));
    let square = DMat2::from_cols(both(right), both(up));
    (square.inverse() * both(end.tangent())).try_normalize()
}
