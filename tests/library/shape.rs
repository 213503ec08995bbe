//! The shape descriptor against scenes whose normals, depth and derivatives are known exactly.

use crate::common::cpu::described;
use crate::common::curved::every_scene;
use crate::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The surface itself: no diffusion, the viewer's height field.
fn exact_settings(foreshortening: f32) -> ShapeParams {
    default_but(|shape: &mut ShapeParams| {
        (shape.foreshortening, shape.scale) = (foreshortening, Scale::Iterations(0));
    })
}

/// Off the middle of a pixel and of the picture.
const CX: f64 = 128.3;
const CY: f64 = 127.6;

/// Whether conductance is 1 in the 3x3 pixels around (`x`, `y`).
fn in_the_open(conductance: &Plane, x: usize, y: usize) -> bool {
    let is_inside = |at: usize, size: usize| (1..size - 1).contains(&at);
    let around = || conductance.rows_within(x - 1..x + 2, y - 1..y + 2);
    is_inside(x, conductance.width())
        && is_inside(y, conductance.height())
        && around().flatten().all(|&c| c == 1.0)
}

/// Root mean square of the relative error of the Hessian's trace on the inner 60 % of a ball.
fn ball_error(radius: f64) -> f64 {
    let side = (2.4 * radius) as usize;
    let centre = side as f64 / 2.0 + 0.3;
    let scene = ExactScene::orthographic(Surface::ball(radius), centre, centre);
    let outcome = described(&scene.frame(side, side), exact_settings(1.0));
    let hessian = outcome.shape.hessian.unwrap();
    let (mut sum, mut count) = (0.0, 0);
    for (x, y) in places(side, side) {
        let from_centre = (x as f64 + 0.5 - centre).hypot(y as f64 + 0.5 - centre);
        if from_centre < 0.6 * radius {
            let exact = scene.exact(x, y).unwrap().hessian.trace();
            let found = f64::from(hessian.xx.at(x, y) + hessian.yy.at(x, y));
            sum += (found / exact - 1.0).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

#[test]
fn the_hessian_of_a_ball_is_second_order() {
    let errors = [32.0, 64.0, 128.0, 256.0].map(ball_error);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.9..2.1).contains(&order), "order {order} in {errors:?}");
    }
}

#[test]
fn foreshortening_steepens_a_ball_as_its_closed_form_says() {
    let radius = 200.0;
    let scene = ExactScene::orthographic(Surface::ball(radius), 240.0, 240.0);
    let frame = scene.frame(480, 480);
    for f in [0.4, 1.0] {
        let outcome = described(&frame, exact_settings(f as f32));
        let mean = outcome.shape.curvatures.unwrap().mean;
        for x in [240, 300, 350, 390] {
            let n_z = scene.exact(x, 240).unwrap().normal.z;
            let expected = ball_trace(radius, n_z, f);
            let found = f64::from(2.0 * mean.at(x, 240));
            // Truncation is (1/R)^2 times a fourth derivative that grows toward the rim.
            let tolerance = 2.0 / (radius * radius * n_z.powi(4));
            let error = (found / expected - 1.0).abs();
            assert!(error < tolerance, "f {f}, n_z {n_z}");
        }
    }
}

#[test]
fn every_scene_has_its_exact_hessian_curvatures_and_directions() {
    for (name, scene) in every_scene(1.0, CX, CY) {
        let outcome = described(&scene.frame(256, 256), exact_settings(1.0));
        let shape = &outcome.shape;
        let (hessian, curvatures) = (shape.hessian.as_ref(), shape.curvatures.as_ref());
        let (hessian, curvatures) = (hessian.unwrap(), curvatures.unwrap());
        let direction = shape.direction_view.as_ref().unwrap();
        let conductance = shape.conductance.as_ref().unwrap();
        let (mut tested, mut turned) = (0, 0);
        for (x, y) in places(256, 256).filter(|&(x, y)| in_the_open(conductance, x, y)) {
            let exact = scene.exact(x, y).unwrap();
            // An arc of radius R has f'' = 1 / (R n_z^3), and the central difference of f' is off by
            // f''''/6 = (5 - 4 n_z^2) / (2 R^3 n_z^7), at most 0.78 f''^3; Sobel's smoothing adds to it.
            if exact.normal.z < 0.55 {
                continue;
            }
            let h = exact.hessian;
            let norm = (h.xx * h.xx + 2.0 * h.xy * h.xy + h.yy * h.yy).sqrt();
            let tolerance = 1e-4 + 0.005 * norm + norm.powi(3);
            let pairs = [
                (hessian.xx.at(x, y), exact.hessian.xx),
                (hessian.xy.at(x, y), exact.hessian.xy),
                (hessian.yy.at(x, y), exact.hessian.yy),
                (curvatures.u.at(x, y), exact.hessian.principal().k_u),
                (curvatures.v.at(x, y), exact.hessian.principal().k_v),
            ];
            for (found, expected) in pairs {
                near(
                    found,
                    expected,
                    tolerance,
                    format_args!("{name} at ({x}, {y})"),
                );
            }
            tested += 1;
            turned += usize::from(check_direction(name, &exact, direction, x, y));
        }
        assert!(tested > 1000, "{name}: only {tested} pixels tested");
        let umbilic = ["plane", "ball", "two balls"].contains(&name) || name.ends_with("corner");
        assert!(umbilic || turned > 500, "{name}: only {turned} directions");
    }
}

/// Compares the direction of the larger curvature where the two differ clearly.
fn check_direction(
    name: &str,
    exact: &Exact,
    direction: &Vector2Planes,
    x: usize,
    y: usize,
) -> bool {
    let principal = exact.hessian.principal();
    let (u, v) = (principal.k_u.abs(), principal.k_v.abs());
    if u.max(v) < 1e-3 || (u - v).abs() < 0.3 * u.max(v) {
        return false;
    }
    let across = if u > v { 0.0 } else { FRAC_PI_2 };
    let (s, c) = (principal.angle + across).sin_cos();
    let found = [&direction.x, &direction.y].map(|plane| f64::from(plane.at(x, y)));
    let off = (c * found[1] - s * found[0]).abs().asin().to_degrees();
    assert!(off < 0.6, "{name} at ({x}, {y}): {found:?}, not ({c}, {s})");
    true
}

#[test]
fn without_foreshortening_the_mean_is_that_of_the_object() {
    // At f = 0, div(-n_xy) is k1 + k2 of the surface itself, for any tilt, orthographically.
    for (name, scene) in every_scene(1.0, CX, CY).into_iter().take(11) {
        let outcome = described(&scene.frame(256, 256), exact_settings(0.0));
        let mean = outcome.shape.curvatures.unwrap().mean;
        let conductance = outcome.shape.conductance.unwrap();
        let mut tested = 0;
        for (x, y) in places(256, 256).filter(|&(x, y)| in_the_open(&conductance, x, y)) {
            let exact = scene.exact(x, y).unwrap();
            if exact.normal.z < 0.5 {
                continue;
            }
            let expected = exact.object_curvatures.k_u + exact.object_curvatures.k_v;
            // Of a ball g = -n_xy = p / R, so H = -I / R in [LW]'s sign and the trace is -2 / R everywhere.
            let share = if name == "ball" { 1e-4 } else { 0.01 };
            let tolerance = 1e-5 * (share / 0.01) + share * expected.abs();
            near(2.0 * mean.at(x, y), expected, tolerance, name);
            tested += 1;
        }
        assert!(tested > 1000, "{name}: only {tested} pixels tested");
    }
}

#[test]
fn creases_are_where_faces_meet() {
    let corner = ExactScene::box_corner(true, 0.3, CX, CY);
    let outcome = described(&corner.frame(256, 256), exact_settings(1.0));
    let crease = outcome.shape.crease.unwrap();
    let mut on_edges = 0;
    for (x, y) in places(255, 255).filter(|&(x, y)| x > 0 && y > 0) {
        let cross = [(x, y), (x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        let faces = cross.map(|(x, y)| corner.exact(x, y).unwrap().normal);
        // The faces of a box meet at 90 degrees.
        let meet = faces.iter().any(|n| n.dot(faces[0]) < 0.5);
        assert_eq!(crease.at(x, y), f32::from(u8::from(meet)), "at ({x}, {y})");
        on_edges += usize::from(meet);
    }
    assert!(on_edges > 300, "only {on_edges} pixels on edges");
}

/// The same, solved so.
fn solved(solver: Solver, iterations: u32) -> ShapeParams {
    let mut shape = diffusing(iterations);
    shape.solver = solver;
    shape
}

/// A frame without depth whose normals are those of the slopes `gradient(x, y)` and whose occlusion
/// map is `occlusion(x, y)`.
fn sloping(
    side: usize,
    gradient: impl Fn(usize, usize) -> [f64; 2],
    occlusion: impl Fn(usize, usize) -> f32,
) -> Frame {
    let plane = ExactScene::orthographic(Surface::plane(DVec3::Z), 0.0, 0.0);
    let mut frame = plane.frame(side, side);
    for (x, y) in places(side, side) {
        let [gx, gy] = gradient(x, y);
        let n = DVec3::new(-gx, -gy, 1.0).normalize();
        set_normal(&mut frame.normal, x, y, n.as_vec3());
    }
    frame.depth = None;
    frame.occlusion = Some(Plane::from_fn(side, side, occlusion));
    frame
}

/// Settings under which only the occlusion map makes edges, and the gradient is that of `sloping`.
fn diffusing(iterations: u32) -> ShapeParams {
    let (lo, hi) = (179.0, 180.0);
    ShapeParams {
        crease: SoftThreshold { lo, hi },
        scale: Scale::Iterations(iterations),
        ..exact_settings(1.0)
    }
}

#[test]
fn nothing_leaks_through_a_closed_silhouette() {
    // A disc of radius 20 stands out in the occlusion map; the slopes inside change, those outside must keep their bits
    // after any number of steps.
    let from_centre = |x: usize, y: usize| (x as f64 - 32.0).hypot(y as f64 - 32.0);
    let scene = |inside: f64, solver| {
        let wave = |x: usize, y: usize| 0.3 * ((x + 2 * y) as f64 * 0.4).sin();
        let is_inside = |x, y| from_centre(x, y) < 20.0;
        let slope = |x, y| if is_inside(x, y) { inside } else { wave(x, y) };
        let disc = |x, y| if is_inside(x, y) { 0.0 } else { 1.0 };
        let frame = sloping(64, |x, y| [slope(x, y), -slope(x, y)], disc);
        described(&frame, solved(solver, 500))
            .shape
            .gradient
            .unwrap()
    };
    for solver in [Solver::Explicit, Solver::Chebyshev] {
        let [one, other] = [0.0, 0.8].map(|inside| scene(inside, solver));
        let mut outside = 0;
        for (x, y) in places(64, 64).filter(|&(x, y)| from_centre(x, y) >= 20.0) {
            let bits = |of: &Vector2Planes| [&of.x, &of.y].map(|plane| plane.at(x, y).to_bits());
            assert_eq!(bits(&one), bits(&other), "at ({x}, {y})");
            outside += 1;
        }
        assert!(outside > 2000);
        assert_ne!(one.x.at(32, 32), other.x.at(32, 32), "the inside");
    }
}

#[test]
fn diffusion_keeps_the_mean() {
    let noise = |x: usize, y: usize| {
        let hash = (x * 7919 + y * 104_729) % 1009;
        0.5 + 0.4 * (hash as f64 / 1009.0 - 0.5)
    };
    let ramp = |x: usize, y: usize| ((x / 7 + y / 5) % 3) as f32 / 2.0;
    let frame = sloping(96, |x, y| [noise(x, y), noise(y, x)], ramp);
    let mean_of = |iterations, solver| {
        let outcome = described(&frame, solved(solver, iterations));
        mean(&outcome.shape.gradient.unwrap().x)
    };
    for solver in [Solver::Explicit, Solver::Chebyshev] {
        let (before, after) = (mean_of(0, solver), mean_of(200, solver));
        let change = (after / before - 1.0).abs();
        assert!(change < 1e-6, "{solver:?}: from {before} to {after}");
    }
}

/// The slope cos(k (x + 1/2)) with k = 2 pi / 32 is an eigenvector of the operator with Neumann borders, of eigenvalue
/// -2 (1 - cos k). Returns the deviation of a diffused one from `decay` of itself.
fn wave_error(settings: ShapeParams, decay: impl Fn(f64) -> f64) -> f64 {
    let k = TAU / 32.0;
    let wave = |x: usize| 0.5 * (k * (x as f64 + 0.5)).cos();
    let outcome = described(&sloping(64, |x, _| [wave(x), 0.0], |_, _| 1.0), settings);
    let gradient = outcome.shape.gradient.unwrap();
    let decay = decay(-2.0 * (1.0 - k.cos()));
    let errors = (0..64).map(|x| (f64::from(gradient.x.at(x, 20)) - decay * wave(x)).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn an_open_wave_decays_at_its_own_rate() {
    // Each step multiplies by 1 + dt times the eigenvalue.
    let stepped = solved(Solver::Explicit, 50);
    assert!(wave_error(stepped, |eigenvalue| (1.0 + 0.2 * eigenvalue).powi(50)) < 2e-6);
    // A time t = sigma^2 / 2 multiplies by e to the t times the eigenvalue.
    for sigma in [1.0_f32, 3.16, 10.0, 28.0, 100.0] {
        let time = 0.5 * f64::from(sigma).powi(2);
        let settings = ShapeParams {
            scale: Scale::Sigma(sigma),
            ..diffusing(0)
        };
        let error = wave_error(settings, |eigenvalue| (time * eigenvalue).exp());
        assert!(error < 1e-4, "sigma {sigma}: {error}");
    }
}

#[test]
fn the_expansion_stays_within_its_tolerance_of_the_steps() {
    // Slopes up to 20 at the floor of n_z, silhouettes, creases and a border of coverage.
    let scenes = [
        ExactScene::two_balls(55.0, 80.0, CX, CY).in_perspective(),
        ExactScene::box_corner(false, 0.3, CX, CY),
    ];
    for frame in scenes.map(|scene| scene.frame(256, 256)) {
        for count in [1, 10, 50, 200] {
            let stepped = ShapeParams {
                solver: Solver::Explicit,
                ..wide(count)
            };
            let steps = described(&frame, stepped).shape.gradient.unwrap();
            for tolerance in [1e-2, 1e-4] {
                let expanded = ShapeParams {
                    tolerance,
                    ..wide(count)
                };
                let found = described(&frame, expanded).shape.gradient.unwrap();
                let error = apart(&found.x, &steps.x);
                // Rounding of slopes up to 20 in the recurrence adds to the tolerance.
                assert!(error < tolerance + 1e-4, "{count}, {tolerance}: {error}");
            }
        }
    }
}

/// The viewer's height field after this many steps.
fn wide(count: u32) -> ShapeParams {
    ShapeParams {
        scale: Scale::Iterations(count),
        ..exact_settings(1.0)
    }
}
