//! Exact scenes: a mirror or a glass ball in a room, traced in f64.

use super::*;

/// The middle of the ball, and of the room.
pub(crate) const CENTER: DVec3 = DVec3::new(0.05, -0.1, -4.0);

/// Radius of the ball.
pub(crate) const RADIUS: f64 = 1.0;

/// Distances from the middle of the room to its walls: x, y, z.
const ROOM: DVec3 = DVec3::new(5.0, 2.0, 6.0);

/// The specular object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Thing {
    MirrorBall,
    GlassBall,
    /// A round part of the plane through the middle of the room with this normal.
    FlatMirror(DVec3),
}

pub(crate) const IOR: f64 = 1.5;

/// An object in a room, seen by a camera with this focal length in the middle of `size` pixels each way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    pub(crate) thing: Thing,
    pub(crate) size: usize,
    pub(crate) focal: f64,
}

impl Scene {
    pub(crate) fn camera(&self) -> Camera {
        let (c, f) = (self.size as f64 / 2.0, self.focal);
        let [fx, fy, cx, cy] = [f, f, c, c];
        let turn = DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(-0.2);
        Camera {
            view_from_world: DAffine3::from_mat3_translation(turn, DVec3::new(0.3, -0.7, 0.2)),
            projection: Projection::Perspective { fx, fy, cx, cy },
        }
    }

    pub(crate) fn sight(&self) -> SightLines {
        SightLines::new(self.camera().projection)
    }

    /// Point and outward normal of the visible surface at a place of the picture.
    fn surface(&self, at: DVec2) -> Option<(DVec3, DVec3)> {
        let (start, line) = self.sight().line(at.x, at.y);
        let direction = line.normalize();
        match self.thing {
            Thing::FlatMirror(normal) => {
                let t = normal.dot(CENTER - start) / normal.dot(direction);
                let point = start + t * direction;
                (point.distance(CENTER) < RADIUS).then_some((point, normal))
            }
            _ => {
                let (near, _) = on_ball(start, direction)?;
                Some((near, (near - CENTER) / RADIUS))
            }
        }
    }

    /// The ray that leaves the object there.
    pub(crate) fn leaving(&self, at: DVec2) -> Option<(DVec3, DVec3)> {
        let (point, normal) = self.surface(at)?;
        let sight = self.sight().line(at.x, at.y).1.normalize();
        if self.thing != Thing::GlassBall {
            return Some((point, sight.reflect(normal)));
        }
        let inside = sight.refract(normal, 1.0 / IOR);
        let (_, far) = on_ball(point, inside)?;
        let out = inside.refract(-(far - CENTER) / RADIUS, IOR);
        Some((far, out))
    }

    /// The point of the room seen there, with the axis of its wall.
    pub(crate) fn hit(&self, at: DVec2) -> Option<(DVec3, usize)> {
        let (start, direction) = self.leaving(at)?;
        Some(wall(start, direction))
    }

    /// A direction on the wall that is met, neither along nor across it.
    pub(crate) fn tangent(axis: usize) -> DVec3 {
        let mut tangent = DVec3::new(0.6, 0.5, 0.62);
        tangent[axis] = 0.0;
        tangent.normalize()
    }

    /// The image direction, x right and y up, of a tangent at the hit point: the inverted Jacobian of the hit point by
    /// differences of 1e-4 pixels. `None` if those are on different walls.
    pub(crate) fn seen(&self, at: DVec2) -> Option<(DVec2, DVec3)> {
        let (_, axis) = self.hit(at)?;
        let tangent = Self::tangent(axis);
        let difference = |step: DVec2| {
            let ends = [at + step, at - step].map(|p| self.hit(p));
            match ends {
                [Some((a, wall)), Some((b, other))] if wall == axis && other == axis => {
                    Some((a - b) / (2.0 * step.length()))
                }
                _ => None,
            }
        };
        let right = difference(DVec2::new(1e-4, 0.0))?;
        let up = difference(DVec2::new(0.0, -1e-4))?;
        let (aa, ab, bb) = (right.dot(right), right.dot(up), up.dot(up));
        let (a, b) = (right.dot(tangent), up.dot(tangent));
        let seen = DVec2::new(bb * a - ab * b, aa * b - ab * a);
        Some((seen.try_normalize()?, tangent))
    }

    fn frame_of(&self, point: impl Fn(DVec2) -> Option<(DVec3, DVec3)>) -> Frame {
        let size = self.size;
        let seen = Plane::from_fn(size, size, |x, y| point(middle(x, y)));
        let normal = |x, y| seen.at(x, y).map_or(DVec3::ZERO, |(_, n)| n);
        let normals = Vector3Planes::from_fn(size, size, normal);
        Frame {
            depth: Some(seen.map(|seen| seen.map_or(0.0, |(p, _)| -p.z as f32))),
            camera: Some(self.camera()),
            ..Frame::of_normals(normals, Mask::new(seen.map(|seen| seen.is_some())))
        }
    }

    /// The visible surface.
    pub(crate) fn frame(&self) -> Frame {
        self.frame_of(|at| self.surface(at))
    }

    /// The back of the ball.
    pub(crate) fn back(&self) -> Frame {
        self.frame_of(|at| {
            let (start, line) = self.sight().line(at.x, at.y);
            let (_, far) = on_ball(start, line.normalize())?;
            // Toward the viewer, as renderers write it.
            Some((far, (CENTER - far) / RADIUS))
        })
    }

    /// The room as the camera sees it with nothing in it.
    pub(crate) fn behind(&self) -> Frame {
        self.frame_of(|at| {
            let (start, line) = self.sight().line(at.x, at.y);
            let (point, axis) = wall(start, line.normalize());
            Some((point, normal_of(point, axis)))
        })
    }

    /// The room from its middle, `height` pixels high.
    pub(crate) fn surroundings(&self, height: usize) -> Surroundings {
        let width = 2 * height;
        let world_from_view = self.camera().view_from_world.inverse();
        let map_from_view = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.3);
        let hit = |x: usize, y: usize| {
            let direction = map_from_view.transpose() * map_direction(x, y, width, height);
            let (point, axis) = wall(CENTER, direction);
            let normal = world_from_view.transform_vector3(normal_of(point, axis));
            let from_center = world_from_view.transform_vector3(point - CENTER);
            (from_center, normal)
        };
        Surroundings {
            center: world_from_view.transform_point3(CENTER),
            map_from_world: map_from_view * self.camera().view_from_world.matrix3,
            points: Vector3Planes::from_fn(width, height, |x, y| hit(x, y).0),
            normal: Vector3Planes::from_fn(width, height, |x, y| hit(x, y).1),
            normal_rounding: 0.0,
            color: None,
        }
    }
}

/// Entry and exit of a line through the ball.
fn on_ball(start: DVec3, direction: DVec3) -> Option<(DVec3, DVec3)> {
    on_sphere(start, direction, CENTER, RADIUS)
}

/// Entry and exit of a line through a sphere.
pub(crate) fn on_sphere(
    start: DVec3,
    direction: DVec3,
    middle: DVec3,
    radius: f64,
) -> Option<(DVec3, DVec3)> {
    let from = start - middle;
    let along = from.dot(direction);
    let square = along * along - from.length_squared() + radius * radius;
    let root = (square > 0.0).then(|| square.sqrt())?;
    let at = |t: f64| start + t * direction;
    Some((at(-along - root), at(-along + root)))
}

/// Hit of a ray from inside the room on its wall, and that wall's axis.
fn wall(start: DVec3, direction: DVec3) -> (DVec3, usize) {
    let from = start - CENTER;
    let (t, axis) = (0..3)
        .map(|axis| {
            let side = ROOM[axis].copysign(direction[axis]);
            ((side - from[axis]) / direction[axis], axis)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("three axes");
    (start + t * direction, axis)
}

/// The normal of a wall, into the room.
fn normal_of(point: DVec3, axis: usize) -> DVec3 {
    let mut normal = DVec3::ZERO;
    normal[axis] = -(point - CENTER)[axis].signum();
    normal
}
