//! Inputs on surfaces: albedo, coverage, invalid numbers, sizes and masks.

use super::super::hostile::HOSTILE;
use super::super::{MASKS, assert_same_colors, covered_where, on_gpu};
use super::{Asked, sky, torus, torus_from_near, with_layers};
use relievo::engine::PlanInputs;
use relievo::engine::gpu::{AdapterKind, Device, DeviceRunner};
use relievo::frame::{ColorPlanes, Plane};
use relievo::light::environment::Environment;
use relievo::params::{AlbedoSource, Material, Method, SampleCount};
use relievo::scenes::{ExactScene, Surface};

#[test]
fn albedo_alpha_and_occlusion() {
    on_gpu(|runner| {
        use AlbedoSource::{Estimate, Layer, Picture, White};
        for albedo in [Layer, Picture, Estimate, White] {
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
        let planes = [(&color.r, 0), (&color.g, 0), (&color.b, 3)];
        let [r, g, b] = planes.map(|(plane, of)| spoiled(plane, of));
        let spoiled = ColorPlanes { r, g, b };
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
            // Small numbers are remainders of a light of 1.
            let made = asked.outcomes(runner, &frame);
            assert_same_colors(&format!("{material:?}, {albedo:?}"), made, 1e-5);
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
        for (name, covers) in MASKS {
            for poison in [0.0, f32::NAN, f32::INFINITY] {
                let frame = covered_where(&torus, covers, poison);
                asked.assert_same(&format!("{name}, {poison}"), runner, &frame);
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
    let refused = runner.execute(&plan, &frame, PlanInputs::lit_by(&asked.light));
    assert!(refused.is_err());
}
