//! Both equations of light warping are one integral.

use super::enhancement::{Bounces, Enhancement, ViewWarp};
use super::geometry::Ray;
use super::light::AreaLight;
use super::material::{Glossy, Material, PerLobe};
use super::path::{Direct, Tracing, Vertex, light_along};
use super::sampler::Sampler;
use super::scene::{Scene, SceneBuilder};
use glam::{Mat3, Vec3};
use relievo::light::environment::Environment;

const BATCHES: u32 = 24;
const SAMPLES: u32 = 4096;

/// The mean of independent batches, and its standard error.
pub(crate) fn mean_and_error(batches: &[f64]) -> (f64, f64) {
    let count = batches.len() as f64;
    let mean = batches.iter().sum::<f64>() / count;
    let squares: f64 = batches.iter().map(|b| (b - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0))).sqrt())
}

/// Hessians in units of the warping strength: convex and concave, a ridge, a groove that lies askew, saddles.
const HESSIANS: [[f32; 3]; 6] = [
    [-2.0, 0.0, -2.0],
    [1.5, 0.0, 1.5],
    [-4.0, 0.0, 0.0],
    [1.2, 1.6, 2.1],
    [0.5, -1.5, -0.8],
    [30.0, 0.0, -30.0],
];

/// A glossy ball in the light of `lights`.
fn lit_by(lights: impl FnOnce(SceneBuilder) -> SceneBuilder) -> Scene {
    let glossy = Glossy::new(Vec3::new(0.7, 0.5, 0.3), 12.0, 0.2);
    lights(SceneBuilder::default().sphere(Vec3::ZERO, 1.0, Material::Glossy(glossy))).build()
}

/// Light of three kinds: from all around, brighter above; a lamp in front; and one that grazes the surface at the point
/// seen and sinks below its horizon.
fn scenes() -> [Scene; 3] {
    let sky = Environment::from_fn(64, 32, |x, y| {
        let sun = if (x, y) == (20, 9) { 60.0 } else { 0.0 };
        [
            sun + 0.2 + y as f32 / 40.0,
            sun + 0.6,
            0.9 - y as f32 / 60.0,
        ]
    });
    let lamp = |corner: Vec3, sides: [Vec3; 2]| AreaLight {
        corner,
        sides,
        radiance: Vec3::new(9.0, 7.0, 4.0),
    };
    let front = lamp(
        Vec3::new(-1.0, 3.0, 2.0),
        [Vec3::X, Vec3::new(0.0, -0.6, 0.8)],
    );
    let grazing = lamp(Vec3::new(2.5, -0.4, -0.6), [Vec3::Z * 1.2, Vec3::Y * 1.2]);
    [
        lit_by(|b| b.surroundings(sky)),
        lit_by(|b| b.area_light(front)),
        lit_by(|b| b.area_light(grazing)),
    ]
}

/// The sight line: some 25 degrees off the normal.
const RAY: Ray = Ray {
    origin: Vec3::new(0.3, 0.3, 4.0),
    direction: Vec3::NEG_Z,
};

/// The point looked at, with the warp of this Hessian.
fn vertex(scene: &Scene, hessian: [f32; 3]) -> Vertex<'_> {
    let (point, _) = scene.met(&RAY).expect("the ball is there");
    let mut vertex = Vertex::new(point, &RAY, 0, &Enhancement::default());
    let view_from_world = Mat3::IDENTITY;
    vertex.altered.warp = Some(ViewWarp::new(view_from_world, hessian, 1.0));
    vertex
}

/// Contribution of a sample, all colours together, per lobe.
type Estimate<'a> = &'a dyn Fn(&mut Sampler) -> Option<PerLobe<Vec3>>;

/// Batches of an estimate, per lobe.
fn batches(seed: u32, estimate: Estimate) -> PerLobe<Vec<f64>> {
    let batch = |batch: u32| {
        let mut sum = [0.0_f64; 2];
        for i in 0..SAMPLES {
            let mut sampler = Sampler::new(seed, batch, i);
            if let Some(light) = estimate(&mut sampler) {
                for (sum, light) in sum.iter_mut().zip(light) {
                    *sum += f64::from(light.element_sum());
                }
            }
        }
        sum.map(|sum| sum / f64::from(SAMPLES))
    };
    let batches: Vec<_> = (0..BATCHES).map(batch).collect();
    [0, 1].map(|lobe| batches.iter().map(|b| b[lobe]).collect())
}

/// The difference of two estimates in standard errors of it, and the first of them.
fn difference(a: &[f64], b: &[f64]) -> (f64, f64) {
    let ((a, a_error), (b, b_error)) = (mean_and_error(a), mean_and_error(b));
    ((a - b).abs() / a_error.hypot(b_error), a)
}

#[test]
fn lights_unwarped_and_lookups_warped_agree() {
    let (mut lit, mut told_apart) = (0, 0);
    for (index, scene) in scenes().iter().enumerate() {
        for hessian in HESSIANS {
            let vertex = vertex(scene, hessian);
            // Equation 1: a direction sampled from the material, looked up at its warped one.
            let lookups = batches(1, &|sampler| {
                let bounce = vertex.bounce(sampler)?;
                let ray = vertex.point.leaving(bounce.direction);
                let radiance = match scene.met(&ray) {
                    Some((point, _)) => scene.emitted(&point),
                    None => scene.lights.beyond(&ray),
                };
                Some(bounce.weight.map(|weight| weight * radiance))
            });
            // Equation 2: a light, unwarped, with the Jacobian; and without it.
            let found = |with_jacobian: bool| {
                batches(2, &|sampler| {
                    let found = vertex.find_light(scene, sampler)?;
                    let jacobian = if with_jacobian { found.jacobian } else { 1.0 };
                    Some(found.light.map(|light| light * jacobian))
                })
            };
            let (lights, forgotten) = (found(true), found(false));
            for lobe in 0..2 {
                let (lookups, lights) = (&lookups[lobe], &lights[lobe]);
                // A light that the warp keeps below the horizon is so by both.
                if [lookups, lights]
                    .iter()
                    .all(|b| b.iter().all(|&light| light == 0.0))
                {
                    continue;
                }
                let (off, light) = difference(lookups, lights);
                assert!(
                    off < 3.0,
                    "light {index}, {hessian:?}, lobe {lobe}: {off} of {light}"
                );
                lit += 1;
                told_apart += u32::from(difference(lookups, &forgotten[lobe]).0 > 3.0);
            }
        }
    }
    // The Jacobian is near 1 in places; elsewhere, omitting it must show.
    assert!(lit >= 30, "only {lit} of 36 are lit");
    assert!(
        told_apart * 5 >= lit * 4,
        "without the Jacobian only {told_apart} of {lit} differ"
    );
}

#[test]
fn whole_paths_agree_however_light_is_found() {
    // Warped and scaled at once, by a curvature of 0.4: the weights of both ways add up to one.
    for scene in scenes() {
        let by = |direct, seed| {
            let tracing = Tracing {
                enhancement: Enhancement {
                    warp: Bounces::All,
                    scale: Bounces::All,
                    feature: 0.1,
                    ..Enhancement::default()
                },
                direct,
                max_bounces: 4,
            };
            batches(seed, &|sampler| {
                Some([light_along(&scene, RAY, &tracing, sampler), Vec3::ZERO])
            })
        };
        let both = by(Direct::Both, 5);
        for (other, seed) in [(Direct::Lights, 6), (Direct::Lookups, 7)] {
            let other = by(other, seed);
            let (off, light) = difference(&both[0], &other[0]);
            assert!(off < 3.0 && light > 0.0, "{off} of {light}");
        }
    }
}
