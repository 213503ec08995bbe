//! The solvers compared with diffusion in double precision, on scenes full of barriers.

use super::Measuring;
use crate::frame::{Plane, Vector2Planes};
use crate::params::{Scale, ShapeParams, Solver};
use crate::plan::Goal;
use crate::report::compare::compare;
use crate::report::engine::{self, Inputs};
use crate::report::scenes::Scene;
use crate::report::timing;
use crate::shape::chebyshev::{Spread, coefficients};

/// Rounding of single precision over hundreds of sweeps, relative to the largest slope.
const ROUNDING: f64 = 3e-6;

/// As an object, where slopes are at most 1 and the tolerance is fully used, and as the viewer's height field.
fn shapes() -> [ShapeParams; 2] {
    [0.0, 1.0].map(|foreshortening| ShapeParams {
        foreshortening,
        ..ShapeParams::default()
    })
}

fn scenes() -> [Scene; 2] {
    [Scene::barriers(200, 150), Scene::ball(160, 120)]
}

fn gradient(scene: &Scene, shape: ShapeParams) -> Vector2Planes {
    let plan = timing::plan(Goal::Layers, &scene.frame, shape).unwrap();
    engine::run(&plan, &scene.frame, Inputs::default())
        .unwrap()
        .shape
        .gradient
        .unwrap()
}

/// Largest error and overshoot of `shape`'s diffusion at its scale, relative to the largest |g|.
fn measured(measuring: &Measuring, scene: &Scene, shape: ShapeParams) -> [f64; 2] {
    let found = gradient(scene, shape);
    let [x, y] = measuring.diffused(shape.scale);
    let mask = &scene.frame.mask;
    let errors = compare([&found.x, &found.y], [&x, &y], mask, measuring.steepest);
    assert_eq!(errors.non_finite, 0);
    [errors.max, measuring.overshoot(&found)]
}

#[test]
fn the_default_tolerance_holds_against_the_exponential() {
    for scene in scenes() {
        for shape in shapes() {
            let measuring = Measuring::new(&scene.frame, shape).unwrap();
            for time in [5.0_f32, 50.0, 400.0, 5000.0] {
                let shape = ShapeParams {
                    scale: Scale::Sigma((2.0 * time).sqrt()),
                    ..shape
                };
                let [error, overshoot] = measured(&measuring, &scene, shape);
                let f = shape.foreshortening;
                println!(
                    "{}, f {f}, t {time}: error {error:.1e}, overshoot {overshoot:.1e}",
                    scene.name
                );
                assert!(error < 1e-4, "{}, f {f}, t {time}: {error}", scene.name);
                // Overshoot is an error: diffusion itself makes no new extremum.
                assert!(
                    overshoot <= error + 1e-7,
                    "{}, f {f}, t {time}: {overshoot}",
                    scene.name
                );
            }
        }
    }
}

#[test]
fn explicit_steps_are_met_to_a_tenth_of_the_tolerance() {
    for scene in scenes() {
        for shape in shapes() {
            let measuring = Measuring::new(&scene.frame, shape).unwrap();
            for count in [1, 10, 50, 200] {
                let shape = ShapeParams {
                    scale: Scale::Iterations(count),
                    ..shape
                };
                let [error, _] = measured(&measuring, &scene, shape);
                let f = shape.foreshortening;
                println!("{}, f {f}, {count} steps: {error:.1e}", scene.name);
                // A tenth of the default tolerance, 1e-4, since steps have one exact result.
                assert!(
                    error < 1e-5,
                    "{}, f {f}, {count} steps: {error}",
                    scene.name
                );
            }
        }
    }
}

#[test]
fn explicit_steps_in_single_precision_are_those_in_double() {
    let scene = Scene::barriers(200, 150);
    for shape in shapes() {
        let measuring = Measuring::new(&scene.frame, shape).unwrap();
        for count in [1, 50, 1000] {
            let shape = ShapeParams {
                solver: Solver::Explicit,
                scale: Scale::Iterations(count),
                ..shape
            };
            let [error, overshoot] = measured(&measuring, &scene, shape);
            assert!(error < ROUNDING, "{count} steps: {error}");
            assert!(overshoot < 1e-6, "{count} steps: {overshoot}");
        }
    }
}

/// The a priori bound: the sum of all |a_k| beyond the degree, plus the correction that preserves the mean. It holds
/// for the root mean square.
fn bound(spread: Spread, tolerance: f64) -> f64 {
    let kept = coefficients(spread, tolerance);
    let all = coefficients(spread, 1e-14);
    let tail: f64 = all.iter().skip(kept.len()).map(|a| a.abs()).sum();
    assert!(tail <= tolerance + 1e-13, "{spread:?}: a tail of {tail}");
    tail + (kept[0] - all[0]).abs()
}

/// Root mean squares of a component's error, and of the component before diffusion.
fn rms(found: &Plane, exact: &Plane<f64>, start: &Plane<f64>) -> [f64; 2] {
    let squares = found.samples().iter().zip(exact.samples());
    let error: f64 = squares.map(|(f, e)| (f64::from(*f) - e).powi(2)).sum();
    let before: f64 = start.samples().iter().map(|v| v * v).sum();
    [error, before].map(|sum| (sum / found.samples().len() as f64).sqrt())
}

#[test]
fn the_error_promised_is_the_error_made() {
    let scene = Scene::barriers(200, 150);
    let shape = shapes()[0];
    let measuring = Measuring::new(&scene.frame, shape).unwrap();
    let mut largest_ratio = 0.0_f64;
    for time in [5.0_f32, 50.0, 400.0] {
        for tolerance in [1e-2_f32, 1e-3, 1e-4, 1e-5] {
            let scale = Scale::Sigma((2.0 * time).sqrt());
            let shape = ShapeParams {
                scale,
                tolerance,
                ..shape
            };
            let allowed = f64::from(tolerance) / shape.largest_slope();
            let bound = bound(Spread::Time(shape.diffusion_time()), allowed);
            let found = gradient(&scene, shape);
            let [x, y] = measuring.diffused(scale);
            for (found, exact, start) in [
                (&found.x, &x, &measuring.gradient[0]),
                (&found.y, &y, &measuring.gradient[1]),
            ] {
                let [error, before] = rms(found, exact, start);
                let ratio = error / (bound * before);
                println!("t {time}, tolerance {tolerance:.0e}: rms {ratio:.2} of the bound");
                assert!(error <= bound * before + ROUNDING, "t {time}, {tolerance}");
            }
            let mask = &scene.frame.mask;
            let errors = compare([&found.x, &found.y], [&x, &y], mask, measuring.steepest);
            let (max, ratio) = (errors.max, errors.max / bound);
            println!(
                "t {time}, tolerance {tolerance:.0e}: {max:.1e}, {ratio:.2} of the bound of {bound:.1e}"
            );
            // The largest error may exceed the bound where waves meet, but never the tolerance.
            assert!(max <= allowed + ROUNDING, "t {time}, {tolerance}: {max}");
            assert!(ratio > 0.05, "t {time}, {tolerance}: {bound} for {max}");
            largest_ratio = largest_ratio.max(ratio);
        }
    }
    // A degree chosen far too high would pass everything above except this.
    assert!(largest_ratio > 0.2, "{largest_ratio}");
}
