//! Normal-ray principal directions against surfaces whose curvatures are known exactly.

mod common;

use common::scenes::{Exact, Scene, Surface};
use common::{mirrored, mirrored_plane, quarter_turned, quarter_turned_plane};
use glam::{DMat3, DQuat, DVec2, DVec3};
use relievo::backend::cpu;
use relievo::frame::{Frame, Plane, Projection, Vector2Planes};
use relievo::params::{Adaptive, Scale, ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, Plan};

/// The direction layer of `frame`, and conductance.
fn directions(frame: &Frame, step: Adaptive) -> (Vector2Planes, Plane) {
    let shape = ShapeParams {
        scale: Scale::Iterations(0),
        direction_step: step,
        ..ShapeParams::default()
    };
    let available = Available::in_frame(frame);
    let plan = Plan::new(Goal::Layers, available, shape, ScalingParams::default()).unwrap();
    let shape = cpu::run(&plan, frame).shape;
    (shape.direction.unwrap(), shape.conductance.unwrap())
}

/// The exact direction, in the picture, of the curvature larger in size; `None` where the two differ by
/// less than a twentieth of their sum.
fn expected(exact: &Exact, projection: Projection) -> Option<DVec2> {
    let c = exact.object_curvatures;
    let (larger, along) = if c.k_u.abs() > c.k_v.abs() {
        (c.k_u, c.u)
    } else {
        (c.k_v, c.v)
    };
    let clear = (c.k_u.abs() - c.k_v.abs()).abs() > 0.05 * (c.k_u.abs() + c.k_v.abs());
    if larger == 0.0 || !clear {
        return None;
    }
    // A small step along the tangent, seen in the picture: the projection's derivative to nine digits.
    let step = 1e-5 * exact.depth;
    let ahead = projection.pixel_of(exact.point + step * along)?;
    let behind = projection.pixel_of(exact.point - step * along)?;
    let seen = ahead - behind;
    Some(DVec2::new(seen.x, -seen.y).normalize())
}

/// Sorted angles in degrees between found and expected directions, over open pixels whose normal faces
/// the viewer with more than 0.35, as measured against the sight line.
fn errors_deg(scene: &Scene, frame: &Frame, step: Adaptive) -> Vec<f64> {
    let (found, conductance) = directions(frame, step);
    let mut errors = Vec::new();
    for y in 0..frame.mask.height() {
        for x in 0..frame.mask.width() {
            let t = DVec2::new(found.x.at(x, y).into(), found.y.at(x, y).into());
            assert!(t.is_finite(), "({x}, {y}): {t}");
            let unit = (t.length() - 1.0).abs() < 1e-6;
            assert!(unit == frame.mask.at(x, y), "({x}, {y}): {t}");
            let Some(exact) = scene.exact(x, y).filter(|_| conductance.at(x, y) > 0.0) else {
                continue;
            };
            let line = scene.projection.to_eye(x as f64 + 0.5, y as f64 + 0.5);
            let facing = exact.normal.dot(line.extend(1.0).normalize());
            if facing < 0.35 {
                continue;
            }
            if let Some(e) = expected(&exact, scene.projection) {
                errors.push(t.perp_dot(e).abs().asin().to_degrees());
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Scenes of about `radius` pixels, orthographic, off the pixel grid.
fn scenes(radius: f64) -> Vec<(&'static str, Scene)> {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    let c = side(radius) as f64 / 2.0;
    let at = |surface| far(Scene::orthographic(surface, c + 0.3, c - 0.4), radius);
    let axes = DVec3::new(1.0, 0.7, 0.5) * radius;
    vec![
        ("ellipsoid", at(Surface::ellipsoid(axes, DMat3::IDENTITY))),
        ("turned ellipsoid", at(Surface::ellipsoid(axes, turn))),
        (
            "torus",
            at(Surface::torus(
                0.7 * radius,
                0.3 * radius,
                DVec3::new(0.3, 0.5, 0.8),
            )),
        ),
        (
            "upright cylinder",
            at(Surface::cylinder(0.8 * radius, DVec3::Y)),
        ),
        (
            "tilted cylinder",
            at(Surface::cylinder(0.7 * radius, DVec3::new(0.6, 0.5, 0.45))),
        ),
        (
            "saddle",
            at(Surface::saddle(0.7 / radius, -0.4 / radius, 0.4)),
        ),
    ]
}

/// The scene moved back so that a radius of 256 px still lies well before the eye.
fn far(scene: Scene, radius: f64) -> Scene {
    let by = DVec3::new(0.0, 0.0, common::scenes::DISTANCE - 3.0 * radius);
    Scene {
        surfaces: scene.surfaces.iter().map(|s| s.moved(by)).collect(),
        ..scene
    }
}

/// In perspective, from three radii away, a pixel being as large as before.
fn deep(scene: Scene, radius: f64) -> Scene {
    let Projection::Orthographic { cx, cy, .. } = scene.projection else {
        panic!("already in perspective");
    };
    let focal = 3.0 * radius;
    Scene {
        projection: Projection::Perspective {
            fx: focal,
            fy: focal,
            cx,
            cy,
        },
        ..scene
    }
}

fn side(radius: f64) -> usize {
    (2.2 * radius) as usize
}

fn framed(scene: &Scene, radius: f64) -> Frame {
    scene.frame(side(radius), side(radius))
}

fn without_depth(frame: &Frame) -> Frame {
    Frame {
        depth: None,
        ..frame.clone()
    }
}

#[test]
fn table() {
    for radius in [32.0, 64.0, 128.0, 256.0] {
        for (name, flat) in scenes(radius) {
            let perspective = deep(flat.clone(), radius);
            for (view, scene) in [("orthographic", flat), ("perspective", perspective)] {
                if view == "perspective" && name == "saddle" {
                    continue;
                }
                let frame = framed(&scene, radius);
                let from_normals = without_depth(&frame);
                let no_camera = Frame {
                    camera: None,
                    ..frame.clone()
                };
                let row: Vec<String> = [&frame, &from_normals, &no_camera]
                    .map(|frame| {
                        let errors = errors_deg(&scene, frame, Adaptive::Auto);
                        format!(
                            "{:.5}/{:.5}/{:.3}",
                            quantile(&errors, 0.5),
                            quantile(&errors, 0.95),
                            quantile(&errors, 1.0)
                        )
                    })
                    .into();
                println!("{radius:4} {name:17} {view:13} {}", row.join("  "));
            }
        }
    }
}
