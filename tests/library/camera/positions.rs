//! Cameras recovered from the positions of small scenes.

use super::measure::{expect_rotation, focal_error, turn_between, turn_deg};
use super::planes::strew;
use super::shots::{Numbers, Scene, Shot, panorama, perspective};
use crate::prelude::*;
use relievo::io::camera::{RecoveredCamera, RecoveryFailure, recover_camera};

/// The positions seen in a shot, with its degradations.
fn positions(shot: &Shot) -> (Vector3Planes, Mask) {
    let mut numbers = Numbers(7);
    let mut points = shot.seen_jittered(&mut numbers).map(|s| s.map(|s| s.point));
    mix(shot.mixed, points.samples_mut(), &mut numbers);
    let stored = |p: DVec3| (p + shot.offset).map(|v| shot.stored(v));
    let position = Vector3Planes::from_fn(points.width(), points.height(), |x, y| {
        points.at(x, y).map_or(DVec3::ZERO, stored)
    });
    (position, Mask::new(points.map(|p| p.is_some())))
}

/// Mixes a share of the points with points elsewhere, as a filter does across edges.
fn mix(mixed: f64, points: &mut [Option<DVec3>], numbers: &mut Numbers) {
    let original = points.to_vec();
    for point in points.iter_mut().flatten() {
        if numbers.next() < mixed {
            let other = original[(numbers.next() * original.len() as f64) as usize];
            let share = numbers.next();
            *point = point.lerp(other.unwrap_or(DVec3::ZERO), share);
        }
    }
}

type Recovered = Result<RecoveredCamera, RecoveryFailure>;

fn recovered_from(shot: &Shot, position: &Vector3Planes, mask: &Mask) -> Recovered {
    recover_camera(position, mask, shot.data, shot.display, shot.aspect as f32)
}

fn recovered(shot: &Shot) -> Recovered {
    let (position, mask) = positions(shot);
    recovered_from(shot, &position, &mask)
}

/// Recovers the camera, which must be within `limit` degrees of the true one.
fn expect_within(case: &str, shot: &Shot, limit: f64) -> RecoveredCamera {
    let found = recovered(shot).unwrap_or_else(|failure| panic!("{case}: {failure}"));
    let truth = shot.camera.view_from_world.matrix3;
    expect_rotation(&found.camera, truth, limit, &(case, &found));
    found
}

#[test]
fn exact_positions_give_the_exact_camera() {
    let shot = Shot::default();
    let found = expect_within("exact", &shot, 1e-3);
    assert!(focal_error(&found.camera, &shot.camera) < 0.01 / 380.0);
    assert!(found.residual_px_p95 < 0.01 && found.inlier_share > 0.9);
    // Points project onto their own pixels, so the centre is right as well.
    let point = DVec3::new(0.3, 0.1, 0.4);
    let (a, b) = (found.camera.pixel_of(point), shot.camera.pixel_of(point));
    assert!((a.unwrap() - b.unwrap()).length() < 0.01);
    let rough = Shot::with(|shot| (shot.jitter, shot.mixed) = (0.5, 0.1));
    assert_eq!(recovered(&rough).unwrap(), recovered(&rough).unwrap());
}

/// A shot that is moved far from the origin, in these units.
fn far(shot: &mut Shot, distance: f64, half: bool) {
    (shot.offset, shot.half) = (DVec3::new(0.8, 0.6, 0.0) * distance, half);
}

/// A shot by another lens, in parallel where there is none, with pixels `aspect` times as wide as high.
fn through(shot: &mut Shot, focal: Option<f64>, eye: [f64; 3], aspect: f64) {
    shot.aspect = aspect;
    shot.camera = match focal {
        Some(focal) => perspective(eye.into(), focal, shot.display, aspect),
        None => Shot::parallel(aspect).camera,
    };
}

const EYE: [f64; 3] = [1.0, -6.0, 2.5];
/// Of what is not bounded.
const ANY: f64 = f64::INFINITY;

/// What is done to the usual shot; the largest errors of its rotation, in degrees, and of its focal length, as a share.
type Row = (&'static str, fn(&mut Shot), f64, f64);

#[rustfmt::skip]
const SHOTS: [Row; 19] = [
    ("half floats", |s| s.half = true, 0.01, ANY),
    ("and jitter", |s| (s.half, s.jitter) = (true, 0.5), 0.02, ANY),
    ("and mixtures", |s| (s.half, s.jitter, s.mixed) = (true, 0.5, 0.1), 0.02, ANY),
    // Half floats are 1/16 of a unit apart at 100 units, and half a unit at 1000.
    ("far, half", |s| far(s, 100.0, true), 0.03, ANY),
    ("farther, half", |s| far(s, 1000.0, true), 0.4, ANY),
    ("farther", |s| far(s, 1000.0, false), 1e-3, ANY),
    ("farthest", |s| far(s, 100_000.0, false), 0.01, ANY),
    ("a plane that recedes", |s| s.scene = Scene::Ground, 1e-3, 0.05 / 380.0),
    ("a rough plane", |s| (s.scene, s.jitter, s.half) = (Scene::Ground, 0.5, true), 0.1, ANY),
    ("parallel", |s| through(s, None, EYE, 1.0), 1e-3, 0.05 / 60.0),
    ("parallel, rough", |s| { through(s, None, EYE, 1.0); (s.jitter, s.half, s.mixed) = (0.5, true, 0.05) }, 0.03, 0.05 / 60.0),
    ("a long lens", |s| { through(s, Some(6400.0), [16.0, -96.0, 40.0], 1.0); s.jitter = 0.5 }, 0.05, 0.02),
    ("a wide lens", |s| { through(s, Some(130.0), [0.6, -2.2, 1.5], 1.0); (s.jitter, s.half, s.mixed) = (0.5, true, 0.1) }, 0.03, ANY),
    ("cropped", |s| s.data = Window::at(40, -30, 200, 210), 1e-3, ANY),
    ("moved", |s| {
        (s.display, s.data) = (Window::at(-100, -50, 320, 240), Window::at(-120, -60, 360, 260));
        through(s, Some(380.0), EYE, 1.0)
    }, 1e-3, ANY),
    ("wide pixels", |s| { through(s, Some(380.0), EYE, 1.5); (s.jitter, s.half) = (0.5, true) }, 0.03, ANY),
    ("wider pixels", |s| { through(s, Some(380.0), EYE, 2.0); (s.jitter, s.half) = (0.5, true) }, 0.03, ANY),
    ("wide pixels, parallel", |s| through(s, None, EYE, 1.5), 1e-3, ANY),
    ("wider pixels, parallel", |s| through(s, None, EYE, 2.0), 1e-3, ANY),
];

#[test]
fn cameras_of_every_kind_are_found_in_spite_of_flaws() {
    for (name, change, degrees, share) in SHOTS {
        let shot = Shot::with(change);
        let found = expect_within(name, &shot, degrees);
        let off = focal_error(&found.camera, &shot.camera);
        assert!(
            off < share || share == ANY,
            "{name}: focal length off by {off}"
        );
        if let Projection::Orthographic { .. } = found.camera.projection {
            let eye = found.camera.view_from_world.transform_point3(DVec3::Z);
            assert!(eye.z < 0.0, "{name}: behind the viewer");
        }
    }
}

#[test]
fn planes_from_many_sides_keep_the_eye_in_front() {
    // A reversed eye behind the plane fits as well: which of the two is met first is chance.
    for seed in 0..16 {
        let mut shot = random_shot(seed);
        (shot.scene, shot.mixed) = (Scene::Ground, 0.0);
        match recovered(&shot) {
            Ok(found) => {
                let turn = turn_between(&found.camera, &shot.camera);
                assert!(turn < 0.1, "seed {seed}: off by {turn} degrees");
            }
            Err(failure) => assert_eq!(failure, RecoveryFailure::CoplanarUndetermined),
        }
    }
}

#[test]
fn a_plane_seen_square_on_or_in_parallel_leaves_the_camera_open() {
    let square_on = |jitter| {
        let mut shot = Shot::with(|shot| (shot.scene, shot.jitter) = (Scene::Ground, jitter));
        shot.camera.view_from_world = DAffine3::from_translation(DVec3::new(0.0, 0.0, -6.0));
        shot
    };
    let mut parallel = Shot::parallel(1.0);
    parallel.scene = Scene::Ground;
    for shot in [square_on(0.5), square_on(0.0), parallel] {
        let failure = recovered(&shot).expect_err("guessed a camera");
        assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
    }
}

#[test]
fn lens_shift_is_found_where_it_shows() {
    let mut shot = Shot::default();
    let [fx, fy, cx, cy] = [380.0, 380.0, 190.0, 100.0];
    shot.camera.projection = Projection::Perspective { fx, fy, cx, cy };
    let found = expect_within("shift", &shot, 1e-2);
    let Projection::Perspective { cx, cy, .. } = found.camera.projection else {
        panic!("parallel")
    };
    assert!((cx - 190.0).abs() < 0.1 && (cy - 100.0).abs() < 0.1);
}

#[test]
fn a_left_handed_world_is_seen_in_a_mirror() {
    let shot = Shot::with(|shot| shot.jitter = 0.5);
    let (mut position, mask) = positions(&shot);
    position.y = position.y.map(|y| -y);
    let found = recovered_from(&shot, &position, &mask).unwrap().camera;
    let mirror = DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0));
    let (found, truth) = (found.view_from_world * mirror, shot.camera.view_from_world);
    assert!(turn_deg(found.matrix3, truth.matrix3) < 0.05);
    assert!(found.translation.distance(truth.translation) < 0.01);
}

#[test]
fn panoramas_are_refused() {
    for (w, h) in [(256, 128), (48, 24)] {
        let seen = panorama(w, h);
        let point = |x, y| seen.at(x, y).map_or(DVec3::ZERO, |s| s.point);
        let position = Vector3Planes::from_fn(w, h, point);
        let window = Window::from_size(w, h);
        let mask = Mask::new(seen.map(|s| s.is_some()));
        let found = recover_camera(&position, &mask, window, window, 1.0);
        let failure = found.expect_err("fitted a panorama");
        let is_named = matches!(failure, RecoveryFailure::NotACamera { .. });
        assert!(is_named, "{failure}");
    }
}

#[test]
fn bad_positions_fail_and_stray_ones_do_no_harm() {
    for value in [0.0, 1.0, f32::NAN, f32::INFINITY, 1e10, 1e-30, f32::MAX] {
        for (w, h) in [(0, 0), (1, 1), (1, 90), (64, 64)] {
            let position = Vector3Planes::from_fn(w, h, |_, _| DVec3::splat(value.into()));
            let window = Window::from_size(w, h);
            let found = recover_camera(&position, &Mask::full(w, h), window, window, 1.0);
            assert!(found.is_err(), "{value} in {w}x{h}");
        }
    }
    let shot = Shot::default();
    let (mut position, mask) = positions(&shot);
    let empty = Mask::new(Plane::filled(320, 240, false));
    let failure = recovered_from(&shot, &position, &empty);
    assert!(matches!(failure, Err(RecoveryFailure::TooFewPoints { .. })));
    strew(&mut position.x, 1, 7);
    let found = recovered_from(&shot, &position, &mask).unwrap();
    assert!(turn_between(&found.camera, &shot.camera) < 1e-3);
    // A single row of pixels is never misread.
    let row = Shot::with(|shot| shot.data = Window::at(0, 120, 320, 1));
    if let Ok(found) = recovered(&row) {
        assert!(turn_between(&found.camera, &row.camera) < 0.1, "{found:?}");
    }
}

/// A shot from a random place with a random lens and random flaws.
fn random_shot(seed: u64) -> Shot {
    let mut numbers = Numbers(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    for _ in 0..8 {
        numbers.next();
    }
    let mut between = |low: f64, high: f64| low + (high - low) * numbers.next();
    let display = Window::from_size(160, 120);
    let (turn, rise) = (between(0.0, std::f64::consts::TAU), between(0.1, 1.4));
    // From 120 degrees wide to a lens 12 widths long, at distances where the scene fills much of the picture.
    let focal = 160.0 * between(0.3f64.ln(), 12.0f64.ln()).exp();
    let distance = 2.0 + focal / 60.0 * between(0.7, 1.3);
    let eye = DVec3::new(turn.cos() * rise.cos(), turn.sin() * rise.cos(), rise.sin()) * distance;
    Shot {
        camera: perspective(eye + DVec3::Z, focal, display, 1.0),
        data: display,
        display,
        offset: DVec3::new(between(-9.0, 9.0), between(-9.0, 9.0), between(-9.0, 9.0)),
        jitter: if between(0.0, 1.0) < 0.5 { 0.5 } else { 0.0 },
        half: between(0.0, 1.0) < 0.5,
        mixed: between(0.0, 0.2),
        ..Shot::default()
    }
}

#[test]
fn random_cameras_are_found() {
    // 400 such cameras were all found, the worst to 0.053 degrees.
    for seed in 0..24 {
        expect_within(&format!("seed {seed}"), &random_shot(seed), 0.1);
    }
}
