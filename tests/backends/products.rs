//! Analytic scenes and real ones, with every solver and kind of readout.

use super::{GOALS, assert_alike, assert_same, on_gpu, plan, waves, with_color, with_shape};
use crate::common::cpu;
use glam::DVec3;
use relievo::engine::{Engine, PlanInputs, Run};
use relievo::frame::{Frame, Normals, Plane};
use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load};
use relievo::params::{Adaptive, Params, Scale, ShapeParams, Solver};
use relievo::plan::Goal;
use relievo::product::Product;
use relievo::scenes::{ExactScene, Surface};
use std::f64::consts::TAU;

type Change = fn(&mut ShapeParams);

const SETTINGS: [(&str, Change); 5] = [
    ("usual", |_| ()),
    ("finest", |p| p.scale = Scale::Iterations(0)),
    ("explicit", |p| {
        p.solver = Solver::Explicit;
        p.scale = Scale::Iterations(33);
        p.foreshortening = 0.7;
    }),
    ("wide", |p| {
        p.scale = Scale::Sigma(9.0);
        p.foreshortening = 1.0;
    }),
    ("reference", |p| p.reference_height = Some(60)),
];

#[test]
fn solvers_and_scales() {
    on_gpu(|runner| {
        // A torus has a border; its size is no multiple of a workgroup.
        let torus = ExactScene::orthographic(Surface::torus(45.0, 18.0, DVec3::Z), 70.0, 66.0);
        let torus = with_color(torus.frame(147, 131));
        for (scene, frame) in [("waves", waves(203, 155)), ("torus", torus)] {
            for (name, change) in SETTINGS {
                let name = format!("{scene}, {name}");
                assert_same(&name, runner, &GOALS, &frame, &with_shape(change));
            }
        }
    });
}

#[test]
fn several_scales_at_once() {
    on_gpu(|runner| {
        let frame = waves(120, 90);
        let scales = Goal::Layers {
            and: &[],
            more_px: &[1.0, 5.0],
        };
        assert_same("scales", runner, &[scales], &frame, &Params::default());
        let mixed = Scale::mixed(&[(1.0, 1.0), (5.0, 1.0)]).unwrap();
        let mixed = with_shape(|shape| shape.scale = mixed);
        assert_same("mixed scales", runner, &[Goal::LAYERS], &frame, &mixed);
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
            let normal = DVec3::new(-slope[0], -slope[1], 1.0).normalize();
            normal.as_vec3().to_array()
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
        let device = Engine::gpu().unwrap();
        for (wraps, sigma) in [
            ([true, true], 8.0),
            ([true, false], 6.0),
            ([false, true], 10.0),
        ] {
            let frame = tile(67, 45, wraps);
            let shape = with_shape(|shape| shape.scale = Scale::Sigma(sigma));
            let plan = plan(Goal::LAYERS, &frame, &shape);
            let found = device.execute(&plan, &frame, PlanInputs::default(), &Run::new());
            let (found, expected) = (found.unwrap(), cpu::run(&plan, &frame).unwrap());
            let name = format!("tile {wraps:?} at {sigma}");
            assert_alike(&name, &found, &expected, |product| {
                product != Product::Picture
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
            let params = with_shape(|shape| {
                (shape.solver, shape.scale) = (solver, Scale::Iterations(21));
            });
            let name = format!("importance, {solver:?}");
            assert_same(&name, runner, &[Goal::LAYERS], &frame, &params);
        }
    });
}

#[test]
fn given_numbers_and_other_sources_of_silhouettes() {
    on_gpu(|runner| {
        let mut frame = waves(90, 70);
        frame.depth = None;
        let mut params = Params::default();
        params.scaling.curvature_gain = Adaptive::Fixed(7.0);
        params.scaling.white_level = Adaptive::Fixed(0.6);
        assert_same("border", runner, &[Goal::Enhance], &frame, &params);
        frame.occlusion = Some(Plane::from_fn(90, 70, |x, y| {
            (0.5 + 0.5 * (0.2 * x as f32 + 0.3 * y as f32).sin()).clamp(0.0, 1.0)
        }));
        frame.normal_length = Some(Plane::from_fn(90, 70, |x, _| 1.0 - 0.005 * x as f32));
        let name = "occlusion and filtered";
        assert_same(name, runner, &[Goal::LAYERS], &frame, &params);
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
        assert_same("bust", runner, &GOALS, &frame, &Params::default());
    });
}
