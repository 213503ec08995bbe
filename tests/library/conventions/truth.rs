//! One scene with all values known, and the error of a frame against it.

use crate::prelude::*;
use std::sync::OnceLock;

pub(crate) const WIDTH: usize = 160;
pub(crate) const HEIGHT: usize = 120;
/// Focal length in pixels: a view of 53 degrees.
pub(crate) const FOCAL: f64 = 160.0;
/// Scene units per unit of the scene of the tests, so that the ball has a radius of about 1.
const UNIT: f64 = 1.0 / 80.0;

/// A ball and a ring in front of a slanted wall that does not fill the picture.
pub(crate) struct Truth {
    seen: Plane<Option<Exact>>,
    /// View from world, right-handed with z up.
    pub(crate) camera: DAffine3,
}

pub(crate) fn display() -> Window {
    Window::from_size(WIDTH, HEIGHT)
}

pub(crate) fn projection() -> Projection {
    Projection::Perspective {
        fx: FOCAL,
        fy: FOCAL,
        cx: 0.5 * WIDTH as f64,
        cy: 0.5 * HEIGHT as f64,
    }
}

/// The scene, seen once.
pub(crate) fn truth() -> &'static Truth {
    static TRUTH: OnceLock<Truth> = OnceLock::new();
    TRUTH.get_or_init(Truth::new)
}

impl Truth {
    fn new() -> Self {
        let ball = Surface::ball(80.0).moved(DVec3::new(-90.0, 30.0, 0.0));
        let ring = Surface::torus(70.0, 30.0, DVec3::new(0.3, 0.8, 0.5));
        let wall = Surface::plane(DVec3::new(-0.25, 0.35, 0.9));
        let scene = ExactScene {
            surfaces: vec![
                ball,
                ring.moved(DVec3::new(100.0, -40.0, 20.0)),
                wall.moved(DVec3::new(0.0, 0.0, -150.0)),
            ],
            projection: projection(),
            ..ExactScene::orthographic(ball, 0.0, 0.0)
        };
        let seen = Plane::from_fn(WIDTH, HEIGHT, |x, y| {
            // The picture ends before the wall does: a band of nothing on the right.
            scene
                .exact(x, y)
                .filter(|e| e.surface < 2 || x < WIDTH - 24)
        });
        // An eye above and aside of the scene's middle, z up.
        let back = DVec3::new(0.55, -0.75, 0.42).normalize();
        let right = DVec3::Z.cross(back).normalize();
        let turn = DMat3::from_cols(right, back.cross(right), back).transpose();
        let eye = DVec3::new(0.4, 0.2, 0.8) + Surface::DISTANCE * UNIT * back;
        Self {
            seen,
            camera: DAffine3::from_mat3_translation(turn, -(turn * eye)),
        }
    }

    fn value(&self, background: f64, value: impl Fn(&Exact) -> f64) -> Plane {
        self.seen
            .map(|seen| seen.as_ref().map_or(background, &value) as f32)
    }

    /// The component `axis` of the unit normals in view space, changed by `change`.
    pub(crate) fn normal(
        &self,
        axis: usize,
        background: f64,
        change: impl Fn(DVec3) -> DVec3,
    ) -> Plane {
        self.value(background, |e| change(e.normal)[axis])
    }

    /// The component `axis` of the points in view space, changed by `change`.
    pub(crate) fn point(
        &self,
        axis: usize,
        background: f64,
        change: impl Fn(DVec3) -> DVec3,
    ) -> Plane {
        self.value(background, |e| change(e.point * UNIT)[axis])
    }

    /// A function of planar depth and distance.
    pub(crate) fn depth(&self, background: f64, change: impl Fn(f64, f64) -> f64) -> Plane {
        self.value(background, |e| {
            change(e.depth * UNIT, e.point.length() * UNIT)
        })
    }

    /// 1 where there is a surface.
    pub(crate) fn alpha(&self) -> Plane {
        self.value(0.0, |_| 1.0)
    }

    /// The pixels that show the scene.
    fn all_seen(&self) -> impl Iterator<Item = (usize, usize, Exact)> {
        places(WIDTH, HEIGHT).filter_map(|(x, y)| Some((x, y, self.seen.at(x, y)?)))
    }

    /// Largest angle, in degrees, between the normals of a frame and the true ones.
    pub(crate) fn worst_angle_deg(&self, frame: &Frame) -> f64 {
        largest(self.all_seen().map(|(x, y, seen)| {
            // From the chord: the cosine rounds below 0.03 degrees.
            let chord = frame.normal.at(x, y).distance(seen.normal);
            2.0 * (0.5 * chord).min(1.0).asin().to_degrees()
        }))
    }

    /// Number of pixels where a frame's mask differs from the true one.
    pub(crate) fn mask_errors(&self, frame: &Frame) -> usize {
        let wrong = |&(x, y): &(usize, usize)| frame.mask.at(x, y) != self.seen.at(x, y).is_some();
        places(WIDTH, HEIGHT).filter(wrong).count()
    }

    /// Largest relative error of depth; of planar depth, or of distance along the sight line, with `unit` units of it
    /// per unit of the scene.
    pub(crate) fn worst_depth(&self, frame: &Frame, along_ray: bool, unit: f64) -> f64 {
        let depth = frame.depth.as_ref().expect("a frame with depth");
        largest(self.all_seen().map(|(x, y, seen)| {
            let planar = !along_ray;
            let exact = if planar {
                seen.depth
            } else {
                seen.point.length()
            };
            (f64::from(depth.at(x, y)) / (exact * UNIT * unit) - 1.0).abs()
        }))
    }
}
