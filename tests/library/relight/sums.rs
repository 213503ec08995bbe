//! The sum over lights against the reference, for every material and method.

use super::{Asked, LIT, METHODS, bits, covered, lights, torus, torus_in_perspective};
use crate::common::cpu::described;
use crate::prelude::*;
use relievo::light::lights::PointLight;
use relievo::scenes::light_reference::{Pixel, Settings, reflected};

/// Largest difference of the red channel from the reference, relative to the largest value.
fn worst(
    asked: &Asked,
    frame: &Frame,
    to_lights: impl Fn(usize, usize) -> Vec<(DVec3, f64)>,
) -> f64 {
    let outcome = asked.outcome(frame);
    let color = outcome.color.as_ref().unwrap();
    let hessian = described(frame, asked.shape).shape.hessian.unwrap();
    let gain = outcome.gain.unwrap_or(0.0);
    let m = &asked.relight.material;
    let settings = Settings {
        method: asked.relight.method,
        alpha: f64::from(asked.relight.warping.warp * gain),
        gain: gain.into(),
        scaling: &asked.scaling,
        material: m,
    };
    let mut largest = 0.0_f64;
    let mut differences = Vec::new();
    for (x, y) in covered(&frame.mask) {
        let at = |plane: &Plane| f64::from(plane.at(x, y));
        let angle = match m.tangent {
            Tangent::Degrees(angle) => f64::from(angle),
            Tangent::Curvature => 0.0,
        };
        let pixel = Pixel::of(frame, &hessian, [x, y], angle);
        let mut expected = 0.0;
        let mut on_horizon = false;
        for (light, intensity) in to_lights(x, y) {
            let [diffuse, specular] = reflected(&pixel, light, &settings);
            let gains = (f64::from(m.diffuse_gain), f64::from(m.specular()));
            expected += intensity * (gains.0 * diffuse + gains.1 * specular);
            on_horizon |= pixel.normal.dot(light).abs() < Pixel::HORIZON;
        }
        if !on_horizon {
            largest = largest.max(expected);
            differences.push((at(&color.r) - expected).abs());
        }
    }
    let count = differences.len();
    assert!(count > 2000, "the horizon spares only {count}");
    assert!(largest > 0.1, "nothing is lit");
    differences.into_iter().fold(0.0, f64::max) / largest
}

fn directions() -> Vec<Vec3> {
    [
        [-0.6, 0.6, 0.53],
        [0.9, 0.1, 0.2],
        [0.0, 0.0, 1.0],
        [0.3, -0.8, -0.3],
        [0.1, 0.2, -0.97],
        [-0.4, -0.5, 0.7],
    ]
    .map(|d| Vec3::from_array(d).normalize())
    .into()
}

#[test]
fn every_material_and_method_agrees_with_the_papers() {
    for frame in [torus(), torus_in_perspective()] {
        for material in LIT {
            for method in METHODS {
                let mut asked = Asked::of(material, method);
                asked.light = lights(&directions());
                // The tones of a cartoon are tested apart.
                asked.relight.toon_levels = None;
                if material == Material::Toon {
                    continue;
                }
                asked.relight.material.tangent = Tangent::Degrees(25.0);
                asked.relight.material.coat = [30.0, 200.0];
                asked.scaling.scaling_diffuse = Some(1.5);
                asked.scaling.scaling_specular = Some(0.7);
                let all: Vec<_> = directions().iter().map(|d| (d.as_dvec3(), 1.0)).collect();
                let error = worst(&asked, &frame, |_, _| all.clone());
                // Powers up to 200 of a cosine that is off by a rounding, 6e-8.
                assert!(error < 3e-5, "{material:?} {method:?}: {error:.1e}");
            }
        }
    }
}

#[test]
fn curvature_toward_the_light_agrees_with_the_paper() {
    for method in [Method::Scale, Method::Both] {
        for anisotropy in [-1.0, 0.5, 1.0] {
            let mut asked = Asked::of(Material::Phong, method);
            asked.scaling.anisotropy = anisotropy;
            let light = directions()[0];
            asked.light = lights(&[light]);
            let error = worst(&asked, &torus(), |_, _| vec![(light.as_dvec3(), 1.0)]);
            assert!(error < 3e-5, "{method:?} {anisotropy}: {error:.1e}");
        }
    }
}

#[test]
fn a_point_light_is_a_direction_and_a_fall_off_for_every_pixel() {
    let frame = torus_in_perspective();
    let projection = frame.camera.unwrap().projection;
    let sight = SightLines::new(projection);
    let depth = frame.depth.clone().unwrap();
    // Some 70 units in front of a point of the ring.
    let (x, y) = covered(&frame.mask).next().unwrap();
    let kind = frame.source.depth_kind;
    let near = sight.point(x as f64, y as f64, depth.at(x, y).into(), kind);
    let position = near.as_vec3() + Vec3::new(-20.0, 30.0, 60.0);
    for method in METHODS {
        let mut asked = Asked::of(Material::BlinnPhong, method);
        let intensity = [5000.0; 3];
        asked.light = Illumination::default();
        asked.light.points.push(PointLight {
            position,
            intensity,
        });
        let error = worst(&asked, &frame, |x, y| {
            let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
            let point = sight.point(px, py, depth.at(x, y).into(), kind);
            let to = position.as_dvec3() - point;
            vec![(to.normalize(), 5000.0 / to.length_squared())]
        });
        assert!(error < 5e-5, "{method:?}: {error:.1e}");
    }
}

#[test]
fn hundreds_of_lights_add_up_and_none_is_lost() {
    // More than one group, and a number with a remainder.
    let frame = torus();
    let many: Vec<Vec3> = relievo::light::light_samples::uniform_directions(203);
    for method in METHODS {
        let mut asked = Asked::of(Material::BlinnPhong, method);
        asked.light = lights(&many);
        let all: Vec<_> = many.iter().map(|d| (d.as_dvec3(), 1.0)).collect();
        let error = worst(&asked, &frame, |_, _| all.clone());
        assert!(error < 2e-5, "{method:?}: {error:.1e}");
    }
}

#[test]
fn a_cartoon_has_as_many_tones_as_asked_for() {
    let frame = torus();
    let mut asked = Asked::of(Material::Toon, Method::Both);
    asked.relight.toon_levels = Some(5);
    asked.relight.toon_softness = 0.0;
    asked.scaling.curvature_gain = Adaptive::Auto;
    // [LW] figure 10: contrast comes before the tones, and leaves them flat.
    asked.relight.warping.contrast = 0.7;
    let color = asked.color(&frame);
    let tone = |(x, y)| (color.r.at(x, y).sqrt() * 5.0 * 1000.0).round() as u32;
    let mut tones: Vec<u32> = covered(&frame.mask).map(tone).collect();
    tones.sort_unstable();
    tones.dedup();
    // Whole fifths of the square root, up to that of the light itself: warped and scaled it adds none.
    assert!(tones.iter().all(|t| t % 1000 == 0), "{tones:?}");
    assert!(tones.len() >= 5 && tones.last() == Some(&5000), "{tones:?}");
}

/// Concavities that are not scaled show plain light, bit for bit, and convexities what they show where all is scaled.
#[test]
fn convexities_and_concavities_are_scaled_apart() {
    let frame = torus_in_perspective();
    let of = |convex, concave| {
        let mut asked = Asked::of(Material::Phong, Method::Scale);
        asked.scaling.scaling_convex = convex;
        asked.scaling.scaling_concave = concave;
        bits(&asked.color(&frame))
    };
    let (both, none) = (of(None, None), of(Some(0.0), Some(0.0)));
    assert!(both == of(Some(1.0), Some(1.0)) && both != none);
    let (convex, concave) = (of(None, Some(0.0)), of(Some(0.0), None));
    let (mut bumps, mut hollows) = (0, 0);
    for i in 0..both.len() {
        let is_bump = convex[i] == both[i] && concave[i] == none[i];
        let is_hollow = convex[i] == none[i] && concave[i] == both[i];
        assert!(is_bump || is_hollow, "{i}");
        bumps += usize::from(!is_hollow);
        hollows += usize::from(!is_bump);
    }
    assert!(bumps > 1000 && hollows > 100, "{bumps} {hollows}");
}
