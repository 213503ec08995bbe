//! The directions that strokes follow, made visible: noise smeared along them.
//!
//! `cargo run --release -p examples --example directions -- [max|min|layer] IN.exr OUT.png [NORMALS]`
//!
//! `max` and `min` are the fields of the larger and the lesser curvature, made calm; `layer` is the
//! direction layer, pixel by pixel.

use relievo::engine::{self, Engine, Run};
use relievo::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use relievo::io::{self, Needs, inputs::Inputs};
use relievo::params::{LineParams, ScalingParams, ShapeParams, StrokeDirections};
use relievo::plan::{Available, Goal, Plan};
use std::path::PathBuf;

/// Pixels that a streak reaches to either side.
const REACH: usize = 12;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from).peekable();
    let named = arguments.next_if(|a| {
        ["max", "min", "layer"]
            .iter()
            .any(|name| a.as_os_str() == *name)
    });
    let which = match named.as_deref().and_then(|name| name.to_str()) {
        Some("layer") => None,
        Some("min") => Some(StrokeDirections::Min),
        _ => Some(StrokeDirections::Max),
    };
    let (Some(picture), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: directions [max|min|layer] IN.exr OUT.png [NORMALS]".into());
    };
    let normal = arguments.next().map(|name| name.display().to_string());
    let inputs = Inputs {
        picture,
        normal,
        ..Inputs::default()
    };
    let needs = Needs {
        color: false,
        projection: true,
        ..Needs::default()
    };
    let frame = io::load(&inputs, needs)?.frame;
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::new(Goal::LAYERS, Available::in_frame(&frame), shape, scaling)?;
    let (engine, inputs) = (Engine::cpu(), engine::PlanInputs::default());
    let shape = engine.execute(&plan, &frame, inputs, &Run::new())?.shape;
    let line = which.map(|directions| LineParams {
        directions,
        ..LineParams::default()
    });
    let fields = line.map(|line| engine.stroke_fields(&plan, &frame, inputs, &line));
    let fields = fields.transpose()?;
    let directions = fields
        .and_then(|mut fields| fields.pop())
        .or(shape.direction);
    let directions = directions.ok_or("no directions were made")?;
    let open = shape.conductance.ok_or("no conductance was made")?;
    let streaks = streaks(&frame, &directions, &open);
    let color = ColorPlanes {
        r: streaks.clone(),
        g: streaks.clone(),
        b: streaks,
    };
    let picture = Picture::of(&color, ViewTransform::None);
    write_atomically(&output, Replace::IfWritable, |w| {
        write_picture(w, &output, PictureFormat::Png, &picture)
    })?;
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
