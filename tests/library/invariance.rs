//! Invariance under mirrors, rotations, crops, windows, threads, tiles and any content outside the mask.

use crate::prelude::*;
use std::num::NonZeroUsize;

/// Every goal, with diffusion by steps and by expansion.
const CASES: [(Goal, Scale); 4] = [
    (Goal::LAYERS, Scale::Iterations(8)),
    (Goal::LAYERS, Scale::Sigma(2.0)),
    (Goal::Display, Scale::Sigma(1.5)),
    (Goal::Enhance, Scale::Iterations(12)),
];

fn plan((goal, scale): (Goal, Scale), frame: &Frame) -> Plan {
    let shape =
        default_but(|shape: &mut ShapeParams| (shape.scale, shape.foreshortening) = (scale, 0.5));
    // Fixed, so that a crop is not judged by another gain.
    let scaling = given(20.0, 0.6);
    Plan::new(goal, Available::in_frame(frame), shape, scaling).unwrap()
}

fn run(case: (Goal, Scale), frame: &Frame) -> Outcome {
    cpu::run(&plan(case, frame), frame).unwrap()
}

/// Balls before each other and a slanted cylinder, in perspective, off centre: silhouettes, a
/// border of coverage and smooth parts; in pictures `times` as large.
fn frames_of_size(times: usize) -> Vec<Frame> {
    let px = |length: f64| length * times as f64;
    let balls = ExactScene::two_balls(px(22.0), px(31.0), px(51.3), px(44.6)).in_perspective();
    let axis = DVec3::new(0.6, 0.5, 0.45);
    let cylinder = ExactScene::orthographic(Surface::cylinder(px(25.0), axis), px(40.0), px(50.0));
    let corner = ExactScene::box_corner(false, 0.3, px(47.0), px(52.0)).in_perspective();
    [balls, cylinder, corner]
        .map(|scene| scene.frame(96 * times, 80 * times))
        .into()
}

/// Every case on every frame.
fn cases() -> Vec<(Frame, (Goal<'static>, Scale))> {
    let frames = frames_of_size(1).into_iter();
    frames
        .flat_map(|frame| CASES.map(|case| (frame.clone(), case)))
        .collect()
}

/// Planes whose values do not turn with the picture.
fn scalars(outcome: &Outcome) -> Vec<(&'static str, &Plane)> {
    let vectors = ["gradient", "hessian", "direction"];
    let mut planes = planes(outcome);
    planes.retain(|(name, _)| !vectors.iter().any(|v| name.starts_with(v)));
    planes
}

fn assert_close(name: &str, found: &Plane, expected: &Plane) {
    let sizes = expected.samples().iter().map(|v| v.abs());
    let (largest, error) = (sizes.fold(0.0, f32::max), apart(found, expected));
    let bound = 1e-6 * largest.max(1.0);
    assert!(error <= bound, "{name} differs by {error} of {largest}");
}

fn assert_same_bits(one: &Outcome, other: &Outcome) {
    let (one, other) = (planes(one), planes(other));
    assert!(!one.is_empty() && one.len() == other.len());
    for ((name, a), (_, b)) in one.into_iter().zip(other) {
        assert!(bits(a) == bits(b), "{name} has other bits");
    }
}

/// Expects the planes of a picture that was moved, and slopes that were moved with it: to x of the first and y of the second.
fn moved(
    move_frame: fn(&Frame) -> Frame,
    move_plane: fn(&Plane) -> Plane,
    slopes: fn(Vector2Planes) -> [Plane; 2],
) {
    for (frame, case) in &cases() {
        let (plain, turned) = (run(*case, frame), run(*case, &move_frame(frame)));
        for ((name, expected), (_, found)) in scalars(&plain).into_iter().zip(scalars(&turned)) {
            assert_close(name, found, &move_plane(expected));
        }
        if let (Some(plain), Some(turned)) = (plain.shape.gradient, turned.shape.gradient) {
            let [x, y] = slopes(plain).map(|plane| move_plane(&plane));
            assert_close("gradient.x", &turned.x, &x);
            assert_close("gradient.y", &turned.y, &y);
        }
    }
}

#[test]
fn a_mirrored_or_turned_picture_gives_the_mirrored_or_turned_result() {
    moved(mirrored, mirrored_plane, |g| [g.x.map(|v| -v), g.y]);
    // Counterclockwise: right becomes up.
    moved(quarter_turned, quarter_turned_plane, |g| {
        [g.y.map(|v| -v), g.x]
    });
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for (frame, case) in &cases() {
        let case = *case;
        let alone = on_threads(1, || run(case, frame));
        for threads in [2, 3, 8] {
            assert_same_bits(&alone, &on_threads(threads, || run(case, frame)));
        }
    }
    let drawn = [Style::Pen, Style::Lines].map(|style| {
        let line = default_but(|line: &mut LineParams| {
            (line.directions, line.strokes.style) = (StrokeDirections::Both, style);
        });
        (Goal::Hatch(Tone::Picture, line), Scale::Sigma(1.5))
    });
    let frames = frames_of_size(2);
    let coarse = in_8_bits(without_depth(frames[0].clone()));
    for frame in frames.iter().chain([&coarse]) {
        for case in drawn {
            let on = |threads| on_threads(threads, || run(case, frame));
            let alone = on(1);
            for threads in [2, 3, 8] {
                let other = on(threads);
                assert_same_bits(&alone, &other);
                let [alone, other] = [&alone, &other].map(|made| made.drawing.as_ref().unwrap());
                assert_eq!(alone.contour_lines, other.contour_lines);
                assert_eq!(alone.lines, other.lines);
            }
        }
    }
}

#[test]
fn any_tile_size_and_number_of_passes_gives_the_same_bits() {
    for (frame, case) in &cases() {
        let case = *case;
        let whole = run(case, frame);
        for sizes in [[7, 5, 1], [33, 80, 3], [96, 16, 5], [1, 1, 2], [16, 24, 64]] {
            let [width, height, sweeps_per_pass] = sizes.map(|n| NonZeroUsize::new(n).unwrap());
            let engine = Engine::cpu().with_options(RunOptions {
                tile: TileSize { width, height },
                sweeps_per_pass,
            });
            let plan = plan(case, frame);
            let cut = engine.execute(&plan, frame, PlanInputs::default(), &Run::new());
            assert_same_bits(&whole, &cut.unwrap());
        }
    }
}

#[test]
fn memory_used_again_leaves_no_trace() {
    let engine = Engine::cpu();
    for (frame, case) in &cases() {
        let case = *case;
        let plan = plan(case, frame);
        let again = engine.execute(&plan, frame, PlanInputs::default(), &Run::new());
        let again = again.unwrap();
        assert_same_bits(&run(case, frame), &again);
        engine.recycle(again);
    }
}

#[test]
fn a_crop_gives_the_same_bits_away_from_its_border() {
    // Directions come from more than 96 pixels away.
    let part = Window {
        x0: 13,
        y0: 9,
        x1: 371,
        y1: 314,
    };
    let frames = frames_of_size(4);
    for (frame, case) in frames.iter().flat_map(|f| CASES.map(|case| (f, case))) {
        let (whole, cropped) = (run(case, frame), run(case, &frame.crop(part)));
        let reach = plan(case, frame).reach() as i32;
        let inner = Window {
            x0: part.x0 + reach,
            y0: part.y0 + reach,
            x1: part.x1 - reach,
            y1: part.y1 - reach,
        };
        for ((name, a), (_, b)) in planes(&whole).into_iter().zip(planes(&cropped)) {
            let (a, b) = (a.crop(frame.data_window, inner), b.crop(part, inner));
            assert!(a == b, "{name} differs inside the crop");
        }
    }
}

#[test]
fn moving_the_windows_changes_nothing() {
    // A picture without a camera may be anywhere: overscan, negative origins.
    for (mut frame, case) in cases() {
        frame.camera = None;
        let here = run(case, &frame);
        frame.data_window = Window::at(-500, 30_000, 96, 80);
        frame.display_window = frame.data_window;
        assert_same_bits(&here, &run(case, &frame));
    }
}
