//! Invariance under threads, crops, mirrors, rotations and poison; extreme values stay finite.

use super::{Asked, LIT, METHODS, bits, covered, difference, sky, torus, torus_in_perspective};
use crate::prelude::*;

fn asked(material: Material, method: Method) -> Asked {
    let mut asked = Asked::of(material, method);
    asked.relight.material.tangent = Tangent::Degrees(20.0);
    asked
}

fn each(color: &ColorPlanes, f: impl Fn(&Plane) -> Plane) -> ColorPlanes {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(f);
    ColorPlanes { r, g, b }
}

fn turned(asked: &Asked, turn: impl Fn(Vec3) -> Vec3, degrees: impl Fn(f32) -> f32) -> Asked {
    let mut turned = asked.clone();
    for light in &mut turned.light.directional {
        light.to_light = turn(light.to_light);
    }
    if let Tangent::Degrees(angle) = turned.relight.material.tangent {
        turned.relight.material.tangent = Tangent::Degrees(degrees(angle));
    }
    turned
}

#[test]
fn mirrors_and_turns_move_the_light_with_the_surface() {
    let frame = torus_in_perspective();
    for material in LIT {
        // Hard tones would make a step of a rounding.
        if material == Material::Toon {
            continue;
        }
        for method in METHODS {
            let asked = asked(material, method);
            let here = asked.color(&frame);
            let in_mirror = turned(&asked, |l| Vec3::new(-l.x, l.y, l.z), |angle| -angle);
            let expected = each(&here, mirrored_plane);
            let error = difference(&in_mirror.color(&mirrored(&frame)), &expected);
            let case = format!("{material:?} {method:?}");
            assert!(error < 5e-5, "{case} mirrored: {error:.1e}");
            let a_quarter = turned(&asked, |l| Vec3::new(-l.y, l.x, l.z), |angle| angle + 90.0);
            let expected = each(&here, quarter_turned_plane);
            let error = difference(&a_quarter.color(&quarter_turned(&frame)), &expected);
            assert!(error < 5e-5, "{case} turned: {error:.1e}");
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let frame = torus_in_perspective();
    let cases = [
        asked(Material::Phong, Method::Both),
        asked(Material::AshikhminShirley, Method::Both)
            .in_environment(sky(), SampleCount::Fixed(33)),
        asked(Material::Phong, Method::Both).in_environment(sky(), SampleCount::Fixed(0)),
        asked(Material::Phong, Method::Both).in_environment(sky(), SampleCount::Auto),
        asked(Material::AshikhminShirley, Method::Plain).in_environment(sky(), SampleCount::Auto),
    ];
    for asked in cases {
        let with = |threads| on_threads(threads, || bits(&asked.color(&frame)));
        let expected = with(1);
        for threads in [2, 3, 8] {
            assert!(with(threads) == expected, "{threads} threads");
        }
    }
}

#[test]
fn a_crop_is_lit_as_the_whole() {
    let frame = torus_in_perspective();
    let part = Window::at(11, 7, 79, 74);
    let lit = METHODS.map(|method| asked(Material::BlinnPhong, method));
    let around = |asked: &Asked| asked.clone().in_environment(sky(), SampleCount::Auto);
    let in_environment = lit.each_ref().map(around);
    for asked in lit.into_iter().chain(in_environment) {
        let method = asked.relight.method;
        let reach = asked.plan(&frame).unwrap().reach();
        let (whole, cropped) = (asked.color(&frame), asked.color(&frame.crop(part)));
        for (x, y) in places(part.width() - 2 * reach, part.height() - 2 * reach) {
            let (x, y) = (x + reach, y + reach);
            let (a, b) = (whole.r.at(x + 11, y + 7), cropped.r.at(x, y));
            assert_eq!(a.to_bits(), b.to_bits(), "{method:?} at {x}, {y}");
        }
    }
}

#[test]
fn what_lies_outside_the_mask_changes_nothing() {
    let frame = torus();
    for material in LIT {
        let asked = asked(material, Method::Both);
        let expected = bits(&asked.color(&frame));
        for poison in [f32::NAN, f32::INFINITY, -1e30] {
            let found = bits(&asked.color(&poisoned(&frame, poison)));
            assert!(found == expected, "{material:?}");
        }
    }
}

#[test]
fn what_is_not_surface_keeps_its_picture() {
    let frame = torus();
    let color = asked(Material::Phong, Method::Both).color(&frame);
    let picture = frame.color.as_ref().unwrap();
    for (x, y) in places(97, 94).filter(|&(x, y)| !frame.mask.at(x, y)) {
        assert_eq!(color.r.at(x, y).to_bits(), picture.r.at(x, y).to_bits());
    }
}

/// The frame with normals that no surface has.
fn hostile() -> Frame {
    let mut frame = torus();
    let values = [0.0, -1.0, 1e-20, 1.0, -0.0, 0.5];
    for (i, (x, y)) in covered(&frame.mask.clone()).enumerate().step_by(3) {
        let n = [0, 1, 2].map(|k| values[(i * 7 + k * 13) % values.len()]);
        set_normal(&mut frame.normal, x, y, n.into());
    }
    frame
}

#[test]
fn extreme_settings_stay_finite() {
    let lights = [Vec3::NEG_Z, Vec3::Z, Vec3::new(0.3, -0.2, -0.9), Vec3::X];
    let lights = super::lights(&lights);
    let spike = super::surroundings(16, |[x, y, _]| {
        let bright = x > 0.8 && y.abs() < 0.3;
        [if bright { 1e6 } else { 0.0 }; 3]
    });
    for (name, frame) in [
        ("hostile", hostile()),
        ("one", masked(torus(), |x, y| (x, y) == (40, 30))),
        ("none", masked(torus(), |_, _| false)),
        ("tiny", torus().crop(Window::at(30, 30, 1, 1))),
    ] {
        for material in LIT {
            for method in METHODS {
                for extreme in [0.0, 1.0, 1e6] {
                    let mut asked = asked(material, method);
                    asked.light = lights.clone();
                    asked.relight.warping.warp = extreme;
                    asked.scaling.scaling = extreme;
                    asked.scaling.curvature_gain = Adaptive::Fixed(extreme.max(1e-3));
                    asked.relight.material.shininess = extreme;
                    asked.relight.material.coat = [extreme, 1e5];
                    asked.relight.material.tangent = Tangent::Curvature;
                    asked.scaling.anisotropy = 1.0 - extreme.min(2.0);
                    asked.relight.warping.contrast = 1.0;
                    assert_finite(&asked, &frame, name);
                    let samples = match material {
                        Material::Lambert | Material::Phong => SampleCount::Auto,
                        _ => SampleCount::Fixed(7),
                    };
                    assert_finite(&asked.in_environment(spike.clone(), samples), &frame, name);
                }
            }
        }
    }
}

fn assert_finite(asked: &Asked, frame: &Frame, name: &str) {
    let color = asked.color(frame);
    let mut samples = channels(&color)
        .into_iter()
        .flat_map(|plane| plane.samples());
    let is_finite = samples.all(|v| v.is_finite());
    assert!(is_finite, "{name} {:?}", asked.relight);
}

#[test]
fn a_hundred_thousand_lights_are_a_lot_and_no_more() {
    let frame = torus().crop(Window::at(25, 25, 20, 20));
    let mut asked = asked(Material::Lambert, Method::Warp);
    let many = relievo::light::light_samples::uniform_directions(100_000);
    asked.light = super::lights(&many);
    let color = asked.color(&frame);
    // The integral of the cosine is pi, each light of 1 stands for 4 pi / n.
    let mean: f32 = covered(&frame.mask).map(|(x, y)| color.r.at(x, y)).sum();
    let mean = mean / frame.mask.count() as f32 * 4.0 / 100_000.0;
    assert!(mean > 0.8 && mean < 1.2, "{mean}");
}

#[test]
fn an_environment_is_made_ready_once_and_again_for_another_purpose() {
    let frame = torus();
    let mut asked =
        asked(Material::Phong, Method::Scale).in_environment(sky(), SampleCount::Fixed(0));
    let engine = Engine::cpu();
    let run = |asked: &Asked| {
        let plan = asked.plan(&frame).unwrap();
        let inputs = PlanInputs::lit_by(&asked.light);
        let outcome = engine.execute(&plan, &frame, inputs, &Run::new()).unwrap();
        let mut timings = outcome.timings.iter();
        let made = timings.any(|(stage, _)| *stage == "environment");
        (bits(outcome.color.as_ref().unwrap()), made)
    };
    let first = run(&asked);
    let again = run(&asked);
    assert!(first.1 && !again.1 && first.0 == again.0);
    // Another highlight, or another environment that looks the same, makes a difference.
    asked.relight.material.shininess = 8.0;
    let wider = run(&asked);
    assert!(wider.1 && wider.0 != first.0 && wider.0 == bits(&asked.color(&frame)));
    asked.light.environment = Some(sky().into());
    assert!(run(&asked).1);
    engine.forget_environment();
    assert!(run(&asked).1);
}
