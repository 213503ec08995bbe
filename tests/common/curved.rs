//! Curved surfaces, and the directions of their curvatures as the picture shows them.

use glam::{DMat3, DQuat, DVec2, DVec3};
use relievo::frame::Projection;
use relievo::scenes::{Exact, ExactScene, Surface};

/// Half axes of 1, 0.7 and 0.5 radii, turned.
pub fn ellipsoid(radius: f64) -> Surface {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    Surface::ellipsoid(DVec3::new(1.0, 0.7, 0.5) * radius, turn)
}

pub fn torus(radius: f64) -> Surface {
    Surface::torus(0.7 * radius, 0.3 * radius, DVec3::new(0.3, 0.5, 0.8))
}

/// A surface off the pixel grid in the middle of a square, seen in parallel from three radii away.
pub fn in_the_middle(surface: Surface, radius: f64, side: usize) -> ExactScene {
    let middle = side as f64 / 2.0;
    let scene = ExactScene::orthographic(surface, middle + 0.3, middle - 0.4);
    scene.at_distance(3.0 * radius)
}

/// In perspective, from three radii away, with pixels of the same size as before.
pub fn deep(scene: &ExactScene, radius: f64) -> ExactScene {
    let Projection::Orthographic { cx, cy, .. } = scene.projection else {
        panic!("already in perspective");
    };
    let (fx, fy) = (3.0 * radius, 3.0 * radius);
    ExactScene {
        projection: Projection::Perspective { fx, fy, cx, cy },
        ..scene.clone()
    }
}

/// A tangent as the picture shows it, from a small step along it: the projection's derivative to nine digits.
pub fn seen_along(exact: &Exact, tangent: DVec3, projection: Projection) -> Option<DVec2> {
    let step = 1e-5 * exact.depth;
    let [ahead, behind] = [step, -step].map(|s| projection.pixel_of(exact.point + s * tangent));
    let seen = ahead? - behind?;
    Some(DVec2::new(seen.x, -seen.y).normalize())
}

/// The directions, in the picture, of the curvatures larger and lesser in size; `None` where they differ by less than this share
/// of their sum.
pub fn curved_along(exact: &Exact, projection: Projection, clearly: f64) -> Option<[DVec2; 2]> {
    let c = exact.object_curvatures;
    let (u, v) = (c.k_u.abs(), c.k_v.abs());
    let [larger, lesser] = if u > v { [c.u, c.v] } else { [c.v, c.u] };
    let is_clear = (u - v).abs() > clearly * (u + v);
    let seen = |tangent| seen_along(exact, tangent, projection);
    is_clear.then_some([seen(larger)?, seen(lesser)?])
}

/// Cosine of the angle between the surface's normal and the sight line.
pub fn facing(scene: &ExactScene, exact: &Exact, x: usize, y: usize) -> f64 {
    let line = scene.projection.to_eye(x as f64 + 0.5, y as f64 + 0.5);
    exact.normal.dot(line.extend(1.0).normalize())
}

/// A scene of every kind around a place of the picture, some 110 pixels large times `scale`: in parallel, then in perspective.
pub fn every_scene(scale: f64, cx: f64, cy: f64) -> Vec<(&'static str, ExactScene)> {
    let px = |length: f64| scale * length;
    let at = |surface| ExactScene::orthographic(surface, cx, cy);
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 0.3)));
    let axes = DVec3::new(120.0, 70.0, 90.0) * scale;
    let leaning = DVec3::new(0.6, 0.5, 0.45);
    #[rustfmt::skip]
    let flat = vec![
        ("plane", at(Surface::plane(DVec3::new(0.5, -0.3, 0.8)))),
        ("ball", at(Surface::ball(px(110.0)))),
        ("ellipsoid", at(Surface::ellipsoid(axes, turn))),
        ("torus", at(Surface::torus(px(80.0), px(35.0), DVec3::new(0.3, 0.5, 0.8)))),
        ("upright cylinder", at(Surface::cylinder(px(100.0), DVec3::Y))),
        ("tilted cylinder", at(Surface::cylinder(px(80.0), leaning))),
        ("box corner", ExactScene::box_corner(true, 0.3, cx, cy)),
        ("room corner", ExactScene::box_corner(false, 0.3, cx, cy)),
        ("two balls", ExactScene::two_balls(px(55.0), px(80.0), cx, cy)),
        ("sine relief", at(Surface::sine_relief(px(6.0), px(80.0), 0.7))),
    ];
    let saddle = (
        "saddle",
        at(Surface::saddle(0.006 / scale, -0.003 / scale, 0.4)),
    );
    let in_perspective = |(name, scene): &(_, ExactScene)| (*name, scene.clone().in_perspective());
    let deep: Vec<_> = flat.iter().map(in_perspective).collect();
    flat.into_iter().chain([saddle]).chain(deep).collect()
}
