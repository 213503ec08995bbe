//! A mirror ball in the middle of the room, and the exact points shown by its pixels.

use super::room::{CENTER, Hit, RoomSurface, hit};
use crate::frame::{
    Camera, ColorPlanes, Frame, Mask, Plane, Projection, SightLines, Vector3Planes,
};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::FRAC_PI_4;

/// Radius of the ball, the unit of all lengths.
const RADIUS: f64 = 1.0;

/// Minimum cosine between normal and sight line for pixels to compare. Near the rim of the ball neighbouring pixels
/// show distant points, and directions err by the size of pixels however they are traced.
pub(crate) const FACING: f64 = 0.3;

/// Focal length over the picture's width: the ball, of radius 1 at a distance of 4, fills 3/4 of it.
const FOCAL: f64 = 1.5;

/// The point of the room shown by a pixel. Pixels are compared if the cosine between their normal and sight line is at
/// least [`FACING`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shown {
    pub(super) hit: Hit,
    /// Whether the map of the room also shows it.
    pub(super) in_map: bool,
    /// The stroke direction in the picture, a unit vector, x right, y up: [`Hit::tangent`] as reflected by the ball.
    /// `None` within [`EDGE_PX`] of the edge of a surface.
    pub(super) direction: Option<DVec2>,
}

impl Shown {
    pub(super) fn is_column(&self) -> bool {
        matches!(self.hit.surface, RoomSurface::Column(_))
    }
}

/// The ball in `size` by `size` pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub(super) size: usize,
}

impl Ball {
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

    /// The unit sight line through a position in the picture, and its intersection with the ball.
    fn on_ball(self, at: DVec2) -> Option<(DVec3, DVec3)> {
        let (start, line) = SightLines::new(self.camera().projection).line(at.x, at.y);
        let direction = line.normalize();
        let from = start - CENTER;
        let along = from.dot(direction);
        let square = along * along - from.length_squared() + RADIUS * RADIUS;
        (square > 0.0).then(|| (direction, start + (-along - square.sqrt()) * direction))
    }

    /// The hit of the sight line through a position in the picture, mirrored at the normal.
    fn hit(self, at: DVec2) -> Option<Hit> {
        let (sight, point) = self.on_ball(at)?;
        let normal = (point - CENTER) / RADIUS;
        Some(hit(point, sight.reflect(normal)))
    }

    /// The point shown by a pixel, if it is compared.
    pub(super) fn shown(self, x: usize, y: usize) -> Option<Shown> {
        let at = middle(x, y);
        let (sight, point) = self.on_ball(at)?;
        if -sight.dot(point - CENTER) < FACING * RADIUS {
            return None;
        }
        let here = self.hit(at)?;
        let from_center = hit(CENTER, here.point - CENTER);
        Some(Shown {
            hit: here,
            in_map: from_center.point.distance(here.point) < IN_MAP,
            direction: self.direction(at, &here),
        })
    }

    /// Whether everything around a position shows the same surface.
    fn is_inside(self, at: DVec2, surface: RoomSurface) -> bool {
        let around = (0..8).map(|k| EDGE_PX * DVec2::from_angle(f64::from(k) * FRAC_PI_4));
        let mut ends = around.map(|offset| self.hit(at + offset));
        ends.all(|hit| hit.is_some_and(|hit| hit.surface == surface))
    }

    /// The direction in the picture of the tangent at the hit point. With J = (dP/dx, dP/dy) it is the w for which J w
    /// is along the tangent: w = (J^T J)^-1 J^T V up to length, by central differences over [`STEP_PX`].
    fn direction(self, at: DVec2, here: &Hit) -> Option<DVec2> {
        if !self.is_inside(at, here.surface) {
            return None;
        }
        let slope = |step: DVec2| {
            let [ahead, behind] = [self.hit(at + step)?, self.hit(at - step)?];
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

    /// The ball in a uniform half tone.
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
        let normals = Vector3Planes {
            x: normal(0),
            y: normal(1),
            z: normal(2),
        };
        Frame {
            depth: Some(plane(&|point| -point.z)),
            color: Some(ColorPlanes::grey(tone)),
            camera: Some(self.camera()),
            ..Frame::of_normals(normals, Mask::new(Plane::from_fn(size, size, covered)))
        }
    }
}

/// Distance from edges of surfaces beyond which directions are compared. Pixels on edges have no direction of their
/// own, whatever was traced: they take their neighbours'. Edges are a pixel wide to each side.
pub(crate) const EDGE_PX: f64 = 2.0;

/// Half step in pixels for central differences: the second-order error, and rounding divided by the step, are both
/// below 1e-8 of the distances shown by the ball.
const STEP_PX: f64 = 1e-4;

/// Points no farther apart than this are identical.
const IN_MAP: f64 = 1e-9;

fn middle(x: usize, y: usize) -> DVec2 {
    DVec2::new(x as f64, y as f64) + 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_the_ball_shows_what_lies_behind_the_viewer() {
        // The sight line toward the centre of the ball hits it at a right angle and returns through the eye, to the
        // wall at z = -4 + 6 = 2: the centre times -1/2, (-0.025, 0.05, 2).
        let ball = Ball { size: 2000 };
        let at = DVec2::splat(1000.0) + 3000.0 / 4.0 * DVec2::new(0.05, 0.1);
        let found = ball.hit(at).expect("the ball is there");
        assert_eq!(found.surface, RoomSurface::Wall(2));
        assert!(found.point.distance(DVec3::new(-0.025, 0.05, 2.0)) < 1e-9);
    }

    #[test]
    fn every_surface_is_shown_and_most_of_it_is_in_the_map() {
        let ball = Ball { size: 160 };
        let all = (0..160 * 160).filter_map(|i| ball.shown(i % 160, i / 160));
        let all: Vec<_> = all.collect();
        let walls = (0..3).map(RoomSurface::Wall);
        for surface in walls.chain((0..4).map(RoomSurface::Column)) {
            let seen = |shown: &&Shown| shown.hit.surface == surface && shown.in_map;
            let count = all.iter().filter(seen).count();
            assert!(count > 20, "{surface:?}: {count}");
        }
        // Strokes have a direction inside surfaces: almost everywhere on walls, and on thick columns.
        let directed = |surface: RoomSurface| {
            let shows = |shown: &&Shown| shown.hit.surface == surface && shown.direction.is_some();
            all.iter().filter(shows).count()
        };
        assert!((0..3).all(|axis| directed(RoomSurface::Wall(axis)) > 300));
        assert!(directed(RoomSurface::Column(0)) > 30);
        let hidden = all.iter().filter(|shown| !shown.in_map).count();
        assert!(hidden > 0 && hidden < all.len() / 20, "{hidden}");
    }
}
