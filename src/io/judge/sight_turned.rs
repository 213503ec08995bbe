//! Whether normals are turned to their sight lines, as V-Ray writes them, judged by how well surfaces hang together.
//!
//! A surface seen at `P = D (u, v, -1)` has `d ln D / du = n_x / (n . e)`, with `e = (-u, -v, 1)` toward the eye, and the
//! same for v and n_y; either sign of the normal will do. These slopes have no curl where the normals are those of a
//! surface: a wall seen at an angle has one normal, but a different one to each sight line.

use super::surface::SurfaceSamples;
use crate::frame::normals::from_sight_line;
use crate::frame::{Camera, NormalSpace, Projection};
use crate::io::inputs::Flip;
use crate::io::normal_space::NormalReading;
use glam::{DVec2, DVec3};

/// Pixels that are looked at, about.
const WANTED: usize = 20_000;
/// Cosine between neighbouring normals below which there is an edge between them.
const SMOOTH: f64 = 0.95;
/// Cosine to the sight line, of a surface too steep to count.
const GRAZING: f64 = 0.1;
/// A misfit up to the first counts as that of surfaces, if it is less than this share of the other.
const HANGS_TOGETHER: (f64, f64) = (0.25, 0.5);

/// How V-Ray writes normals.
pub(crate) const BY_SIGHT: NormalReading = NormalReading {
    space: NormalSpace::Sight,
    flip: Flip {
        x: true,
        ..Flip::NONE
    },
};

/// Whether surfaces hang together much better with `stored` normals turned to the sight lines, [`BY_SIGHT`], than as
/// `reading` reads them; with both misfits.
pub(crate) fn shows(
    surface: &SurfaceSamples,
    camera: &Camera,
    stored: impl Fn(usize, usize) -> DVec3,
    reading: NormalReading,
) -> Option<[f64; 2]> {
    if matches!(camera.projection, Projection::Orthographic { .. }) {
        return None;
    }
    let misfit = |NormalReading { space, flip }| {
        misfit(surface, &camera.projection, |x, y| {
            let n = flip.of(stored(x, y));
            match space {
                NormalSpace::View => n,
                NormalSpace::World => camera.view_from_world.matrix3 * n,
                NormalSpace::Sight => from_sight_line(n, eye(surface, &camera.projection, x, y)),
            }
        })
    };
    let (by_sight, other) = (misfit(BY_SIGHT)?, misfit(reading)?);
    let (most, share) = HANGS_TOGETHER;
    (by_sight < most && by_sight < share * other).then_some([by_sight, other])
}

/// The direction to the eye, scaled to z = 1.
fn eye(surface: &SurfaceSamples, projection: &Projection, x: usize, y: usize) -> DVec2 {
    let place = surface.data_window.middle(x, y);
    projection.to_eye(place.x, place.y)
}

/// The curl of the slopes of `normal`, as a share of all their changes; `None` where they don't change.
fn misfit(
    surface: &SurfaceSamples,
    projection: &Projection,
    normal: impl Fn(usize, usize) -> DVec3,
) -> Option<f64> {
    let mask = surface.mask;
    let (mut curl, mut all) = (0.0, 0.0);
    for (x, y) in mask.sample(WANTED) {
        if y == 0 || x + 1 == mask.width() || !mask.at(x + 1, y) || !mask.at(x, y - 1) {
            continue;
        }
        let places = [(x, y), (x + 1, y), (x, y - 1)];
        let [n, right, up] = places.map(|(x, y)| normal(x, y));
        if n.dot(right).min(n.dot(up)) < SMOOTH {
            continue;
        }
        let eyes = places.map(|(x, y)| eye(surface, projection, x, y));
        let facing = |n: DVec3, eye: DVec2| n.dot(eye.extend(1.0));
        let [here, right, up] = [(n, eyes[0]), (right, eyes[1]), (up, eyes[2])].map(|(n, eye)| {
            let facing = facing(n, eye);
            (facing.abs() > GRAZING).then(|| n.truncate() / facing)
        });
        let (Some(here), Some(right), Some(up)) = (here, right, up) else {
            continue;
        };
        let across = (right - here) / (eyes[1].x - eyes[0].x).abs();
        let along = (up - here) / (eyes[2].y - eyes[0].y).abs();
        curl += (along.x - across.y).abs();
        all += across.abs().element_sum() + along.abs().element_sum();
    }
    (all > 0.0).then(|| curl / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes, Window};
    use glam::{DAffine3, DQuat};

    /// Two walls beside a roof, seen at 53 degrees across, as they are and as V-Ray writes them, the second from behind.
    #[test]
    fn walls_that_bend_as_sight_lines_do_are_turned_back() {
        let window = Window::from_size(64, 64);
        let mask = Mask::full(64, 64);
        let (fx, fy, cx, cy) = (64.0, 64.0, 32.0, 32.0);
        let camera = Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::Perspective { fx, fy, cx, cy },
        };
        let surface = SurfaceSamples {
            mask: &mask,
            position: None,
            depth: None,
            attributes: None,
            data_window: window,
            display_window: window,
            pixel_aspect: 1.0,
        };
        let seen = |x: usize, y: usize| match (x < 32, y < 20) {
            (_, true) => DVec3::new(0.1, -0.8, 0.6),
            (true, _) => DVec3::new(0.6, 0.0, 0.8),
            _ => DVec3::new(-0.5, 0.2, 0.7).normalize(),
        };
        let eye = |x, y| eye(&surface, &camera.projection, x, y);
        let stored = Vector3Planes::from_fn(64, 64, |x, y| {
            let toward = eye(x, y).extend(1.0).normalize();
            let turned = DQuat::from_rotation_arc(toward, DVec3::Z) * seen(x, y).normalize();
            let side = if x < 32 { 1.0 } else { -1.0 };
            side * DVec3::new(-1.0, 1.0, 1.0) * turned
        });
        let plain = NormalReading {
            space: NormalSpace::View,
            ..BY_SIGHT
        };
        let [by_sight, other] =
            shows(&surface, &camera, |x, y| stored.at(x, y), plain).expect("turned");
        // What is left is that changes across and along are those half a pixel apart: 0.0017. As they are read it is 0.074.
        assert!(by_sight < 2e-3 && other > 0.05, "{by_sight} {other}");
        for (x, y) in [(3, 3), (10, 50), (60, 60)] {
            let found = from_sight_line(BY_SIGHT.flip.of(stored.at(x, y)), eye(x, y));
            let off = found - seen(x, y).normalize();
            // 3e-7 is the rounding of a unit vector to floats, times some operations.
            assert!(off.length() < 1e-6, "{found}");
        }
        // Where they are those of view space, they stay.
        let own = |x, y| BY_SIGHT.flip.of(seen(x, y).normalize());
        assert_eq!(shows(&surface, &camera, own, plain), None);
    }
}
