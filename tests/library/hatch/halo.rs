//! Halos: paper left bare behind a rim in front, and nowhere on the surface that has the rim.

use super::*;
use std::collections::HashSet;

/// The tone that strokes are to have, with a halo of this factor; levels are given, so that nothing else differs.
pub(super) fn asked(frame: &Frame, halo: f32) -> Plane {
    asked_before(frame, halo, Background::Plain)
}

/// The same, with the background drawn in this way.
pub(super) fn asked_before(frame: &Frame, halo: f32, background: Background) -> Plane {
    let mut line = straight(LineParams::default());
    (line.contours, line.interior) = (None, None);
    (line.tone.halo, line.tone.background) = (halo, background);
    cpu::drawn(frame, Tone::Shape(None), line).asked.unwrap()
}

/// The pixels whose tone a halo of this factor changes, and all that it leaves bare.
fn changed(frame: &Frame, halo: f32) -> (HashSet<(usize, usize)>, Plane) {
    let [without, with] = [0.0, halo].map(|halo| asked(frame, halo));
    let pixels = places(with.width(), with.height());
    let differs = pixels.filter(|&(x, y)| with.at(x, y) != without.at(x, y));
    (differs.collect(), with)
}

/// Without the picture that would give a tone of its own.
pub(super) fn bare(frame: Frame) -> Frame {
    Frame {
        color: None,
        albedo: None,
        ..frame
    }
}

#[test]
fn a_surface_alone_bares_none_of_its_own_pixels() {
    let ball = ExactScene::orthographic(Surface::ball(160.0), 200.0, 200.0);
    // From a ninth of its radius to ten ninths: depth .1 to 1 of the whole.
    let near = bare(ball.at_distance(160.0 * (1.0 + 1.0 / 9.0)).frame(400, 400));
    let plane = |degrees: f64| {
        let turned = degrees.to_radians();
        let normal = DVec3::new(turned.sin(), 0.0, turned.cos());
        let scene = ExactScene::orthographic(Surface::plane(normal), 100.0, 100.0);
        bare(scene.at_distance(8000.0).frame(200, 200))
    };
    // A floor seen in perspective, up to its horizon in row 40: z = h f / (y - 40).
    let floor = {
        let (width, height, camera_height, focal) = (200, 200, 1.6, 240.0);
        let below = |y: usize| y as f64 + 0.5 - 40.0;
        let depth = |_, y| (camera_height * focal / below(y).max(0.5)) as f32;
        let [fx, fy, cx, cy] = [focal, focal, 100.0, 40.0];
        let up = Vector3Planes::from_fn(width, height, |_, _| DVec3::Y);
        let mask = Mask::new(Plane::from_fn(width, height, |_, y| y >= 40));
        Frame {
            depth: Some(Plane::from_fn(width, height, depth)),
            camera: Some(Camera {
                view_from_world: DAffine3::IDENTITY,
                projection: Projection::Perspective { fx, fy, cx, cy },
            }),
            ..Frame::of_normals(up, mask)
        }
    };
    for (name, frame) in [
        ("ball", near),
        ("plane at 60 degrees", plane(60.0)),
        ("plane at 87 degrees", plane(87.0)),
        ("floor", floor),
    ] {
        for halo in [1.0, 4.0] {
            let (pixels, _) = changed(&frame, halo);
            assert!(pixels.is_empty(), "{name}, {halo}: {}", pixels.len());
        }
    }
}

#[test]
fn a_ball_before_a_wall_has_a_whole_ring_of_one_width_around_it() {
    // Of factor 14 the halo is 14 / 350 of 200 pixels wide.
    let (size, halo, width) = (200, 14.0, 8);
    // Walls turned by so much, so far behind the ball that all of them is.
    let before_wall = |degrees: f64, far: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let wall = Surface::plane(DVec3::new(0.6 * sin, -0.8 * sin, cos));
        let mut scene = ExactScene::orthographic(Surface::ball(60.0), 100.3, 99.4);
        scene.surfaces.push(wall.moved(DVec3::new(0.0, 0.0, -far)));
        scene
    };
    let seen_from = |distance: f64, scene: ExactScene| scene.at_distance(distance).in_perspective();
    for (name, scene) in [
        ("level", before_wall(0.0, 300.0)),
        ("at 60 degrees", before_wall(60.0, 600.0)),
        ("at 87 degrees", before_wall(87.0, 3500.0)),
        ("near", seen_from(400.0, before_wall(0.0, 300.0))),
        (
            "near at 60 degrees",
            seen_from(500.0, before_wall(60.0, 600.0)),
        ),
    ] {
        let (changed, with) = changed(&bare(scene.frame(size, size)), halo);
        let is_ball = |x, y| scene.exact(x, y).is_some_and(|seen| seen.surface == 0);
        let ball = Plane::from_fn(size, size, is_ball);
        for (x, y) in places(size, size) {
            let case = format!("{name}: {x}, {y}");
            if ball.at(x, y) {
                assert!(!changed.contains(&(x, y)), "{case} is the ball's own");
                continue;
            }
            let around = |i: usize| i.saturating_sub(width + 1)..(i + width + 2).min(size);
            let nearest = around(y)
                .flat_map(|v| around(x).map(move |u| [u, v]))
                .filter(|&[u, v]| ball.at(u, v))
                .map(|[u, v]| f64::hypot(u as f64 - x as f64, v as f64 - y as f64))
                .fold(f64::INFINITY, f64::min);
            if nearest <= width as f64 {
                assert!(with.at(x, y) == 0.0, "{case} has ink");
            } else if nearest > width as f64 + 0.5 {
                assert!(!changed.contains(&(x, y)), "{case} is beyond the ring");
            }
        }
    }
}
