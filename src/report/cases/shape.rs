//! Cases of the shape: normals and depth to edges, gradient, curvature, directions, height.

use super::{Case, apart, larger, pixels, table, worst};
use crate::engine::{Engine, Outcome, Request, Run};
use crate::error::Result;
use crate::frame::from_depth::{Precision, normals_of_depth};
use crate::frame::{Frame, Normals, Plane, StoredDepth, Vector3Planes};
use crate::params::{Params, Scale, ScalingParams, ShapeParams, Solver};
use crate::plan::Goal;
use crate::product::Product;
use crate::scenes::frames::{masked, noise};
use crate::scenes::{ExactScene, Scene, Surface, angle_deg, ball_trace};
use glam::{DMat3, DQuat, DVec2, DVec3};

fn described(frame: &Frame, shape: ShapeParams) -> Result<Outcome> {
    let request = Request::layers(Params::of(shape, ScalingParams::default()));
    Engine::cpu().run(&request, frame, &Run::new())
}

/// The surface itself, undiffused.
fn itself(foreshortening: f32) -> ShapeParams {
    ShapeParams {
        foreshortening,
        scale: Scale::Iterations(0),
        ..ShapeParams::default()
    }
}

fn trace(outcome: &Outcome, x: usize, y: usize) -> f64 {
    let hessian = outcome.shape.hessian.as_ref().expect("layers hold it");
    f64::from(hessian.xx.at(x, y)) + f64::from(hessian.yy.at(x, y))
}

/// Whether no edge is within a pixel.
fn is_open(outcome: &Outcome, x: usize, y: usize) -> bool {
    let plane = outcome.shape.conductance.as_ref().expect("layers hold it");
    let is_inside = x > 0 && y > 0 && x + 1 < plane.width() && y + 1 < plane.height();
    is_inside
        && plane
            .rows_within(x - 1..x + 2, y - 1..y + 2)
            .flatten()
            .all(|&c| c == 1.0)
}

fn silhouette(outcome: &Outcome) -> &Plane {
    outcome.shape.silhouette.as_ref().expect("layers hold it")
}

fn crease(outcome: &Outcome) -> &Plane {
    outcome.shape.crease.as_ref().expect("layers hold it")
}

fn at(surface: Surface) -> ExactScene {
    ExactScene::orthographic(surface, 128.3, 127.6).at_distance(20_000.0)
}

/// A plane's curvature and silhouettes, away from the picture's border.
fn plane(tilt_deg: f64, foreshortening: f32) -> Result<f64> {
    let (sin, cos) = tilt_deg.to_radians().sin_cos();
    let scene = at(Surface::plane(DVec3::new(0.8 * sin, 0.6 * sin, cos)));
    let frame = scene.frame(96, 96);
    let outcome = described(&frame, itself(foreshortening))?;
    let silhouette = silhouette(&outcome);
    Ok(worst(&frame, |x, y| {
        let is_inside = (2..94).contains(&x) && (2..94).contains(&y);
        is_inside.then(|| trace(&outcome, x, y).abs().max(silhouette.at(x, y).into()))
    }))
}

/// The error of the trace where `exact` knows it, in relation to `scale`.
fn trace_error(
    frame: &Frame,
    shape: ShapeParams,
    scale: f64,
    exact: impl Fn(usize, usize) -> Option<f64>,
) -> Result<f64> {
    let outcome = described(frame, shape)?;
    Ok(worst(frame, |x, y| {
        let exact = exact(x, y).filter(|_| is_open(&outcome, x, y))?;
        Some((trace(&outcome, x, y) - exact) / scale)
    }))
}

fn ball(radius: f64, foreshortening: f32, least_n_z: f64) -> Result<f64> {
    let scene = at(Surface::ball(radius));
    let frame = scene.frame(256, 256);
    let outcome = described(&frame, itself(foreshortening))?;
    Ok(worst(&frame, |x, y| {
        let n_z = scene.exact(x, y)?.normal.z;
        let is_seen = n_z > least_n_z && is_open(&outcome, x, y);
        let exact = ball_trace(radius, n_z, foreshortening.into());
        is_seen.then(|| trace(&outcome, x, y) / exact - 1.0)
    }))
}

/// The normals that depth shows of a ball of 100 pixels, and their trace: the largest angle to the exact ones, in degrees, and
/// the root mean square error of the trace, in relation to that of the exact ones.
fn of_depth() -> Result<[f64; 2]> {
    let scene = ExactScene::orthographic(Surface::ball(100.0), 128.3, 127.6).in_perspective();
    let frame = scene.frame(256, 256);
    let (Some(depth), Some(camera)) = (&frame.depth, &frame.camera) else {
        return Ok([f64::NAN; 2]);
    };
    let seen = (camera.projection, frame.data_window);
    let covers = |x: usize, y: usize| frame.mask.at(x, y);
    let normal = normals_of_depth(depth, StoredDepth::Planar, seen, covers, Precision::Float);
    let made = Frame {
        normal,
        ..frame.clone()
    };
    let [found, exact] = [
        described(&made, itself(0.0))?,
        described(&frame, itself(0.0))?,
    ];
    let (mut off, mut error, mut size) = (0.0_f64, 0.0, 0.0);
    for (x, y) in pixels(256, 256) {
        if scene.exact(x, y).is_some_and(|exact| exact.normal.z > 0.7) {
            let [seen, normal] = [&made, &frame].map(|frame| frame.normal.at(x, y));
            off = off.max(seen.angle_between(normal).to_degrees());
            let [found, exact] = [&found, &exact].map(|outcome| trace(outcome, x, y));
            error += (found - exact).powi(2);
            size += exact * exact;
        }
    }
    Ok([off, (error / size).sqrt()])
}

/// The Hessian of a height field against its second derivatives, in relation to the largest.
fn height_field(scene: &ExactScene, least_n_z: f64) -> Result<f64> {
    let frame = scene.frame(256, 256);
    let outcome = described(&frame, itself(1.0))?;
    let hessian = outcome.shape.hessian.as_ref().expect("layers hold it");
    let mut largest = 0.0_f64;
    let mut off = 0.0_f64;
    for (x, y) in pixels(256, 256) {
        let Some(exact) = scene.exact(x, y).filter(|e| e.normal.z > least_n_z) else {
            continue;
        };
        if !is_open(&outcome, x, y) {
            continue;
        }
        let pairs = [
            (&hessian.xx, exact.hessian.xx),
            (&hessian.xy, exact.hessian.xy),
            (&hessian.yy, exact.hessian.yy),
        ];
        for (plane, exact) in pairs {
            largest = largest.max(exact.abs());
            off = off.max((f64::from(plane.at(x, y)) - exact).abs());
        }
    }
    Ok(off / largest)
}

fn waves(scale: Scale, solver: Solver, time: f64) -> Result<f64> {
    let scene = Scene::waves(320, 300);
    let shape = ShapeParams {
        scale,
        solver,
        foreshortening: 1.0,
        ..ShapeParams::default()
    };
    let (height, square) = (Scene::HEIGHT, Scene::WAVE.powi(2));
    let peak = 2.0 * height * square * (-2.0 * square * time).exp();
    trace_error(&scene.frame, shape, peak, |x, y| {
        scene.exact_trace(x, y, time)
    })
}

/// The share of the pixels on both sides of a border between surfaces of which neither is marked.
fn unmarked(scene: &ExactScene, size: usize, marks: fn(&Outcome) -> &Plane) -> Result<f64> {
    let outcome = described(&scene.frame(size, size), itself(0.0))?;
    let marks = marks(&outcome);
    let seen = |x: usize, y: usize| scene.exact(x, y).map(|exact| exact.surface);
    let (mut missed, mut borders) = (0, 0);
    for (x, y) in pixels(size - 1, size - 1).filter(|&(x, y)| x > 0 && y > 0) {
        for (nx, ny) in [(x + 1, y), (x, y + 1)] {
            if let (Some(a), Some(b)) = (seen(x, y), seen(nx, ny))
                && a != b
            {
                borders += 1;
                missed += usize::from(marks.at(x, y).max(marks.at(nx, ny)) < 0.5);
            }
        }
    }
    Ok(f64::from(missed as u32) / f64::from(borders.max(0) as u32))
}

/// A ball of radius 60 before a wall, the gap between its rim and the wall being `gap`.
fn before_wall(gap: f64, distance: f64) -> ExactScene {
    let mut scene = ExactScene::orthographic(Surface::ball(60.0), 100.3, 99.6);
    scene
        .surfaces
        .push(Surface::plane(DVec3::Z).moved(DVec3::new(0.0, 0.0, -gap)));
    scene.at_distance(distance)
}

/// The picture transposed: columns are rows, x is -y.
fn transposed(frame: &Frame) -> Frame {
    let turn = |plane: &Plane, sign: f32| {
        Plane::from_fn(plane.height(), plane.width(), |x, y| sign * plane.at(y, x))
    };
    let normal = Vector3Planes {
        x: turn(&frame.normal.y, -1.0),
        y: turn(&frame.normal.x, -1.0),
        z: turn(&frame.normal.z, 1.0),
    };
    let (width, height) = (frame.mask.height(), frame.mask.width());
    let whole = Frame {
        depth: frame.depth.as_ref().map(|depth| turn(depth, 1.0)),
        ..Frame::of_normals(normal, crate::frame::Mask::full(width, height))
    };
    masked(whole, |x, y| frame.mask.at(y, x))
}

fn traces_apart(a: &Frame, b: &Frame, to: impl Fn(usize, usize) -> [usize; 2]) -> Result<f64> {
    let shape = ShapeParams::default();
    let (a_made, b_made) = (described(a, shape)?, described(b, shape)?);
    Ok(worst(a, |x, y| {
        let [bx, by] = to(x, y);
        Some(trace(&a_made, x, y) - trace(&b_made, bx, by))
    }))
}

/// How many of the trace's samples are no numbers, and how many covered pixels there are too few or too many.
fn not_numbers(normal: impl Fn(usize, usize) -> [f32; 3], covered: usize) -> Result<f64> {
    let normals: Vec<f32> = (0..48 * 48).flat_map(|i| normal(i % 48, i / 48)).collect();
    let frame = Frame::builder(48, 48)
        .normals(Normals::view(&normals))
        .build()?;
    let outcome = described(&frame, ShapeParams::default())?;
    let bad = pixels(48, 48)
        .filter(|&(x, y)| !trace(&outcome, x, y).is_finite())
        .count();
    Ok((bad + frame.mask.count().abs_diff(covered)) as f64)
}

/// How far slopes leave their range before diffusion, in relation to it.
fn overshoot(sigma: f32) -> Result<f64> {
    let scene = Scene::barriers(256, 192);
    let of = |scale| ShapeParams {
        scale,
        foreshortening: 1.0,
        ..ShapeParams::default()
    };
    let before = described(&scene.frame, of(Scale::Iterations(0)))?;
    let after = described(&scene.frame, of(Scale::Sigma(sigma)))?;
    let slopes = |outcome: &Outcome| outcome.shape.gradient.clone().expect("layers hold it");
    let largest = |plane: &Plane| plane.samples().iter().map(|&v| v.into()).fold(0.0, larger);
    let (before, after) = (slopes(&before), slopes(&after));
    let x = largest(&after.x) / largest(&before.x) - 1.0;
    let y = largest(&after.y) / largest(&before.y) - 1.0;
    Ok(x.max(y).max(0.0))
}

fn steps_and_chebyshev() -> Result<f64> {
    let frame = Scene::barriers(200, 150).frame;
    let of = |solver| ShapeParams {
        scale: Scale::Iterations(50),
        solver,
        ..ShapeParams::default()
    };
    let [steps, fast] =
        [Solver::Explicit, Solver::Chebyshev].map(|solver| described(&frame, of(solver)));
    let slopes = |outcome: Outcome| outcome.shape.gradient.expect("layers hold it");
    let (steps, fast) = (slopes(steps?), slopes(fast?));
    Ok(apart(&steps.x, &fast.x).max(apart(&steps.y, &fast.y)))
}

fn directions() -> Result<f64> {
    let scene = Scene::ellipsoid(240, 200);
    let outcome = described(&scene.frame, itself(1.0))?;
    let found = outcome.shape.direction.as_ref().expect("layers hold it");
    let mut off = Vec::new();
    for (x, y) in pixels(240, 200) {
        if let Some(exact) = scene.exact_direction(x, y) {
            let found = DVec2::new(found.x.at(x, y).into(), found.y.at(x, y).into());
            off.push(angle_deg(found, exact));
        }
    }
    off.sort_by(f64::total_cmp);
    Ok(off[off.len() * 95 / 100])
}

fn principal_curvatures(surface: Surface, exact: [f64; 2]) -> Result<f64> {
    let scene = at(surface);
    let frame = scene.frame(256, 256);
    let outcome = described(&frame, itself(0.0))?;
    let found = outcome.shape.curvatures.as_ref().expect("layers hold it");
    Ok(worst(&frame, |x, y| {
        let is_seen = is_open(&outcome, x, y) && scene.exact(x, y)?.normal.z > 0.3;
        let pair = [&found.u, &found.v].map(|plane| f64::from(plane.at(x, y)));
        // In either order.
        let off = |[a, b]: [f64; 2]| (pair[0] - a).abs().max((pair[1] - b).abs());
        let off = off(exact).min(off([exact[1], exact[0]]));
        is_seen.then_some(off / exact[0].abs().max(exact[1].abs()))
    }))
}

fn reference_height() -> Result<f64> {
    let of = |radius: f64, size: usize| -> Result<f64> {
        let middle = size as f64 / 2.0;
        let frame =
            ExactScene::orthographic(Surface::ball(radius), middle, middle).frame(size, size);
        let shape = ShapeParams {
            reference_height: Some(200),
            ..ShapeParams::default()
        };
        Ok(trace(&described(&frame, shape)?, size / 2, size / 2))
    };
    Ok(of(160.0, 400)? / of(80.0, 200)? - 1.0)
}

fn height() -> Result<f64> {
    let scene = Scene::waves(256, 256);
    let frame = Frame {
        depth: None,
        ..scene.frame
    };
    let goal = Goal::Layers {
        and: &[Product::Height],
        more_px: &[],
    };
    let request = Request::new(goal, Params::of(itself(0.0), ScalingParams::default()));
    let outcome = Engine::cpu().run(&request, &frame, &Run::new())?;
    let plane = outcome.planes(Product::Height)[0];
    let exact = |x: usize, y: usize| {
        let [x, y] = [x, y].map(|i| (Scene::WAVE * (i as f64 + 0.5)).cos());
        Scene::HEIGHT * x * y
    };
    // Normals tell a height but for a constant: of whole waves the mean is 0.
    let samples = plane.samples();
    let mean = samples.iter().map(|v| f64::from(*v)).sum::<f64>() / samples.len() as f64;
    Ok(worst(&frame, |x, y| {
        Some((f64::from(plane.at(x, y)) - mean - exact(x, y)) / Scene::HEIGHT)
    }))
}

/// The silhouettes of a picture seen from above, away from its border.
fn no_silhouette() -> Result<f64> {
    let frame = at(Surface::sine_relief(12.0, 60.0, 0.3)).frame(256, 256);
    let outcome = described(&frame, itself(0.0))?;
    let found = silhouette(&outcome);
    Ok(worst(&frame, |x, y| {
        ((2..254).contains(&x) && (2..254).contains(&y)).then(|| found.at(x, y).into())
    }))
}

fn mirrored() -> Result<f64> {
    let scene = ExactScene::two_balls(55.0, 80.0, 128.0, 127.0);
    let [a, b] = [&scene, &scene.mirrored(256)].map(|scene| scene.frame(256, 256));
    traces_apart(&a, &b, |x, y| [255 - x, y])
}

fn turned_over() -> Result<f64> {
    let frame = Frame {
        camera: None,
        ..two_balls().frame(256, 240)
    };
    traces_apart(&frame, &transposed(&frame), |x, y| [y, x])
}

fn two_balls() -> ExactScene {
    ExactScene::two_balls(55.0, 80.0, 128.3, 127.6)
}

fn corner(block: bool) -> ExactScene {
    ExactScene::box_corner(block, 0.3, 128.3, 127.6)
}

fn ellipsoid() -> ExactScene {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    let surface = Surface::ellipsoid(DVec3::new(120.0, 70.0, 90.0), turn);
    ExactScene::orthographic(surface, 128.3, 127.6).in_perspective()
}

fn torus() -> ExactScene {
    at(Surface::torus(80.0, 35.0, DVec3::new(0.3, 0.5, 0.8)))
}

/// Every seventh normal is none.
fn holes() -> Result<f64> {
    let is_bad = |x: usize, y: usize| (x + 3 * y).is_multiple_of(7);
    let covered = pixels(48, 48).filter(|&(x, y)| !is_bad(x, y)).count();
    let normal = |x, y| {
        if is_bad(x, y) {
            [f32::NAN; 3]
        } else {
            [0.6, 0.0, 0.8]
        }
    };
    not_numbers(normal, covered)
}

fn one_pixel() -> Result<f64> {
    let frame = Frame::builder(1, 1)
        .normals(Normals::view(&[0.6_f32, 0.0, 0.8][..]))
        .build()?;
    Ok(trace(&described(&frame, ShapeParams::default())?, 0, 0))
}

#[rustfmt::skip] // It would break the rows.
pub(super) fn cases() -> Vec<Case> {
    use Solver::{Chebyshev, Explicit};
    table! {
        "plane, facing", "curvature 0, no silhouette", 0.0 => plane(0.0, 0.0);
        "plane, 60 degrees", "curvature 0, no silhouette", 0.0 => plane(60.0, 1.0);
        "plane, 85 degrees", "curvature 0, no silhouette", 0.0 => plane(85.0, 1.0);
        "plane, 89 degrees", "curvature 0, no silhouette", 0.0 => plane(89.0, 0.0);
        "ball of 100 px, foreshortening 0", "trace -2/R, to 1e-4", 1e-4 => ball(100.0, 0.0, 0.1);
        // Central differences lose a sixth of the third derivative of the depth, 3 x / (z^5 R^2) in radii: at n_z = z = 0.7
        // and x = 0.71 that turns the normal by 0.006 degrees, a little more in perspective.
        "normals of a ball's depth", "exact normals, in degrees", 0.02 => Ok(of_depth()?[0]);
        "curvature of a ball's depth", "that of its exact normals", 0.01 => Ok(of_depth()?[1]);
        // Truncation is (1/R)^2 times a fourth derivative that grows as n_z^-4: 2 / (100^2 0.6^4).
        "ball of 100 px, foreshortening 1, n_z > 0.6", "trace of the height field", 1.55e-3 => ball(100.0, 1.0, 0.6);
        "the same, n_z > 0.15", "trace of the height field, to 1 %", 1e-2 => ball(100.0, 1.0, 0.15),
            missed: "central differences of a slope that grows as 1 / n_z^3";
        "cylinder of 100 px", "curvatures 0 and -1/R", 1e-3
            => principal_curvatures(Surface::cylinder(100.0, DVec3::Y), [0.0, -0.01]);
        // (2 pi / 80)^2 / 3: a wave of 80 px by central differences.
        "waves of 80 px, turned", "second derivatives", 4e-3
            => height_field(&at(Surface::sine_relief(6.0, 80.0, 0.7)), 0.1);
        "saddle", "second derivatives", 1e-3 => height_field(&at(Surface::saddle(0.006, -0.003, 0.4)), 0.5);
        // The same of its tube: 2 / (35^2 0.6^4).
        "torus, n_z > 0.6", "second derivatives", 1.3e-2 => height_field(&torus(), 0.6);
        "ellipsoid in perspective, n_z > 0.8", "second derivatives", 5e-3 => height_field(&ellipsoid(), 0.8);
        "ellipsoid, directions of 95 % of pixels", "of the larger curvature, in degrees", 1.0 => directions();
        // Derivatives by differences over two pixels and three rows: 1 - k^2/6 - k^2/3 of a wave's, k = 2 pi / 64.
        "waves of 64 px, 50 explicit steps", "decay of a wave", 4.9e-3 => waves(Scale::Iterations(50), Explicit, 10.0);
        "waves of 64 px, sigma 6", "decay of a wave", 4.9e-3 => waves(Scale::Sigma(6.0), Chebyshev, 18.0);
        "waves of 64 px, sigma 20", "decay of a wave", 2e-2 => waves(Scale::Sigma(20.0), Chebyshev, 200.0);
        "50 steps and their expansion, at barriers", "the same slopes, to the tolerance", 1e-4 => steps_and_chebyshev();
        "sigma 200 at barriers", "slopes stay in their range", 1e-4 => overshoot(200.0);
        "ball before a wall, 300 units", "all of its outline is silhouette", 0.0
            => unmarked(&before_wall(40.0, 300.0), 200, silhouette);
        "ball before a wall, 30,000 units", "all of its outline is silhouette", 0.0
            => unmarked(&before_wall(40.0, 30_000.0), 200, silhouette);
        "ball that all but touches a wall", "all of its outline is silhouette", 0.0
            => unmarked(&before_wall(-59.5, 300.0), 200, silhouette),
            missed: "a gap below 1.5 px is within the noise of rendered depth";
        "two balls, one before the other", "all of the border is silhouette", 0.0 => unmarked(&two_balls(), 256, silhouette);
        "waves, seen from above", "no silhouette", 0.0 => no_silhouette();
        "edges of a cube", "all are creases", 0.0 => unmarked(&corner(true), 256, crease);
        "edges of a room", "all are creases", 0.0 => unmarked(&corner(false), 256, crease);
        "mirrored picture", "the same curvature, bit for bit", 0.0 => mirrored();
        "transposed picture", "the same curvature, bit for bit", 0.0 => turned_over();
        "twice the picture, with a reference height", "the same curvature", 1e-3 => reference_height();
        "waves, height of their normals", "the height, but for a constant", 1e-2 => height();
        "NaN normals, every seventh", "left out of the surface, all else numbers", 0.0 => holes();
        "no surface at all", "nothing but zeros", 0.0 => not_numbers(|_, _| [0.0; 3], 0);
        "random normals, the far side too", "all numbers", 0.0
            => not_numbers(|x, y| [1, 2, 3].map(|c| 2.0 * noise(x, y, c) - 1.0), 48 * 48);
        "one pixel", "curvature 0", 0.0 => one_pixel();
    }
}
