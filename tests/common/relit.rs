//! New light on a small scene: every material and method.

use glam::DVec3;
use relievo::frame::Frame;
use relievo::light::environment::Environment;
use relievo::light::lights::Illumination;
use relievo::params::{Material, Method, RelightParams, SampleCount, ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, Plan};
use relievo::scenes::{ExactScene, Surface};

/// Settings of a test.
#[derive(Clone)]
pub struct Asked {
    pub shape: ShapeParams,
    pub scaling: ScalingParams,
    pub relight: RelightParams,
    pub light: Illumination,
}

impl Asked {
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub fn in_environment(self, environment: Environment, samples: SampleCount) -> Self {
        self.with(|asked| {
            asked.light = Illumination {
                environment: Some(environment.into()),
                ..Illumination::default()
            };
            asked.relight.samples = samples;
        })
    }

    pub fn plan(&self, frame: &Frame) -> relievo::Result<Plan> {
        Plan::new(
            Goal::Relight(self.relight),
            Available::in_frame(frame).lit_by(&self.light),
            self.shape,
            self.scaling,
        )
    }
}

/// Every material that single lights shine on.
pub const LIT: [Material; 6] = [
    Material::Lambert,
    Material::Phong,
    Material::BlinnPhong,
    Material::Toon,
    Material::Sublambert,
    Material::AshikhminShirley,
];

pub const METHODS: [Method; 4] = [Method::Plain, Method::Warp, Method::Scale, Method::Both];

/// Convex, concave and saddle pixels, silhouettes, uncovered corners: for frames of 97x94.
pub fn torus_scene() -> ExactScene {
    let axis = DVec3::new(0.3, 0.2, 0.9);
    ExactScene::orthographic(Surface::torus(30.0, 14.0, axis), 48.2, 47.1)
}

/// The environment of this radiance by direction.
pub fn surroundings(width: usize, radiance: impl Fn([f32; 3]) -> [f32; 3]) -> Environment {
    let blank = Environment::from_fn(width, width / 2, |_, _| [0.0; 3]);
    Environment::from_fn(width, width / 2, |x, y| {
        radiance(blank.direction(x, y).to_array())
    })
}

/// An environment with a bright side, a dark one, and some colour; the bright side falls off with this power.
pub fn sky(falls_off: i32) -> Environment {
    surroundings(64, |[x, y, z]| {
        let glow = (0.5_f32 + 0.5 * (0.6 * x + 0.5 * y + 0.62 * z)).max(0.0);
        let glow = glow.powi(falls_off);
        [
            0.1 + 2.0 * glow,
            0.15 + 1.5 * glow,
            0.3 + glow + 0.2 * y.abs(),
        ]
    })
}
