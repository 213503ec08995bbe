//! Scenes whose depth, normals and curvature are known in closed form.
//!
//! View space: x right, y up, z toward the viewer, the eye at the origin. Lengths are in pixels: an orthographic scene
//! has one pixel per unit, a perspective one has it at a distance of the focal length.
//!
//! All quantities of a scene follow from the value, gradient and second derivatives of its surfaces' functions, by the
//! rules derived below.

use super::surfaces::Surface;
use crate::frame::{Camera, ColorPlanes, Frame, Mask, Plane, Projection, Vector3Planes};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Which of several surfaces is visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// The nearest along the sight line, for separate objects.
    Nearest,
    /// The farthest, for the faces of one convex body, which a sight line enters at the last of them.
    Farthest,
}

/// Surfaces and their projection.
#[derive(Debug, Clone, PartialEq)]
pub struct ExactScene {
    /// The surfaces.
    pub surfaces: Vec<Surface>,
    /// Which of them is visible.
    pub seen: Seen,
    /// The projection; pixels are square.
    pub projection: Projection,
}

/// A symmetric 2x2 matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric {
    /// Top left.
    pub xx: f64,
    /// Off the diagonal.
    pub xy: f64,
    /// Bottom right.
    pub yy: f64,
}

/// Eigenvalues of a symmetric 2x2 matrix, `k_u >= k_v`, and the angle of the first, from x
/// counterclockwise, in 0..pi. An umbilic has no direction; its angle is arbitrary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Principal {
    /// The larger eigenvalue.
    pub k_u: f64,
    /// The smaller one.
    pub k_v: f64,
    /// The angle of the first.
    pub angle: f64,
}

/// Curvatures of the surface itself, `k_u >= k_v`, negative where convex, with unit directions in
/// view space (either sign).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectCurvatures {
    /// The larger curvature.
    pub k_u: f64,
    /// The smaller one.
    pub k_v: f64,
    /// Its direction, that of the larger.
    pub u: DVec3,
    /// That of the smaller.
    pub v: DVec3,
}

/// The surface point seen at one position in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exact {
    /// Index of the surface seen.
    pub surface: usize,
    /// The point seen, in view space.
    pub point: DVec3,
    /// Distance along the view axis.
    pub depth: f64,
    /// View-space unit normal, on the viewer's side.
    pub normal: DVec3,
    /// Height toward the viewer in pixels, up to a constant: `-depth` in orthographic projection,
    /// `-focal ln(depth)` in perspective.
    pub height: f64,
    /// Gradient of the height per pixel, y up. In either projection this is the depth gradient with a foreshortening of
    /// 1: `-(n_x, n_y) / (n . v)`, v the direction to the eye scaled to `v_z = 1`.
    pub gradient: DVec2,
    /// Second derivatives of the height per pixel, y up.
    pub hessian: Symmetric,
    /// Curvatures of the surface seen, per unit of length.
    pub object_curvatures: ObjectCurvatures,
}

impl Symmetric {
    /// Sum of the eigenvalues.
    pub fn trace(&self) -> f64 {
        self.xx + self.yy
    }

    /// Eigenvalues and direction: with m the mean of the diagonal and (c, s) = ((xx - yy)/2, xy), the matrix is m + [c
    /// s; s -c], a stretch by q = |(c, s)| along half the angle of (c, s).
    pub fn principal(&self) -> Principal {
        let m = 0.5 * (self.xx + self.yy);
        let c = 0.5 * (self.xx - self.yy);
        let q = c.hypot(self.xy);
        Principal {
            k_u: m + q,
            k_v: m - q,
            angle: (0.5 * self.xy.atan2(c)).rem_euclid(PI),
        }
    }
}

impl ExactScene {
    /// One surface in orthographic projection, one pixel per unit, the view axis at (`cx`, `cy`).
    pub fn orthographic(surface: Surface, cx: f64, cy: f64) -> Self {
        Self {
            surfaces: vec![surface],
            seen: Seen::Nearest,
            projection: Projection::Orthographic {
                sx: 1.0,
                sy: 1.0,
                cx,
                cy,
            },
        }
    }

    /// The scene with its shapes at this distance from the eye rather than [`Surface::DISTANCE`].
    pub fn at_distance(mut self, distance: f64) -> Self {
        for surface in &mut self.surfaces {
            *surface = surface.moved(DVec3::new(0.0, 0.0, Surface::DISTANCE - distance));
        }
        self
    }

    /// The scene in perspective, with the same view axis, at about the same size.
    pub fn in_perspective(self) -> Self {
        let projection = match self.projection {
            Projection::Orthographic { sx, sy, cx, cy } => Projection::Perspective {
                fx: sx * Surface::DISTANCE,
                fy: sy * Surface::DISTANCE,
                cx,
                cy,
            },
            perspective @ Projection::Perspective { .. } => perspective,
        };
        Self { projection, ..self }
    }

    /// A ball of radius `near` in front of, and partly covering, one of radius `far` to its upper right.
    pub fn two_balls(near: f64, far: f64, cx: f64, cy: f64) -> Self {
        let mut scene = Self::orthographic(
            Surface::ball(near).moved(DVec3::new(-0.7 * near, -0.4 * near, 1.5 * near)),
            cx,
            cy,
        );
        scene
            .surfaces
            .push(Surface::ball(far).moved(DVec3::new(0.6 * far, 0.4 * far, -1.5 * far)));
        scene
    }

    /// Three square faces that meet in a corner on the view axis: of a block pointing at the viewer, or of a room,
    /// pointing away. `roll` rotates it about the view axis; at 0 one edge runs straight down (block) or up (room). All
    /// normals have `n_z = 1/sqrt(3)`.
    pub fn box_corner(block: bool, roll: f64, cx: f64, cy: f64) -> Self {
        // Three perpendicular unit vectors at equal angles to z: z/sqrt(3) plus vectors of length sqrt(2/3) in the
        // picture, a third of a turn apart.
        let face = |i: u32| {
            let turn = DVec2::from_angle(roll + PI / 2.0 + f64::from(i) * 2.0 * PI / 3.0);
            let tilt = turn * (2.0_f64 / 3.0).sqrt();
            Surface::plane(tilt.extend((1.0_f64 / 3.0).sqrt()))
        };
        Self {
            surfaces: (0..3).map(face).collect(),
            seen: if block { Seen::Farthest } else { Seen::Nearest },
            ..Self::orthographic(face(0), cx, cy)
        }
    }

    /// The mirrored scene, matching `mirrored` for a frame `width` pixels wide.
    pub fn mirrored(&self, width: usize) -> Self {
        let mut projection = self.projection;
        let (Projection::Perspective { cx, .. } | Projection::Orthographic { cx, .. }) =
            &mut projection;
        *cx = width as f64 - *cx;
        Self {
            surfaces: self.surfaces.iter().map(|s| s.mirrored()).collect(),
            seen: self.seen,
            projection,
        }
    }

    /// Pixels per unit of length, at a distance of 1 in perspective.
    pub fn scale(&self) -> f64 {
        let (x, y) = match self.projection {
            Projection::Orthographic { sx, sy, .. } => (sx, sy),
            Projection::Perspective { fx, fy, .. } => (fx, fy),
        };
        assert!(x == y, "scenes have square pixels");
        x
    }

    /// Origin and direction of the sight line through (`x`, `y`), with the direction's z = -1, so that the parameter
    /// along it is the depth.
    fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let s = self.scale();
        match self.projection {
            Projection::Orthographic { cx, cy, .. } => {
                (DVec3::new((x - cx) / s, (cy - y) / s, 0.0), DVec3::NEG_Z)
            }
            Projection::Perspective { cx, cy, .. } => {
                (DVec3::ZERO, DVec3::new((x - cx) / s, (cy - y) / s, -1.0))
            }
        }
    }

    /// The surface point seen at the centre of the pixel in column `x` of row `y`.
    pub fn exact(&self, x: usize, y: usize) -> Option<Exact> {
        self.exact_at(x as f64 + 0.5, y as f64 + 0.5)
    }

    /// The surface point seen at the picture position (`x`, `y`): pixel edges at integers, rows down.
    pub fn exact_at(&self, x: f64, y: f64) -> Option<Exact> {
        let (origin, direction) = self.ray(x, y);
        let hits = self
            .surfaces
            .iter()
            .enumerate()
            .filter_map(|(i, s)| s.hit(origin, direction).map(|t| (i, t)));
        let (surface, depth) = match self.seen {
            Seen::Nearest => hits.min_by(|a, b| a.1.total_cmp(&b.1)),
            Seen::Farthest => hits.max_by(|a, b| a.1.total_cmp(&b.1)),
        }?;
        let point = origin + depth * direction;
        let (gradient, second) = self.surfaces[surface].derivatives(point);
        // The normal is F's gradient, oriented toward the origin of the sight line.
        let outward = gradient * -gradient.dot(direction).signum();
        let normal = outward.normalize();
        let scale = self.scale();
        let (slope, bend, height) = match self.projection {
            // F(x, y, z) = 0 with z the height.
            Projection::Orthographic { .. } => {
                let (slope, bend) = graph(gradient, second);
                (slope, bend, -scale * depth)
            }
            // The point is p = e^-h (X, Y, -1) with h = -ln(depth). As a function of (X, Y, h),
            // writing d for e^-h, F has the derivatives
            //   F_X = d F_x,  F_h = -F' . p,
            //   F_XX = d^2 F_xx,  F_Xh = -d (F_x + (F'' p)_x),  F_hh = F' . p + p . F'' p.
            Projection::Perspective { .. } => {
                let bent = second * point;
                let along = gradient.dot(point);
                let first = DVec3::new(depth * gradient.x, depth * gradient.y, -along);
                let d2 = depth * depth;
                let (xx, xy, yy) = (second.x_axis.x, second.x_axis.y, second.y_axis.y);
                let xh = -depth * (gradient.x + bent.x);
                let yh = -depth * (gradient.y + bent.y);
                let hh = along + point.dot(bent);
                let second = DMat3::from_cols(
                    DVec3::new(d2 * xx, d2 * xy, xh),
                    DVec3::new(d2 * xy, d2 * yy, yh),
                    DVec3::new(xh, yh, hh),
                );
                let (slope, bend) = graph(first, second);
                (slope, bend, -scale * depth.ln())
            }
        };
        Some(Exact {
            surface,
            point,
            depth,
            normal,
            height,
            // Positions and height are both in pixels: slopes are unchanged, second derivatives are per pixel.
            gradient: slope,
            hessian: Symmetric {
                xx: bend.xx / scale,
                xy: bend.xy / scale,
                yy: bend.yy / scale,
            },
            object_curvatures: object_curvatures(outward, second * outward.dot(gradient).signum()),
        })
    }

    /// The foreshortened depth gradient `-(n_x, n_y) / (n . v)^f` at a picture position.
    pub fn depth_gradient(&self, x: f64, y: f64, foreshortening: f64) -> Option<DVec2> {
        let n = self.exact_at(x, y)?.normal;
        let facing = n.dot(self.projection.to_eye(x, y).extend(1.0));
        Some(-n.truncate() * facing.powf(-foreshortening))
    }

    /// The derivatives `[d g_x/dx, d g_x/dy, d g_y/dx, d g_y/dy]` per pixel, y up, of the foreshortened depth gradient,
    /// by five-point differences: accurate to about nine digits. `None` if the five points do not lie on one surface.
    pub fn depth_gradient_jacobian(&self, x: f64, y: f64, foreshortening: f64) -> Option<[f64; 4]> {
        let here = self.exact_at(x, y)?.surface;
        let g = |x: f64, y: f64| {
            let same = self.exact_at(x, y)?.surface == here;
            same.then(|| self.depth_gradient(x, y, foreshortening))?
        };
        let across = five_point(|t| g(x + t, y))?;
        let up = five_point(|t| g(x, y - t))?;
        Some([across.x, up.x, across.y, up.y])
    }

    /// The frame of `width` x `height` pixels, samples taken at pixel centres and rounded to f32.
    ///
    /// The picture is grey and lit from above: `0.1 + 0.6 max(0, n . (0, 0.6, 0.8))`.
    pub fn frame(&self, width: usize, height: usize) -> Frame {
        let seen: Vec<_> = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| self.exact(x, y))
            .collect();
        let plane = |value: fn(&Exact) -> f64| {
            let samples = seen.iter().map(|e| e.as_ref().map_or(0.0, value) as f32);
            Plane::from_samples(width, height, samples.collect())
        };
        let gray = plane(|e| 0.1 + 0.6 * e.normal.dot(DVec3::new(0.0, 0.6, 0.8)).max(0.0));
        let covered = seen.iter().map(Option::is_some).collect();
        let normals = Vector3Planes {
            x: plane(|e| e.normal.x),
            y: plane(|e| e.normal.y),
            z: plane(|e| e.normal.z),
        };
        Frame {
            depth: Some(plane(|e| e.depth)),
            color: Some(ColorPlanes::grey(gray)),
            alpha: Some(plane(|_| 1.0)),
            camera: Some(Camera {
                view_from_world: DAffine3::IDENTITY,
                projection: self.projection,
            }),
            ..Frame::of_normals(
                normals,
                Mask::new(Plane::from_samples(width, height, covered)),
            )
        }
    }
}

/// First and second derivatives of the third coordinate w over the first two where F(x, y, w) = 0.
///
/// Differentiating F(x, y, w(x, y)) = 0 once gives F_x + F_w w_x = 0; once more along y,
/// `F_xy + F_xw w_y + F_yw w_x + F_ww w_x w_y + F_w w_xy = 0`; likewise for xx and yy.
fn graph(first: DVec3, second: DMat3) -> (DVec2, Symmetric) {
    let slope = -first.truncate() / first.z;
    let bend = |i: usize, j: usize| {
        let f = |a: usize, b: usize| second.col(b)[a];
        let sum = f(i, j) + f(i, 2) * slope[j] + f(j, 2) * slope[i] + f(2, 2) * slope[i] * slope[j];
        -sum / first.z
    };
    let bend = Symmetric {
        xx: bend(0, 0),
        xy: bend(0, 1),
        yy: bend(1, 1),
    };
    (slope, bend)
}

/// Curvatures of F = 0, whose gradient points to the viewer's side.
///
/// Over its tangent plane the surface is a graph w(t) along the normal with zero slope, so the equation above reduces
/// to w_ij = -F_ij / |F'|: the second derivatives of F in a tangent basis, negative where F grows outward, as on a
/// ball.
fn object_curvatures(gradient: DVec3, second: DMat3) -> ObjectCurvatures {
    let length = gradient.length();
    let (a, b) = (gradient / length).any_orthonormal_pair();
    let principal = Symmetric {
        xx: -a.dot(second * a) / length,
        xy: -a.dot(second * b) / length,
        yy: -b.dot(second * b) / length,
    }
    .principal();
    let (sin, cos) = principal.angle.sin_cos();
    ObjectCurvatures {
        k_u: principal.k_u,
        k_v: principal.k_v,
        u: a * cos + b * sin,
        v: b * cos - a * sin,
    }
}

/// The derivative of `f` at 0, with an error of fourth order in the step.
pub fn five_point(f: impl Fn(f64) -> Option<DVec2>) -> Option<DVec2> {
    const STEP: f64 = 5e-3;
    let (one, two) = (f(STEP)? - f(-STEP)?, f(2.0 * STEP)? - f(-2.0 * STEP)?);
    Some((8.0 * one - two) / (12.0 * STEP))
}

/// Trace of the gradient of `g = -(n_x, n_y) / n_z^f` on a ball of radius `radius` in orthographic projection, at the
/// normal z component `n_z`.
///
/// On the ball n = (x, y, z)/R with z = sqrt(R^2 - x^2 - y^2), so g = -(x, y) R^(f-1) z^-f. Its
/// divergence is -R^(f-1) [2 z^-f + (x, y) . grad z^-f], and grad z = -(x, y)/z turns the last term
/// into f (x^2 + y^2) z^-(f+2). With z = R n_z and x^2 + y^2 = R^2 (1 - n_z^2):
/// `-[2 n_z^-f + f (1 - n_z^2) n_z^-(f+2)] / R`.
pub fn ball_trace(radius: f64, n_z: f64, f: f64) -> f64 {
    let around = 2.0 * n_z.powf(-f);
    let toward_rim = f * (1.0 - n_z * n_z) * n_z.powf(-(f + 2.0));
    -(around + toward_rim) / radius
}
