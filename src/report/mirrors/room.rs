//! A mirror ball in a room with columns: what it shows, and how, exactly.
//!
//! View space is world space. The room is a box around the ball, its walls square to the axes; columns stand in it from
//! the floor to the ceiling. Everything is planes, round tubes and a ball, and every ray is met by a formula in double
//! precision.

use crate::frame::{
    Camera, ColorPlanes, DepthKind, Frame, LightLayers, Mask, Plane, Projection, SightLines,
    Source, Surroundings, Vector3Planes, Window, map_direction,
};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3Swizzles};
use std::f64::consts::FRAC_PI_4;

/// The middle of the ball and of the room, from the eye; the map of the room is seen from here.
const CENTER: DVec3 = DVec3::new(0.05, -0.1, -4.0);

/// Radius of the ball, the unit of all lengths.
const RADIUS: f64 = 1.0;

/// From the middle of the room to its walls: x, y, z.
const ROOM: DVec3 = DVec3::new(5.0, 2.0, 6.0);

/// A column: where its axis stands, x and z from the middle of the room, and its radius.
struct Column {
    at: DVec2,
    radius: f64,
}

/// From the middle of the room they are 23, 11, 4.6 and 2.3 degrees wide.
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
        at: DVec2::new(2.6, -1.5),
        radius: 0.06,
    },
];

/// What the scene shows, in words.
pub const ABOUT: &str = "a mirror ball of radius 1 in a room of 10 x 4 x 12 with four columns, of radius 0.5, 0.3, 0.12 and 0.06, \
     seen from its middle 23, 11, 4.6 and 2.3 degrees wide";

/// Cosine between normal and sight line from which on pixels are compared. Nearer to the rim of the ball neighbours show
/// what lies far apart, and directions are off by the size of pixels, however they are traced.
pub const FACING: f64 = 0.3;

/// Focal length over the width of the picture: the ball, of radius 1 at a distance of 4, takes 3/4 of it.
const FOCAL: f64 = 1.5;

/// A surface of the room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Surface {
    /// The two walls square to an axis.
    Wall(usize),
    /// A column.
    Column(usize),
}

/// Where a ray ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Met {
    pub(super) point: DVec3,
    pub(super) surface: Surface,
}

/// What a pixel of the ball shows. Pixels are compared whose normal and sight line have a cosine of at least [`FACING`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shown {
    pub(super) met: Met,
    /// Whether the map of the room shows it too.
    pub(super) in_map: bool,
    /// The direction in the picture, unit, x right, y up, that strokes take there: [`Met::tangent`] as the ball shows it.
    /// `None` within [`EDGE_PX`] of the edge of a surface.
    pub(super) direction: Option<DVec2>,
}

impl Met {
    /// The unit normal, into the room.
    fn normal(&self) -> DVec3 {
        let from = self.point - CENTER;
        match self.surface {
            Surface::Wall(axis) => {
                let mut normal = DVec3::ZERO;
                normal[axis] = -from[axis].signum();
                normal
            }
            Surface::Column(i) => {
                let across = (from.xz() - COLUMNS[i].at) / COLUMNS[i].radius;
                DVec3::new(across.x, 0.0, across.y)
            }
        }
    }

    /// The direction that strokes follow: around columns, that of their curvature; on walls x, or y where they are square
    /// to x, crossed with the normal ([`crate::params::Fallback::Surface`]).
    pub(super) fn tangent(&self) -> DVec3 {
        let normal = self.normal();
        match self.surface {
            Surface::Wall(0) | Surface::Column(_) => DVec3::Y.cross(normal),
            Surface::Wall(_) => DVec3::X.cross(normal),
        }
    }
}

/// Distance of a point from the middle of the room.
pub(super) fn from_center(point: DVec3) -> f64 {
    point.distance(CENTER)
}

/// The surface nearest to a point.
pub(super) fn nearest_surface(point: DVec3) -> Surface {
    let from = point - CENTER;
    let wall = |axis: usize| ((ROOM[axis] - from[axis].abs()).abs(), Surface::Wall(axis));
    let column = |i: usize| {
        let Column { at, radius } = COLUMNS[i];
        ((from.xz().distance(at) - radius).abs(), Surface::Column(i))
    };
    let all = (0..3).map(wall).chain((0..COLUMNS.len()).map(column));
    let nearest = all.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.expect("a room has walls").1
}

/// Where a ray from inside the room, outside the columns, ends: at the nearest of all surfaces ahead.
fn met(start: DVec3, direction: DVec3) -> Met {
    let from = start - CENTER;
    // side = from + t direction along each axis, toward the wall ahead.
    let wall = |axis: usize| {
        let side = ROOM[axis].copysign(direction[axis]);
        ((side - from[axis]) / direction[axis], Surface::Wall(axis))
    };
    // |f + t d|^2 = r^2 across the axis, the nearer root: with a = d.d, b = f.d and c = f.f - r^2, t = c / (-b + root).
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
        ahead.then(|| (c / (square.sqrt() - b), Surface::Column(i)))
    };
    let all = (0..3)
        .map(wall)
        .chain((0..COLUMNS.len()).filter_map(column));
    let (t, surface) = all
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a room has walls");
    Met {
        point: start + t * direction,
        surface,
    }
}

/// The scene in so many pixels each way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene {
    pub(super) size: usize,
}

impl Scene {
    fn camera(self) -> Camera {
        let (size, middle) = (self.size as f64, 0.5 * self.size as f64);
        Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::Perspective {
                fx: FOCAL * size,
                fy: FOCAL * size,
                cx: middle,
                cy: middle,
            },
        }
    }

    /// The unit sight line through a place of the picture, and where it meets the ball.
    fn on_ball(self, at: DVec2) -> Option<(DVec3, DVec3)> {
        let (start, line) = SightLines::new(self.camera().projection).line(at.x, at.y);
        let direction = line.normalize();
        let from = start - CENTER;
        let along = from.dot(direction);
        let square = along * along - from.length_squared() + RADIUS * RADIUS;
        (square > 0.0).then(|| (direction, start + (-along - square.sqrt()) * direction))
    }

    /// What the ball shows at a place of the picture: the sight line mirrored at the normal, followed to its end.
    fn met(self, at: DVec2) -> Option<Met> {
        let (sight, point) = self.on_ball(at)?;
        let normal = (point - CENTER) / RADIUS;
        Some(met(point, sight.reflect(normal)))
    }

    /// What a pixel shows, if it is compared.
    pub(super) fn shown(self, x: usize, y: usize) -> Option<Shown> {
        let at = middle(x, y);
        let (sight, point) = self.on_ball(at)?;
        if -sight.dot(point - CENTER) < FACING * RADIUS {
            return None;
        }
        let here = self.met(at)?;
        let from_center = met(CENTER, here.point - CENTER);
        Some(Shown {
            met: here,
            in_map: from_center.point.distance(here.point) < IN_MAP,
            direction: self.direction(at, &here),
        })
    }

    /// Whether all that lies around a place shows the same surface.
    fn is_inside(self, at: DVec2, surface: Surface) -> bool {
        let around = (0..8).map(|k| EDGE_PX * DVec2::from_angle(f64::from(k) * FRAC_PI_4));
        let mut ends = around.map(|offset| self.met(at + offset));
        ends.all(|met| met.is_some_and(|met| met.surface == surface))
    }

    /// The direction in the picture of the tangent at what is met. With J = (dP/dx, dP/dy) that is where J w is along
    /// the tangent: w = (J^T J)^-1 J^T V up to length, by differences over [`STEP_PX`] to both sides.
    fn direction(self, at: DVec2, here: &Met) -> Option<DVec2> {
        if !self.is_inside(at, here.surface) {
            return None;
        }
        let slope = |step: DVec2| {
            let [ahead, behind] = [self.met(at + step)?, self.met(at - step)?];
            Some((ahead.point - behind.point) / (2.0 * STEP_PX))
        };
        // Rows run down, y up.
        let right = slope(DVec2::new(STEP_PX, 0.0))?;
        let up = slope(DVec2::new(0.0, -STEP_PX))?;
        let (aa, ab, bb) = (right.dot(right), right.dot(up), up.dot(up));
        let tangent = here.tangent();
        let (a, b) = (right.dot(tangent), up.dot(tangent));
        DVec2::new(bb * a - ab * b, aa * b - ab * a).try_normalize()
    }

    /// The ball in an even tone, a half.
    pub(super) fn frame(self) -> Frame {
        let size = self.size;
        let plane = |value: &dyn Fn(DVec3) -> f64| {
            Plane::from_fn(size, size, |x, y| {
                let on_ball = self.on_ball(middle(x, y));
                on_ball.map_or(0.0, |(_, point)| value(point) as f32)
            })
        };
        let normal = |axis: usize| plane(&|point| (point - CENTER)[axis] / RADIUS);
        let covered = |x, y| self.on_ball(middle(x, y)).is_some();
        let tone = Plane::filled(size, size, 0.5);
        Frame {
            data_window: Window::from_size(size, size),
            display_window: Window::from_size(size, size),
            pixel_aspect: 1.0,
            mask: Mask::new(Plane::from_fn(size, size, covered)),
            normal: Vector3Planes {
                x: normal(0),
                y: normal(1),
                z: normal(2),
            },
            normal_length: None,
            depth: Some(plane(&|point| -point.z)),
            occlusion: None,
            importance: None,
            color: Some(ColorPlanes {
                r: tone.clone(),
                g: tone.clone(),
                b: tone,
            }),
            albedo: None,
            alpha: None,
            light: LightLayers::default(),
            camera: Some(self.camera()),
            source: Source {
                depth_kind: DepthKind::Planar,
                ..Source::default()
            },
        }
    }
}

/// How far from the edges of surfaces directions are compared. Pixels on edges have none of their own, whatever was traced:
/// they take their neighbours'. Edges are a pixel wide to each side.
pub const EDGE_PX: f64 = 2.0;

/// Half the difference in pixels over which slopes are taken: errors of the second order, and those of rounding over
/// it, are both below 1e-8 of what the ball shows.
const STEP_PX: f64 = 1e-4;

/// Two points no farther apart than this are one.
const IN_MAP: f64 = 1e-9;

fn middle(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64, y as f64) + 0.5
}

/// The map of the room from its middle, `height` rows of it.
pub(super) fn surroundings(height: usize) -> Surroundings {
    let width = 2 * height;
    let all = Plane::from_fn(width, height, |x, y| {
        met(CENTER, map_direction(x, y, width, height))
    });
    let planes = |value: &dyn Fn(&Met) -> DVec3| {
        let plane = |k: usize| all.map(|met| value(&met)[k] as f32);
        Vector3Planes {
            x: plane(0),
            y: plane(1),
            z: plane(2),
        }
    };
    Surroundings {
        center: CENTER,
        map_from_world: DMat3::IDENTITY,
        points: planes(&|met| met.point - CENTER),
        normal: planes(&Met::normal),
        normal_rounding: 0.0,
        color: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_end_at_the_nearest_surface() {
        // From the middle along x: the wall at 5. At the first column, 1.8 root 2 = 2.5456 away: its radius less.
        let wall = met(CENTER, DVec3::X);
        assert_eq!(wall.surface, Surface::Wall(0));
        assert!((from_center(wall.point) - 5.0).abs() < 1e-12);
        let column = met(CENTER, DVec3::new(1.0, 0.0, 1.0).normalize());
        assert_eq!(column.surface, Surface::Column(0));
        assert!((from_center(column.point) - (1.8 * 2.0_f64.sqrt() - 0.5)).abs() < 1e-12);
        // Its normal leads back to the middle; strokes go around it, level.
        let back = -DVec3::new(0.5, 0.0, 0.5).normalize();
        assert!(column.normal().distance(back) < 1e-12);
        assert!(column.tangent().cross(DVec3::new(1.0, 0.0, -1.0)).length() < 1e-12);
        for met in [wall, column] {
            assert_eq!(nearest_surface(met.point), met.surface);
        }
    }

    #[test]
    fn the_middle_of_the_ball_shows_what_lies_behind_the_viewer() {
        // The sight line toward the middle of the ball falls square on it and goes back the way it came: to the wall
        // at z = -4 + 6, half of -4 before the eye, (0.05, -0.1) times -1/2.
        let scene = Scene { size: 2000 };
        let at = DVec2::splat(1000.0) + 3000.0 / 4.0 * DVec2::new(0.05, 0.1);
        let found = scene.met(at).expect("the ball is there");
        assert_eq!(found.surface, Surface::Wall(2));
        assert!(found.point.distance(DVec3::new(-0.025, 0.05, 2.0)) < 1e-9);
    }

    #[test]
    fn every_surface_is_shown_and_most_of_it_is_in_the_map() {
        let scene = Scene { size: 100 };
        let all = (0..100 * 100).filter_map(|i| scene.shown(i % 100, i / 100));
        let all: Vec<_> = all.collect();
        let walls = (0..3).map(Surface::Wall);
        for surface in walls.chain((0..COLUMNS.len()).map(Surface::Column)) {
            let seen = |shown: &&Shown| shown.met.surface == surface && shown.in_map;
            let count = all.iter().filter(seen).count();
            assert!(count > 5, "{surface:?}: {count}");
        }
        // Strokes have a direction inside of surfaces: of walls nearly everywhere, of thick columns.
        let directed = |surface: Surface| {
            let shows = |shown: &&Shown| shown.met.surface == surface && shown.direction.is_some();
            all.iter().filter(shows).count()
        };
        assert!((0..3).all(|axis| directed(Surface::Wall(axis)) > 300));
        assert!(directed(Surface::Column(0)) > 30);
        let hidden = all.iter().filter(|shown| !shown.in_map).count();
        assert!(hidden > 0 && hidden < all.len() / 20, "{hidden}");
    }
}
