//! Shared by the examples: reading a frame, setting pictures side by side, writing them.

#![allow(dead_code, reason = "each example uses its part")]

pub(crate) mod room;

use relievo::engine::{Engine, Request, Run};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
use relievo::io::{self, Needs, inputs::Inputs, srgb};
use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
use relievo::params::{Params, RelightParams, ScalingParams, ShapeParams};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

/// Linear grey behind frames without a background.
const BACKDROP: f32 = 0.06;

/// An error as one line, and the exit code.
pub(crate) fn exit(result: Result<(), Box<dyn Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The frame of a render, or of a photo and its normal map.
pub(crate) fn load(picture: &str, normal: Option<&str>) -> relievo::Result<Frame> {
    let inputs = Inputs {
        picture: picture.into(),
        normal: normal.map(Into::into),
        ..Inputs::default()
    };
    let needs = Needs {
        color: true,
        albedo: true,
        projection: false,
        ..Needs::default()
    };
    Ok(io::load(&inputs, needs)?.frame)
}

/// A white light of 1 from this azimuth and elevation, in degrees.
pub(crate) fn light_from(azimuth: f32, elevation: f32) -> Illumination {
    Illumination {
        directional: vec![DirectionalLight {
            to_light: direction_of(azimuth, elevation),
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    }
}

/// The frame in new light, over the backdrop.
pub(crate) fn relit(
    frame: &Frame,
    light: &Illumination,
    relight: RelightParams,
    scaling: ScalingParams,
) -> relievo::Result<ColorPlanes> {
    let request = Request::relight(
        Params {
            relight,
            ..Params::of(ShapeParams::default(), scaling)
        },
        light,
    );
    let outcome = Engine::cpu().run(&request, frame, &Run::new())?;
    let color = outcome.color.expect("light makes a picture");
    Ok(over_backdrop(&color, frame))
}

/// A premultiplied picture over the backdrop.
pub(crate) fn over_backdrop(color: &ColorPlanes, frame: &Frame) -> ColorPlanes {
    let alpha = |x, y| frame.alpha.as_ref().map_or(1.0, |a| a.at(x, y));
    let over = |plane: &Plane| {
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            plane.at(x, y) + (1.0 - alpha(x, y)) * BACKDROP
        })
    };
    ColorPlanes {
        r: over(&color.r),
        g: over(&color.g),
        b: over(&color.b),
    }
}

/// Pictures of one size in rows of `columns`.
pub(crate) fn grid(pictures: &[ColorPlanes], columns: usize) -> ColorPlanes {
    let (width, height) = (pictures[0].r.width(), pictures[0].r.height());
    let rows = pictures.len().div_ceil(columns);
    let whole = |channel: fn(&ColorPlanes) -> &Plane| {
        Plane::from_fn(width * columns, height * rows, |x, y| {
            let picture = pictures.get(x / width + columns * (y / height));
            picture.map_or(0.0, |picture| channel(picture).at(x % width, y % height))
        })
    };
    ColorPlanes {
        r: whole(|c| &c.r),
        g: whole(|c| &c.g),
        b: whole(|c| &c.b),
    }
}

/// Writes a picture in the format of its name.
pub(crate) fn write(path: &str, color: &ColorPlanes) -> relievo::Result<()> {
    let path = Path::new(path);
    let format = PictureFormat::of_path(path).unwrap_or(PictureFormat::Png);
    let picture = Picture::of(color, ViewTransform::Srgb);
    write_atomically(path, Replace::IfWritable, |w| {
        write_picture(w, path, format, &picture)
    })
}

/// Red, green and blue, sRGB-encoded in 8 bits.
pub(crate) fn codes(color: &ColorPlanes) -> Vec<u8> {
    let code = |v: f32| (srgb::encoded(f64::from(v).clamp(0.0, 1.0)) * 255.0).round() as u8;
    let channels = [&color.r, &color.g, &color.b].map(|plane| plane.samples());
    let pixels = 0..channels[0].len();
    pixels
        .flat_map(|i| channels.map(|channel| code(channel[i])))
        .collect()
}
