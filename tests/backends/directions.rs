//! Directions of the surface's own curvature: every kind of surface, under every projection, in every storage.

use super::{MASKS, assert_alike, covered_where, on_gpu, outcomes, plan, with_shape};
use crate::common::in_8_bits;
use glam::{DMat3, DVec3};
use relievo::engine::PlanInputs;
use relievo::engine::gpu::DeviceRunner;
use relievo::frame::{DepthKind, Frame, Plane, SightLines, Window};
use relievo::params::{Adaptive, Scale};
use relievo::plan::Goal;
use relievo::product::Product;
use relievo::scenes::{ExactScene, Surface};

/// Asserts that both backends find the same directions in a frame.
#[track_caller]
fn assert_same_directions(name: &str, runner: &DeviceRunner, frame: &Frame) {
    for step in [Adaptive::Auto, Adaptive::Fixed(3.0)] {
        let params = with_shape(|shape| {
            (shape.scale, shape.direction_step) = (Scale::Iterations(0), step);
        });
        let plan = plan(Goal::LAYERS, frame, &params);
        let [found, expected] = outcomes(runner, &plan, frame, PlanInputs::default());
        assert_alike(&format!("{name}, {step:?}"), &found, &expected, |product| {
            product == Product::Direction
        });
    }
}

/// Surfaces of every form, some of them cut off by the border: umbilic, parabolic, planar, and of opposite curvatures.
fn scenes() -> Vec<(&'static str, ExactScene)> {
    let turn = DMat3::from_rotation_z(0.5) * DMat3::from_rotation_x(-0.8);
    let ellipsoid = Surface::ellipsoid(DVec3::new(50.0, 35.0, 25.0), turn);
    let cylinder = Surface::cylinder(30.0, DVec3::new(0.5, 1.0, 0.3));
    let torus = Surface::torus(36.0, 14.0, DVec3::new(0.2, 0.4, 1.0));
    let seen = |surface| ExactScene::orthographic(surface, 61.3, 48.6);
    vec![
        ("ball", seen(Surface::ball(40.0))),
        ("ellipsoid", seen(ellipsoid)),
        ("cylinder", seen(cylinder)),
        ("torus", seen(torus)),
        ("saddle", seen(Surface::saddle(0.02, -0.013, 0.4))),
        ("plane", seen(Surface::plane(DVec3::new(0.3, -0.2, 1.0)))),
        ("corner", ExactScene::box_corner(true, 0.2, 61.3, 48.6)),
        ("balls", ExactScene::two_balls(22.0, 30.0, 61.3, 48.6)),
        ("waves", seen(Surface::sine_relief(3.0, 24.0, 0.4))),
    ]
}

/// The depth of a frame as distances from the eye.
fn along_rays(mut frame: Frame, scene: &ExactScene) -> Frame {
    let sight = SightLines::new(scene.projection);
    let depth = frame.depth.as_ref().unwrap();
    let (width, height) = (depth.width(), depth.height());
    frame.depth = Some(Plane::from_fn(width, height, |x, y| {
        let (_, line) = sight.line(x as f64 + 0.5, y as f64 + 0.5);
        (f64::from(depth.at(x, y)) * line.length()) as f32
    }));
    frame.source.depth_kind = DepthKind::Ray;
    frame
}

#[test]
fn surfaces_of_every_form() {
    on_gpu(|runner| {
        for (name, scene) in scenes() {
            for (seen, scene) in [("far", scene.clone()), ("near", scene.in_perspective())] {
                let whole = scene.frame(123, 97);
                let without = Frame {
                    depth: None,
                    ..whole.clone()
                };
                let along = along_rays(whole.clone(), &scene);
                for (depth, frame) in [("depth", whole), ("no depth", without), ("rays", along)] {
                    for (bits, frame) in [("f32", frame.clone()), ("8 bits", in_8_bits(frame))] {
                        let name = format!("{name}, {seen}, {depth}, {bits}");
                        assert_same_directions(&name, runner, &frame);
                    }
                }
            }
        }
    });
}

#[test]
fn parts_of_a_picture() {
    on_gpu(|runner| {
        let torus = Surface::torus(36.0, 14.0, DVec3::new(0.2, 0.4, 1.0));
        let scene = ExactScene::orthographic(torus, 61.3, 48.6).in_perspective();
        let whole = scene.frame(123, 97);
        let (x0, y0) = (whole.data_window.x0 + 17, whole.data_window.y0 + 8);
        let crop = whole.crop(Window::at(x0, y0, 77, 61));
        assert_same_directions("crop", runner, &crop);
        for (name, covers) in MASKS {
            for poison in [0.0, f32::NAN, f32::INFINITY, -1.0] {
                let name = format!("{name}, poisoned by {poison}");
                let frame = covered_where(&whole, covers, poison);
                assert_same_directions(&name, runner, &frame);
            }
        }
        for (width, height) in [(1, 1), (1, 40), (40, 1), (65, 3)] {
            let frame = whole.crop(Window::at(x0 + 5, y0 + 5, width, height));
            assert_same_directions(&format!("{width}x{height}"), runner, &frame);
        }
    });
}
