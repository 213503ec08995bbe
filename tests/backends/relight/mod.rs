//! New light: every material, method and kind of light.

mod lights;
mod materials;
mod surfaces;

use super::{assert_within, outcomes, with_color};
use crate::common::relit::{self, Asked, LIT, METHODS, torus_scene};
use glam::Vec3;
use relievo::engine::gpu::DeviceRunner;
use relievo::engine::{Outcome, PlanInputs};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::light::environment::Environment;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::light::lit_sphere::LitSphere;
use relievo::params::{
    AlbedoSource, Material, Method, RelightParams, Scale, ScalingParams, ShapeParams, Tangent,
};
use relievo::product::Product;
use std::f64::consts::PI;

impl Asked {
    /// Lights from six sides on white.
    fn of(material: Material, method: Method) -> Self {
        let mut relight = RelightParams {
            method,
            albedo: AlbedoSource::White,
            ..RelightParams::default()
        };
        relight.material.material = material;
        relight.material.tangent = Tangent::Degrees(25.0);
        relight.material.coat = [30.0, 90.0];
        Self {
            shape: ShapeParams {
                scale: Scale::Iterations(4),
                ..ShapeParams::default()
            },
            scaling: ScalingParams {
                scaling_diffuse: Some(1.5),
                scaling_specular: Some(0.7),
                ..ScalingParams::default()
            },
            relight,
            light: six_lights(),
        }
    }

    #[track_caller]
    fn assert_same(&self, name: &str, runner: &DeviceRunner, frame: &Frame) {
        let plan = self.plan(frame).unwrap();
        assert_eq!(DeviceRunner::lacks(&plan), None, "{name}");
        let [found, expected] = self.outcomes(runner, frame);
        let allowed = self.tolerance();
        assert_within(name, &found, &expected, |product| {
            (product == Product::Picture).then_some(allowed)
        });
    }

    #[track_caller]
    fn outcomes(&self, runner: &DeviceRunner, frame: &Frame) -> [Outcome; 2] {
        let inputs = PlanInputs::lit_by(&self.light);
        outcomes(runner, &self.plan(frame).unwrap(), frame, inputs)
    }

    /// The largest difference between backends, relative to the largest value: that of [`Product::Picture`], except for
    /// light that amplifies rounding. A lobe with exponent p multiplies the error of its cosine by p at its peak; one with
    /// an exponent below 1 raises, next to the terminator, the rounding error itself to that power. A picture is sampled a
    /// fraction of a pixel off, which counts where neighbours differ. The step between two tones is 1.5 over its softness
    /// times as steep as its input; a hard step may move a pixel to the next tone.
    fn tolerance(&self) -> f64 {
        let material = &self.relight.material;
        let largest = |exponent: f32| f64::from(exponent) * COSINE_ERROR;
        let lobe = match material.material {
            Material::Phong | Material::BlinnPhong => largest(material.shininess),
            Material::AshikhminShirley => largest(material.coat[0].max(material.coat[1])),
            Material::Sublambert => COSINE_ERROR.powf(material.flatness.into()),
            Material::Lambert | Material::Toon | Material::Mirror | Material::Glass => 0.0,
        };
        let seen = match &self.light.environment {
            Some(map) if material.material.shows_surroundings() => {
                let [width, height] = [map.width(), map.height()].map(|n| n as f64);
                (width / 2.0 + height) * ANGLE_ERROR / PI
            }
            _ => 0.0,
        };
        let spheres = self.light.lit_spheres.iter();
        let pixels = spheres.map(|sphere| sphere.size().iter().sum::<usize>() as f64);
        let painted = pixels.fold(0.0, f64::max) * COSINE_ERROR;
        let least = Product::Picture.tolerance();
        let smooth = least.max(lobe).max(seen).max(painted);
        let softness = self.relight.tones().map(|tones| f64::from(tones.softness));
        match softness {
            Some(softness) if softness > 0.0 => smooth * (1.5 / softness).max(1.0),
            Some(_) => 1.0,
            None => smooth,
        }
    }
}

/// Error of a dot product of unit vectors: two roundings of each half, on either side.
const COSINE_ERROR: f64 = 1.0 / (1 << 22) as f64;

/// Error of an angle, in radians: that of the arc tangent plus that of its direction.
const ANGLE_ERROR: f64 = 4e-7 + COSINE_ERROR;

fn six_lights() -> Illumination {
    let from = [
        [-0.6, 0.6, 0.53],
        [0.9, 0.1, 0.2],
        [0.0, 0.0, 1.0],
        [0.3, -0.8, -0.3],
        [0.1, 0.2, -0.97],
        [-0.4, -0.5, 0.7],
    ];
    let lights = from.into_iter().enumerate();
    let lights = lights.map(|(i, direction)| DirectionalLight {
        to_light: Vec3::from_array(direction).normalize(),
        intensity: [0.4, 0.3 + 0.1 * i as f32, 0.9 - 0.1 * i as f32],
    });
    Illumination {
        directional: lights.collect(),
        ..Illumination::default()
    }
}

fn sky() -> Environment {
    relit::sky(3).rotated_deg(33.0)
}

fn ball(bright: f32) -> LitSphere {
    let plane = |k: f32| {
        Plane::from_fn(61, 47, |x, y| {
            bright * (1.0 + (0.09 * k * x as f32).sin() * (0.08 * y as f32).cos())
        })
    };
    let [r, g, b] = [1.0, 1.4, 0.7].map(plane);
    LitSphere::new(ColorPlanes { r, g, b })
}

/// Convex, concave and saddle pixels, silhouettes, uncovered corners; with a picture.
fn torus() -> Frame {
    with_color(torus_scene().frame(97, 94))
}

/// The same seen by an eye close by.
fn torus_from_near() -> Frame {
    with_color(torus_scene().in_perspective().frame(97, 94))
}

/// Partly covered pixels, albedo, and light that does not reach every corner.
fn with_layers(mut frame: Frame) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let plane = |k: f32| {
        Plane::from_fn(width, height, |x, y| {
            0.5 + 0.4 * (0.3 * k * x as f32).sin() * (0.2 * y as f32).cos()
        })
    };
    frame.alpha = Some(Plane::from_fn(width, height, |x, y| {
        match (frame.mask.at(x, y), (x + y) % 5) {
            (true, 0) => 0.0,
            (true, k) => 0.2 * k as f32,
            (false, 1) => 0.25,
            (false, _) => 0.0,
        }
    }));
    let [r, g, b] = [1.0, 1.3, 0.6].map(plane);
    frame.albedo = Some(ColorPlanes { r, g, b });
    frame.light.occlusion = Some(plane(0.8));
    frame
}
