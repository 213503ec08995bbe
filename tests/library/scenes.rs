//! The scenes that other tests are measured against: what they say of slopes and curvature, by differences and closed forms.

use crate::common::curved::every_scene;
use crate::prelude::*;
use relievo::scenes::exact::{Exact, ExactScene, ball_trace, five_point};
use relievo::scenes::surfaces::Surface;

const SIDE: usize = 96;
/// Off the middle of a pixel and of the picture, so that no symmetry hides a mistake.
const CX: f64 = 49.3;
const CY: f64 = 45.8;

fn orthographic(surface: Surface) -> ExactScene {
    ExactScene::orthographic(surface, CX, CY)
}

/// Runs `check` at scattered positions of every scene that are not close to an outline or an edge.
fn at_scattered_positions(check: impl Fn(&str, &ExactScene, DVec2, Exact)) {
    for (name, scene) in every_scene(0.375, CX, CY) {
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
            let is_near =
                |e: Exact| e.surface == exact.surface && (e.depth - exact.depth).abs() < 2.0;
            let seen = corners.map(|(x, y)| scene.exact_at(at.x + x, at.y + y));
            let whole = seen.into_iter().all(|seen| seen.is_some_and(is_near));
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
    let off = format!("off by {error:.1e}");
    assert!(error <= tolerance, "{what}: {found}, not {expected}: {off}");
}

#[test]
fn points_lie_on_their_surface_and_project_to_their_pixel() {
    at_scattered_positions(|name, scene, at, exact| {
        let surface = &scene.surfaces[exact.surface];
        let distance = surface.value(exact.point) / surface.derivatives(exact.point).0.length();
        assert!(distance.abs() < 1e-9, "{name}: {distance} off the surface");
        assert_eq!(exact.depth, -exact.point.z, "{name}");
        let back = scene.projection.pixel_of(exact.point);
        let back = back.expect("in front of the eye");
        assert!(back.distance(at) < 1e-9, "{name}: {at} came back as {back}");
    });
}

#[test]
fn gradient_is_that_of_the_height() {
    at_scattered_positions(|name, scene, at, exact| {
        let height = |x: f64, y: f64| Some(DVec2::splat(scene.exact_at(x, y)?.height));
        let across = five_point(|t| height(at.x + t, at.y)).expect("no edge here");
        let up = five_point(|t| height(at.x, at.y - t)).expect("no edge here");
        let scale = exact.gradient.length().max(1.0);
        assert_near(across.x, exact.gradient.x, scale, 1e-6, name);
        assert_near(up.x, exact.gradient.y, scale, 1e-6, name);
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
        let found = [across.x, across.y, up.x, up.y];
        for (found, expected) in found.into_iter().zip([h.xx, h.xy, h.xy, h.yy]) {
            assert_near(found, expected, scale, 1e-6, name);
        }
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
        let jacobian = scene.depth_gradient_jacobian(at.x, at.y, 0.0);
        let [xx, _, _, yy] = jacobian.expect("no edge here");
        let object = exact.object_curvatures;
        let scale = object.k_u.abs().max(object.k_v.abs()).max(1e-3);
        assert_near(xx + yy, object.k_u + object.k_v, scale, 1e-6, name);
    });
}

/// Right of the axis and above it the normal points right and up: rows run down, y does not.
#[test]
fn rows_run_down_and_y_runs_up() {
    let flat = orthographic(Surface::ball(40.0));
    for scene in [flat.clone(), flat.in_perspective()] {
        let seen = scene
            .exact_at(CX + 12.0, CY - 9.0)
            .expect("inside the outline");
        let (n, g) = (seen.normal, seen.gradient);
        assert!(n.x > 0.2 && n.y > 0.15, "{n}");
        assert!(g.x < 0.0 && g.y < 0.0, "{g}");
    }
}

/// A torus bends by -1/r around the tube and by -cos(t)/(R + r cos(t)) around the axis, t the angle
/// around the tube from the outside.
#[test]
fn torus_curvature() {
    let (ring, tube, axis) = (30.0, 12.0, DVec3::new(0.3, 0.5, 0.8).normalize());
    let scene = orthographic(Surface::torus(ring, tube, axis));
    let center = DVec3::new(0.0, 0.0, -Surface::DISTANCE);
    let (mut checked, mut saddles) = (0, 0);
    for seen in places(SIDE, SIDE).filter_map(|(x, y)| scene.exact(x, y)) {
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
    let are_enough = checked > 1500 && saddles > 500;
    assert!(are_enough, "{checked} seen, {saddles} of them saddles");
}

#[test]
fn foreshortened_ball_has_the_trace_in_closed_form() {
    let radius = 40.0;
    let scene = orthographic(Surface::ball(radius));
    for n_z in [0.95, 0.5, 0.2, 0.1] {
        let aside = radius * f64::sqrt(1.0 - n_z * n_z);
        let way = DVec2::from_angle(0.6) * aside;
        for f in [0.0, 0.4, 1.0, 2.0] {
            let jacobian = scene.depth_gradient_jacobian(CX + way.x, CY - way.y, f);
            let [xx, _, _, yy] = jacobian.expect("inside the outline");
            let expected = ball_trace(radius, n_z, f);
            assert_near(xx + yy, expected, expected.abs(), 1e-6, "trace");
        }
    }
    // Printed values: 130/R at n_z = 0.2 and 1010/R at 0.1, for f = 1.
    for (n_z, printed) in [(0.2, 130.0), (0.1, 1010.0)] {
        let trace = ball_trace(1.0, n_z, 1.0);
        assert_near(trace, -printed, printed, 1e-12, "printed");
    }
}
