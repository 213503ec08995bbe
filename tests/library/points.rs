//! Surface points from any layers that give them: positions, or depth of any kind.

use crate::common::exr::{Part, Stored};
use crate::common::files::{load, read};
use crate::common::program::fixture;
use crate::prelude::*;
use std::fs;
use std::path::PathBuf;

const SIDE: usize = 280;

/// An ellipsoid of 110 px off the view axis, seen through a wide lens: planar depth and that along
/// sight lines differ by 1 part in 17.
fn scene() -> ExactScene {
    let ellipsoid = crate::common::curved::ellipsoid(110.0);
    let [fx, fy, cx, cy] = [400.0, 400.0, 0.0, 140.0];
    ExactScene {
        projection: Projection::Perspective { fx, fy, cx, cy },
        ..ExactScene::orthographic(ellipsoid.moved(DVec3::new(140.0, 0.0, 0.0)), 0.0, 0.0)
    }
}

/// The frame from a file with the normals of the scene in view space and the planes given.
fn read_with(frame: &Frame, planes: &[(&str, &Plane, Stored)], camera: Option<PathBuf>) -> Frame {
    let n = &frame.normal;
    let mut part = Part::of([("N.X", &n.x), ("N.Y", &n.y), ("N.Z", &n.z)]);
    for &(name, plane, stored) in planes {
        part = part.channel(name, stored, plane);
    }
    let loaded = read(part, |inputs, needs| {
        (inputs.camera, inputs.normal_space) = (camera, Some(NormalSpace::View));
        needs.projection = true;
    });
    loaded.frame
}

/// The 95th percentile of the angle, in degrees, between the directions of two frames, and the source of the first
/// one's points.
fn compared(frame: &Frame, truth: &Frame) -> (f64, Points) {
    let run = |frame: &Frame| {
        let plan = cpu::plan(Goal::LAYERS, frame, ShapeParams::default()).unwrap();
        (cpu::run(&plan, frame).unwrap().shape, plan.points)
    };
    let ((found, points), (exact, _)) = (run(frame), run(truth));
    let (a, b) = (found.direction.unwrap(), exact.direction.unwrap());
    let open = exact.conductance.unwrap();
    let mut angles = Vec::new();
    for (x, y) in places(SIDE, SIDE) {
        if open.at(x, y) == 1.0 && truth.normal.z.at(x, y) > 0.5 {
            let sine = a.x.at(x, y) * b.y.at(x, y) - a.y.at(x, y) * b.x.at(x, y);
            angles.push(f64::from(sine.abs()).asin().to_degrees());
        }
    }
    assert!(angles.len() > 5000);
    (quantile(&sorted(angles), 0.95), points)
}

#[test]
fn positions_stand_in_for_depth() {
    let scene = scene();
    let frame = scene.frame(SIDE, SIDE);
    // The scene in units of 110 px, looked at from aside, at the origin and far from it: there f32
    // counts in steps of 6e-5, 7e-3 px.
    for (place, bound) in [(0.0, 0.01), (1000.0, 0.3)] {
        let turn = DMat3::from_rotation_y(0.8) * DMat3::from_rotation_x(-0.4);
        let world = DAffine3::from_mat3_translation(turn, DVec3::new(place, -place, 0.5 * place));
        let seen = |e: Exact| world.transform_point3(e.point / 110.0);
        let at = |x, y| scene.exact(x, y).map_or(DVec3::ZERO, seen);
        let Vector3Planes { x, y, z } = Vector3Planes::from_fn(SIDE, SIDE, at);
        let position = [("P.X", &x), ("P.Y", &y), ("P.Z", &z)];
        let position = position.map(|(name, plane)| (name, plane, Stored::Float));
        let loaded = read_with(&frame, &position, None);
        assert_eq!(loaded.source.depth_kind, DepthKind::Planar);
        assert_eq!(loaded.mask, frame.mask);
        let [depth, truth] = [&loaded, &frame].map(|frame| frame.depth.as_ref().unwrap());
        for (found, exact) in depth.samples().iter().zip(truth.samples()) {
            assert!((found * 110.0 - exact).abs() < 1e-3 + 2e-5 * place as f32 * 110.0);
        }
        let (p95, points) = compared(&loaded, &frame);
        assert_eq!(points, Points::Depth);
        assert!(p95 < bound, "around {place}: {p95} degrees");
    }
}

#[test]
fn what_depth_measures_is_told_by_the_normals() {
    let (scene, desk) = (scene(), tempfile::tempdir().unwrap());
    let frame = scene.frame(SIDE, SIDE);
    let camera = desk.path().join("camera.json");
    let lens = r#"{"focal_px": 400, "principal_point_px": [0, 140]}"#;
    fs::write(&camera, lens).unwrap();
    type Depth = fn(&Exact) -> f64;
    let planar: Depth = |e| e.depth;
    #[rustfmt::skip]
    let cases: [(&str, Depth, Stored, DepthKind); 4] = [
        ("planar", planar, Stored::Float, DepthKind::Planar),
        ("sight line", |e| e.point.length(), Stored::Float, DepthKind::Ray),
        ("inverse", |e| 1.0 / e.depth, Stored::Float, DepthKind::Planar),
        ("half floats", planar, Stored::Half, DepthKind::Relative),
    ];
    for (name, depth, stored, kind) in cases {
        let seen = |x, y| scene.exact(x, y).as_ref().map_or(0.0, depth) as f32;
        let depth = Plane::from_fn(SIDE, SIDE, seen);
        let loaded = read_with(&frame, &[("Z", &depth, stored)], Some(camera.clone()));
        assert_eq!(loaded.source.depth_kind, kind, "{name}");
        let (p95, points) = compared(&loaded, &frame);
        let is_relative = kind == DepthKind::Relative;
        assert_eq!(points == Points::Depth, !is_relative, "{name}");
        // Points from normals are of the second order too; 0.0037 was measured.
        assert!(p95 < 0.01, "{name}: {p95} degrees");
    }
}

#[test]
fn coarse_storage_of_normals_is_known() {
    let frame = scene().frame(SIDE, SIDE);
    assert_eq!(read_with(&frame, &[], None).source.normal_rounding, 0.0);
    let steps = |rounding| ShapeParams::default().direction_steps_px(rounding);
    assert_eq!(steps(0.0), [1, 1]);
    let tablet = load(fixture("tablet.color.jpg"), |inputs, _| {
        inputs.normal = Some(fixture("tablet.normal.png").display().to_string());
    });
    let rounding = tablet.frame.source.normal_rounding;
    assert_eq!(rounding, 1.0 / 255.0);
    assert_eq!(steps(rounding), [4, 16]);
}
