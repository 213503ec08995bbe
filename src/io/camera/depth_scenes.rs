//! Rotations recovered from depth and normals of small scenes whose camera is known.

use super::from_depth::{DepthCamera, DepthKind, recover_camera_from_depth};
use super::recover::RecoveryFailure;
use crate::frame::{Camera, Mask, Plane, Projection, Vector3Planes, Window};
use glam::{DAffine3, DMat3, DVec2, DVec3, EulerRot};
use half::f16;

/// Two balls, above a ground at height 0.
const BALLS: [(DVec3, f64); 2] = [
    (DVec3::new(0.0, 0.0, 1.0), 1.0),
    (DVec3::new(1.4, 0.9, 0.5), 0.5),
];

#[derive(Clone, Copy, PartialEq)]
enum Scene {
    Balls,
    Ground,
}

/// Where a ray first meets the scene, as a share of `along`, and the normal there.
fn hit(scene: Scene, from: DVec3, along: DVec3) -> Option<(f64, DVec3)> {
    let down = -from.z / along.z;
    let near = (from + down * along).length() < 6.0;
    let mut hits: Vec<(f64, DVec3)> = near.then_some((down, DVec3::Z)).into_iter().collect();
    for (centre, radius) in BALLS.iter().filter(|_| scene == Scene::Balls) {
        let to = from - *centre;
        let (a, b) = (along.length_squared(), to.dot(along));
        let root = b * b - a * (to.length_squared() - radius * radius);
        if root > 0.0 {
            let t = -(b + root.sqrt()) / a;
            hits.push((t, (to + t * along) / *radius));
        }
    }
    hits.retain(|(t, _)| *t > 0.0);
    hits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// A picture of a scene, with what spoils its depth and normals.
#[derive(Clone)]
struct Shot {
    scene: Scene,
    camera: Camera,
    data: Window,
    display: Window,
    aspect: f64,
    ray: bool,
    half: bool,
    jitter: f64,
    /// Turns the normals into another space than the one the camera looks from.
    normals: DMat3,
}

struct Layers {
    normal: Vector3Planes,
    depth: Plane,
    mask: Mask,
}

fn looking(eye: DVec3, roll: f64) -> DAffine3 {
    let back = (eye - DVec3::new(0.3, 0.2, 0.7)).normalize();
    let right = DVec3::Z.cross(back).normalize();
    let upright = DMat3::from_cols(right, back.cross(right), back).transpose();
    let rotation = DMat3::from_rotation_z(roll) * upright;
    DAffine3::from_mat3_translation(rotation, -(rotation * eye))
}

impl Default for Shot {
    fn default() -> Self {
        Shot {
            scene: Scene::Balls,
            camera: Camera {
                view_from_world: looking(DVec3::new(1.0, -6.0, 2.5), 0.0),
                projection: Projection::Perspective {
                    fx: 380.0,
                    fy: 380.0,
                    cx: 160.0,
                    cy: 120.0,
                },
            },
            data: Window::from_size(320, 240),
            display: Window::from_size(320, 240),
            aspect: 1.0,
            ray: false,
            half: false,
            jitter: 0.0,
            normals: DMat3::IDENTITY,
        }
    }
}

impl Shot {
    fn parallel() -> Self {
        let mut shot = Shot::default();
        shot.camera.projection = Projection::Orthographic {
            sx: 60.0,
            sy: 60.0,
            cx: 160.0,
            cy: 120.0,
        };
        shot
    }

    /// Depth and normal seen at a place of the picture.
    fn seen_at(&self, at: DVec2) -> Option<(f64, DVec3)> {
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
        let (t, normal) = hit(self.scene, world.transform_point3(from), direction)?;
        let depth = if self.ray { t * along.length() } else { t };
        Some((depth, self.normals * normal))
    }

    fn stored(&self, value: f64) -> f32 {
        if self.half {
            f16::from_f64(value).to_f32()
        } else {
            value as f32
        }
    }

    fn layers(&self) -> Layers {
        let (w, h) = (self.data.width(), self.data.height());
        let corner = DVec2::new(self.data.x0.into(), self.data.y0.into());
        let mut state = 7u64;
        let mut off = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            self.jitter * ((state >> 32) as f64 / (1u64 << 31) as f64 - 1.0)
        };
        let places: Vec<DVec2> = (0..w * h)
            .map(|i| corner + DVec2::new((i % w) as f64 + 0.5, (i / w) as f64 + 0.5))
            .collect();
        // Depth comes from a random place in the pixel, normals from its middle.
        let depths: Vec<Option<f64>> = places
            .iter()
            .map(|at| Some(self.seen_at(at + DVec2::new(off(), off()))?.0))
            .collect();
        let normals: Vec<Option<DVec3>> =
            places.iter().map(|at| Some(self.seen_at(*at)?.1)).collect();
        let covered = |i: usize| depths[i].is_some() && normals[i].is_some();
        let axis = |axis: usize| {
            let of = |n: &Option<DVec3>| n.map_or(0.0, |n| self.stored(n[axis]));
            Plane::from_samples(w, h, normals.iter().map(of).collect())
        };
        let depth = |d: &Option<f64>| d.map_or(1e10, |d| self.stored(d));
        Layers {
            normal: Vector3Planes {
                x: axis(0),
                y: axis(1),
                z: axis(2),
            },
            depth: Plane::from_samples(w, h, depths.iter().map(depth).collect()),
            mask: Mask::new(Plane::from_fn(w, h, |x, y| covered(y * w + x))),
        }
    }

    fn recovered_from(&self, layers: &Layers) -> Result<DepthCamera, RecoveryFailure> {
        recover_camera_from_depth(
            &layers.normal,
            &layers.depth,
            &layers.mask,
            self.data,
            self.display,
            self.aspect as f32,
        )
    }

    fn recovered(&self) -> Result<DepthCamera, RecoveryFailure> {
        self.recovered_from(&self.layers())
    }

    /// Recovers the camera, which must lie within `limit` degrees of the true one.
    fn expect_within(&self, limit: f64) -> DepthCamera {
        let found = self.recovered().expect("no camera");
        let m = found.camera.view_from_world.matrix3;
        let truth = self.camera.view_from_world.matrix3 * self.normals.transpose();
        let turn = turn_deg(m * truth.transpose());
        println!("turn {turn:.5} deg, {found:?}");
        assert!(turn < limit, "off by {turn} degrees: {found:?}");
        let off = m * m.transpose() - DMat3::IDENTITY;
        assert!(off.to_cols_array().iter().all(|e| e.abs() < 1e-12));
        assert!(m.determinant() > 0.0);
        assert_eq!(found.camera.view_from_world.translation, DVec3::ZERO);
        found
    }
}

/// Angle of a rotation. Read off its sine: the cosine rounds below 1e-6.
fn turn_deg(m: DMat3) -> f64 {
    let twice_sine = DVec3::new(
        m.y_axis.z - m.z_axis.y,
        m.z_axis.x - m.x_axis.z,
        m.x_axis.y - m.y_axis.x,
    );
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    twice_sine.length().atan2(trace - 1.0).to_degrees()
}

fn expect_focal(found: &DepthCamera, focal: f64, share: f64) {
    let Projection::Perspective { fx, .. } = found.camera.projection else {
        panic!("not a perspective: {found:?}")
    };
    assert!((fx / focal - 1.0).abs() < share, "{fx}");
    assert!(!found.focal_uncertain);
}

#[test]
fn exact_layers_give_rotation_and_focal_length() {
    let found = Shot::default().expect_within(0.02);
    expect_focal(&found, 380.0, 2e-3);
    assert_eq!(found.depth_kind, DepthKind::Planar);
    assert!(found.residual_deg_median < 0.2 && found.rotation_uncertainty_deg < 0.1);
}

#[test]
fn rotations_about_every_axis_are_found() {
    for (a, b, c) in [(0.4, -1.1, 2.0), (-2.5, 0.7, 0.3), (3.1, 1.4, -1.9)] {
        let shot = Shot {
            normals: DMat3::from_euler(EulerRot::XYZ, a, b, c),
            ..Shot::default()
        };
        shot.expect_within(0.02);
    }
    let mut rolled = Shot::default();
    rolled.camera.view_from_world = looking(DVec3::new(-3.0, -4.0, 4.0), 2.2);
    rolled.expect_within(0.05);
}

#[test]
fn view_space_normals_need_no_rotation() {
    let mut shot = Shot::default();
    shot.normals = shot.camera.view_from_world.matrix3;
    let found = shot.expect_within(0.02);
    assert!(turn_deg(found.camera.view_from_world.matrix3) < 0.02);
}

#[test]
fn half_floats_and_jitter_cost_tenths_of_a_degree() {
    let half = Shot {
        half: true,
        ..Shot::default()
    };
    half.expect_within(0.1);
    let jitter = Shot {
        jitter: 0.5,
        ..Shot::default()
    };
    jitter.expect_within(0.3);
    let both = Shot {
        half: true,
        ..jitter
    };
    both.expect_within(0.3);
}

#[test]
fn parallel_projections_are_told_apart() {
    let found = Shot::parallel().expect_within(0.05);
    let Projection::Orthographic { sx, .. } = found.camera.projection else {
        panic!("not parallel: {found:?}")
    };
    assert!((sx / 60.0 - 1.0).abs() < 5e-3, "{sx}");
    let rough = Shot {
        half: true,
        jitter: 0.5,
        ..Shot::parallel()
    };
    rough.expect_within(0.5);
}

#[test]
fn distance_along_the_ray_is_told_from_planar_depth() {
    let shot = Shot {
        ray: true,
        ..Shot::default()
    };
    let found = shot.expect_within(0.02);
    expect_focal(&found, 380.0, 2e-3);
    assert_eq!(found.depth_kind, DepthKind::Ray);
}

#[test]
fn crops_and_tall_pixels_keep_the_camera() {
    let cropped = Shot {
        data: Window::at(40, 30, 200, 170),
        ..Shot::default()
    };
    expect_focal(&cropped.expect_within(0.03), 380.0, 5e-3);
    let mut tall = Shot {
        aspect: 2.0,
        ..Shot::default()
    };
    tall.camera.projection = Projection::Perspective {
        fx: 380.0,
        fy: 760.0,
        cx: 160.0,
        cy: 120.0,
    };
    expect_focal(&tall.expect_within(0.03), 380.0, 5e-3);
}

#[test]
fn the_same_layers_give_the_same_bits() {
    let shot = Shot {
        jitter: 0.5,
        half: true,
        ..Shot::default()
    };
    assert_eq!(shot.recovered().unwrap(), shot.recovered().unwrap());
}

#[test]
fn one_plane_leaves_a_turn_open() {
    for projection in [Shot::default(), Shot::parallel()] {
        for (jitter, half) in [(0.0, false), (0.5, true)] {
            let shot = Shot {
                scene: Scene::Ground,
                jitter,
                half,
                ..projection.clone()
            };
            let failure = shot.recovered().expect_err("guessed a camera");
            println!("{failure}");
            assert!(matches!(
                failure,
                RecoveryFailure::ParallelNormals | RecoveryFailure::Undetermined { .. }
            ));
        }
    }
}

#[test]
fn mirrored_normals_are_refused() {
    let shot = Shot::default();
    let mut layers = shot.layers();
    layers.normal.x = layers.normal.x.map(|x| -x);
    let failure = shot.recovered_from(&layers);
    assert_eq!(failure, Err(RecoveryFailure::Mirrored));
}

#[test]
fn depth_that_is_none_is_refused() {
    let shot = Shot::default();
    let mut layers = shot.layers();
    let mut state = 1u32;
    layers.depth = layers.depth.map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        1.0 + (state >> 8) as f32 / (1u32 << 24) as f32
    });
    assert!(shot.recovered_from(&layers).is_err());
    layers.depth = shot.layers().normal.y.map(|n| 2.0 + n);
    let failure = shot.recovered_from(&layers).expect_err("fitted shading");
    println!("{failure}");
}

#[test]
fn bad_layers_fail_without_panic() {
    for value in [0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, f32::MAX] {
        for (w, h) in [(0, 0), (1, 1), (1, 90), (2, 2), (64, 64)] {
            let plane = Plane::filled(w, h, value);
            let unit = Plane::filled(w, h, 1.0);
            let shot = Shot {
                data: Window::from_size(w, h),
                display: Window::from_size(w, h),
                ..Shot::default()
            };
            let zero = Plane::filled(w, h, 0.0);
            for (x, depth) in [(&plane, &unit), (&unit, &plane), (&plane, &plane)] {
                let normal = Vector3Planes {
                    x: x.clone(),
                    y: zero.clone(),
                    z: zero.clone(),
                };
                let layers = Layers {
                    normal,
                    depth: depth.clone(),
                    mask: Mask::full(w, h),
                };
                assert!(shot.recovered_from(&layers).is_err(), "{value} in {w}x{h}");
            }
        }
    }
}

#[test]
fn stray_values_and_an_empty_mask_do_no_harm() {
    let shot = Shot::default();
    let mut layers = shot.layers();
    let strays = [f32::NAN, f32::INFINITY, -1e30, 65504.0, 3e8];
    for (i, value) in strays.into_iter().enumerate() {
        for y in (i * 5..240).step_by(23) {
            let row = layers.depth.row_mut(y);
            row.iter_mut().step_by(37).for_each(|d| *d = value);
            let row = layers.normal.z.row_mut(y);
            row.iter_mut().step_by(41).for_each(|n| *n = value);
        }
    }
    let found = shot.recovered_from(&layers).unwrap().camera.view_from_world;
    let truth = shot.camera.view_from_world.matrix3;
    assert!(turn_deg(found.matrix3 * truth.transpose()) < 0.05);
    layers.mask = Mask::new(Plane::filled(320, 240, false));
    let failure = shot.recovered_from(&layers);
    assert!(matches!(
        failure,
        Err(RecoveryFailure::TooFewPatches { found: 0, .. })
    ));
}

#[test]
fn a_long_lens_is_still_a_camera() {
    let camera = Camera {
        view_from_world: looking(DVec3::new(16.0, -96.0, 40.0), 0.0),
        projection: Projection::Perspective {
            fx: 6400.0,
            fy: 6400.0,
            cx: 160.0,
            cy: 120.0,
        },
    };
    let shot = Shot {
        camera,
        ..Shot::default()
    };
    expect_focal(&shot.expect_within(0.05), 6400.0, 0.01);
}

#[test]
fn panoramas_are_refused() {
    let (w, h) = (512, 256);
    let eye = DVec3::new(0.5, -3.0, 1.3);
    let seen = |x: usize, y: usize| {
        let lon = (x as f64 + 0.5) / w as f64 * std::f64::consts::TAU;
        let lat = (0.5 - (y as f64 + 0.5) / h as f64) * std::f64::consts::PI;
        let along = DVec3::new(lat.cos() * lon.sin(), -lat.cos() * lon.cos(), lat.sin());
        hit(Scene::Balls, eye, along)
    };
    let axis =
        |axis: usize| Plane::from_fn(w, h, |x, y| seen(x, y).map_or(0.0, |s| s.1[axis] as f32));
    let layers = Layers {
        normal: Vector3Planes {
            x: axis(0),
            y: axis(1),
            z: axis(2),
        },
        depth: Plane::from_fn(w, h, |x, y| seen(x, y).map_or(1e10, |s| s.0 as f32)),
        mask: Mask::new(Plane::from_fn(w, h, |x, y| seen(x, y).is_some())),
    };
    let shot = Shot {
        data: Window::from_size(w, h),
        display: Window::from_size(w, h),
        ..Shot::default()
    };
    let failure = shot.recovered_from(&layers).expect_err("fitted a panorama");
    println!("{failure}");
}
