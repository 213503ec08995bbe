//! Lines along edges that the device found.

use super::drawing::{assert_drawn, pen};
use super::{covered_where, on_gpu, with_color};
use glam::{DVec2, DVec3};
use relievo::frame::{Frame, Mask, Plane, Vector3Planes};
use relievo::params::StrokeScale;
use relievo::plan::Tone;
use relievo::scenes::{ExactScene, Surface};

/// A wall, square to the view axis.
fn wall(width: usize, height: usize) -> Frame {
    let scene = ExactScene::orthographic(Surface::plane(DVec3::Z), 80.0, 60.0);
    with_color(scene.frame(width, height))
}

/// Coverage of pixels by a disc, from the distance between its border and their centres.
fn disc(width: usize, height: usize) -> Plane {
    let middle = DVec2::new(0.48 * width as f64, 0.53 * height as f64);
    Plane::from_fn(width, height, |x, y| {
        let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let inside = 0.4 * height as f64 - at.distance(middle);
        (0.5 + inside).clamp(0.0, 1.0) as f32
    })
}

/// Frames whose edges come from every kind of evidence.
fn edged() -> Vec<(&'static str, Frame)> {
    let balls = ExactScene::two_balls(30.0, 38.0, 82.2, 70.4);
    let far = with_color(balls.frame(165, 141));
    let near = with_color(balls.in_perspective().frame(165, 141));
    let block = with_color(ExactScene::box_corner(true, 0.3, 80.3, 62.9).frame(163, 129));
    let disc = disc(150, 131);
    let steps = |[low, high]: [f32; 2]| disc.map(|share| low + share * (high - low));

    let mut spread = wall(150, 131);
    let distance = Surface::DISTANCE as f32;
    spread.depth = Some(steps([1.25 * distance, distance]));
    let mut occluded = wall(150, 131);
    occluded.depth = None;
    occluded.occlusion = Some(steps([0.9, 0.2]));
    let mut unmapped = wall(150, 131);
    unmapped.depth = None;
    unmapped.mask = Mask::new(disc.map(|share| share >= 0.5));

    // A step of 80 between two columns, of which normals that lean by 20 to 1 explain 20, or the opposite.
    let leaning = |scene: ExactScene| {
        let mut frame = with_color(scene.frame(150, 120));
        let depth = |x: usize| Surface::DISTANCE as f32 - if x < 70 { 0.0 } else { 80.0 };
        frame.depth = Some(Plane::from_fn(150, 120, |x, _| depth(x)));
        frame.normal = Vector3Planes::from_fn(150, 120, |x, y| match (x, y < 60) {
            (69 | 70, true) => DVec3::new(1.0, 0.0, 0.05).normalize(),
            (69 | 70, false) => DVec3::new(-1.0, 0.0, 0.05).normalize(),
            _ => DVec3::Z,
        });
        frame
    };
    let plain = || ExactScene::orthographic(Surface::plane(DVec3::Z), 80.0, 60.0);
    let mut beside = leaning(plain());
    beside.mask = Mask::new(Plane::from_fn(150, 120, |x, _| x < 72));

    let with_holes = |frame| covered_where(frame, |x, y| !(x % 40 < 6 && y % 30 < 4), f32::NAN);
    let mut rim = unmapped.clone();
    rim.alpha = Some(disc);
    vec![
        ("holes of no depth", with_holes(&near)),
        ("holes of no depth, far", with_holes(&far)),
        ("perspective", near),
        ("orthographic", far),
        ("creases", block),
        ("leaning, perspective", leaning(plain().in_perspective())),
        ("leaning, orthographic", leaning(plain())),
        ("beside the border", beside),
        ("spread by a filter", spread),
        ("occlusion map", occluded),
        ("border alone", unmapped),
        ("alpha at the rim", rim),
    ]
}

#[test]
fn lines_along_edges_of_the_device() {
    on_gpu(|runner| {
        for (name, frame) in edged() {
            let mut line = pen();
            line.strokes.scale = StrokeScale::Factor(1.0);
            let [_, contours] = assert_drawn(name, runner, &frame, line, Tone::Picture);
            assert!(contours > 100.0, "{name}: {contours}");
        }
    });
}
