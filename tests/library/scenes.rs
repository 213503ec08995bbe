//! The scenes that other tests are measured against, checked against their own definitions.

use crate::common::{mirrored, poisoned, quarter_turned, quarter_turned_plane};
use glam::{DMat3, DQuat, DVec2, DVec3};
use relievo::frame::{Frame, Plane, Projection};
use relievo::scenes::exact::{Exact, ExactScene, Seen, ball_trace, five_point};
use relievo::scenes::surfaces::{DISTANCE, Surface};
use std::f64::consts::{FRAC_PI_2, PI};

const SIDE: usize = 96;
/// Off the middle of a pixel and of the picture, so that no symmetry hides a mistake.
const CX: f64 = 49.3;
const CY: f64 = 45.8;

fn orthographic(surface: Surface) -> ExactScene {
    ExactScene::orthographic(surface, CX, CY)
}

fn every_scene() -> Vec<(&'static str, ExactScene)> {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    let flat = vec![
        (
            "plane",
            orthographic(Surface::plane(DVec3::new(0.5, -0.3, 0.8))),
        ),
        ("ball", orthographic(Surface::ball(40.0))),
        (
            "ellipsoid",
            orthographic(Surface::ellipsoid(DVec3::new(44.0, 22.0, 33.0), turn)),
        ),
        (
            "torus",
            orthographic(Surface::torus(30.0, 12.0, DVec3::new(0.3, 0.5, 0.8))),
        ),
        (
            "upright cylinder",
            orthographic(Surface::cylinder(35.0, DVec3::Y)),
        ),
        (
            "tilted cylinder",
            orthographic(Surface::cylinder(25.0, DVec3::new(0.6, 0.5, 0.45))),
        ),
        ("saddle", orthographic(Surface::saddle(0.02, -0.01, 0.4))),
        ("box corner", ExactScene::box_corner(true, 0.3, CX, CY)),
        ("room corner", ExactScene::box_corner(false, 0.3, CX, CY)),
        ("two balls", ExactScene::two_balls(20.0, 30.0, CX, CY)),
        (
            "sine relief",
            orthographic(Surface::sine_relief(3.0, 24.0, 0.7)),
        ),
    ];
    let deep: Vec<_> = flat
        .iter()
        .filter(|(name, _)| *name != "saddle")
        .map(|(name, scene)| (*name, scene.clone().in_perspective()))
        .collect();
    flat.into_iter().chain(deep).collect()
}

/// Runs `check` at scattered positions of every scene that are not close to an outline or an edge.
fn at_scattered_positions(check: impl Fn(&str, &ExactScene, DVec2, Exact)) {
    for (name, scene) in every_scene() {
        let name = match scene.projection {
            Projection::Orthographic { .. } => format!("orthographic {name}"),
            Projection::Perspective { .. } => format!("perspective {name}"),
        };
        let mut checked = 0;
        for i in 0..400_u32 {
            // Steps by the golden ratio and by the root of two cover the square evenly.
            let step = |by: f64| SIDE as f64 * (f64::from(i) * by).fract();
            let at = DVec2::new(step(0.618_033_988_7), step(0.414_213_562_4));
            let Some(exact) = scene.exact_at(at.x, at.y) else {
                continue;
            };
            let to_eye = scene.projection.to_eye(at.x, at.y).extend(1.0);
            let corners = [(-0.1, -0.1), (0.1, -0.1), (-0.1, 0.1), (0.1, 0.1)];
            let whole = corners.into_iter().all(|(x, y)| {
                scene.exact_at(at.x + x, at.y + y).is_some_and(|e| {
                    e.surface == exact.surface && (e.depth - exact.depth).abs() < 2.0
                })
            });
            if whole && exact.normal.dot(to_eye.normalize()) > 0.2 {
                check(&name, &scene, at, exact);
                checked += 1;
            }
        }
        assert!(checked > 60, "{name}: only {checked} positions checked");
    }
}

/// Asserts that two numbers are equal to within `tolerance`, relative to `scale`.
#[track_caller]
fn assert_near(found: f64, expected: f64, scale: f64, tolerance: f64, what: &str) {
    let error = (found - expected).abs() / scale;
    assert!(
        error <= tolerance,
        "{what}: {found} is not {expected} (off by {error:.1e})"
    );
}

#[test]
fn points_lie_on_their_surface_and_project_to_their_pixel() {
    at_scattered_positions(|name, scene, at, exact| {
        let surface = &scene.surfaces[exact.surface];
        let distance = surface.value(exact.point) / surface.derivatives(exact.point).0.length();
        assert!(distance.abs() < 1e-9, "{name}: {distance} off the surface");
        assert_eq!(exact.depth, -exact.point.z, "{name}");
        let back = scene
            .projection
            .pixel_of(exact.point)
            .expect("in front of the eye");
        assert!(back.distance(at) < 1e-9, "{name}: {at} came back as {back}");
    });
}

#[test]
fn derivatives_of_the_surface_functions_agree_with_differences() {
    at_scattered_positions(|name, scene, _, exact| {
        // Off the surface too: nothing here depends on F being zero.
        let p = exact.point + DVec3::new(0.3, -0.2, 0.5);
        let surface = &scene.surfaces[exact.surface];
        let (gradient, second) = surface.derivatives(p);
        for i in 0..3 {
            let value = |t: f64| Some(DVec2::splat(surface.value(p + t * DVec3::AXES[i])));
            let slope = five_point(value).expect("defined everywhere").x;
            assert_near(slope, gradient[i], gradient.length(), 1e-6, name);
            for j in 0..3 {
                let slope = |t: f64| {
                    Some(DVec2::splat(
                        surface.derivatives(p + t * DVec3::AXES[i]).0[j],
                    ))
                };
                let bend = five_point(slope).expect("defined everywhere").x;
                let scale = gradient.length() / 30.0;
                assert_near(bend, second.col(i)[j], scale, 1e-6, name);
            }
        }
    });
}

#[test]
fn gradient_is_that_of_the_height() {
    at_scattered_positions(|name, scene, at, exact| {
        let height = |x: f64, y: f64| Some(DVec2::splat(scene.exact_at(x, y)?.height));
        let across = five_point(|t| height(at.x + t, at.y))
            .expect("no edge here")
            .x;
        let up = five_point(|t| height(at.x, at.y - t))
            .expect("no edge here")
            .x;
        let scale = exact.gradient.length().max(1.0);
        assert_near(across, exact.gradient.x, scale, 1e-6, name);
        assert_near(up, exact.gradient.y, scale, 1e-6, name);
    });
}

#[test]
fn hessian_is_that_of_the_height() {
    at_scattered_positions(|name, scene, at, exact| {
        let gradient = |x: f64, y: f64| Some(scene.exact_at(x, y)?.gradient);
        let across = five_point(|t| gradient(at.x + t, at.y)).expect("no edge here");
        let up = five_point(|t| gradient(at.x, at.y - t)).expect("no edge here");
        let h = exact.hessian;
        let scale = h.xx.abs().max(h.yy.abs()).max(h.xy.abs()).max(1e-3);
        for (found, expected) in [
            (across.x, h.xx),
            (across.y, h.xy),
            (up.x, h.xy),
            (up.y, h.yy),
        ] {
            assert_near(found, expected, scale, 1e-6, name);
        }
    });
}

#[test]
fn normals_are_unit_and_give_the_gradient() {
    at_scattered_positions(|name, scene, at, exact| {
        assert_near(exact.normal.length(), 1.0, 1.0, 1e-14, name);
        let from_normal = scene.depth_gradient(at.x, at.y, 1.0).expect("seen");
        let scale = exact.gradient.length().max(1.0);
        assert!(
            from_normal.distance(exact.gradient) < 1e-12 * scale,
            "{name}"
        );
    });
}

/// With no foreshortening the divergence of `-(n_x, n_y)` is the sum of the surface's own curvatures, for any slant, in
/// orthographic projection.
#[test]
fn divergence_of_the_normal_is_the_object_curvature() {
    at_scattered_positions(|name, scene, at, exact| {
        if matches!(scene.projection, Projection::Perspective { .. }) {
            return;
        }
        let [xx, _, _, yy] = scene
            .depth_gradient_jacobian(at.x, at.y, 0.0)
            .expect("no edge here");
        let object = exact.object_curvatures;
        let scale = object.k_u.abs().max(object.k_v.abs()).max(1e-3);
        assert_near(xx + yy, object.k_u + object.k_v, scale, 1e-6, name);
    });
}

#[test]
fn principal_values_rebuild_the_hessian() {
    at_scattered_positions(|name, _, _, exact| {
        let h = exact.hessian;
        let p = h.principal();
        assert!(p.k_u >= p.k_v && (0.0..=PI).contains(&p.angle), "{name}");
        let (s, c) = p.angle.sin_cos();
        let scale = p.k_u.abs().max(p.k_v.abs()).max(1e-6);
        assert_near(p.k_u * c * c + p.k_v * s * s, h.xx, scale, 1e-12, name);
        assert_near((p.k_u - p.k_v) * s * c, h.xy, scale, 1e-12, name);
        assert_near(p.k_u * s * s + p.k_v * c * c, h.yy, scale, 1e-12, name);
    });
}

#[test]
fn principal_directions_are_tangent_and_square() {
    at_scattered_positions(|name, _, _, exact| {
        let object = exact.object_curvatures;
        assert!(object.k_u >= object.k_v, "{name}");
        for (a, b) in [
            (object.u, exact.normal),
            (object.v, exact.normal),
            (object.u, object.v),
        ] {
            assert_near(a.dot(b), 0.0, 1.0, 1e-12, name);
        }
    });
}

/// A ball curves by -1/R in all directions; seen head on so does its height.
#[test]
fn ball_curvature() {
    let scene = orthographic(Surface::ball(40.0));
    let top = scene.exact_at(CX, CY).expect("the ball is on the axis");
    for k in [top.hessian.xx, top.hessian.yy, top.object_curvatures.k_u] {
        assert_near(k, -1.0 / 40.0, 1.0 / 40.0, 1e-12, "at the top");
    }
    assert_eq!(top.normal, DVec3::Z);
    assert_eq!(top.depth, DISTANCE - 40.0);
    let aside = scene
        .exact_at(CX + 30.0, CY - 10.0)
        .expect("inside the outline")
        .object_curvatures;
    assert_near(aside.k_u, -1.0 / 40.0, 1.0 / 40.0, 1e-12, "aside");
    assert_near(aside.k_v, -1.0 / 40.0, 1.0 / 40.0, 1e-12, "aside");
}

/// From within, a ball is a bowl: its normals turn to the viewer and its curvatures change sign.
#[test]
fn ball_from_within_is_concave() {
    let radius = DISTANCE + 100.0;
    for scene in [
        orthographic(Surface::ball(radius)),
        orthographic(Surface::ball(radius)).in_perspective(),
    ] {
        let seen = scene.exact_at(CX + 20.0, CY - 9.0).expect("all around");
        assert!(
            seen.normal.z > 0.9 && seen.normal.x < 0.0,
            "{}",
            seen.normal
        );
        let object = seen.object_curvatures;
        assert_near(object.k_u, 1.0 / radius, 1.0 / radius, 1e-12, "k_u");
        assert_near(object.k_v, 1.0 / radius, 1.0 / radius, 1e-12, "k_v");
        let [xx, _, _, yy] = scene
            .depth_gradient_jacobian(CX + 20.0, CY - 9.0, 1.0)
            .expect("no edge");
        let bend = seen.hessian.trace();
        assert!(bend > 0.0, "{bend}");
        assert_near(xx + yy, bend, bend, 1e-6, "trace");
    }
}

/// Right of the axis and above it the normal points right and up: rows run down, y does not.
#[test]
fn rows_run_down_and_y_runs_up() {
    for scene in [
        orthographic(Surface::ball(40.0)),
        orthographic(Surface::ball(40.0)).in_perspective(),
    ] {
        let seen = scene
            .exact_at(CX + 12.0, CY - 9.0)
            .expect("inside the outline");
        assert!(
            seen.normal.x > 0.2 && seen.normal.y > 0.15,
            "{}",
            seen.normal
        );
        assert!(
            seen.gradient.x < 0.0 && seen.gradient.y < 0.0,
            "{}",
            seen.gradient
        );
    }
}

/// Around a cylinder -1/R, along it 0.
#[test]
fn cylinder_curvature() {
    for axis in [DVec3::Y, DVec3::new(0.6, 0.5, 0.45)] {
        let scene = orthographic(Surface::cylinder(25.0, axis));
        let seen = scene
            .exact_at(CX + 5.0, CY + 3.0)
            .expect("inside the outline");
        let object = seen.object_curvatures;
        assert_near(object.k_u, 0.0, 1.0, 1e-14, "along");
        assert_near(object.k_v, -1.0 / 25.0, 1.0, 1e-14, "around");
        assert_near(
            object.u.dot(axis.normalize()).abs(),
            1.0,
            1.0,
            1e-12,
            "direction",
        );
    }
    // Upright, the strongest bend is across the picture: the greatest (0) runs up it.
    let upright = orthographic(Surface::cylinder(25.0, DVec3::Y));
    let bend = upright
        .exact_at(CX + 7.0, CY)
        .expect("inside the outline")
        .hessian
        .principal();
    assert_near(bend.angle, FRAC_PI_2, 1.0, 1e-12, "angle");
    assert_near(bend.k_u, 0.0, 1.0, 1e-14, "up");
}

/// A torus bends by -1/r around the tube and by -cos(t)/(R + r cos(t)) around the axis, t the angle
/// around the tube from the outside.
#[test]
fn torus_curvature() {
    let (ring, tube, axis) = (30.0, 12.0, DVec3::new(0.3, 0.5, 0.8).normalize());
    let scene = orthographic(Surface::torus(ring, tube, axis));
    let center = DVec3::new(0.0, 0.0, -DISTANCE);
    let (mut checked, mut saddles) = (0, 0);
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let Some(seen) = scene.exact(x, y) else {
            continue;
        };
        let q = seen.point - center;
        let outward = (q - q.dot(axis) * axis).normalize();
        let cos = seen.normal.dot(outward);
        let mut expected = [-1.0 / tube, -cos / (ring + tube * cos)];
        expected.sort_by(f64::total_cmp);
        let object = seen.object_curvatures;
        assert_near(object.k_v, expected[0], 1.0, 1e-10, "smaller");
        assert_near(object.k_u, expected[1], 1.0, 1e-10, "greater");
        checked += 1;
        saddles += usize::from(object.k_u > 0.0);
    }
    assert!(
        checked > 1500 && saddles > 500,
        "{checked} seen, {saddles} of them saddles"
    );
}

/// On x^2/a^2 + y^2/b^2 + z^2/c^2 = 1, with h = 1/|(x/a^2, y/b^2, z/c^2)| the distance of the tangent
/// plane from the centre, the product of the curvatures is h^4 / (abc)^2 and their sum is
/// h^3 (|p|^2 - a^2 - b^2 - c^2) / (abc)^2.
#[test]
fn ellipsoid_curvature() {
    let axes = DVec3::new(44.0, 22.0, 33.0);
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    let scene = orthographic(Surface::ellipsoid(axes, turn));
    let mut checked = 0;
    for (x, y) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let Some(seen) = scene.exact(x, y) else {
            continue;
        };
        let p = turn.transpose() * (seen.point + DVec3::new(0.0, 0.0, DISTANCE));
        let h = 1.0 / (p / (axes * axes)).length();
        let volume2 = axes.element_product().powi(2);
        let product = h.powi(4) / volume2;
        let sum = h.powi(3) * (p.length_squared() - axes.length_squared()) / volume2;
        let object = seen.object_curvatures;
        assert_near(object.k_u * object.k_v, product, product, 1e-9, "product");
        assert_near(object.k_u + object.k_v, sum, sum.abs(), 1e-9, "sum");
        checked += 1;
    }
    assert!(checked > 1500, "{checked} seen");
}

/// A graph of second order has the same Hessian everywhere, for any slope.
#[test]
fn saddle_hessian() {
    let scene = orthographic(Surface::saddle(0.02, -0.01, 0.4));
    for (x, y) in [(10.0, 10.0), (80.5, 20.5), (49.3, 45.8)] {
        let bend = scene
            .exact_at(x, y)
            .expect("fills the picture")
            .hessian
            .principal();
        assert_near(bend.k_u, 0.02, 1.0, 1e-14, "k_u");
        assert_near(bend.k_v, -0.01, 1.0, 1e-14, "k_v");
        assert_near(bend.angle, 0.4, 1.0, 1e-12, "angle");
    }
}

/// z = a sin(k s): its second derivative is -a k^2 sin(k s), across the crests.
#[test]
fn sine_relief_hessian() {
    let k = 2.0 * PI / 24.0;
    let scene = orthographic(Surface::sine_relief(3.0, 24.0, 0.0));
    for x in [3.0, 20.25, 71.5] {
        let seen = scene.exact_at(x, 30.0).expect("fills the picture");
        let wave = 3.0 * (k * (x - CX)).sin();
        assert_near(seen.depth, DISTANCE - wave, 1.0, 1e-12, "depth");
        assert_near(seen.hessian.xx, -k * k * wave, k * k, 1e-12, "across");
        assert_near(seen.hessian.yy, 0.0, 1.0, 1e-14, "along");
    }
}

/// A plane is flat without foreshortening in either projection. With it, in perspective, n . v changes
/// over the picture by `-(n_x, n_y)/focal` per pixel, so `g = -(n_x, n_y) (n . v)^-f` has the trace
/// `-f (n_x^2 + n_y^2) (n . v)^-(f+1) / focal`: a plane seen at a slant counts as slightly convex.
#[test]
fn plane_curvature() {
    let normal = DVec3::new(0.5, -0.3, 0.8).normalize();
    let flat = orthographic(Surface::plane(normal));
    let seen = flat.exact_at(20.0, 30.0).expect("fills the picture");
    assert_eq!(seen.hessian.trace(), 0.0);
    assert_eq!(seen.object_curvatures.k_u, 0.0);

    let deep = flat.in_perspective();
    let (x, y) = (20.0, 30.0);
    let facing = normal.dot(deep.projection.to_eye(x, y).extend(1.0));
    for f in [0.0, 0.4, 1.0, 2.0] {
        let [xx, xy, yx, yy] = deep
            .depth_gradient_jacobian(x, y, f)
            .expect("fills the picture");
        let slant = normal.truncate().length_squared();
        let expected = -f * slant * facing.powf(-(f + 1.0)) / DISTANCE;
        assert_near(xx + yy, expected, 1.0, 1e-10, "trace");
        assert_near(xy, yx, 1.0, 1e-10, "a plane's gradient stays symmetric");
    }
}

#[test]
fn foreshortened_ball_has_the_trace_in_closed_form() {
    let radius = 40.0;
    let scene = orthographic(Surface::ball(radius));
    for n_z in [0.95, 0.5, 0.2, 0.1] {
        let aside = radius * f64::sqrt(1.0 - n_z * n_z);
        let way = DVec2::from_angle(0.6) * aside;
        for f in [0.0, 0.4, 1.0, 2.0] {
            let [xx, _, _, yy] = scene
                .depth_gradient_jacobian(CX + way.x, CY - way.y, f)
                .expect("inside the outline");
            let expected = ball_trace(radius, n_z, f);
            assert_near(xx + yy, expected, expected.abs(), 1e-6, "trace");
        }
    }
    // Printed values: 130/R at n_z = 0.2 and 1010/R at 0.1, for f = 1.
    assert_near(ball_trace(1.0, 0.2, 1.0), -130.0, 130.0, 1e-12, "n_z = 0.2");
    assert_near(
        ball_trace(1.0, 0.1, 1.0),
        -1010.0,
        1010.0,
        1e-12,
        "n_z = 0.1",
    );
}

#[test]
fn near_ball_hides_part_of_the_far_one() {
    for scene in [
        ExactScene::two_balls(20.0, 30.0, CX, CY),
        ExactScene::two_balls(20.0, 30.0, CX, CY).in_perspective(),
    ] {
        let seen: Vec<_> = (0..SIDE * SIDE)
            .filter_map(|i| scene.exact(i % SIDE, i / SIDE))
            .collect();
        let count = |which| seen.iter().filter(|e| e.surface == which).count();
        assert!(
            count(0) > 1000 && count(1) > 1000,
            "{} and {}",
            count(0),
            count(1)
        );
        let alone = ExactScene {
            surfaces: vec![scene.surfaces[1]],
            ..scene.clone()
        };
        let whole = (0..SIDE * SIDE)
            .filter(|i| alone.exact(i % SIDE, i / SIDE).is_some())
            .count();
        assert!(whole > count(1) + 200, "{} of {whole} are seen", count(1));
    }
}

#[test]
fn corner_faces_meet_on_the_axis() {
    for block in [true, false] {
        let corner = ExactScene::box_corner(block, 0.3, CX, CY);
        assert_eq!(corner.seen == Seen::Farthest, block);
        for scene in [corner.clone(), corner.in_perspective()] {
            let depth = |x: f64, y: f64| scene.exact_at(x, y).expect("fills the picture").depth;
            assert_near(depth(CX, CY), DISTANCE, 1.0, 1e-9, "the corner");
            let away = depth(CX + 20.0, CY + 5.0) - DISTANCE;
            assert!(if block { away > 5.0 } else { away < -5.0 }, "{away}");
            let faces = [
                (0, 0),
                (SIDE - 1, 0),
                (0, SIDE - 1),
                (SIDE - 1, SIDE - 1),
                (SIDE / 2, 0),
            ];
            let mut seen =
                faces.map(|(x, y)| scene.exact(x, y).expect("fills the picture").surface);
            seen.sort_unstable();
            assert!(
                seen.contains(&0) && seen.contains(&1) && seen.contains(&2),
                "{seen:?}"
            );
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let normal = |i: usize| scene.surfaces[i].derivatives(DVec3::ZERO).0;
                assert_near(normal(a).dot(normal(b)), 0.0, 1.0, 1e-14, "right angles");
            }
        }
    }
}

#[test]
fn frames_hold_the_exact_samples() {
    for (name, scene) in every_scene() {
        let frame = scene.frame(SIDE, 70);
        assert_eq!(
            (frame.normal.x.width(), frame.normal.x.height()),
            (SIDE, 70)
        );
        let depth = frame.depth.as_ref().expect("scenes have depth");
        for (x, y) in (0..70).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let exact = scene.exact(x, y);
            assert_eq!(frame.mask.at(x, y), exact.is_some(), "{name} at {x}, {y}");
            let Some(exact) = exact else { continue };
            assert_eq!(depth.at(x, y), exact.depth as f32, "{name}");
            assert!(depth.at(x, y) > 0.0, "{name}");
            assert_eq!(frame.normal.y.at(x, y), exact.normal.y as f32, "{name}");
        }
    }
}

/// Compares all surface data of two frames, except samples outside the mask and the picture.
fn assert_same_surfaces(a: &Frame, b: &Frame, tolerance: f32, name: &str) {
    assert_eq!(a.data_window, b.data_window, "{name}");
    assert_eq!(a.display_window, b.display_window, "{name}");
    assert_eq!(a.mask, b.mask, "{name}");
    let (a, b) = (poisoned(a, 0.5), poisoned(b, 0.5));
    let depth = |f: &Frame| f.depth.clone().expect("scenes have depth");
    for (plane, p, q) in [
        ("n_x", &a.normal.x, &b.normal.x),
        ("n_y", &a.normal.y, &b.normal.y),
        ("n_z", &a.normal.z, &b.normal.z),
        ("depth", &depth(&a), &depth(&b)),
    ] {
        for (p, q) in p.samples().iter().zip(q.samples()) {
            assert!(
                (p - q).abs() <= tolerance * p.abs().max(1.0),
                "{name}, {plane}: {p} and {q}"
            );
        }
    }
}

#[test]
fn mirrored_frame_is_the_frame_of_the_mirrored_scene() {
    for (name, scene) in every_scene() {
        let frame = mirrored(&scene.frame(SIDE, 70));
        let expected = scene.mirrored(SIDE).frame(SIDE, 70);
        assert_same_surfaces(&frame, &expected, 1e-6, name);
        assert_eq!(frame.camera, expected.camera, "{name}");
        assert_same_surfaces(&mirrored(&frame), &scene.frame(SIDE, 70), 0.0, name);
    }
}

#[test]
fn four_quarter_turns_change_nothing() {
    for (name, scene) in every_scene() {
        let frame = scene.frame(SIDE, 70);
        let once = quarter_turned(&frame);
        assert_eq!(
            (once.data_window.width(), once.data_window.height()),
            (70, SIDE)
        );
        let back = quarter_turned(&quarter_turned(&quarter_turned(&once)));
        assert_same_surfaces(&back, &frame, 0.0, name);
        assert_eq!(back.camera, frame.camera, "{name}");
        assert_eq!(back.color, frame.color, "{name}");
    }
}

/// A point of the world appears in the rotated picture at its rotated pixel, and the rotated normal is that of the
/// rotated camera.
#[test]
fn quarter_turn_and_mirror_keep_camera_and_samples_together() {
    for (name, scene) in every_scene() {
        let frame = scene.frame(SIDE, 70);
        let (x, y) = (40, 31);
        let Some(exact) = scene.exact(x, y) else {
            continue;
        };
        let turned = quarter_turned(&frame);
        let camera = turned.camera.expect("scenes have a camera");
        let at = camera.pixel_of(exact.point).expect("in front of the eye");
        let (column, row) = (at.x.floor() as usize, at.y.floor() as usize);
        assert_eq!((column, row), (y, SIDE - 1 - x), "{name}");
        let normal = camera.view_from_world.transform_vector3(exact.normal);
        assert_eq!(turned.normal.x.at(column, row), normal.x as f32, "{name}");
        assert_eq!(turned.normal.y.at(column, row), normal.y as f32, "{name}");
        let depth = frame.depth.as_ref().map(quarter_turned_plane);
        assert_eq!(turned.depth, depth, "{name}");

        let mirror = mirrored(&frame).camera.expect("scenes have a camera");
        let world = DVec3::new(-exact.point.x, exact.point.y, exact.point.z);
        let at = mirror.pixel_of(world).expect("in front of the eye");
        assert_eq!(
            (at.x.floor() as usize, at.y.floor() as usize),
            (SIDE - 1 - x, y),
            "{name}"
        );
    }
}

#[test]
fn poison_touches_only_what_is_outside_the_mask() {
    let frame = orthographic(Surface::ball(30.0)).frame(SIDE, 70);
    let spoiled = poisoned(&frame, f32::NAN);
    let nan = |p: &Plane| p.samples().iter().filter(|s| s.is_nan()).count();
    assert_eq!(nan(&spoiled.normal.z), SIDE * 70 - frame.mask.count());
    assert_same_surfaces(&spoiled, &frame, 0.0, "ball");
    assert_eq!(spoiled.color, frame.color);
}
