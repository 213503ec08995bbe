//! Light separated in a file: lobes, light groups, ambient occlusion.

use super::{assert_same, on_gpu, plan, waves};
use crate::common::cpu;
use glam::Vec3;
use relievo::engine::Inputs;
use relievo::engine::gpu::{Choice, Device, Runner};
use relievo::frame::{ColorPlanes, Frame, LightGroup, Lobe, LobeLayers, Plane};
use relievo::params::{Adaptive, Scale, ScalingParams, ShapeParams};
use relievo::plan::Goal;

/// A light of a size and a wave of its own.
fn light(frame: &Frame, size: f32, wave: f32) -> ColorPlanes {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let plane = |k: f32| {
        Plane::from_fn(width, height, |x, y| {
            // Below 0 at the troughs: never meant by a renderer, but written by some.
            size * (0.9 + (wave * x as f32 + 0.05 * k * y as f32).sin())
        })
    };
    ColorPlanes {
        r: plane(1.0),
        g: plane(2.0),
        b: plane(3.0),
    }
}

/// Two lobes, one with all of its layers, one with light alone.
pub(super) fn with_lobes(mut frame: Frame) -> Frame {
    let diffuse = LobeLayers {
        lobe: Lobe::Diffuse,
        direct: Some(light(&frame, 0.2, 0.11)),
        indirect: Some(light(&frame, 0.05, 0.03)),
        color: Some(light(&frame, 0.4, 0.2)),
        albedo: None,
    };
    let coat = LobeLayers {
        lobe: Lobe::Coat,
        direct: Some(light(&frame, 0.1, 0.3)),
        indirect: None,
        color: None,
        albedo: Some(light(&frame, 0.5, 0.07)),
    };
    frame.light.lobes = vec![diffuse, coat];
    frame
}

fn with_groups(mut frame: Frame) -> Frame {
    let group = |size, wave, to_light: Vec<Vec3>| LightGroup {
        name: "key".into(),
        light: light(&frame, size, wave),
        to_light,
    };
    let around = (0..5).map(|i| Vec3::new(0.2 * i as f32, 0.3, 0.7).normalize());
    frame.light.groups = vec![
        group(0.2, 0.11, vec![Vec3::new(-0.6, 0.64, 0.48)]),
        group(0.1, 0.05, around.collect()),
        // Behind the surface.
        group(0.1, 0.2, vec![Vec3::NEG_Z]),
    ];
    frame
}

fn with_occlusion(mut frame: Frame) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    frame.light.occlusion = Some(Plane::from_fn(width, height, |x, y| {
        0.5 + 0.5 * (0.1 * x as f32 + 0.2 * y as f32).cos()
    }));
    frame
}

/// Frames with layers, and how they are scaled.
fn cases(width: usize, height: usize) -> Vec<(&'static str, Frame, ScalingParams)> {
    let usual = ScalingParams::default();
    let ambient = ScalingParams {
        scaling_ambient: Some(0.7),
        ..usual
    };
    let anisotropic = ScalingParams {
        anisotropy: 0.8,
        ..usual
    };
    let white = ScalingParams {
        white_level: Adaptive::Fixed(0.4),
        curvature_gain: Adaptive::Fixed(5.0),
        ..ambient
    };
    let frame = || waves(width, height);
    vec![
        ("lobes", with_lobes(frame()), usual),
        ("lobes, ambient apart", with_lobes(frame()), ambient),
        ("lobes, white level given", with_lobes(frame()), white),
        ("groups", with_groups(frame()), usual),
        ("groups, by direction", with_groups(frame()), anisotropic),
        ("occlusion", with_occlusion(frame()), ambient),
        ("occlusion, gain given", with_occlusion(frame()), white),
        (
            "groups and occlusion",
            with_occlusion(with_groups(frame())),
            ambient,
        ),
    ]
}

#[test]
fn lobes_groups_and_occlusion() {
    on_gpu(|runner| {
        for (width, height) in [(131, 70), (1, 1)] {
            for (name, frame, scaling) in cases(width, height) {
                let plan = plan(Goal::Enhance, &frame, ShapeParams::default(), scaling);
                let name = format!("{name}, {width}x{height}");
                assert_same(&name, runner, &plan, &frame);
                let expected = cpu::run(&plan, &frame).unwrap().term_white_levels;
                let found = runner
                    .execute(&plan, &frame, Inputs::default())
                    .unwrap()
                    .term_white_levels;
                assert_eq!(found.len(), expected.len(), "{name}");
                for (found, expected) in found.iter().zip(expected) {
                    assert_eq!(found.0, expected.0);
                    assert!(
                        (found.1 / expected.1 - 1.0).abs() < 1e-6,
                        "{name}: {found:?}"
                    );
                }
            }
        }
    });
}

#[test]
fn layers_that_are_no_numbers() {
    on_gpu(|runner| {
        let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 0.0];
        for (name, mut frame, scaling) in cases(60, 40) {
            let poison = |plane: &Plane| {
                let mut poisoned = plane.clone();
                for (i, value) in hostile.into_iter().enumerate() {
                    poisoned.row_mut(11)[7 * i + 2] = value;
                }
                poisoned
            };
            frame.light = frame.light.map(poison);
            let plan = plan(Goal::Enhance, &frame, ShapeParams::default(), scaling);
            assert_same(&format!("hostile {name}"), runner, &plan, &frame);
        }
    });
}

#[test]
fn a_device_that_takes_small_planes_scales_layers_in_strips() {
    let Ok(device) = Device::open(Choice::Any) else {
        return;
    };
    // 90 columns of vectors of four are 1440 bytes a row: 100 rows at a time.
    let runner = Runner::new(device.limited_to(144_000));
    let shape = ShapeParams {
        scale: Scale::Iterations(4),
        ..ShapeParams::default()
    };
    for (name, frame, scaling) in cases(90, 300) {
        let plan = plan(Goal::Enhance, &frame, shape, scaling);
        assert_same(&format!("strips, {name}"), &runner, &plan, &frame);
    }
}
