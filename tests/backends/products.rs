//! Analytic scenes and real ones, with every solver and kind of readout.

use super::{assert_alike, assert_same, on_gpu, plan, waves, with_color};
use glam::DVec3;
use relievo::engine::{Engine, Run};
use relievo::frame::{Frame, Normals, Plane};
use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load};
use relievo::params::{Adaptive, Scale, ScalingParams, ShapeParams, Solver};
use relievo::plan::{Available, Goal, Plan};
use relievo::product::Product;
use relievo::scenes::{ExactScene, Surface};
use std::f64::consts::TAU;

const GOALS: [Goal; 3] = [Goal::LAYERS, Goal::Display, Goal::Enhance];

fn settings() -> Vec<(&'static str, ShapeParams)> {
    let with = |change: fn(&mut ShapeParams)| {
        let mut params = ShapeParams::default();
        change(&mut params);
        params
    };
    vec![
        ("usual", ShapeParams::default()),
        ("finest", with(|p| p.scale = Scale::Iterations(0))),
        (
            "explicit",
            with(|p| {
                p.solver = Solver::Explicit;
                p.scale = Scale::Iterations(33);
                p.foreshortening = 0.7;
            }),
        ),
        (
            "wide",
            with(|p| {
                p.scale = Scale::Sigma(9.0);
                p.foreshortening = 1.0;
            }),
        ),
        ("reference", with(|p| p.reference_height = Some(60))),
    ]
}

#[test]
fn solvers_and_scales() {
    on_gpu(|runner| {
        // A torus has a border; its size is no multiple of a workgroup.
        let torus = ExactScene::orthographic(Surface::torus(45.0, 18.0, DVec3::Z), 70.0, 66.0);
        let torus = with_color(torus.frame(147, 131));
        for (scene, frame) in [("waves", waves(203, 155)), ("torus", torus)] {
            for (name, shape) in settings() {
                for goal in GOALS {
                    let plan = plan(goal, &frame, shape, ScalingParams::default());
                    let name = format!("{scene}, {name}, {goal:?}");
                    assert_same(&name, runner, &plan, &frame);
                }
            }
        }
    });
}

#[test]
fn several_scales_at_once() {
    on_gpu(|runner| {
        let frame = waves(120, 90);
        let available = Available::in_frame(&frame);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = Plan::new(
            Goal::Layers {
                and: &[],
                more_px: &[1.0, 5.0],
            },
            available,
            shape,
            scaling,
        )
        .unwrap();
        assert_same("scales", runner, &plan, &frame);
        let scale = Scale::mixed(&[(1.0, 1.0), (5.0, 1.0)]).unwrap();
        let plan = Plan::new(
            Goal::LAYERS,
            available,
            ShapeParams { scale, ..shape },
            scaling,
        )
        .unwrap();
        assert_same("mixed scales", runner, &plan, &frame);
    });
}

/// Waves on a slope that continue across opposite borders.
fn tile(width: usize, height: usize, wraps: [bool; 2]) -> Frame {
    let normals: Vec<f32> = (0..width * height)
        .flat_map(|i| {
            let [u, v] = [
                (i % width) as f64 / width as f64,
                (i / width) as f64 / height as f64,
            ];
            let slope = [
                0.5 + 0.3 * (TAU * (2.0 * u + v)).cos(),
                0.4 + 0.2 * (TAU * (u - v)).sin(),
            ];
            let n = DVec3::new(-slope[0], -slope[1], 1.0).normalize();
            n.as_vec3().to_array()
        })
        .collect();
    let frame = Frame::builder(width, height)
        .normals(Normals::view(&normals))
        .build();
    Frame {
        wraps,
        ..frame.unwrap()
    }
}

/// Joined borders, at scales of some 50 sweeps, more than there are rows: a third of the wider waves is left.
#[test]
fn tiles() {
    on_gpu(|_| {
        let engines = [Engine::gpu().unwrap(), Engine::cpu()];
        for (wraps, sigma) in [
            ([true, true], 8.0),
            ([true, false], 6.0),
            ([false, true], 10.0),
        ] {
            let frame = tile(67, 45, wraps);
            let shape = ShapeParams {
                scale: Scale::Sigma(sigma),
                ..ShapeParams::default()
            };
            let plan = plan(Goal::LAYERS, &frame, shape, ScalingParams::default());
            let [found, expected] = engines.each_ref().map(|engine| {
                let inputs = relievo::engine::PlanInputs::default();
                engine.execute(&plan, &frame, inputs, &Run::new()).unwrap()
            });
            let name = format!("tile {wraps:?} at {sigma}");
            assert_alike(&name, &found, &expected, |product| {
                (product != Product::Picture).then(|| product.tolerance())
            });
        }
    });
}

#[test]
fn importance() {
    on_gpu(|runner| {
        let mut frame = waves(130, 80);
        frame.importance = Some(Plane::from_fn(130, 80, |x, _| x as f32 / 129.0));
        for solver in [Solver::Chebyshev, Solver::Explicit] {
            let shape = ShapeParams {
                solver,
                scale: Scale::Iterations(21),
                ..ShapeParams::default()
            };
            let plan = plan(Goal::LAYERS, &frame, shape, ScalingParams::default());
            assert_same("importance", runner, &plan, &frame);
        }
    });
}

#[test]
fn given_numbers_and_other_sources_of_silhouettes() {
    on_gpu(|runner| {
        let mut frame = waves(90, 70);
        frame.depth = None;
        let scaling = ScalingParams {
            curvature_gain: Adaptive::Fixed(7.0),
            white_level: Adaptive::Fixed(0.6),
            ..ScalingParams::default()
        };
        let shape = ShapeParams::default();
        let border = plan(Goal::Enhance, &frame, shape, scaling);
        assert_same("border", runner, &border, &frame);
        frame.occlusion = Some(Plane::from_fn(90, 70, |x, y| {
            (0.5 + 0.5 * (0.2 * x as f32 + 0.3 * y as f32).sin()).clamp(0.0, 1.0)
        }));
        frame.normal_length = Some(Plane::from_fn(90, 70, |x, _| 1.0 - 0.005 * x as f32));
        let occlusion = plan(Goal::LAYERS, &frame, shape, scaling);
        assert_same("occlusion and filtered", runner, &occlusion, &frame);
    });
}

#[test]
fn real_renders() {
    on_gpu(|runner| {
        let inputs = Inputs {
            picture: "fixtures/bust.exr".into(),
            ..Inputs::default()
        };
        let needs = Needs {
            color: true,
            projection: true,
            ..Needs::default()
        };
        let frame = load(&inputs, needs).unwrap().frame;
        for goal in GOALS {
            let plan = plan(
                goal,
                &frame,
                ShapeParams::default(),
                ScalingParams::default(),
            );
            assert_same(&format!("bust, {goal:?}"), runner, &plan, &frame);
        }
    });
}
