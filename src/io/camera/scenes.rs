//! Cameras recovered from small scenes whose camera is known.

use super::recover::{RecoveredCamera, RecoveryFailure, recover_camera};
use crate::frame::{Camera, Mask, Plane, Projection, Vector3Planes, Window};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use half::f16;

/// What the sight lines meet.
#[derive(Clone, Copy)]
enum Scene {
    /// Two balls on a ground.
    Balls,
    /// The ground alone.
    Ground,
}

/// A ball, and the ground at height 0.
const BALLS: [(DVec3, f64); 2] = [
    (DVec3::new(0.0, 0.0, 1.0), 1.0),
    (DVec3::new(1.4, 0.9, 0.5), 0.5),
];

impl Scene {
    /// Where a ray first meets the scene.
    fn hit(self, from: DVec3, along: DVec3) -> Option<DVec3> {
        let ground = (-from.z / along.z > 0.0).then(|| from - along * (from.z / along.z));
        let mut hits: Vec<DVec3> = ground.filter(|p| p.length() < 6.0).into_iter().collect();
        if let Scene::Balls = self {
            hits.extend(
                BALLS
                    .iter()
                    .filter_map(|&(c, r)| ball_hit(from - c, along, r)),
            );
        }
        let distance = |p: &DVec3| (*p - from).dot(along);
        hits.retain(|p| distance(p) > 0.0);
        hits.into_iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

fn ball_hit(from_centre: DVec3, along: DVec3, radius: f64) -> Option<DVec3> {
    let (a, b) = (along.length_squared(), from_centre.dot(along));
    let root = b * b - a * (from_centre.length_squared() - radius * radius);
    let centre = BALLS.iter().find(|(_, r)| *r == radius)?.0;
    (root > 0.0).then(|| centre + from_centre - along * ((b + root.sqrt()) / a))
}

/// A picture of a scene, before its positions are spoiled.
#[derive(Clone)]
struct Shot {
    scene: Scene,
    camera: Camera,
    data: Window,
    display: Window,
    aspect: f64,
    offset: DVec3,
    jitter: f64,
    half: bool,
    mixed: f64,
}

/// The rotation and translation of an eye at `eye` that looks at `target` with z up.
fn looking(eye: DVec3, target: DVec3) -> DAffine3 {
    let back = (eye - target).normalize();
    let right = DVec3::Z.cross(back).normalize();
    let rotation = DMat3::from_cols(right, back.cross(right), back).transpose();
    DAffine3::from_mat3_translation(rotation, -(rotation * eye))
}

fn perspective(eye: DVec3, focal: f64, display: Window, aspect: f64) -> Camera {
    let (cx, cy) = centre(display);
    Camera {
        view_from_world: looking(eye, DVec3::new(0.3, 0.2, 0.7)),
        projection: Projection::Perspective {
            fx: focal,
            fy: focal * aspect,
            cx,
            cy,
        },
    }
}

fn centre(display: Window) -> (f64, f64) {
    (
        0.5 * f64::from(display.x0 + display.x1),
        0.5 * f64::from(display.y0 + display.y1),
    )
}

impl Default for Shot {
    fn default() -> Self {
        let display = Window::from_size(320, 240);
        Shot {
            scene: Scene::Balls,
            camera: perspective(DVec3::new(1.0, -6.0, 2.5), 380.0, display, 1.0),
            data: display,
            display,
            aspect: 1.0,
            offset: DVec3::ZERO,
            jitter: 0.0,
            half: false,
            mixed: 0.0,
        }
    }
}

/// A plain sequence of numbers in 0..1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }
}

impl Shot {
    /// The point seen at a place of the picture, in the scene's own frame.
    fn seen_at(&self, at: DVec2) -> Option<DVec3> {
        let world = self.camera.view_from_world.inverse();
        let (from, along) = match self.camera.projection {
            Projection::Perspective { fx, fy, cx, cy } => (
                DVec3::ZERO,
                DVec3::new((at.x - cx) / fx, (cy - at.y) / fy, -1.0),
            ),
            Projection::Orthographic { sx, sy, cx, cy } => (
                DVec3::new((at.x - cx) / sx, (cy - at.y) / sy, 0.0),
                DVec3::NEG_Z,
            ),
        };
        let direction = world.transform_vector3(along);
        self.scene.hit(world.transform_point3(from), direction)
    }

    fn positions(&self) -> (Vector3Planes, Mask) {
        let mut numbers = Numbers(7);
        let (w, h) = (self.data.width(), self.data.height());
        let mut points: Vec<Option<DVec3>> = Vec::with_capacity(w * h);
        for y in 0..h {
            for x in 0..w {
                let mut off = || self.jitter * (2.0 * numbers.next() - 1.0);
                let corner = DVec2::new(self.data.x0.into(), self.data.y0.into());
                let at = corner + DVec2::new(x as f64 + 0.5 + off(), y as f64 + 0.5 + off());
                points.push(self.seen_at(at));
            }
        }
        self.mix(&mut points, &mut numbers);
        let covered = Plane::from_fn(w, h, |x, y| points[y * w + x].is_some());
        let plane = |axis: usize| {
            Plane::from_fn(w, h, |x, y| {
                points[y * w + x].map_or(0.0, |p| self.stored((p + self.offset)[axis]))
            })
        };
        let position = Vector3Planes {
            x: plane(0),
            y: plane(1),
            z: plane(2),
        };
        (position, Mask::new(covered))
    }

    /// Mixes a share of the points with points elsewhere, as a filter does across edges.
    fn mix(&self, points: &mut [Option<DVec3>], numbers: &mut Numbers) {
        let original = points.to_vec();
        for point in points.iter_mut().flatten() {
            if numbers.next() < self.mixed {
                let other = original[(numbers.next() * original.len() as f64) as usize];
                let share = numbers.next();
                *point = point.lerp(other.unwrap_or(DVec3::ZERO), share);
            }
        }
    }

    fn stored(&self, value: f64) -> f32 {
        if self.half {
            f16::from_f64(value).to_f32()
        } else {
            value as f32
        }
    }

    fn recovered(&self) -> Result<RecoveredCamera, RecoveryFailure> {
        let (position, mask) = self.positions();
        recover_camera(
            &position,
            &mask,
            self.data,
            self.display,
            self.aspect as f32,
        )
    }

    /// Recovers the camera; the angle of the turn from the true one, in degrees, must stay below `limit`.
    fn expect_within(&self, limit: f64) -> RecoveredCamera {
        let found = self.recovered().expect("no camera");
        let turn = turn_deg(&found.camera, &self.camera);
        assert!(turn < limit, "off by {turn} degrees: {found:?}");
        let m = found.camera.view_from_world.matrix3;
        let off = m * m.transpose() - DMat3::IDENTITY;
        assert!(off.to_cols_array().iter().all(|e| e.abs() < 1e-12));
        assert!(m.determinant() > 0.0);
        found
    }
}

/// Angle of the rotation between two cameras. Read off its sine: the cosine rounds below 1e-6.
fn turn_deg(a: &Camera, b: &Camera) -> f64 {
    let m = a.view_from_world.matrix3 * b.view_from_world.matrix3.transpose();
    let twice_sine = DVec3::new(
        m.y_axis.z - m.z_axis.y,
        m.z_axis.x - m.x_axis.z,
        m.x_axis.y - m.y_axis.x,
    );
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    twice_sine.length().atan2(trace - 1.0).to_degrees()
}

fn focal(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Perspective { fx, .. } => fx,
        Projection::Orthographic { .. } => panic!("parallel"),
    }
}

#[test]
fn exact_positions_give_the_exact_camera() {
    let found = Shot::default().expect_within(1e-3);
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
    let shot = Shot {
        jitter: 0.5,
        mixed: 0.1,
        ..Shot::default()
    };
    assert_eq!(shot.recovered().unwrap(), shot.recovered().unwrap());
}

#[test]
fn half_floats_and_jitter_cost_hundredths_of_a_degree() {
    let half = Shot {
        half: true,
        ..Shot::default()
    };
    half.expect_within(0.01);
    let jitter = Shot {
        jitter: 0.5,
        ..half.clone()
    };
    jitter.expect_within(0.02);
    let mixed = Shot {
        mixed: 0.1,
        ..jitter
    };
    mixed.expect_within(0.02);
}

#[test]
fn scenes_far_from_the_origin_keep_their_camera() {
    let far = |distance: f64, half: bool| Shot {
        offset: DVec3::new(0.8, 0.6, 0.0) * distance,
        half,
        ..Shot::default()
    };
    // Half floats are 1/16 of a unit apart at 100 units, and half a unit at 1000.
    far(100.0, true).expect_within(0.03);
    far(1000.0, true).expect_within(0.4);
    far(1000.0, false).expect_within(1e-3);
    far(100_000.0, false).expect_within(0.01);
}

#[test]
fn a_plane_gives_its_camera_where_it_recedes() {
    let shot = Shot {
        scene: Scene::Ground,
        ..Shot::default()
    };
    let found = shot.expect_within(1e-3);
    assert!((focal(&found.camera) - 380.0).abs() < 0.05);
    let rough = Shot {
        jitter: 0.5,
        half: true,
        ..shot
    };
    rough.expect_within(0.1);
}

#[test]
fn planes_from_many_sides_keep_the_eye_in_front() {
    // A reversed eye behind the plane fits as well: which of the two is met first is chance.
    for seed in 0..16 {
        let shot = Shot {
            scene: Scene::Ground,
            mixed: 0.0,
            ..random_shot(seed)
        };
        match shot.recovered() {
            Ok(found) => {
                let turn = turn_deg(&found.camera, &shot.camera);
                assert!(turn < 0.1, "seed {seed}: off by {turn} degrees");
            }
            Err(failure) => assert_eq!(failure, RecoveryFailure::CoplanarUndetermined),
        }
    }
}

#[test]
fn a_plane_seen_square_on_leaves_the_camera_open() {
    let mut shot = Shot {
        scene: Scene::Ground,
        jitter: 0.5,
        ..Shot::default()
    };
    shot.camera.view_from_world = DAffine3::from_translation(DVec3::new(0.0, 0.0, -6.0));
    let failure = shot.recovered().expect_err("guessed a camera");
    assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
    shot.jitter = 0.0;
    let failure = shot.recovered().expect_err("guessed a camera");
    assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
}

fn parallel_shot(aspect: f64) -> Shot {
    let mut shot = Shot {
        aspect,
        ..Shot::default()
    };
    let (cx, cy) = centre(shot.display);
    shot.camera.projection = Projection::Orthographic {
        sx: 60.0,
        sy: 60.0 * aspect,
        cx,
        cy,
    };
    shot
}

#[test]
fn parallel_projections_are_told_apart() {
    let exact = parallel_shot(1.0);
    let rough = Shot {
        jitter: 0.5,
        half: true,
        mixed: 0.05,
        ..exact.clone()
    };
    for (shot, limit) in [(exact, 1e-3), (rough, 0.03)] {
        let found = shot.expect_within(limit);
        let Projection::Orthographic { sx, .. } = found.camera.projection else {
            panic!("not parallel: {found:?}")
        };
        assert!((sx - 60.0).abs() < 0.05, "{sx}");
        let eye = found.camera.view_from_world.transform_point3(DVec3::Z);
        assert!(eye.z < 0.0, "behind the viewer");
    }
    let mut plane = parallel_shot(1.0);
    plane.scene = Scene::Ground;
    let failure = plane.recovered().expect_err("guessed a camera");
    assert_eq!(failure, RecoveryFailure::CoplanarUndetermined);
}

#[test]
fn a_long_lens_is_still_a_perspective() {
    let display = Window::from_size(320, 240);
    let eye = DVec3::new(16.0, -96.0, 40.0);
    let shot = Shot {
        camera: perspective(eye, 6400.0, display, 1.0),
        jitter: 0.5,
        ..Shot::default()
    };
    let found = shot.expect_within(0.05);
    assert!((focal(&found.camera) / 6400.0 - 1.0).abs() < 0.02);
}

#[test]
fn a_wide_lens_is_found() {
    let shot = Shot {
        camera: perspective(
            DVec3::new(0.6, -2.2, 1.5),
            130.0,
            Window::from_size(320, 240),
            1.0,
        ),
        jitter: 0.5,
        half: true,
        mixed: 0.1,
        ..Shot::default()
    };
    shot.expect_within(0.03);
}

#[test]
fn crops_and_tall_pixels_keep_the_camera() {
    let cropped = Shot {
        data: Window::at(40, -30, 200, 210),
        ..Shot::default()
    };
    cropped.expect_within(1e-3);
    let display = Window::at(-100, -50, 320, 240);
    let moved = Shot {
        camera: perspective(DVec3::new(1.0, -6.0, 2.5), 380.0, display, 1.0),
        data: Window::at(-120, -60, 360, 260),
        display,
        ..Shot::default()
    };
    moved.expect_within(1e-3);
    for aspect in [1.5, 2.0] {
        let window = Window::from_size(320, 240);
        let shot = Shot {
            camera: perspective(DVec3::new(1.0, -6.0, 2.5), 380.0, window, aspect),
            aspect,
            jitter: 0.5,
            half: true,
            ..Shot::default()
        };
        shot.expect_within(0.03);
        parallel_shot(aspect).expect_within(1e-3);
    }
}

#[test]
fn lens_shift_is_found_where_it_shows() {
    let mut shot = Shot::default();
    shot.camera.projection = Projection::Perspective {
        fx: 380.0,
        fy: 380.0,
        cx: 190.0,
        cy: 100.0,
    };
    let found = shot.expect_within(1e-2);
    let Projection::Perspective { cx, cy, .. } = found.camera.projection else {
        panic!("parallel")
    };
    assert!((cx - 190.0).abs() < 0.1 && (cy - 100.0).abs() < 0.1);
}

#[test]
fn a_mirrored_scene_is_refused() {
    let shot = Shot {
        jitter: 0.5,
        ..Shot::default()
    };
    let (mut position, mask) = shot.positions();
    position.y = position.y.map(|y| -y);
    let failure = recover_camera(&position, &mask, shot.data, shot.display, 1.0);
    assert_eq!(failure, Err(RecoveryFailure::Mirrored));
}

#[test]
fn panoramas_are_refused() {
    for (w, h) in [(256, 128), (48, 24)] {
        let failure = panorama_failure(w, h);
        assert!(
            matches!(failure, RecoveryFailure::NotACamera { .. }),
            "{failure}"
        );
    }
}

fn panorama_failure(w: usize, h: usize) -> RecoveryFailure {
    let shot = Shot::default();
    let eye = DVec3::new(0.5, -3.0, 1.3);
    let hit = |x: usize, y: usize| {
        let (lon, lat) = (
            (x as f64 + 0.5) / w as f64 * std::f64::consts::TAU,
            (0.5 - (y as f64 + 0.5) / h as f64) * std::f64::consts::PI,
        );
        let along = DVec3::new(lat.cos() * lon.sin(), -lat.cos() * lon.cos(), lat.sin());
        shot.scene.hit(eye, along)
    };
    let covered = Plane::from_fn(w, h, |x, y| hit(x, y).is_some());
    let plane =
        |axis: usize| Plane::from_fn(w, h, |x, y| hit(x, y).map_or(0.0, |p| p[axis] as f32));
    let position = Vector3Planes {
        x: plane(0),
        y: plane(1),
        z: plane(2),
    };
    let window = Window::from_size(w, h);
    recover_camera(&position, &Mask::new(covered), window, window, 1.0)
        .expect_err("fitted a panorama")
}

#[test]
fn bad_positions_fail_without_panic() {
    let uniform = |w: usize, h: usize, value: f32| {
        let plane = Plane::filled(w, h, value);
        let position = Vector3Planes {
            x: plane.clone(),
            y: plane.clone(),
            z: plane,
        };
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
    let (mut position, mask) = shot.positions();
    let empty = Mask::new(Plane::filled(320, 240, false));
    let failure = recover_camera(&position, &empty, shot.data, shot.display, 1.0);
    assert!(matches!(failure, Err(RecoveryFailure::TooFewPoints { .. })));
    for (i, value) in [f32::NAN, f32::INFINITY, -1e30, 65504.0, 3e8]
        .into_iter()
        .enumerate()
    {
        for y in (i..240).step_by(23) {
            position
                .x
                .row_mut(y)
                .iter_mut()
                .step_by(7)
                .for_each(|s| *s = value);
        }
    }
    let found = recover_camera(&position, &mask, shot.data, shot.display, 1.0).unwrap();
    assert!(turn_deg(&found.camera, &shot.camera) < 1e-3);
}

#[test]
fn a_single_row_of_pixels_is_never_misread() {
    let shot = Shot {
        data: Window::at(0, 120, 320, 1),
        ..Shot::default()
    };
    if let Ok(found) = shot.recovered() {
        assert!(turn_deg(&found.camera, &shot.camera) < 0.1, "{found:?}");
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
    // From 120 degrees wide to a lens 12 widths long, from where the scene fills much of the picture.
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
    // Of 400 such cameras all were found, the worst to 0.053 degrees.
    for seed in 0..24 {
        random_shot(seed).expect_within(0.1);
    }
}
