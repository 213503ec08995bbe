//! A rendered sequence of the collection, whose motion layer and cameras are known.

use super::*;
use crate::common::files;
use relievo::io::camera::read_camera;
use std::path::Path;

fn loaded(directory: &Path, number: i32) -> Loaded {
    let file = |end| directory.join(format!("monkeyrun.{number:04}.{end}"));
    files::load(file("exr"), |inputs, needs| {
        inputs.camera = Some(file("json"));
        *needs = moving();
    })
}

#[test]
fn motion_is_read_as_blender_writes_it() {
    let Some(directory) = real("renders/seq") else {
        return;
    };
    for number in [2, 7, 12] {
        let mut now = loaded(&directory, number);
        // Depth of half floats is good to 5e-4 of itself: of ten pixels of parallax that is nothing.
        now.frame.source.depth_kind = DepthKind::Planar;
        let before = directory.join(format!("monkeyrun.{:04}.json", number - 1));
        let before = read_camera(&before, now.frame.display_window, 1.0).unwrap();
        let expected = static_world_motion(&now.frame, &before).unwrap();
        let found = now.motion.unwrap().by_name().unwrap();
        // The ground does not move; it fills the lowest rows, except for objects standing on it.
        let off = places(640, 50).map(|(x, y)| {
            let off = [(&found.x, &expected.x), (&found.y, &expected.y)];
            let [dx, dy] = off.map(|(a, b)| f64::from(a.at(x, y + 310) - b.at(x, y + 310)));
            dx.hypot(dy)
        });
        let off = sorted(off);
        let [median, most] = [0.5, 0.95].map(|share| quantile(&off, share));
        let case = format!("frame {number}: {median}, {most} px off");
        assert!(median < 0.05 && most < 0.3, "{case}");
        let length = expected.x.at(320, 350);
        assert!(length.abs() > 1.0, "the camera moves: {length}");
    }
}

/// A frame, and what is drawn of it.
struct Drawn {
    frame: Frame,
    still: Plane,
    carried: Drawing,
    lines: Plane,
}

/// A card of one tone facing the viewer, with the outline and depth of `frame`.
fn even(frame: &Frame, tone: f32) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let frame = Frame {
        normal: normals(width, height, |_, _| Vec3::Z),
        normal_length: None,
        alpha: None,
        ..frame.clone()
    };
    grey(frame, tone)
}

/// Mean absolute differences of ink from each drawing, moved along with the surface, to the next, over the pixels seen in both:
/// of strokes fixed in the picture, of strokes that move with the surface, of those of a card of one tone and direction, so that
/// moving a drawing is all that its difference comes from, and of lines along edges and inside surfaces without strokes.
fn differences(frames: impl Iterator<Item = Loaded>) -> [f64; 4] {
    let mut line = default_but(|line: &mut LineParams| {
        (line.contours, line.interior) = (None, None);
        line.strokes.scale = StrokeScale::Factor(1.0);
    });
    let mut alone = default_but(|alone: &mut LineParams| {
        (alone.lines_only, alone.strokes) = (true, line.strokes);
    });
    let mut scaling = ScalingParams::default();
    let mut before: Option<Drawn> = None;
    let (mut sums, mut count) = ([0.0; 4], 0.0);
    for Loaded { frame, motion, .. } in frames {
        let motion = motion.and_then(|layers| layers.by_name()).unwrap();
        // Levels are those of the first frame.
        let outcome = drawn(&frame, (Tone::Enhanced, scaling), line, true, None);
        let still = outcome.drawing.unwrap();
        line.tone.white_point = Adaptive::Fixed(still.white_point);
        scaling.curvature_gain = Adaptive::Fixed(outcome.gain.unwrap());
        scaling.white_level = Adaptive::Fixed(outcome.white_level.unwrap());
        let sequence = SequenceInputs {
            before: before
                .as_ref()
                .and_then(|before| before.carried.coordinates.as_ref()),
            motion: Some(&motion),
        };
        let carried = drawn(
            &frame,
            (Tone::Enhanced, scaling),
            line,
            true,
            Some(sequence),
        );
        let carried = carried.drawing.unwrap();
        let outcome = drawn(&frame, (Tone::Picture, scaling), alone, true, None);
        let levels = outcome.line_levels.map(LineLevels::Given);
        alone.interior.as_mut().unwrap().levels = levels.unwrap();
        let lines = outcome.drawing.unwrap();
        let [edges, interior] = [lines.contours.unwrap(), lines.interior.unwrap()];
        let both = |x, y| 1.0 - (1.0 - edges.at(x, y)) * (1.0 - interior.at(x, y));
        let lines = Plane::from_fn(frame.mask.width(), frame.mask.height(), both);
        let now = Drawn {
            frame,
            still: still.hatching,
            carried,
            lines,
        };
        if let Some(then) = &before {
            let coordinates = then.carried.coordinates.as_ref().unwrap();
            let seen = coordinates.seen_before(&now.frame, &motion);
            let tone = 1.0 - mean(&now.carried.hatching, |x, y| now.frame.mask.at(x, y));
            let [card, moved] = [&then.frame, &now.frame].map(|frame| even(frame, tone as f32));
            let card = first(&card, ruled(45.0));
            let moved = next(&card, &moved, &motion, ruled(45.0));
            let (there, here) = (then.frame.data_window, now.frame.data_window);
            let [right, down] = [here.x0 - there.x0, here.y0 - there.y0].map(f64::from);
            let pairs = [
                (&then.still, &now.still),
                (&then.carried.hatching, &now.carried.hatching),
                (&card.hatching, &moved.hatching),
                (&then.lines, &now.lines),
            ];
            for (sum, (then, now)) in sums.iter_mut().zip(pairs) {
                let off = covered(&seen).map(|(x, y)| {
                    let [dx, dy] = [&motion.x, &motion.y].map(|plane| f64::from(plane.at(x, y)));
                    let then = between(then, x as f64 + right - dx, y as f64 + down + dy);
                    (f64::from(now.at(x, y)) - then).abs()
                });
                *sum += off.sum::<f64>() / seen.count().max(1) as f64;
            }
            count += 1.0;
        }
        before = Some(now);
    }
    sums.map(|sum| sum / count)
}

#[test]
fn strokes_that_move_with_the_surface_swim_less() {
    let Some(directory) = real("renders/seq") else {
        return;
    };
    let found = differences((1..=5).map(|number| loaded(&directory, number)));
    let [still, carried, floor, lines] = found;
    assert!(floor < carried && carried < 0.7 * still, "{found:?}");
    // Lines alone cover less paper than strokes, and follow the surface.
    assert!(lines > 0.0 && lines < carried, "{found:?}");
}
