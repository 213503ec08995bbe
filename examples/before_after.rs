//! Before, after, and the curvature that made the difference: the picture at the top of the README.
//!
//! `cargo run --release -p examples --example before_after -- IN.exr OUT.png`

use relievo::engine::{Engine, Request, Run};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use relievo::io::{self, Needs, inputs::Inputs, srgb};
use relievo::params::{Params, ScalingParams, ShapeParams};
use std::path::PathBuf;

/// Linear grey behind the pictures: on white a pale stone loses its edge.
const BACKDROP: f32 = 0.06;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut paths = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(picture), Some(output)) = (paths.next(), paths.next()) else {
        return Err("usage: before_after IN.exr OUT.png".into());
    };
    let frame = io::load(
        &Inputs {
            picture,
            ..Inputs::default()
        },
        Needs {
            color: true,
            projection: false,
            ..Needs::default()
        },
    )?
    .frame;
    let made = |request: &Request| -> Result<ColorPlanes, Box<dyn std::error::Error>> {
        let outcome = Engine::cpu().run(request, &frame, &Run::new())?;
        outcome.color.ok_or_else(|| "no picture was made".into())
    };
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let before = frame.color.clone().ok_or("the input has no picture")?;
    let after = made(&Request::enhance(Params::of(shape, scaling)))?;
    let curvature = linear(&made(&Request::display(Params::of(shape, scaling)))?);
    let strip = beside(&[
        over_backdrop(&before, &frame),
        over_backdrop(&after, &frame),
        curvature,
    ]);
    let picture = Picture::of(&strip, ViewTransform::Srgb);
    write_atomically(&output, Replace::IfWritable, |w| {
        write_picture(w, &output, PictureFormat::Png, &picture)
    })?;
    Ok(())
}

fn each(color: &ColorPlanes, f: impl Fn(&Plane) -> Plane) -> ColorPlanes {
    ColorPlanes {
        r: f(&color.r),
        g: f(&color.g),
        b: f(&color.b),
    }
}

/// A premultiplied picture over the backdrop.
fn over_backdrop(color: &ColorPlanes, frame: &Frame) -> ColorPlanes {
    let alpha = |x, y| frame.alpha.as_ref().map_or(1.0, |a| a.at(x, y));
    each(color, |plane| {
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            plane.at(x, y) + (1.0 - alpha(x, y)) * BACKDROP
        })
    })
}

/// The display is sRGB-encoded already; the strip is encoded as a whole.
fn linear(display: &ColorPlanes) -> ColorPlanes {
    let decoded = |v: f32| srgb::decoded(f64::from(v)) as f32;
    each(display, |plane| plane.map(decoded))
}

/// Pictures of one size side by side.
fn beside(pictures: &[ColorPlanes]) -> ColorPlanes {
    let (width, height) = (pictures[0].r.width(), pictures[0].r.height());
    let strip = |channel: fn(&ColorPlanes) -> &Plane| {
        Plane::from_fn(width * pictures.len(), height, |x, y| {
            channel(&pictures[x / width]).at(x % width, y)
        })
    };
    ColorPlanes {
        r: strip(|c| &c.r),
        g: strip(|c| &c.g),
        b: strip(|c| &c.b),
    }
}
