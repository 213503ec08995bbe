//! Cameras recovered from the positions of small scenes.

use super::measure::{expect_rotation, focal, turn_between, turn_deg};
use super::planes::strew;
use super::shots::{Numbers, Scene, Shot, panorama, perspective};
use glam::{DAffine3, DVec3};
use relievo::frame::{Mask, Plane, Projection, Vector3Planes, Window};
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

fn recovered_from(
    shot: &Shot,
    position: &Vector3Planes,
    mask: &Mask,
) -> Result<RecoveredCamera, RecoveryFailure> {
    let (data, display) = (shot.data, shot.display);
    recover_camera(position, mask, data, display, shot.aspect as f32)
}

fn recovered(shot: &Shot) -> Result<RecoveredCamera, RecoveryFailure> {
    let (position, mask) = positions(shot);
    recovered_from(shot, &position, &mask)
}

/// Recovers the camera, which must be within `limit` degrees of the true one.
fn expect_within(shot: &Shot, limit: f64) -> RecoveredCamera {
    let found = recovered(shot).expect("no camera");
    let truth = shot.camera.view_from_world.matrix3;
    expect_rotation(&found.camera, truth, limit, &found);
    found
}

#[test]
fn exact_positions_give_the_exact_camera() {
    let found = expect_within(&Shot::default(), 1e-3);
    assert!((focal(&found.camera) - 380.0).abs() < 0.01);
    assert!(found.residual_px_p95 < 0.01 && found.inlier_share > 0.9);
    // Points project onto their own pixels, so the centre is right as well.
    let shot = Shot::default();
    let point = DVec3::new(0.3, 0.1, 0.4);
    let (a, b) = (found.camera.pixel_of(point), shot.camera.pixel_of(point));
    assert!((a.unwrap() - b.unwrap()).length() < 0.01);
}

#[test]
fn the_same_positions_give_the_same_bits() {
    let shot = Shot::with(|shot| (shot.jitter, shot.mixed) = (0.5, 0.1));
    assert_eq!(recovered(&shot).unwrap(), recovered(&shot).unwrap());
}

#[test]
fn half_floats_and_jitter_cost_hundredths_of_a_degree() {
    let mut shot = Shot::with(|shot| shot.half = true);
    expect_within(&shot, 0.01);
    shot.jitter = 0.5;
    expect_within(&shot, 0.02);
    shot.mixed = 0.1;
    expect_within(&shot, 0.02);
}

#[test]
fn scenes_far_from_the_origin_keep_their_camera() {
    let far = |distance: f64, half: bool| {
        Shot::with(|shot| (shot.offset, shot.half) = (DVec3::new(0.8, 0.6, 0.0) * distance, half))
    };
    // Half floats are 1/16 of a unit apart at 100 units, and half a unit at 1000.
    expect_within(&far(100.0, true), 0.03);
    expect_within(&far(1000.0, true), 0.4);
    expect_within(&far(1000.0, false), 1e-3);
    expect_within(&far(100_000.0, false), 0.01);
}

#[test]
fn a_plane_gives_its_camera_where_it_recedes() {
    let mut shot = Shot::with(|shot| shot.scene = Scene::Ground);
    let found = expect_within(&shot, 1e-3);
    assert!((focal(&found.camera) - 380.0).abs() < 0.05);
    (shot.jitter, shot.half) = (0.5, true);
    expect_within(&shot, 0.1);
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
fn a_plane_seen_square_on_leaves_the_camera_open() {
    let mut shot = Shot::with(|shot| shot.scene = Scene::Ground);
    shot.camera.view_from_world = DAffine3::from_translation(DVec3::new(0.0, 0.0, -6.0));
    for jitter in [0.5, 0.0] {
        shot.jitter = jitter;
        let failure = recovered(&shot).expect_err("guessed a camera");
        assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
    }
}

#[test]
fn parallel_projections_are_told_apart() {
    let exact = Shot::parallel(1.0);
    let rough = Shot {
        jitter: 0.5,
        half: true,
        mixed: 0.05,
        ..exact.clone()
    };
    for (shot, limit) in [(exact, 1e-3), (rough, 0.03)] {
        let found = expect_within(&shot, limit);
        let Projection::Orthographic { sx, .. } = found.camera.projection else {
            panic!("not parallel: {found:?}")
        };
        assert!((sx - 60.0).abs() < 0.05, "{sx}");
        let eye = found.camera.view_from_world.transform_point3(DVec3::Z);
        assert!(eye.z < 0.0, "behind the viewer");
    }
    let mut plane = Shot::parallel(1.0);
    plane.scene = Scene::Ground;
    let failure = recovered(&plane).expect_err("guessed a camera");
    assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
}

#[test]
fn a_long_lens_is_still_a_perspective() {
    let display = Window::from_size(320, 240);
    let eye = DVec3::new(16.0, -96.0, 40.0);
    let shot = Shot::with(|shot| {
        (shot.camera, shot.jitter) = (perspective(eye, 6400.0, display, 1.0), 0.5)
    });
    let found = expect_within(&shot, 0.05);
    assert!((focal(&found.camera) / 6400.0 - 1.0).abs() < 0.02);
}

#[test]
fn a_wide_lens_is_found() {
    let (eye, window) = (DVec3::new(0.6, -2.2, 1.5), Window::from_size(320, 240));
    let mut shot = Shot::with(|shot| shot.camera = perspective(eye, 130.0, window, 1.0));
    (shot.jitter, shot.half, shot.mixed) = (0.5, true, 0.1);
    expect_within(&shot, 0.03);
}

#[test]
fn crops_and_tall_pixels_keep_the_camera() {
    let cropped = Shot::with(|shot| shot.data = Window::at(40, -30, 200, 210));
    expect_within(&cropped, 1e-3);
    let eye = DVec3::new(1.0, -6.0, 2.5);
    let mut moved = Shot::with(|shot| shot.display = Window::at(-100, -50, 320, 240));
    moved.camera = perspective(eye, 380.0, moved.display, 1.0);
    moved.data = Window::at(-120, -60, 360, 260);
    expect_within(&moved, 1e-3);
    for aspect in [1.5, 2.0] {
        let mut shot = Shot::with(|shot| shot.aspect = aspect);
        shot.camera = perspective(eye, 380.0, shot.display, aspect);
        (shot.jitter, shot.half) = (0.5, true);
        expect_within(&shot, 0.03);
        expect_within(&Shot::parallel(aspect), 1e-3);
    }
}

#[test]
fn lens_shift_is_found_where_it_shows() {
    let mut shot = Shot::default();
    let [fx, fy, cx, cy] = [380.0, 380.0, 190.0, 100.0];
    shot.camera.projection = Projection::Perspective { fx, fy, cx, cy };
    let found = expect_within(&shot, 1e-2);
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
        let position =
            Vector3Planes::from_fn(w, h, |x, y| seen.at(x, y).map_or(DVec3::ZERO, |s| s.point));
        let window = Window::from_size(w, h);
        let mask = Mask::new(seen.map(|s| s.is_some()));
        let found = recover_camera(&position, &mask, window, window, 1.0);
        let failure = found.expect_err("fitted a panorama");
        let is_named = matches!(failure, RecoveryFailure::NotACamera { .. });
        assert!(is_named, "{failure}");
    }
}

#[test]
fn bad_positions_fail_without_panic() {
    let uniform = |w: usize, h: usize, value: f32| {
        let position = Vector3Planes::from_fn(w, h, |_, _| DVec3::splat(value.into()));
        let window = Window::from_size(w, h);
        recover_camera(&position, &Mask::full(w, h), window, window, 1.0)
    };
    for value in [0.0, 1.0, f32::NAN, f32::INFINITY, 1e10, 1e-30, f32::MAX] {
        for (w, h) in [(0, 0), (1, 1), (1, 90), (64, 64)] {
            assert!(uniform(w, h, value).is_err(), "{value} in {w}x{h}");
        }
    }
}

#[test]
fn an_empty_mask_and_stray_values_do_no_harm() {
    let shot = Shot::default();
    let (mut position, mask) = positions(&shot);
    let empty = Mask::new(Plane::filled(320, 240, false));
    let failure = recovered_from(&shot, &position, &empty);
    assert!(matches!(failure, Err(RecoveryFailure::TooFewPoints { .. })));
    strew(&mut position.x, 1, 7);
    let found = recovered_from(&shot, &position, &mask).unwrap();
    assert!(turn_between(&found.camera, &shot.camera) < 1e-3);
}

#[test]
fn a_single_row_of_pixels_is_never_misread() {
    let shot = Shot::with(|shot| shot.data = Window::at(0, 120, 320, 1));
    if let Ok(found) = recovered(&shot) {
        assert!(turn_between(&found.camera, &shot.camera) < 0.1, "{found:?}");
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
        expect_within(&random_shot(seed), 0.1);
    }
}
