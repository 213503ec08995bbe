//! Several scales, and scales of every pixel's own, from the sweeps of one.

use crate::common::cpu::{self, described};
use crate::prelude::*;

/// Balls one before the other: silhouettes between them, smooth parts, uncovered ground.
fn frame() -> Frame {
    let scene = ExactScene::two_balls(26.0, 37.0, 61.3, 52.6).in_perspective();
    scene.frame(120, 100)
}

fn with(solver: Solver, scale: Scale) -> ShapeParams {
    default_but(|shape: &mut ShapeParams| (shape.solver, shape.scale) = (solver, scale))
}

fn gradient(frame: &Frame, shape: ShapeParams) -> Vector2Planes {
    described(frame, shape).shape.gradient.unwrap()
}

/// Expects two planes to have the same bits, except for the sign of 0.
#[track_caller]
fn same(a: &Plane, b: &Plane) {
    for (a, b) in a.samples().iter().zip(b.samples()) {
        assert_eq!(a, b);
    }
}

fn without_importance(frame: &Frame) -> Frame {
    Frame {
        importance: None,
        ..frame.clone()
    }
}

/// A frame whose pixels have the importance of `share(n)`, `n` running through the numbers below `count`.
fn painted(count: usize, share: impl Fn(usize) -> f32) -> (Frame, Plane<usize>) {
    let mut frame = frame();
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let number = Plane::from_fn(width, height, |x, y| (x * 7 + y * 13) % count);
    frame.importance = Some(number.map(share));
    (frame, number)
}

#[test]
fn explicit_steps_stop_where_a_pixel_has_had_its_share() {
    // 20 steps, in shares of 1/4 (few levels) and of 1/20 (many).
    for count in [5, 21] {
        let share = |n: usize| n as f32 / (count - 1) as f32;
        let (frame, number) = painted(count, share);
        let found = gradient(&frame, with(Solver::Explicit, Scale::Iterations(20)));
        let plain = without_importance(&frame);
        for n in 0..count {
            let steps = 20 * n / (count - 1);
            let scale = Scale::Iterations(steps as u32);
            let expected = gradient(&plain, with(Solver::Explicit, scale));
            for (x, y) in places(120, 100) {
                if number.at(x, y) == n {
                    let at = |planes: &Vector2Planes| (planes.x.at(x, y), planes.y.at(x, y));
                    assert_eq!(at(&found), at(&expected), "{steps} steps at ({x}, {y})");
                }
            }
        }
    }
}

#[test]
fn every_pixel_is_diffused_for_its_share_of_the_time() {
    let sigma = 6.0;
    for count in [5, 12] {
        let share = |n: usize| n as f32 / (count - 1) as f32;
        let (frame, number) = painted(count, share);
        let found = gradient(&frame, with(Solver::Chebyshev, Scale::Sigma(sigma)));
        let plain = without_importance(&frame);
        for n in 0..count {
            // A share of the time is its root of the sigma. The map is stored in 1023 steps: a time off by
            // 1/2046 of t changes a wave of decay m by t m e^(-s t m) / 2046, at most 1 / (2046 e s).
            let share = share(n);
            let scale = Scale::Sigma(sigma * share.sqrt());
            let expected = gradient(&plain, with(Solver::Chebyshev, scale));
            let in_time = if share > 0.0 { 1.8e-4 / share } else { 0.0 };
            for (x, y) in places(120, 100) {
                if number.at(x, y) == n {
                    let error = (found.x.at(x, y) - expected.x.at(x, y)).abs();
                    // Twice the tolerance: both are expansions.
                    let bound = 2e-4 + in_time;
                    assert!(error < bound, "share {share} at ({x}, {y}): {error}");
                }
            }
        }
    }
}

#[test]
fn full_importance_is_as_none_and_no_number_is_none_at_all() {
    for solver in [Solver::Chebyshev, Solver::Explicit] {
        let shape = with(solver, Scale::Sigma(4.0));
        let plain = frame();
        let with_importance = |importance| Frame {
            importance: Some(importance),
            ..plain.clone()
        };
        let ones = with_importance(Plane::filled(120, 100, 1.0));
        same(&gradient(&ones, shape).x, &gradient(&plain, shape).x);
        let hostile = [f32::NAN, -1.0, f32::NEG_INFINITY];
        let nothing = with_importance(Plane::from_fn(120, 100, |x, _| hostile[x % 3]));
        let expected = gradient(&plain, with(solver, Scale::Iterations(0)));
        same(&gradient(&nothing, shape).x, &expected.x);
    }
}

/// A plan of all layers, with more scales.
fn plan_with(frame: &Frame, shape: ShapeParams, more_px: &[f32]) -> relievo::Result<Plan> {
    cpu::plan(Goal::Layers { and: &[], more_px }, frame, shape)
}

#[test]
fn several_scales_are_what_each_is_alone() {
    let frame = frame();
    let sigmas = [3.0_f32, 8.0, 0.0, 1.5];
    let at = |sigma| with(Solver::Chebyshev, Scale::Sigma(sigma));
    let plan = plan_with(&frame, at(sigmas[0]), &sigmas[1..]).unwrap();
    let all = cpu::run(&plan, &frame).unwrap().shape;
    assert_eq!(all.more_scales.len(), 3);
    for (scale, sigma) in all.more_scales.iter().zip(&sigmas[1..]) {
        assert_eq!(scale.sigma_px, *sigma);
        let alone = described(&frame, at(*sigma)).shape.curvatures.unwrap();
        same(&scale.curvatures.u, &alone.u);
    }
    same(&all.gradient.unwrap().x, &gradient(&frame, at(sigmas[0])).x);
}

/// Slopes of two scales, with weights in proportion to them: .2 of 2 px and .8 of 8.
#[test]
fn mixed_scales_add_up() {
    let (plain, number) = painted(3, |_| 1.0);
    let at = |frame: &Frame, scale| gradient(frame, with(Solver::Chebyshev, scale));
    let (fine, coarse) = (Scale::Sigma(2.0), Scale::Sigma(8.0));
    let mixed = Scale::mixed(&[(2.0, 1.0), (8.0, 1.0)]).unwrap();
    let full = at(&plain, mixed);
    // By importance both times shrink: a quarter of the time is half of the sigma.
    let mut shared = plain.clone();
    shared.importance = Some(number.map(|n| [0.0, 0.25, 1.0][n]));
    let shared = at(&shared, mixed);
    let plain = without_importance(&plain);
    let expected = [(0.0, 0.0), (1.0, 4.0), (2.0, 8.0)].map(|(fine, coarse)| {
        let [fine, coarse] = [fine, coarse].map(|sigma| at(&plain, Scale::Sigma(sigma)).x);
        Plane::from_fn(120, 100, |x, y| 0.2 * fine.at(x, y) + 0.8 * coarse.at(x, y))
    });
    let [fine, coarse] = [fine, coarse].map(|scale| at(&plain, scale).x);
    let mut changed = 0.0_f32;
    for (x, y) in covered(&plain.mask) {
        // Each is within the tolerance of 1e-4; a map of importance is stored in 1023 steps.
        let error = (full.x.at(x, y) - expected[2].at(x, y)).abs();
        assert!(error < 2e-4, "({x}, {y}): {error}");
        let error = (shared.x.at(x, y) - expected[number.at(x, y)].at(x, y)).abs();
        assert!(error < 1e-3, "({x}, {y}): {error}");
        changed = changed.max((fine.at(x, y) - coarse.at(x, y)).abs());
    }
    assert!(changed > 0.05, "{changed}");
}

#[test]
fn several_scales_are_refused_where_they_cannot_share() {
    let mut frame = frame();
    let plan = |frame: &Frame, solver, more: &[f32]| {
        plan_with(frame, with(solver, Scale::Sigma(2.0)), more)
    };
    assert!(plan(&frame, Solver::Chebyshev, &[4.0]).is_ok());
    assert!(plan(&frame, Solver::Explicit, &[4.0]).is_err());
    let mixed = |solver, sigma| {
        let mixed = Scale::mixed(&[(2.0, 1.0), (sigma, 1.0)]).unwrap();
        plan_with(&frame, with(solver, mixed), &[])
    };
    assert!(mixed(Solver::Chebyshev, 4.0).is_ok());
    assert!(mixed(Solver::Explicit, 4.0).is_err());
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        assert!(plan(&frame, Solver::Chebyshev, &[bad]).is_err());
        assert!(mixed(Solver::Chebyshev, bad).is_err());
    }
    frame.importance = Some(Plane::filled(120, 100, 0.5));
    assert!(plan(&frame, Solver::Chebyshev, &[4.0]).is_err());
    assert!(plan(&frame, Solver::Chebyshev, &[]).is_ok());
}
