//! Energy is conserved where light is not altered; altered light keeps shadows in place.

use super::enhancement::{Bounces, Enhancement};
use super::geometry::Ray;
use super::light::AreaLight;
use super::material::{Glossy, Material};
use super::mesh::Mesh;
use super::path::{Direct, Tracing, light_along};
use super::render::{Camera, Job};
use super::sampler::Sampler;
use super::scene::{Scene, SceneBuilder};
use super::warp_tests::mean_and_error;
use glam::Vec3;
use relievo::light::environment::Environment;

const WAYS: [Direct; 3] = [Direct::Both, Direct::Lights, Direct::Lookups];

fn tracing(direct: Direct, max_bounces: usize) -> Tracing {
    Tracing {
        direct,
        max_bounces,
        ..Tracing::default()
    }
}

/// Light of 1 from everywhere.
fn white() -> Environment {
    Environment::from_fn(4, 2, |_, _| [1.0; 3])
}

/// Mean of red along a ray, and its standard error by 16 independent batches.
fn mean(scene: &Scene, ray: Ray, tracing: &Tracing, samples: u32) -> (f64, f64) {
    let batch = |seed| {
        let light = (0..samples).map(|i| {
            let mut sampler = Sampler::new(seed, 0, i);
            f64::from(light_along(scene, ray, tracing, &mut sampler).x)
        });
        light.sum::<f64>() / f64::from(samples)
    };
    mean_and_error(&(0..16).map(batch).collect::<Vec<_>>())
}

#[test]
fn a_white_ball_vanishes_in_a_furnace() {
    // The light that a white Lambertian surface reflects of 1 from everywhere is the integral of cos/pi: 1. A
    // convex one sees nothing of itself, so every pixel is 1, on the ball as beside it.
    let scene = SceneBuilder::default()
        .sphere(Vec3::ZERO, 1.0, Material::Matte(Vec3::ONE))
        .surroundings(white())
        .build();
    for direct in WAYS {
        let job = Job {
            scene: &scene,
            camera: Camera::new(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 40.0, [24, 24]),
            tracing: tracing(direct, 4),
            samples: 4096,
            seed: 3,
        };
        // By lookups each path contributes exactly 1. By lights, evenly over the sphere, one contributes 4 cos above
        // and 0 below: its variance is 16/6 - 1, so that of 4096 independent ones sqrt(5/3/4096) = 0.02. Both together
        // vary less. The worst of 576 pixels may be 4 of these errors off, their mean 3 over 24.
        let error = if direct == Direct::Lookups {
            1e-5
        } else {
            0.0202
        };
        let light: Vec<f32> = job.pixels().iter().map(|light| light.x).collect();
        let worst = light.iter().map(|l| (l - 1.0).abs()).fold(0.0, f32::max);
        let mean = light.iter().sum::<f32>() / light.len() as f32;
        assert!(worst < 4.0 * error, "{direct:?}: {worst}");
        assert!(
            (mean - 1.0).abs() < 3.0 * error / 24.0 + 1e-5,
            "{direct:?}: {mean}"
        );
    }
}

#[test]
fn a_coat_never_reflects_more_than_came() {
    // In the furnace: the diffuse base gets the light left by the coat, and both together lose some.
    for (exponent, reflectance) in [(1.0, 0.3), (20.0, 0.05), (200.0, 0.3), (2000.0, 0.9)] {
        let glossy = Glossy::new(Vec3::ONE, exponent, reflectance);
        let scene = SceneBuilder::default()
            .sphere(Vec3::ZERO, 1.0, Material::Glossy(glossy))
            .surroundings(white())
            .build();
        for x in [0.0, 0.5, 0.8, 0.95, 0.99] {
            let ray = Ray {
                origin: Vec3::new(x, 0.0, 3.0),
                direction: Vec3::NEG_Z,
            };
            for direct in WAYS {
                let (light, error) = mean(&scene, ray, &tracing(direct, 4), 512);
                // Lights alone hardly meet the narrowest lobe: their error is large there.
                let (least, most) = (light - 3.0 * error, light + 3.0 * error);
                let case = (exponent, reflectance, x, direct);
                assert!(least < 1.0 && most > 0.2, "{case:?}: {light}");
            }
        }
    }
}

/// Six rectangles around the origin that face inward.
fn closed_box(material: Material, emission: Vec3) -> Scene {
    let mut builder = SceneBuilder::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for out in [axis, -axis] {
            let a = 2.0 * axis.any_orthonormal_vector();
            let b = 2.0 * (-out).cross(a).normalize();
            let side = Mesh::rectangle(out - 0.5 * (a + b), [a, b]);
            builder = builder.mesh(side, material).shining(emission);
        }
    }
    builder.build()
}

#[test]
fn a_closed_emitter_has_the_radiance_of_the_series() {
    // L = E + rho L at every point and in every direction, as light of L from everywhere is reflected as rho L: L = E /
    // (1 - rho). Paths end only by chance: after 200 surfaces rho^200 is negligible.
    for rho in [0.2, 0.5, 0.8] {
        let (material, emission) = (Material::Matte(Vec3::splat(rho)), Vec3::splat(0.7));
        let ball = SceneBuilder::default()
            .sphere(Vec3::ZERO, 1.0, material)
            .shining(emission)
            .build();
        for scene in [ball, closed_box(material, emission)] {
            let ray = Ray {
                origin: Vec3::new(0.1, 0.2, -0.3),
                direction: Vec3::new(0.3, -0.5, 0.8).normalize(),
            };
            let (light, error) = mean(&scene, ray, &tracing(Direct::Both, 200), 2048);
            let expected = 0.7 / (1.0 - f64::from(rho));
            assert!(
                (light - expected).abs() < 3.0 * error.max(1e-5),
                "{light}, not {expected}"
            );
            assert!(error < 0.02 * expected, "{error}");
        }
    }
}

/// A bumpy ball over a floor, under an area light.
fn under_a_lamp() -> Scene {
    let points = (0..=60).flat_map(|row| {
        (0..120).map(move |column| {
            let [polar, around] =
                [row as f32 / 60.0, column as f32 / 60.0].map(|t| t * std::f32::consts::PI);
            let radius = 0.8 + 0.04 * (9.0 * around).cos() * polar.sin() * (12.0 * polar).sin();
            let (sin, cos) = polar.sin_cos();
            Vec3::Y + radius * Vec3::new(sin * around.cos(), cos, sin * around.sin())
        })
    });
    SceneBuilder::default()
        .mesh(
            Mesh::grid(points.collect(), 120, true),
            Material::Matte(Vec3::splat(0.8)),
        )
        .mesh(
            Mesh::rectangle(Vec3::new(-4.0, 0.0, 4.0), [8.0 * Vec3::X, -8.0 * Vec3::Z]),
            Material::Matte(Vec3::splat(0.6)),
        )
        .area_light(AreaLight {
            corner: Vec3::new(-3.0, 3.0, 0.0),
            sides: [Vec3::X, Vec3::Z],
            radiance: Vec3::splat(10.0),
        })
        .build()
}

#[test]
fn scaling_leaves_soft_shadows_their_shape() {
    // [RS] figure 11. Each light sample is scaled separately, with unchanged visibility. So the floor, which is flat,
    // keeps every bit; and on the ball unlit parts stay black, and lit parts stay lit.
    let scene = under_a_lamp();
    let direct = |scale| {
        let enhancement = Enhancement {
            scale,
            feature: 0.1,
            ..Enhancement::default()
        };
        let job = Job {
            scene: &scene,
            camera: Camera::new(
                Vec3::new(0.0, 2.0, 6.0),
                Vec3::new(0.0, 0.6, 0.0),
                35.0,
                [64, 48],
            ),
            tracing: Tracing {
                enhancement,
                ..tracing(Direct::Both, 1)
            },
            samples: 16,
            seed: 1,
        };
        let [width, height] = job.camera.size;
        let on_floor = (0..width * height).map(|i| {
            let middle = [i % width, i / width].map(|at| at as f32 + 0.5);
            let met = scene.met(&job.camera.ray(middle));
            met.is_some_and(|(point, _)| point.normal.y == 1.0)
        });
        job.pixels().into_iter().zip(on_floor).collect::<Vec<_>>()
    };
    let (plain, scaled) = (direct(Bounces::None), direct(Bounces::First));
    let (mut floor, mut penumbra, mut changed) = (0, 0, 0);
    for ((plain, is_floor), (scaled, _)) in plain.iter().zip(&scaled) {
        assert_eq!(*plain == Vec3::ZERO, *scaled == Vec3::ZERO);
        changed += u32::from(plain != scaled);
        if *is_floor && plain == scaled {
            floor += 1;
            penumbra += u32::from(plain.x > 0.0 && plain.x < 0.2);
        }
    }
    let all_floor = plain.iter().filter(|(_, is_floor)| *is_floor).count();
    // Pixels at the rim of the ball show both.
    assert!(floor > all_floor * 97 / 100, "{floor} of {all_floor}");
    assert!(penumbra > 20 && changed > 150, "{penumbra} {changed}");
}
