//! New light: against a reference in double precision that follows the papers sample by sample, closed forms, and
//! invariances.

mod alignment;
mod closed_forms;
mod environments;
mod invariances;
mod nothing_asked;
mod raking;
mod shadows;
mod sums;

use crate::common::relit::{self, Asked, LIT, METHODS, surroundings, torus_scene};
use crate::prelude::*;

impl Asked {
    /// Light of 1 from 30 degrees above the upper left, on white.
    fn of(material: Material, method: Method) -> Self {
        Self {
            shape: default_but(|shape: &mut ShapeParams| shape.scale = Scale::Iterations(4)),
            scaling: default_but(|s: &mut ScalingParams| s.curvature_gain = Adaptive::Fixed(12.0)),
            // With gains of 1 and no ambient light a formula gives the picture.
            relight: default_but(|relight: &mut RelightParams| {
                (relight.method, relight.albedo) = (method, AlbedoSource::White);
                relight.environment_gain = Adaptive::Fixed(1.0);
                let own = &mut relight.material;
                (own.material, own.ambient) = (material, 0.0);
                (own.diffuse_gain, own.specular_gain) = (1.0, Some(1.0));
            }),
            light: lights(&[Vec3::new(-0.6, 0.6, 0.53)]),
        }
    }

    fn outcome(&self, frame: &Frame) -> Outcome {
        let plan = self.plan(frame).unwrap();
        cpu::execute(&plan, frame, PlanInputs::lit_by(&self.light)).unwrap()
    }

    fn color(&self, frame: &Frame) -> ColorPlanes {
        self.outcome(frame).color.expect("light makes a picture")
    }
}

/// Lights of 1 from these directions.
fn lights(directions: &[Vec3]) -> Illumination {
    let directional = directions.iter().map(|direction| DirectionalLight {
        to_light: direction.normalize(),
        intensity: [1.0; 3],
    });
    default_but(|light: &mut Illumination| light.directional = directional.collect())
}

fn torus() -> Frame {
    torus_scene().frame(97, 94)
}

/// The same seen by an eye close by.
fn torus_in_perspective() -> Frame {
    torus_scene().in_perspective().frame(97, 94)
}

/// A frame of these normals, of any length, and nothing else.
fn facing(width: usize, height: usize, mut normal: impl FnMut(usize, usize) -> Vec3) -> Frame {
    let normals = places(width, height).flat_map(|(x, y)| normal(x, y).normalize().to_array());
    let normals: Vec<f32> = normals.collect();
    let frame = Frame::builder(width, height).normals(Normals::view(&normals));
    frame.build().unwrap()
}

fn sky() -> Environment {
    relit::sky(4)
}

/// The largest difference of two pictures.
fn difference(a: &ColorPlanes, b: &ColorPlanes) -> f32 {
    let pairs = channels(a).into_iter().zip(channels(b));
    pairs.map(|(a, b)| apart(a, b)).fold(0.0, f32::max)
}

fn bits(color: &ColorPlanes) -> Vec<u32> {
    channels(color).map(crate::common::bits).concat()
}
