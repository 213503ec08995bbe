//! New light: against a reference in double precision that follows the papers sample by sample, closed
//! forms, and what must change nothing.

mod closed_forms;
mod invariances;
mod nothing_asked;
mod sums;

use glam::{DVec3, Vec3};
use relievo::backend::cpu::{Outcome, Runner};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::light::environment::Environment;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::params::{
    Adaptive, Material, Method, RelightParams, Samples, Scale, ScalingParams, ShapeParams,
};
use relievo::plan::{Available, LightKinds, Plan};
use relievo::report::light::bare;
use relievo::report::scenes::{ExactScene, Surface};

/// What a test asks for; the rest is as it comes.
#[derive(Clone)]
struct Asked {
    shape: ShapeParams,
    scaling: ScalingParams,
    relight: RelightParams,
    light: Illumination,
}

impl Asked {
    /// Light of 1 from 30 degrees above the upper left, on white.
    fn of(material: Material, method: Method) -> Self {
        Self {
            shape: ShapeParams {
                scale: Scale::Iterations(4),
                ..ShapeParams::default()
            },
            scaling: ScalingParams {
                curvature_gain: Adaptive::Fixed(12.0),
                ..ScalingParams::default()
            },
            relight: bare(material, method),
            light: lights(&[Vec3::new(-0.6, 0.6, 0.53)]),
        }
    }

    fn plan(&self, frame: &Frame) -> relievo::Result<Plan> {
        Plan::relight(
            Available::in_frame(frame),
            self.shape,
            self.scaling,
            self.relight,
            LightKinds::in_light(&self.light),
        )
    }

    fn outcome(&self, frame: &Frame) -> Outcome {
        let plan = self.plan(frame).unwrap();
        Runner::default().relight(&plan, frame, &self.light)
    }

    fn color(&self, frame: &Frame) -> ColorPlanes {
        self.outcome(frame).color.expect("light makes a picture")
    }

    fn in_environment(mut self, environment: Environment, samples: Samples) -> Self {
        self.light = Illumination {
            environment: Some(environment.into()),
            ..Illumination::default()
        };
        self.relight.samples = samples;
        self
    }
}

/// Lights of 1 from these directions.
fn lights(directions: &[Vec3]) -> Illumination {
    let directional = directions.iter().map(|direction| DirectionalLight {
        to_light: direction.normalize(),
        intensity: [1.0; 3],
    });
    Illumination {
        directional: directional.collect(),
        ..Illumination::default()
    }
}

/// A wavy torus-like set of shapes: convex, concave and saddle pixels, silhouettes, uncovered corners.
fn torus() -> Frame {
    let axis = DVec3::new(0.3, 0.2, 0.9);
    ExactScene::orthographic(Surface::torus(30.0, 14.0, axis), 48.2, 47.1).frame(97, 94)
}

/// The same seen by an eye close by.
fn torus_in_perspective() -> Frame {
    let axis = DVec3::new(0.3, 0.2, 0.9);
    ExactScene::orthographic(Surface::torus(30.0, 14.0, axis), 48.2, 47.1)
        .in_perspective()
        .frame(97, 94)
}

/// Every material that single lights shine on.
const LIT: [Material; 6] = [
    Material::Lambert,
    Material::Phong,
    Material::BlinnPhong,
    Material::Toon,
    Material::Sublambert,
    Material::AshikhminShirley,
];

const METHODS: [Method; 4] = [Method::Plain, Method::Warp, Method::Scale, Method::Both];

/// The environment of this radiance by direction.
fn surroundings(width: usize, radiance: impl Fn([f32; 3]) -> [f32; 3]) -> Environment {
    let blank = Environment::from_fn(width, width / 2, |_, _| [0.0; 3]);
    Environment::from_fn(width, width / 2, |x, y| {
        radiance(blank.direction(x, y).to_array())
    })
}

/// An environment with a bright side, a dark one, and some colour.
fn sky() -> Environment {
    surroundings(64, |[x, y, z]| {
        let glow = (0.5_f32 + 0.5 * (0.6 * x + 0.5 * y + 0.62 * z))
            .max(0.0)
            .powi(4);
        [
            0.1 + 2.0 * glow,
            0.15 + 1.5 * glow,
            0.3 + glow + 0.2 * y.abs(),
        ]
    })
}

fn covered(frame: &Frame) -> impl Iterator<Item = (usize, usize)> + '_ {
    let mask = &frame.mask;
    (0..mask.height())
        .flat_map(|y| (0..mask.width()).map(move |x| (x, y)))
        .filter(|&(x, y)| mask.at(x, y))
}

fn bits(color: &ColorPlanes) -> Vec<u32> {
    let planes: [&Plane; 3] = [&color.r, &color.g, &color.b];
    let samples = planes.into_iter().flat_map(|plane| plane.samples());
    samples.map(|v| v.to_bits()).collect()
}
