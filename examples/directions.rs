//! The directions that strokes follow, made visible: noise smeared along them.
//!
//! `cargo run --release -p examples --example directions -- [max|min|layer] IN.exr OUT.png [NORMALS]`
//!
//! `max` and `min` are the fields of the larger and the lesser curvature, made calm; `layer` is the
//! direction layer, pixel by pixel.

mod common;

use common::Outcome;
use relievo::engine::{Engine, PlanInputs, Run};
use relievo::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use relievo::io::{Needs, inputs::Inputs, load, picture::ViewTransform};
use relievo::params::{LineParams, ScalingParams, ShapeParams, StrokeDirections};
use relievo::plan::{Available, Goal, Plan};
use std::process::ExitCode;

/// Pixels that a streak reaches to either side.
const REACH: usize = 12;

fn main() -> ExitCode {
    common::run(|arguments| {
        let (which, files) = match arguments {
            ["layer", files @ ..] => (None, files),
            ["min", files @ ..] => (Some(StrokeDirections::Min), files),
            ["max", files @ ..] | files => (Some(StrokeDirections::Max), files),
        };
        match files {
            [picture, output, normal @ ..] => show(which, picture, output, normal.first()),
            _ => Err("usage: directions [max|min|layer] IN.exr OUT.png [NORMALS]".into()),
        }
    })
}

fn show(
    which: Option<StrokeDirections>,
    picture: &str,
    output: &str,
    normal: Option<&&str>,
) -> Outcome<()> {
    let inputs = Inputs {
        picture: picture.into(),
        normal: normal.map(|name| (*name).into()),
        ..Inputs::default()
    };
    let needs = Needs {
        projection: true,
        ..Needs::default()
    };
    let frame = load(&inputs, needs)?.frame;
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::new(Goal::LAYERS, Available::in_frame(&frame), shape, scaling)?;
    let (engine, inputs) = (Engine::cpu(), PlanInputs::default());
    let shape = engine.execute(&plan, &frame, inputs, &Run::new())?.shape;
    let directions = match which {
        None => shape.direction,
        Some(directions) => {
            let line = LineParams {
                directions,
                ..LineParams::default()
            };
            let mut fields = engine.stroke_fields(&plan, &frame, inputs, &line)?;
            fields.pop()
        }
    };
    let directions = directions.ok_or("no directions were made")?;
    let open = shape.conductance.ok_or("no conductance was made")?;
    let streaks = ColorPlanes::grey(streaks(&frame, &directions, &open));
    common::write_as(output, &streaks, ViewTransform::None)?;
    Ok(())
}

/// Noise averaged along the directions, darker toward the rim; edges black, background white.
fn streaks(frame: &Frame, directions: &Vector2Planes, open: &Plane) -> Plane {
    let (width, height) = (open.width(), open.height());
    Plane::from_fn(width, height, |x, y| {
        if !frame.mask.at(x, y) {
            return 1.0;
        }
        let (mut sum, mut count) = (noise(x, y), 1.0);
        for side in [1.0, -1.0] {
            let (mut px, mut py) = (x as f32 + 0.5, y as f32 + 0.5);
            let mut ahead = (side, 0.0);
            for step in 0..REACH {
                let (x, y) = (px as usize, py as usize);
                let (tx, ty) = (directions.x.at(x, y), directions.y.at(x, y));
                // Equal to its opposite, so continue in the direction of the last step. Rows run down.
                let forward = match step {
                    0 => side,
                    _ => (tx * ahead.0 + ty * ahead.1).signum(),
                };
                ahead = (forward * tx, forward * ty);
                (px, py) = (px + ahead.0, py - ahead.1);
                let inside = px >= 0.0 && py >= 0.0 && px < width as f32 && py < height as f32;
                if !inside || open.at(px as usize, py as usize) == 0.0 {
                    break;
                }
                sum += noise(px as usize, py as usize);
                count += 1.0;
            }
        }
        let contrast = (0.5 + 2.5 * (sum / count - 0.5)).clamp(0.0, 1.0);
        let light = 0.35 + 0.65 * frame.normal.z.at(x, y).clamp(0.0, 1.0);
        contrast * light * open.at(x, y)
    })
}

/// A value in 0..1 that only the place decides.
fn noise(x: usize, y: usize) -> f32 {
    let mut bits = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    (bits ^ (bits >> 15)) as f32 / u32::MAX as f32
}
