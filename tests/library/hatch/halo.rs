//! Halos: paper left bare behind a rim in front, and nowhere on the surface that has the rim.

use super::*;
use glam::{DAffine3, DVec3};
use relievo::frame::{Camera, Mask, Projection, Vector3Planes};
use relievo::params::Background;
use relievo::scenes::Surface;

/// The tone that strokes are to have, with a halo of this factor; levels are given, so that nothing else differs.
pub(super) fn asked(frame: &Frame, halo: f32) -> Plane {
    asked_before(frame, halo, Background::Plain)
}

/// The same, with the background drawn in this way.
pub(super) fn asked_before(frame: &Frame, halo: f32, background: Background) -> Plane {
    let mut line = straight(LineParams {
        contours: None,
        interior: None,
        ..LineParams::default()
    });
    line.tone.halo = halo;
    line.tone.background = background;
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let available = Available::in_frame(frame);
    let plan = Plan::new(
        Goal::Hatch(Tone::Shape(None), line),
        available,
        shape,
        scaling,
    );
    let outcome = Engine::cpu()
        .execute(&plan.unwrap(), frame, Inputs::default(), &Run::new())
        .unwrap();
    outcome.drawing.unwrap().asked.unwrap()
}

/// The pixels whose tone a halo of this factor changes, and all that it leaves bare.
fn changed(frame: &Frame, halo: f32) -> (Vec<[usize; 2]>, Plane) {
    let [without, with] = [0.0, halo].map(|halo| asked(frame, halo));
    let pixels = (0..with.height()).flat_map(|y| (0..with.width()).map(move |x| [x, y]));
    let differs = pixels.filter(|&[x, y]| with.at(x, y) != without.at(x, y));
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
        let depth = Plane::from_fn(width, height, |_, y| {
            (camera_height * focal / below(y).max(0.5)) as f32
        });
        let up = Vector3Planes::from_fn(width, height, |_, _| DVec3::Y);
        let mask = Mask::new(Plane::from_fn(width, height, |_, y| y >= 40));
        Frame {
            depth: Some(depth),
            camera: Some(Camera {
                view_from_world: DAffine3::IDENTITY,
                projection: Projection::Perspective {
                    fx: focal,
                    fy: focal,
                    cx: 100.0,
                    cy: 40.0,
                },
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
fn a_ball_before_a_wall_has_a_whole_ring_around_it() {
    // The wall is two radii behind the ball's rim.
    let scene = ExactScene::orthographic(Surface::ball(60.0), 100.0, 100.0).at_distance(300.0);
    let mut frame = bare(scene.frame(200, 200));
    let on_ball = frame.mask.clone();
    let beside = |plane: &Plane, wall: f32| {
        Plane::from_fn(200, 200, |x, y| match on_ball.at(x, y) {
            true => plane.at(x, y),
            false => wall,
        })
    };
    frame.depth = Some(beside(frame.depth.as_ref().unwrap(), 420.0));
    frame.normal.z = beside(&frame.normal.z, 1.0);
    frame.mask = Mask::full(200, 200);
    // Of factor 4 the halo is 4 / 350 of 200 pixels wide, 2.3: two pixels.
    let (pixels, with) = changed(&frame, 4.0);
    for [x, y] in pixels {
        assert!(!on_ball.at(x, y), "{x}, {y} is the ball's own");
    }
    for step in 0..720 {
        let angle = f64::from(step).to_radians() / 2.0;
        let at = |radius: f64| {
            let place = DVec3::new(angle.cos(), angle.sin(), 0.0) * radius + DVec3::splat(100.0);
            [place.x as usize, place.y as usize]
        };
        let [x, y] = at(61.2);
        assert!(with.at(x, y) == 0.0, "{step}: {x}, {y} has ink");
    }
}
