//! Hostile values and sizes from files and callers: the GPU treats them as the CPU does.

use super::{
    GOALS, MASKS, assert_same, assert_same_colors, covered_where, on_gpu, outcomes, plan, waves,
};
use crate::common::cpu;
use relievo::engine::PlanInputs;
use relievo::frame::Window;
use relievo::params::{Adaptive, Params};
use relievo::plan::Goal;

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
        let plan = plan(Goal::Enhance, &frame, &Params::default());
        let made = outcomes(runner, &plan, &frame, PlanInputs::default());
        assert_same_colors("enhanced", made, f32::MIN_POSITIVE);
    });
}

#[test]
fn sizes_and_masks() {
    on_gpu(|runner| {
        let usual = Params::default();
        let sizes = [
            (1, 1),
            (1, 7),
            (65, 1),
            (33, 2),
            (64, 32),
            (129, 5),
            (300, 3),
        ];
        for (width, height) in sizes {
            let (name, frame) = (format!("{width}x{height}"), waves(width, height));
            assert_same(&name, runner, &GOALS, &frame, &usual);
        }
        let frame = waves(80, 60);
        for (name, covers) in MASKS {
            for poison in [0.0, f32::NAN, f32::INFINITY, -1.0] {
                let name = format!("{name}, poisoned by {poison}");
                let frame = covered_where(&frame, covers, poison);
                assert_same(&name, runner, &GOALS, &frame, &usual);
            }
        }
    });
}

#[test]
fn a_crop_is_the_whole_away_from_its_border() {
    on_gpu(|runner| {
        let frame = waves(200, 150);
        let mut params = Params::default();
        params.scaling.curvature_gain = Adaptive::Fixed(3.0);
        params.scaling.white_level = Adaptive::Fixed(1.0);
        let plan = plan(Goal::Enhance, &frame, &params);
        let whole = cpu::run(&plan, &frame).unwrap().color.unwrap();
        let window = frame.data_window;
        let crop = frame.crop(Window::at(window.x0 + 31, window.y0 + 22, 140, 101));
        let part = runner.execute(&plan, &crop, PlanInputs::default());
        let part = part.unwrap().color.unwrap();
        let reach = plan.reach();
        for y in reach..101 - reach {
            for x in reach..140 - reach {
                let (found, expected) = (part.g.at(x, y), whole.g.at(x + 31, y + 22));
                assert!((found - expected).abs() <= 1e-5 * expected, "({x}, {y})");
            }
        }
    });
}
