//! Small scenes with known answers: those measured by the report, and the analytic surfaces they are made of.
//!
//! All measured scenes are orthographic, one unit per pixel. A closed form of the curvature after diffusion, where
//! there is one, gives the error of the whole method, including the grid, as a yardstick for the error of a solver.

pub(crate) mod environment;
pub mod exact;
pub mod frames;
pub mod surfaces;

pub use environment::environment;
pub use exact::{Exact, ExactScene, ball_trace};
pub use surfaces::Surface;

use crate::frame::{Frame, Mask, Plane, Vector3Planes};
use crate::params::ShapeParams;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// A scene with its known answers.
pub struct Scene {
    /// Its name, also used for files.
    pub name: &'static str,
    /// Description, in a sentence.
    pub about: &'static str,
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

/// Wave number per pixel of [`Scene::waves`]: 64 pixels long.
pub const WAVE: f64 = 2.0 * PI / 64.0;
/// Height of [`Scene::waves`] in pixels: slopes up to 1/2.
pub const HEIGHT: f64 = 5.0;
/// Distance of the scenes from the eye.
const DISTANCE: f64 = 2000.0;

impl Scene {
    /// The parameters for finding its shape, except for the scale.
    pub(super) fn shape(&self, tolerance: f32) -> ShapeParams {
        ShapeParams {
            foreshortening: self.foreshortening,
            tolerance,
            ..ShapeParams::default()
        }
    }

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
            DVec3::new(HEIGHT * WAVE * sx * cy, -HEIGHT * WAVE * cx * sy, 1.0).normalize()
        };
        Self {
            name: "waves",
            about: "waves of 64 pixels, 5 high, no edges",
            frame: frame(width, height, |x, y| Some((normal(x, y), DISTANCE))),
            foreshortening: 1.0,
            truth: Truth::Waves,
        }
    }

    /// A plane facing the viewer, the whole picture covered.
    pub fn plane(width: usize, height: usize) -> Self {
        Self {
            name: "plane",
            about: "a plane that faces the viewer",
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
            about: "a ball on nothing",
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
            about: "a tilted ellipsoid of half axes 1, 0.7 and 0.5",
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
            about: "overlapping caps and roofs: steps and creases everywhere, conductance from 0 to 1",
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

    /// A strip across the rim of a ball with a radius of 4000 pixels: columns of every n_z from 0 to 0.67.
    pub fn rim() -> Self {
        let ball = ExactScene::orthographic(Surface::ball(RIM_RADIUS), RIM_RADIUS + 4.0, 16.5);
        Self {
            name: "rim",
            about: "a strip across the rim of a ball of 4000 pixels radius",
            frame: bare(&ball.at_distance(40.0 * DISTANCE), 1024, 33),
            foreshortening: 1.0,
            truth: Truth::Ball { radius: RIM_RADIUS },
        }
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
                let decay = (-2.0 * WAVE * WAVE * time).exp();
                Some(-2.0 * HEIGHT * WAVE * WAVE * decay * wave_at(x).1 * wave_at(y).1)
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

/// Radius of the ball of [`Scene::rim`].
pub(crate) const RIM_RADIUS: f64 = 4000.0;

/// Sine and cosine of a wave at the centre of pixel `i`.
fn wave_at(i: usize) -> (f64, f64) {
    (WAVE * (i as f64 + 0.5)).sin_cos()
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
struct Piece {
    x: f64,
    y: f64,
    reach: f64,
    depth: f64,
    /// Direction across the ridge of a roof; `None` for a cap.
    across: Option<f64>,
}

impl Piece {
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
fn pieces(width: f64, height: f64) -> Vec<Piece> {
    let ground = Piece {
        x: 0.5 * width,
        y: 0.5 * height,
        reach: 2.0 * width.hypot(height),
        depth: DISTANCE,
        across: Some(0.4),
    };
    let step = |i: u32, by: f64| (f64::from(i) * by).fract();
    let scattered = (1..=90).map(|i| Piece {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_traces_of_a_ball() {
        // Expected from the closed form at n_z .5 and .1, f = 0: 2 / R; f = 1: 10 / R and 1010 / R.
        for (nz, f, times) in [
            (0.5, 0.0, 2.0),
            (0.1, 0.0, 2.0),
            (0.5, 1.0, 10.0),
            (0.1, 1.0, 1010.0),
        ] {
            assert!(
                (ball_trace(50.0, nz, f) * 50.0 / -times - 1.0).abs() < 1e-12,
                "{nz} {f}"
            );
        }
    }

    #[test]
    fn normals_turn_along_the_ellipsoid_s_directions() {
        // Along a line of curvature the normal turns by the curvature, along the line itself (Rodrigues); by central
        // differences over a hundredth of a pixel.
        let scene = Scene::ellipsoid(120, 100);
        let Truth::Ellipsoid(exact) = &scene.truth else {
            panic!("no ellipsoid");
        };
        let mut checked = 0;
        for (x, y) in (0..120).flat_map(|x| (0..100).map(move |y| (x, y))) {
            let Some(direction) = scene.exact_direction(x, y) else {
                continue;
            };
            let at = DVec2::new(x as f64, y as f64) + 0.5;
            let [ahead, behind] = [0.01, -0.01].map(|by| {
                let to = at + by * DVec2::new(direction.x, -direction.y);
                exact.exact_at(to.x, to.y).unwrap()
            });
            let turned = ahead.normal - behind.normal;
            let angle = turned.angle_between(ahead.point - behind.point);
            assert!(angle < 1e-4, "{x} {y}: {angle}");
            let normal = &scene.frame.normal;
            assert!(normal.z.at(x, y) > 0.35);
            checked += 1;
        }
        assert!(checked > 2000, "{checked}");
    }

    #[test]
    fn normals_are_those_of_the_depth() {
        // The slope of the depth by central differences, away from edges: grad h = -grad depth.
        for scene in [
            Scene::ball(120, 100),
            Scene::barriers(120, 100),
            Scene::rim(),
        ] {
            let Frame {
                normal,
                depth,
                mask,
                ..
            } = &scene.frame;
            let depth = depth.as_ref().unwrap();
            let mut checked = 0;
            for (x, y) in (2..118).flat_map(|x| (2..31).map(move |y| (x, y))) {
                let covered = (0..9).all(|i| mask.at(x + i % 3 - 1, y + i / 3 - 1));
                let n = |p: &Plane| f64::from(p.at(x, y));
                let slope = [-n(&normal.x) / n(&normal.z), -n(&normal.y) / n(&normal.z)];
                let d = |x, y| f64::from(depth.at(x, y));
                let found = [
                    0.5 * (d(x - 1, y) - d(x + 1, y)),
                    0.5 * (d(x, y + 1) - d(x, y - 1)),
                ];
                let bent = (d(x - 1, y) + d(x + 1, y) - 2.0 * d(x, y))
                    .abs()
                    .max((d(x, y - 1) + d(x, y + 1) - 2.0 * d(x, y)).abs());
                if covered && bent < 0.1 && slope[0].hypot(slope[1]) < 1.0 {
                    assert!(
                        (0..2).all(|i| (found[i] - slope[i]).abs() < 0.05),
                        "{} {x} {y}: {found:?} {slope:?}",
                        scene.name
                    );
                    checked += 1;
                }
            }
            // All of the strip is steeper than 1 in its first 118 columns.
            assert!(
                checked > 300 || scene.name == "rim",
                "{}: {checked}",
                scene.name
            );
        }
    }

    #[test]
    fn waves_have_the_gradient_of_their_height() {
        let scene = Scene::waves(64, 64);
        let normal = &scene.frame.normal;
        let height = |x: f64, y: f64| HEIGHT * (WAVE * (x + 0.5)).cos() * (WAVE * (y + 0.5)).cos();
        for (x, y) in (0..64).flat_map(|x| (0..64).map(move |y| (x, y))) {
            let (px, py) = (x as f64, y as f64);
            let slope = [
                (height(px + 1e-3, py) - height(px - 1e-3, py)) / 2e-3,
                (height(px, py - 1e-3) - height(px, py + 1e-3)) / 2e-3,
            ];
            let z = f64::from(normal.z.at(x, y));
            let found = [&normal.x, &normal.y].map(|p| -f64::from(p.at(x, y)) / z);
            assert!(
                (0..2).all(|i| (found[i] - slope[i]).abs() < 1e-6),
                "{x} {y}"
            );
        }
    }

    #[test]
    fn barriers_are_of_every_strength() {
        use crate::engine::cpu;
        use crate::params::ScalingParams;
        use crate::plan::{Available, Goal, Plan};
        let frame = Scene::barriers(320, 240).frame;
        let plan = Plan::new(
            Goal::Layers,
            Available::in_frame(&frame),
            ShapeParams::default(),
            ScalingParams::default(),
        )
        .unwrap();
        let c = cpu::run(&plan, &frame).unwrap().shape.conductance.unwrap();
        let count = |from: f32, to: f32| {
            c.samples()
                .iter()
                .filter(|&&c| from <= c && c <= to)
                .count()
        };
        println!(
            "closed {}, between {}, open {}",
            count(0.0, 0.0),
            count(0.01, 0.99),
            count(1.0, 1.0)
        );
        assert!(count(0.0, 0.0) > 1000 && count(0.01, 0.99) > 300 && count(1.0, 1.0) > 30_000);
        let jumps = (0..240)
            .flat_map(|y| c.row(y).windows(2))
            .filter(|w| w[0] == 1.0 && w[1] == 0.0);
        assert!(jumps.count() > 100);
    }
}
