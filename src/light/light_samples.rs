//! Directions that sample continuous light: the whole sphere, or the disc of an area light.

use super::environment::Environment;
use super::lights::DirectionalLight;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::PI;

/// The golden angle: a full turn over the square of the golden ratio.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// `n` unit directions spread evenly over the sphere, each representing 4 pi / n steradians.
///
/// The spherical Fibonacci lattice: heights in even steps, azimuths a golden angle apart.
pub fn uniform_directions(n: usize) -> Vec<Vec3> {
    spiral(PI, n).map(DVec3::as_vec3).collect()
}

/// The environment as `n` lights, one for each of the [`uniform_directions`] except black ones: dense sampling of the
/// rendering equation.
///
/// Every pixel's power goes to its nearest direction, so that intensities add up to the power over pi, and a sun
/// between directions counts in full.
pub fn uniform_lights(environment: &Environment, n: usize) -> Vec<DirectionalLight> {
    let directions = uniform_directions(n);
    if n == 0 {
        return Vec::new();
    }
    // About 6 pixels per direction.
    let map = environment.resized((2.0 * (PI * n as f64).sqrt()).ceil() as usize);
    let mut power = vec![[0.0_f64; 3]; n];
    for y in 0..map.height() {
        let share = map.solid_angle(y) / PI;
        for x in 0..map.width() {
            let nearest = nearest(&directions, map.direction(x, y));
            for (power, radiance) in power[nearest].iter_mut().zip(map.pixel(x, y)) {
                *power += share * f64::from(radiance);
            }
        }
    }
    let lights = directions.into_iter().zip(power);
    lights
        .filter(|(_, power)| power.iter().any(|&p| p > 0.0))
        .map(|(to_light, power)| DirectionalLight {
            to_light,
            intensity: power.map(|p| p as f32),
        })
        .collect()
}

/// The index of the lattice direction nearest to `d`.
fn nearest(directions: &[Vec3], d: Vec3) -> usize {
    // Heights are sorted, 2/n apart. A cell has the area of a disc of radius 2/sqrt(n), and its corners lie within 1.5
    // times that radius: heights differ by less than 3/sqrt(n).
    let n = directions.len();
    let level = (1.0 - d.z) / 2.0 * n as f32;
    let reach = 1.5 * (n as f32).sqrt() + 1.0;
    let first = ((level - reach).max(0.0) as usize).min(n - 1);
    let end = ((level + reach) as usize + 1).min(n);
    let mut best = (first, f32::NEG_INFINITY);
    for (i, direction) in directions[first..end].iter().enumerate() {
        let cosine = direction.dot(d);
        if cosine > best.1 {
            best = (first + i, cosine);
        }
    }
    best.0
}

/// `n` unit directions spread evenly over the disc within `angular_radius` radians (0..pi) of `to_light`, each
/// representing the same solid angle: one n-th of 2 pi (1 - cos `angular_radius`).
///
/// Vogel's spiral, rotated so that its mean direction is exactly `to_light`, as for the disc. A NaN radius counts as 0,
/// and a zero `to_light` as +z.
pub fn light_disc(to_light: Vec3, angular_radius: f32, n: usize) -> Vec<Vec3> {
    let to_light = to_light.as_dvec3().try_normalize().unwrap_or(DVec3::Z);
    let radius = f64::from(angular_radius.max(0.0)).min(PI);
    let directions: Vec<DVec3> = spiral(radius, n).collect();
    let mean = directions.iter().sum::<DVec3>();
    // A whole sphere has no mean direction, and needs no rotation.
    let mean = match mean.length() > 1e-3 * n as f64 {
        true => mean.normalize(),
        false => DVec3::Z,
    };
    let turn =
        DQuat::from_rotation_arc(DVec3::Z, to_light) * DQuat::from_rotation_arc(mean, DVec3::Z);
    let turned = directions.into_iter().map(|d| (turn * d).normalize());
    turned.map(DVec3::as_vec3).collect()
}

/// Directions within `radius` of +z, with heights in even steps: zones of equal height have equal solid angle.
fn spiral(radius: f64, n: usize) -> impl Iterator<Item = DVec3> {
    let depth = 1.0 - radius.cos();
    (0..n).map(move |i| {
        let z = 1.0 - depth * (i as f64 + 0.5) / n as f64;
        let across = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = (GOLDEN_ANGLE * i as f64).sin_cos();
        DVec3::new(across * cos, across * sin, z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattice_integrates_cosines() {
        for n in [64, 1024, 16384] {
            let directions = uniform_directions(n);
            assert_eq!(directions.len(), n);
            let mean = directions.iter().map(|d| d.as_dvec3()).sum::<DVec3>() / n as f64;
            // Twice the share of one direction in the sphere.
            assert!(mean.length() < 2.0 / n as f64, "{n}: {mean}");
            for normal in [DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Y] {
                // The integral of max(n.l, 0) / pi over the sphere is 1.
                let cosines = directions.iter().map(|d| d.as_dvec3().dot(normal).max(0.0));
                let integral = cosines.sum::<f64>() * 4.0 / n as f64;
                assert!((integral - 1.0).abs() < 2.0 / n as f64, "{n}: {integral}");
            }
        }
        assert!(uniform_directions(0).is_empty());
        assert!((uniform_directions(1)[0] - Vec3::X).length() < 1e-6);
    }

    #[test]
    fn uniform_lights_keep_power() {
        // One pixel of 256x128 shines, over a dim sky: most directions miss it.
        let map = Environment::from_fn(256, 128, |x, y| match (x, y) {
            (100, 60) => [1e4, 0.0, 1.0],
            _ => [0.01; 3],
        });
        for n in [1, 2, 64, 256, 4096] {
            let lights = uniform_lights(&map, n);
            for (c, power) in map.power().into_iter().enumerate() {
                let sum: f64 = lights.iter().map(|l| f64::from(l.intensity[c])).sum();
                assert!((sum * PI / power - 1.0).abs() < 1e-5, "{n}: {sum}");
            }
        }
        assert!(uniform_lights(&map, 0).is_empty());
    }

    #[test]
    fn the_nearest_direction_is_found() {
        for n in [1, 2, 3, 10, 100, 1000] {
            let directions = uniform_directions(n);
            for d in uniform_directions(1777) {
                let cosines = directions.iter().map(|l| l.dot(d));
                let largest = cosines.fold(f32::NEG_INFINITY, f32::max);
                assert_eq!(
                    directions[nearest(&directions, d)].dot(d),
                    largest,
                    "{n}: {d}"
                );
            }
        }
    }

    #[test]
    fn a_disc_lies_around_its_light() {
        let to_light = Vec3::new(0.6, -0.48, 0.64);
        for n in [1, 4, 16, 256] {
            for radius in [0.0, 0.01, 0.3, 1.5] {
                let directions = light_disc(to_light, radius, n);
                let mean = directions.iter().map(|d| d.as_dvec3()).sum::<DVec3>() / n as f64;
                let mean = mean.as_vec3();
                assert!(
                    (mean.normalize() - to_light).length() < 1e-6,
                    "{n}, {radius}"
                );
                // The mean cosine over a cap is half its height; for the spiral that is exact before the rotation,
                // which differs by the length of its mean, at most a tenth for 4 directions.
                let middle = (1.0 + radius.cos()) / 2.0;
                let exact = mean.length() - middle;
                let allowed = if n == 1 {
                    1.0
                } else {
                    0.12 * radius * radius / n as f32
                };
                assert!(exact.abs() <= allowed + 1e-6, "{n}, {radius}: {exact}");
                let widest = directions
                    .iter()
                    .map(|d| d.dot(to_light).clamp(-1.0, 1.0).acos());
                let widest = widest.fold(0.0_f32, f32::max);
                assert!(widest <= 1.35 * radius + 1e-3, "{n}, {radius}: {widest}");
            }
        }
        assert!((light_disc(to_light, 0.3, 1)[0] - to_light).length() < 1e-6);
    }

    #[test]
    fn hostile_discs_are_unit_directions() {
        for to_light in [
            Vec3::ZERO,
            Vec3::NAN,
            Vec3::NEG_Z,
            Vec3::splat(f32::INFINITY),
        ] {
            for radius in [f32::NAN, f32::INFINITY, -1.0, 4.0] {
                for direction in light_disc(to_light, radius, 7) {
                    assert!(
                        (direction.length() - 1.0).abs() < 1e-5,
                        "{to_light}, {radius}"
                    );
                }
            }
        }
        assert!(light_disc(Vec3::Z, 0.1, 0).is_empty());
    }
}
