//! Sequences: strokes that move with the surface.

mod cards;
mod conventions;
mod distortion;
mod dots;
mod rendered;
mod wheel;

use crate::prelude::*;
use std::fmt::Display;

/// The needs of a frame whose strokes move with the surface.
fn moving() -> Needs {
    default_but(|needs: &mut Needs| {
        (needs.color, needs.projection, needs.motion) = (true, true, true);
    })
}

/// A frame of cards that face the viewer, of one tone, at the distances `depth(x, y)`.
fn cards([w, h]: [usize; 2], tone: f32, depth: impl Fn(usize, usize) -> Option<f32>) -> Frame {
    let seen = Plane::from_fn(w, h, depth);
    let facing = normals(w, h, |_, _| Vec3::Z);
    let frame = Frame {
        depth: Some(seen.map(|depth| depth.unwrap_or(0.0))),
        ..Frame::of_normals(facing, Mask::new(seen.map(|depth| depth.is_some())))
    };
    grey(frame, tone)
}

/// One card that fills a picture.
fn card(size: [usize; 2]) -> Frame {
    cards(size, 0.5, |_, _| Some(7.0))
}

/// Motion by pixel, x right, y up, from how far it has come in pixel columns and rows, rows down.
fn motion(frame: &Frame, come: impl Fn(f64, f64) -> [f64; 2]) -> Vector2Planes {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let at = |x: usize, y: usize| come(x as f64 + 0.5, y as f64 + 0.5);
    let [x, y] = [0, 1].map(|axis| Plane::from_fn(width, height, |x, y| at(x, y)[axis] as f32));
    Vector2Planes {
        x,
        y: y.map(|down| -down),
    }
}

/// Strokes at `degrees` wherever curvature does not lead; tone is luminance itself.
fn ruled(degrees: f32) -> LineParams {
    default_but(|line: &mut LineParams| {
        line.directions = StrokeDirections::Max;
        line.field.fallback = Fallback::Angle(degrees);
        line.contours = None;
        (line.tone.white_point, line.tone.gamma) = (Adaptive::Fixed(1.0), 1.0);
        line.strokes.scale = StrokeScale::Factor(1.0);
    })
}

/// What is drawn of a frame, alone or of a sequence.
fn drawn(
    frame: &Frame,
    (tone, scaling): (Tone, ScalingParams),
    line: LineParams,
    in_sequence: bool,
    sequence: Option<SequenceInputs>,
) -> Outcome {
    let available = Available {
        moving: in_sequence,
        in_sequence,
        ..Available::in_frame(frame)
    };
    let goal = Goal::Hatch(tone, line);
    let plan = Plan::new(goal, available, ShapeParams::default(), scaling);
    let inputs = PlanInputs {
        sequence,
        ..PlanInputs::default()
    };
    cpu::execute(&plan.unwrap(), frame, inputs).unwrap()
}

fn draw(frame: &Frame, line: LineParams, sequence: Option<SequenceInputs>) -> Drawing {
    let of_picture = (Tone::Picture, ScalingParams::default());
    let outcome = drawn(frame, of_picture, line, sequence.is_some(), sequence);
    outcome.drawing.expect("a drawing was planned")
}

/// The first frame of a sequence.
fn first(frame: &Frame, line: LineParams) -> Drawing {
    draw(frame, line, Some(SequenceInputs::default()))
}

/// The frame after `before`, drawn.
fn next(before: &Drawing, frame: &Frame, motion: &Vector2Planes, line: LineParams) -> Drawing {
    let sequence = SequenceInputs {
        before: before.coordinates.as_ref(),
        motion: Some(motion),
    };
    draw(frame, line, Some(sequence))
}

/// The share of each pixel of one map of coordinates, the oldest first.
fn shares(drawing: &Drawing) -> Vec<f64> {
    let coordinates = drawing.coordinates.as_ref();
    coordinates
        .expect("a sequence has coordinates")
        .mean_shares()
}

/// Mean over the pixels of `part`.
fn mean(plane: &Plane, part: impl Fn(usize, usize) -> bool) -> f64 {
    let all = places(plane.width(), plane.height()).filter(|&(x, y)| part(x, y));
    let sum: f64 = all.clone().map(|(x, y)| f64::from(plane.at(x, y))).sum();
    sum / all.count().max(1) as f64
}

/// Expects a tone of one half, by the ink in the mean.
#[track_caller]
fn is_half_inked(drawing: &Drawing, what: impl Display) {
    near(mean(&drawing.hatching, everywhere), 0.5, 0.02, what);
}

/// Mean absolute difference between `now` and `before` at the previous position `from` of each pixel: whole columns and
/// rows.
fn difference(
    now: &Plane,
    before: &Plane,
    from: impl Fn(usize, usize) -> Option<[usize; 2]>,
) -> f64 {
    let differences = Plane::from_fn(now.width(), now.height(), |x, y| match from(x, y) {
        Some([u, v]) => (now.at(x, y) - before.at(u, v)).abs(),
        None => 0.0,
    });
    mean(&differences, |x, y| from(x, y).is_some())
}

/// Where a card of 60 x 60 is that passes at 4 px a frame.
fn passing(step: usize) -> impl Fn(usize, usize) -> bool + Copy {
    move |x, y| (10 + 4 * step..70 + 4 * step).contains(&x) && (40..100).contains(&y)
}

/// Its motion over what stays.
fn passage(frame: &Frame, step: usize) -> Vector2Planes {
    let front = passing(step);
    motion(frame, |x, y| match front(x as usize, y as usize) {
        true => [4.0, 0.0],
        false => [0.0; 2],
    })
}

fn everywhere(_: usize, _: usize) -> bool {
    true
}
