//! Sequences: strokes that move with the surface.

mod cards;
mod conventions;
mod distortion;
mod dots;
mod measured;
mod rendered;
mod wheel;

use crate::common::cpu;
use relievo::engine::{Drawing, PlanInputs, SequenceInputs, TextureCoordinates};
use relievo::frame::{
    ColorPlanes, Frame, LightLayers, Mask, Plane, Source, Vector2Planes, Vector3Planes, Window,
};
use relievo::io::Needs;
use relievo::params::{
    Adaptive, Fallback, FieldParams, LineParams, ScalingParams, ShapeParams, StrokeDirections,
    StrokeScale,
};
use relievo::plan::{Available, Goal, Plan, Tone};

/// The needs of a frame whose strokes move with the surface.
fn moving() -> Needs {
    Needs {
        color: true,
        projection: true,
        motion: true,
        ..Needs::default()
    }
}

/// A frame of cards that face the viewer, of one tone, at the distances `depth(x, y)`.
fn cards(window: Window, tone: f32, depth: impl Fn(usize, usize) -> Option<f32>) -> Frame {
    let (width, height) = (window.width(), window.height());
    let seen = Plane::from_fn(width, height, depth);
    let flat = |value| Plane::filled(width, height, value);
    Frame {
        data_window: window,
        display_window: window,
        pixel_aspect: 1.0,
        mask: Mask::new(seen.map(|depth| depth.is_some())),
        normal: Vector3Planes {
            x: flat(0.0),
            y: flat(0.0),
            z: flat(1.0),
        },
        normal_length: None,
        confidence: None,
        depth: Some(seen.map(|depth| depth.unwrap_or(0.0))),
        occlusion: None,
        importance: None,
        strength: None,
        objects: None,
        stroke_fallback: None,
        color: Some(ColorPlanes {
            r: flat(tone),
            g: flat(tone),
            b: flat(tone),
        }),
        albedo: None,
        alpha: None,
        light: LightLayers::default(),
        camera: None,
        wraps: [false; 2],
        source: Source::default(),
    }
}

/// Motion by pixel, x right, y up, from how far it has come in pixel columns and rows, rows down.
fn motion(frame: &Frame, come: impl Fn(f64, f64) -> [f64; 2]) -> Vector2Planes {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let at = |x: usize, y: usize| come(x as f64 + 0.5, y as f64 + 0.5);
    Vector2Planes {
        x: Plane::from_fn(width, height, |x, y| at(x, y)[0] as f32),
        y: Plane::from_fn(width, height, |x, y| -at(x, y)[1] as f32),
    }
}

/// Strokes at `degrees` wherever curvature does not lead; tone is luminance itself.
fn ruled(degrees: f32) -> LineParams {
    let mut line = LineParams {
        directions: StrokeDirections::Max,
        field: FieldParams {
            fallback: Fallback::Angle(degrees),
            ..FieldParams::default()
        },
        contours: None,
        ..LineParams::default()
    };
    line.tone.white_point = Adaptive::Fixed(1.0);
    line.tone.gamma = 1.0;
    line.strokes.scale = StrokeScale::Factor(1.0);
    line
}

fn plan(frame: &Frame, line: LineParams) -> Plan {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let available = Available::in_frame(frame);
    Plan::new(Goal::Hatch(Tone::Picture, line), available, shape, scaling).unwrap()
}

fn draw(frame: &Frame, line: LineParams, sequence: Option<SequenceInputs>) -> Drawing {
    let inputs = PlanInputs {
        sequence,
        ..PlanInputs::default()
    };
    let outcome = cpu::execute(&plan(frame, line), frame, inputs).unwrap();
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

fn coordinates(drawing: &Drawing) -> &TextureCoordinates {
    drawing
        .coordinates
        .as_ref()
        .expect("a sequence has coordinates")
}

/// Mean over the pixels of `part`.
fn mean(plane: &Plane, part: impl Fn(usize, usize) -> bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..plane.height() {
        for x in (0..plane.width()).filter(|&x| part(x, y)) {
            sum += f64::from(plane.at(x, y));
            count += 1;
        }
    }
    sum / f64::from(count.max(1))
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

fn everywhere(_: usize, _: usize) -> bool {
    true
}
