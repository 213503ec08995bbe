//! Hostile values and sizes from files and callers: the GPU treats them as the CPU does.

use super::{assert_same, on_gpu, plan, waves};
use crate::common::cpu;
use crate::common::poisoned;
use relievo::engine::PlanInputs;
use relievo::frame::Window;
use relievo::params::{Adaptive, ScalingParams, ShapeParams};
use relievo::plan::Goal;
use relievo::scenes::frames::masked;

/// Values that no renderer means as a colour.
pub(super) const HOSTILE: [f32; 7] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    -3.0,
    0.0,
    1e-40,
];

#[test]
fn colors_that_are_no_numbers() {
    on_gpu(|runner| {
        let mut frame = waves(70, 50);
        let color = frame.color.as_mut().unwrap();
        for (i, value) in HOSTILE.into_iter().enumerate() {
            color.r.row_mut(10)[5 * i] = value;
            color.b.row_mut(20)[5 * i] = value;
            color.g.row_mut(20)[5 * i] = value;
        }
        let scaling = ScalingParams::default();
        let plan = plan(Goal::Enhance, &frame, ShapeParams::default(), scaling);
        let expected = cpu::run(&plan, &frame).unwrap().color.unwrap();
        let found = runner
            .execute(&plan, &frame, PlanInputs::default())
            .unwrap()
            .color
            .unwrap();
        for (found, expected) in [
            (found.r, expected.r),
            (found.g, expected.g),
            (found.b, expected.b),
        ] {
            for (f, e) in found.samples().iter().zip(expected.samples()) {
                let same = f == e || f.is_nan() && e.is_nan() || (f / e - 1.0).abs() < 1e-5;
                assert!(
                    same || f.abs().max(e.abs()) < f32::MIN_POSITIVE,
                    "{f:e}, not {e:e}"
                );
            }
        }
    });
}

#[test]
fn sizes() {
    on_gpu(|runner| {
        for (width, height) in [
            (1, 1),
            (1, 7),
            (65, 1),
            (33, 2),
            (64, 32),
            (129, 5),
            (300, 3),
        ] {
            let frame = waves(width, height);
            for goal in [Goal::LAYERS, Goal::Enhance] {
                let plan = plan(
                    goal,
                    &frame,
                    ShapeParams::default(),
                    ScalingParams::default(),
                );
                assert_same(&format!("{width}x{height}"), runner, &plan, &frame);
            }
        }
    });
}

#[test]
fn masks() {
    on_gpu(|runner| {
        let speckled = |x: usize, y: usize| !(x * 7 + y * 13).is_multiple_of(5);
        for (name, frame) in [
            ("nothing", masked(waves(40, 30), |_, _| false)),
            ("one pixel", masked(waves(40, 30), |x, y| x == 20 && y == 9)),
            ("speckled", masked(waves(80, 60), speckled)),
            ("half", masked(waves(80, 60), |x, _| x < 37)),
        ] {
            for goal in [Goal::LAYERS, Goal::Display, Goal::Enhance] {
                let plan = plan(
                    goal,
                    &frame,
                    ShapeParams::default(),
                    ScalingParams::default(),
                );
                assert_same(name, runner, &plan, &frame);
            }
        }
    });
}

#[test]
fn what_lies_outside_the_mask_changes_nothing() {
    on_gpu(|runner| {
        let frame = masked(waves(80, 60), |x, y| (x / 20 + y / 20).is_multiple_of(2));
        for poison in [f32::NAN, f32::INFINITY, -1.0] {
            let frame = poisoned(&frame, poison);
            let plan = plan(
                Goal::LAYERS,
                &frame,
                ShapeParams::default(),
                ScalingParams::default(),
            );
            assert_same(&format!("poisoned by {poison}"), runner, &plan, &frame);
        }
    });
}

#[test]
fn a_crop_is_the_whole_away_from_its_border() {
    on_gpu(|runner| {
        let frame = waves(200, 150);
        let scaling = ScalingParams {
            curvature_gain: Adaptive::Fixed(3.0),
            white_level: Adaptive::Fixed(1.0),
            ..ScalingParams::default()
        };
        let plan = plan(Goal::Enhance, &frame, ShapeParams::default(), scaling);
        let whole = cpu::run(&plan, &frame).unwrap().color.unwrap();
        let window = frame.data_window;
        let (x0, y0) = (window.x0 + 31, window.y0 + 22);
        let crop = frame.crop(Window::at(x0, y0, 140, 101));
        let part = runner
            .execute(&plan, &crop, PlanInputs::default())
            .unwrap()
            .color
            .unwrap();
        let reach = plan.reach();
        for y in reach..101 - reach {
            for x in reach..140 - reach {
                let (found, expected) = (part.g.at(x, y), whole.g.at(x + 31, y + 22));
                assert!((found - expected).abs() <= 1e-5 * expected, "({x}, {y})");
            }
        }
    });
}
