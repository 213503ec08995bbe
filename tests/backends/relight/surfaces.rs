//! Inputs on surfaces: albedo, coverage, invalid numbers, sizes and masks.

use super::super::hostile::HOSTILE;
use super::super::on_gpu;
use super::{Asked, sky, torus, torus_from_near, with_layers};
use crate::common::cpu;
use crate::common::poisoned;
use relievo::engine::PlanInputs;
use relievo::engine::gpu::{AdapterKind, Device, DeviceRunner};
use relievo::frame::{ColorPlanes, Mask, Plane};
use relievo::light::environment::Environment;
use relievo::params::{AlbedoSource, Material, Method, SampleCount};
use relievo::scenes::{ExactScene, Surface};

#[test]
fn albedo_alpha_and_occlusion() {
    on_gpu(|runner| {
        for albedo in [
            AlbedoSource::Layer,
            AlbedoSource::Picture,
            AlbedoSource::Estimate,
            AlbedoSource::White,
        ] {
            let asked = Asked::of(Material::BlinnPhong, Method::Both);
            let asked = asked.with(|asked| asked.relight.albedo = albedo);
            let mut frame = with_layers(torus());
            asked.assert_same(&format!("{albedo:?}"), runner, &frame);
            frame.alpha = None;
            frame.light.occlusion = None;
            asked.assert_same(&format!("{albedo:?}, opaque"), runner, &frame);
        }
    });
}

#[test]
fn colors_that_are_no_numbers() {
    on_gpu(|runner| {
        let mut frame = torus();
        let spoiled = |plane: &Plane, of: usize| {
            Plane::from_fn(97, 94, |x, y| match (x * 31 + y * 17 + of) % 11 {
                k if k < HOSTILE.len() => HOSTILE[k],
                _ => plane.at(x, y),
            })
        };
        let color = frame.color.as_ref().unwrap();
        let spoiled = ColorPlanes {
            r: spoiled(&color.r, 0),
            g: spoiled(&color.g, 0),
            b: spoiled(&color.b, 3),
        };
        frame.albedo = Some(spoiled.clone());
        frame.color = Some(spoiled);
        for (material, albedo) in [
            (Material::BlinnPhong, AlbedoSource::Layer),
            (Material::Toon, AlbedoSource::Layer),
            (Material::Lambert, AlbedoSource::Picture),
        ] {
            let asked = Asked::of(material, Method::Both).with(|asked| {
                asked.relight.albedo = albedo;
                asked.relight.toon_levels = Some(4);
                asked.relight.toon_softness = 1.0;
            });
            let plan = asked.plan(&frame).unwrap();
            let expected = cpu::execute(&plan, &frame, PlanInputs::lit_by(&asked.light)).unwrap();
            let found = runner
                .execute(&plan, &frame, PlanInputs::lit_by(&asked.light))
                .unwrap();
            let [expected, found] = [expected, found].map(|outcome| outcome.color.unwrap());
            for (found, expected) in [
                (found.r, expected.r),
                (found.g, expected.g),
                (found.b, expected.b),
            ] {
                for (f, e) in found.samples().iter().zip(expected.samples()) {
                    let same = f == e || f.is_nan() && e.is_nan() || (f - e).abs() < 1e-5 * e.abs();
                    // Small numbers are remainders of a light of 1.
                    assert!(same || f.abs().max(e.abs()) < 1e-5, "{f:e}, not {e:e}");
                }
            }
        }
    });
}

#[test]
fn sizes_and_masks() {
    on_gpu(|runner| {
        let asked = Asked::of(Material::BlinnPhong, Method::Both);
        for (width, height) in [(1, 1), (1, 7), (65, 1), (129, 5)] {
            let scene = ExactScene::orthographic(Surface::sine_relief(3.0, 24.0, 0.4), 30.0, 20.0);
            let frame = scene.frame(width, height);
            asked.assert_same(&format!("{width}x{height}"), runner, &frame);
        }
        let torus = torus();
        for (name, covers) in [
            ("nothing", (|_, _| false) as fn(usize, usize) -> bool),
            ("one pixel", |x, y| x == 20 && y == 40),
            ("speckled", |x, y| !(x * 7 + y * 13).is_multiple_of(5)),
        ] {
            let mut frame = torus.clone();
            frame.mask = Mask::new(Plane::from_fn(97, 94, |x, y| {
                torus.mask.at(x, y) && covers(x, y)
            }));
            asked.assert_same(name, runner, &frame);
            for poison in [f32::NAN, f32::INFINITY] {
                asked.assert_same(name, runner, &poisoned(&frame, poison));
            }
        }
    });
}

#[test]
fn an_environment_too_large_for_the_device_is_refused() {
    let Ok(device) = Device::open(AdapterKind::Any) else {
        return;
    };
    let frame = with_layers(torus_from_near());
    // 97x94 vectors of two fit, and 64x32 pixels of 16 bytes; four times as many do not.
    let runner = DeviceRunner::new(device.limited_to(97 * 94 * 8));
    let asked = Asked::of(Material::Mirror, Method::Plain).in_environment(sky(), SampleCount::Auto);
    asked.assert_same("mirrored", &runner, &frame);
    let blank = Environment::from_fn(128, 64, |_, _| [1.0; 3]);
    let asked = asked.in_environment(blank, SampleCount::Auto);
    let plan = asked.plan(&frame).unwrap();
    assert!(
        runner
            .execute(&plan, &frame, PlanInputs::lit_by(&asked.light))
            .is_err()
    );
}
