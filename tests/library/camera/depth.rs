//! Rotations and lenses recovered from the depth and normals of small scenes.

use super::measure::{expect_rotation, focal_error, turn_between, turn_deg};
use super::planes::strew;
use super::shots::{Numbers, Scene, Seen, Shot, looking, panorama, perspective};
use crate::common::exr::Part;
use crate::common::files::read;
use crate::prelude::*;
use glam::EulerRot;
use relievo::io::camera::{DepthCamera, RecoveryFailure, recover_camera_from_depth};

struct Layers {
    normal: Vector3Planes,
    depth: Plane,
    mask: Mask,
}

/// The layers seen in a shot, with its degradations.
fn layers_of(shot: &Shot) -> Layers {
    // Depth comes from a random place in the pixel, normals from its middle.
    let (near, middle) = (shot.seen_jittered(&mut Numbers(7)), shot.seen());
    let (w, h) = (middle.width(), middle.height());
    let depth = |s: Seen| shot.stored(if shot.ray { s.distance } else { s.steps }) as f32;
    let normal = |s: Seen| (shot.normals * s.normal).map(|v| shot.stored(v));
    let are_both = |x, y| near.at(x, y).is_some() && middle.at(x, y).is_some();
    Layers {
        normal: Vector3Planes::from_fn(w, h, |x, y| middle.at(x, y).map_or(DVec3::ZERO, normal)),
        depth: near.map(|s| s.map_or(1e10, depth)),
        mask: Mask::new(Plane::from_fn(w, h, are_both)),
    }
}

fn recovered_from(shot: &Shot, layers: &Layers) -> Result<DepthCamera, RecoveryFailure> {
    let Layers {
        normal,
        depth,
        mask,
    } = layers;
    let (data, display) = (shot.data, shot.display);
    recover_camera_from_depth(normal, depth, mask, data, display, shot.aspect as f32)
}

fn recovered(shot: &Shot) -> Result<DepthCamera, RecoveryFailure> {
    recovered_from(shot, &layers_of(shot))
}

#[test]
fn exact_layers_give_rotation_and_focal_length() {
    let shot = Shot::default();
    let found = recovered(&shot).unwrap();
    assert_eq!(found.depth_kind, DepthKind::Planar);
    assert!(found.residual_deg_median < 0.2 && found.rotation_uncertainty_deg < 0.1);
    let rough = Shot::with(|shot| (shot.jitter, shot.half) = (0.5, true));
    assert_eq!(recovered(&rough).unwrap(), recovered(&rough).unwrap());
    let ray = recovered(&Shot::with(|shot| shot.ray = true)).unwrap();
    assert_eq!(ray.depth_kind, DepthKind::Ray);
}

fn turned(shot: &mut Shot, angles: [f64; 3]) {
    let [a, b, c] = angles;
    shot.normals = DMat3::from_euler(EulerRot::XYZ, a, b, c);
}

/// Of what is not bounded.
const ANY: f64 = f64::INFINITY;

/// What is done to the usual shot; the largest errors of its rotation, in degrees, and of its focal length, as a share.
type Row = (&'static str, fn(&mut Shot), f64, f64);

#[rustfmt::skip]
const SHOTS: [Row; 15] = [
    ("exact", |_| (), 0.02, 2e-3),
    ("turned", |s| turned(s, [0.4, -1.1, 2.0]), 0.02, ANY),
    ("turned otherwise", |s| turned(s, [-2.5, 0.7, 0.3]), 0.02, ANY),
    ("turned far", |s| turned(s, [3.1, 1.4, -1.9]), 0.02, ANY),
    ("rolled", |s| {
        let roll = DAffine3::from_mat3(DMat3::from_rotation_z(2.2));
        s.camera.view_from_world = roll * looking(DVec3::new(-3.0, -4.0, 4.0))
    }, 0.05, ANY),
    ("half floats", |s| s.half = true, 0.1, ANY),
    ("jitter", |s| s.jitter = 0.5, 0.3, ANY),
    ("half floats and jitter", |s| (s.half, s.jitter) = (true, 0.5), 0.3, ANY),
    ("parallel", |s| *s = Shot::parallel(1.0), 0.05, 5e-3),
    ("parallel and rough", |s| { *s = Shot::parallel(1.0); (s.half, s.jitter) = (true, 0.5) }, 0.5, ANY),
    ("along the ray", |s| s.ray = true, 0.02, 2e-3),
    ("cropped", |s| s.data = Window::at(40, 30, 200, 170), 0.03, 5e-3),
    ("wide pixels", |s| {
        (s.aspect, s.camera) = (2.0, perspective(DVec3::new(1.0, -6.0, 2.5), 380.0, s.display, 2.0))
    }, 0.03, 5e-3),
    ("a long lens", |s| s.camera = perspective(DVec3::new(16.0, -96.0, 40.0), 6400.0, s.display, 1.0), 0.05, 0.01),
    ("in view space", |s| s.normals = s.camera.view_from_world.matrix3, 0.02, ANY),
];

#[test]
fn cameras_of_every_kind_are_found_in_spite_of_flaws() {
    for (name, change, degrees, share) in SHOTS {
        let shot = Shot::with(change);
        let found = recovered(&shot).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let truth = shot.camera.view_from_world.matrix3 * shot.normals.transpose();
        expect_rotation(&found.camera, truth, degrees, &(name, &found));
        assert_eq!(found.camera.view_from_world.translation, DVec3::ZERO);
        let off = focal_error(&found.camera, &shot.camera);
        let is_known = off < share && !found.focal_uncertain || share == ANY;
        assert!(is_known, "{name}: focal length off by {off}");
    }
}

#[test]
fn one_plane_leaves_a_turn_open() {
    for projection in [Shot::default(), Shot::parallel(1.0)] {
        for (jitter, half) in [(0.0, false), (0.5, true)] {
            let shot = Shot {
                scene: Scene::Ground,
                jitter,
                half,
                ..projection.clone()
            };
            let failure = recovered(&shot).expect_err("guessed a camera");
            use RecoveryFailure::{ParallelNormals, Undetermined};
            assert!(matches!(failure, ParallelNormals | Undetermined { .. }));
        }
    }
}

#[test]
fn mirrored_normals_are_turned_by_a_mirror() {
    let shot = Shot::default();
    let mut layers = layers_of(&shot);
    layers.normal.x = layers.normal.x.map(|x| -x);
    let found = recovered_from(&shot, &layers).unwrap();
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let turn = found.camera.view_from_world.matrix3 * mirror;
    assert!(turn_deg(turn, shot.camera.view_from_world.matrix3) < 0.05);
}

#[test]
fn depth_that_is_none_is_refused() {
    let shot = Shot::default();
    let mut layers = layers_of(&shot);
    let mut numbers = Numbers(1);
    layers.depth = layers.depth.map(|_| 1.0 + numbers.next() as f32);
    assert!(recovered_from(&shot, &layers).is_err());
    layers.depth = layers_of(&shot).normal.y.map(|n| 2.0 + n);
    assert!(recovered_from(&shot, &layers).is_err(), "fitted shading");
}

#[test]
fn bad_layers_fail_without_panic() {
    for value in [0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, f32::MAX] {
        for (w, h) in [(0, 0), (1, 1), (1, 90), (2, 2), (64, 64)] {
            let shot = Shot::with(|shot| shot.of_size(w, h));
            for (x, depth) in [(value, 1.0), (1.0, value), (value, value)] {
                let layers = Layers {
                    normal: Vector3Planes::from_fn(w, h, |_, _| DVec3::new(x.into(), 0.0, 0.0)),
                    depth: Plane::filled(w, h, depth),
                    mask: Mask::full(w, h),
                };
                let is_refused = recovered_from(&shot, &layers).is_err();
                assert!(is_refused, "{value} in {w}x{h}");
            }
        }
    }
}

#[test]
fn stray_values_and_an_empty_mask_do_no_harm() {
    let shot = Shot::default();
    let mut layers = layers_of(&shot);
    strew(&mut layers.depth, 5, 37);
    strew(&mut layers.normal.z, 5, 41);
    let found = recovered_from(&shot, &layers).unwrap();
    assert!(turn_between(&found.camera, &shot.camera) < 0.05);
    layers.mask = Mask::new(Plane::filled(320, 240, false));
    let failure = recovered_from(&shot, &layers).unwrap_err();
    let is_told = matches!(failure, RecoveryFailure::TooFewPatches { found: 0, .. });
    assert!(is_told, "{failure}");
}

#[test]
fn panoramas_are_refused() {
    let (w, h) = (512, 256);
    let seen = panorama(w, h);
    let normal = |x, y| seen.at(x, y).map_or(DVec3::ZERO, |s| s.normal);
    let layers = Layers {
        normal: Vector3Planes::from_fn(w, h, normal),
        depth: seen.map(|s| s.map_or(1e10, |s| s.steps as f32)),
        mask: Mask::new(seen.map(|s| s.is_some())),
    };
    let shot = Shot::with(|shot| shot.of_size(w, h));
    assert!(recovered_from(&shot, &layers).is_err(), "fitted a panorama");
}

/// Most of the picture is a wall that faces the viewer: any lens explains it.
#[test]
fn a_ball_before_a_wall_tells_parallel_lines_of_sight_from_perspective() {
    let display = Window::from_size(96, 96);
    // A ball of 30 pixels, its middle 90 from the picture plane, and the wall 120.
    let mut scene = ExactScene::orthographic(Surface::ball(30.0), 48.0, 48.0);
    let wall = Surface::plane(DVec3::Z).moved(DVec3::new(0.0, 0.0, -30.0));
    scene.surfaces.push(wall);
    let Frame {
        normal,
        depth,
        mask,
        ..
    } = scene.at_distance(90.0).frame(96, 96);
    let depth = depth.unwrap().map(|depth| depth / 30.0);
    let found = recover_camera_from_depth(&normal, &depth, &mask, display, display, 1.0).unwrap();
    let Projection::Orthographic { sx, .. } = found.camera.projection else {
        panic!("{found:?}");
    };
    assert!((sx / 30.0 - 1.0).abs() < 0.01, "{found:?}");
    assert!(!found.has_equal && !found.is_scattered);
}

/// Normals that are nearly parallel follow the slopes of depth and, turned by half a circle, those of its inverse.
#[test]
fn depth_of_a_nearly_flat_surface_is_taken_for_what_it_is() {
    let waves = |x: usize, y: usize| {
        let (x, y) = (x as f64 / 6.0, -(y as f64) / 6.0);
        // 50 pixels are a unit: a wave of 0.02 over 6 pixels rises by 0.17 at most.
        let [along_x, along_y] = [x.cos() * y.sin(), x.sin() * y.cos()].map(|v| v / 6.0);
        let normal = DVec3::new(-along_x, -along_y, 1.0).normalize();
        (0.02 * x.sin() * y.sin(), normal)
    };
    let depth = Plane::from_fn(96, 96, |x, y| (10.0 - waves(x, y).0) as f32);
    let normal = Vector3Planes::from_fn(96, 96, |x, y| waves(x, y).1);
    let Vector3Planes { x, y, z } = &normal;
    let part = Part::of([("N.X", x), ("N.Y", y), ("N.Z", z), ("Z", &depth)]);
    let loaded = read(part, |_, needs| needs.projection = true);
    assert_eq!(loaded.conventions.depth_kind, Some(StoredDepth::Planar));
    let camera = loaded.frame.camera.unwrap();
    let is_parallel = matches!(camera.projection, Projection::Orthographic { .. });
    assert!(is_parallel, "{camera:?}");
}

#[test]
fn scattered_depth_is_told_from_samples_within_their_pixels() {
    let scattered = |jitter| {
        let found = recovered(&Shot::with(|shot| shot.jitter = jitter));
        found.unwrap().is_scattered
    };
    // Uniform over a pixel, and over three: standard deviations of 0.29 and 0.87.
    assert_eq!([0.5, 1.5].map(scattered), [false, true]);
}
