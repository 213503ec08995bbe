//! Small scenes with known answers, and the analytic surfaces they are made of: for unit tests, tests of the library, examples, and
//! the report's cases.
//!
//! All scenes are orthographic, one unit per pixel. A closed form of the curvature after diffusion, where
//! there is one, gives the error of the whole method, including the grid, as a yardstick for the error of a solver.

pub(crate) mod environment;
pub mod exact;
pub mod frames;
pub mod light_reference;
pub mod surfaces;

pub use environment::environment;
pub use exact::{Exact, ExactScene, ball_trace};
pub use surfaces::Surface;

use crate::frame::{Frame, Mask, Plane, Vector3Planes};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// A scene with its known answers.
pub struct Scene {
    /// Its name, also used for files.
    pub name: &'static str,
    /// The frame.
    pub frame: Frame,
    /// The foreshortening to analyse it with.
    pub foreshortening: f32,
    truth: Truth,
}

/// Closed forms of the trace after diffusion, far enough from borders.
enum Truth {
    /// Waves `h = a cos(kx) cos(ky)`: the trace is `-2 a k^2 cos cos e^(-2 k^2 t)`.
    Waves,
    /// A ball at foreshortening 0: the gradient is linear, and unchanged by diffusion; -2/R.
    Ball { radius: f64 },
    /// An ellipsoid: its own directions of curvature, without diffusion.
    Ellipsoid(ExactScene),
    /// Only the reference in double precision.
    Unknown,
}

/// Distance of the scenes from the eye.
const DISTANCE: f64 = 2000.0;

impl Scene {
    /// Wave number per pixel of [`Scene::waves`]: 64 pixels long.
    pub const WAVE: f64 = 2.0 * PI / 64.0;
    /// Height of [`Scene::waves`] in pixels: slopes up to 1/2.
    pub const HEIGHT: f64 = 5.0;

    /// All scenes, at one size.
    pub fn all(width: usize, height: usize) -> Vec<Self> {
        vec![
            Self::waves(width, height),
            Self::ball(width, height),
            Self::barriers(width, height),
        ]
    }

    /// Waves `h = a cos(kx) cos(ky)`, the whole picture covered.
    pub fn waves(width: usize, height: usize) -> Self {
        let normal = |x: usize, y: usize| {
            let ((sx, cx), (sy, cy)) = (wave_at(x), wave_at(y));
            // y points up, rows run down: d/dy = -d/drow.
            let slope = Self::HEIGHT * Self::WAVE;
            DVec3::new(slope * sx * cy, -slope * cx * sy, 1.0).normalize()
        };
        Self {
            name: "waves",
            frame: frame(width, height, |x, y| Some((normal(x, y), DISTANCE))),
            foreshortening: 1.0,
            truth: Truth::Waves,
        }
    }

    /// A plane facing the viewer, the whole picture covered.
    pub fn plane(width: usize, height: usize) -> Self {
        Self {
            name: "plane",
            frame: frame(width, height, |_, _| Some((DVec3::Z, DISTANCE))),
            foreshortening: 0.0,
            truth: Truth::Unknown,
        }
    }

    /// A ball that fills nine tenths of the picture's shorter side.
    pub fn ball(width: usize, height: usize) -> Self {
        let radius = 0.45 * width.min(height) as f64;
        let ball = off_the_grid(Surface::ball(radius), width, height);
        Self {
            name: "ball",
            frame: bare(&ball, width, height),
            foreshortening: 0.0,
            truth: Truth::Ball { radius },
        }
    }

    /// A tilted ellipsoid with half axes 1, 0.7 and 0.5, as large as the ball of [`Scene::ball`]. Without depth, so
    /// that directions come from normals.
    pub fn ellipsoid(width: usize, height: usize) -> Self {
        let half_axes = DVec3::new(1.0, 0.7, 0.5) * 0.45 * width.min(height) as f64;
        let tilt = DMat3::from_rotation_z(0.5)
            * DMat3::from_rotation_y(0.6)
            * DMat3::from_rotation_x(-0.8);
        let ellipsoid = off_the_grid(Surface::ellipsoid(half_axes, tilt), width, height);
        Self {
            name: "ellipsoid",
            frame: Frame {
                depth: None,
                ..bare(&ellipsoid, width, height)
            },
            foreshortening: 1.0,
            truth: Truth::Ellipsoid(ellipsoid),
        }
    }

    /// Overlapping shallow caps and roofs at many depths: steps and creases everywhere, conductances from 0 to 1, some
    /// changing from one to the other within a pixel.
    pub fn barriers(width: usize, height: usize) -> Self {
        let pieces = pieces(width as f64, height as f64);
        let at = |x: usize, y: usize| {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let hits = pieces.iter().filter_map(|piece| piece.at(px, py));
            hits.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        Self {
            name: "barriers",
            frame: frame(width, height, at),
            foreshortening: 1.0,
            truth: Truth::Unknown,
        }
    }

    /// The unit direction in the picture, y up, of the surface's own larger curvature by magnitude, at column `x`, row
    /// `y`. `None` where it is unknown, where the two curvatures differ by less than a tenth of the larger, and where
    /// n_z is below 0.35.
    pub fn exact_direction(&self, x: usize, y: usize) -> Option<DVec2> {
        let Truth::Ellipsoid(scene) = &self.truth else {
            return None;
        };
        let exact = scene.exact(x, y)?;
        // Negative where convex, so k_v is the larger in magnitude.
        let bent = exact.object_curvatures;
        let differ = bent.k_u - bent.k_v > 0.1 * -bent.k_v;
        (exact.normal.z > 0.35 && differ).then(|| bent.v.truncate().normalize())
    }

    /// The trace of the Hessian at column `x`, row `y` after diffusion over `time`; `None` where it is unknown, or
    /// where a border is within five sigmas.
    pub fn exact_trace(&self, x: usize, y: usize, time: f64) -> Option<f64> {
        let margin = 2.0 + 5.0 * (2.0 * time).sqrt();
        let (w, h) = (
            self.frame.mask.width() as f64,
            self.frame.mask.height() as f64,
        );
        let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
        match self.truth {
            Truth::Waves if px.min(py).min(w - px).min(h - py) > margin => {
                let square = Self::WAVE.powi(2);
                let peak = -2.0 * Self::HEIGHT * square * (-2.0 * square * time).exp();
                Some(peak * wave_at(x).1 * wave_at(y).1)
            }
            Truth::Ball { radius } if self.foreshortening == 0.0 => {
                let from_middle = (px - 0.5 * w - 0.3).hypot(0.5 * h - 0.2 - py);
                (from_middle < radius - margin).then_some(-2.0 / radius)
            }
            _ => None,
        }
    }
}

/// The surface at the distance of the scenes, near the centre of the picture but off the pixel grid.
fn off_the_grid(surface: Surface, width: usize, height: usize) -> ExactScene {
    let [cx, cy] = [width, height].map(|size| 0.5 * size as f64);
    ExactScene::orthographic(surface, cx + 0.3, cy - 0.2).at_distance(DISTANCE)
}

/// The normals and depth of a scene, without a picture or a camera.
fn bare(scene: &ExactScene, width: usize, height: usize) -> Frame {
    frame(width, height, |x, y| {
        scene.exact(x, y).map(|exact| (exact.normal, exact.depth))
    })
}

/// Sine and cosine of a wave at the centre of pixel `i`.
fn wave_at(i: usize) -> (f64, f64) {
    (Scene::WAVE * (i as f64 + 0.5)).sin_cos()
}

/// The unit normal of a ball around the origin, seen at (`x`, `y`), y up.
fn ball_at(x: f64, y: f64, radius: f64) -> Option<DVec3> {
    let z2 = radius * radius - x * x - y * y;
    (z2 > 0.0).then(|| DVec3::new(x, y, z2.sqrt()) / radius)
}

fn frame(width: usize, height: usize, at: impl Fn(usize, usize) -> Option<(DVec3, f64)>) -> Frame {
    let seen = Plane::from_fn(width, height, at);
    let normal = |axis: usize| seen.map(|s| s.map_or(0.0, |(n, _)| n[axis] as f32));
    let normals = Vector3Planes {
        x: normal(0),
        y: normal(1),
        z: normal(2),
    };
    Frame {
        depth: Some(seen.map(|s| s.map_or(0.0, |(_, depth)| depth as f32))),
        ..Frame::of_normals(normals, Mask::new(seen.map(|s| s.is_some())))
    }
}

/// A piece of the barriers: a cap of a ball, or a roof of two slopes.
struct BarrierPiece {
    x: f64,
    y: f64,
    reach: f64,
    depth: f64,
    /// Direction across the ridge of a roof; `None` for a cap.
    across: Option<f64>,
}

impl BarrierPiece {
    /// Normal and depth if it covers (`x`, `y`), rows running down.
    fn at(&self, x: f64, y: f64) -> Option<(DVec3, f64)> {
        let (dx, dy) = (x - self.x, self.y - y);
        if dx.hypot(dy) > self.reach {
            return None;
        }
        match self.across {
            None => {
                let n = ball_at(dx, dy, 1.1 * self.reach)?;
                Some((n, self.depth - 1.1 * self.reach * n.z))
            }
            Some(angle) => {
                let along = dx * angle.cos() + dy * angle.sin();
                let slope = 0.7 * along.signum();
                let n = DVec3::new(slope * angle.cos(), slope * angle.sin(), 1.0).normalize();
                Some((n, self.depth + 0.7 * along.abs()))
            }
        }
    }
}

/// A ground and 90 pieces on it, scattered by irrational steps, each a few per cent of the distance above the next:
/// silhouettes that are faint, half and full.
fn pieces(width: f64, height: f64) -> Vec<BarrierPiece> {
    let ground = BarrierPiece {
        x: 0.5 * width,
        y: 0.5 * height,
        reach: 2.0 * width.hypot(height),
        depth: DISTANCE,
        across: Some(0.4),
    };
    let step = |i: u32, by: f64| (f64::from(i) * by).fract();
    let scattered = (1..=90).map(|i| BarrierPiece {
        x: width * step(i, 0.618_033_988_7),
        y: height * step(i, 0.414_213_562_4),
        reach: height * (0.02 + 0.1 * step(i, 0.732_050_807_6)),
        depth: DISTANCE * (0.9 - 0.7 * step(i, 0.236_067_977_5)),
        across: (i % 3 == 0).then(|| PI * step(i, 0.141_592_653_6)),
    });
    std::iter::once(ground).chain(scattered).collect()
}

/// The angle between two directions, opposites being equal; 90 degrees if one is missing.
pub fn angle_deg(found: DVec2, exact: DVec2) -> f64 {
    if found == DVec2::ZERO {
        return 90.0;
    }
    let (sin, cos) = (found.perp_dot(exact), found.dot(exact));
    sin.abs().atan2(cos.abs()).to_degrees()
}
