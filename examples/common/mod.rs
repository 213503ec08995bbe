//! Shared by the examples: reading a frame, setting pictures side by side, writing them.

#![allow(dead_code, reason = "each example uses its part")]

pub(crate) mod room;

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, RgbImage, RgbaImage};
use relievo::engine::{Engine, Request, Run};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::io::output::{Replace, write_atomically};
use relievo::io::picture::{Picture, PictureFormat, ViewTransform, pixels, write_picture};
use relievo::io::{self, Needs, inputs::Inputs};
use relievo::light::environment::Environment;
use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
use relievo::params::{Params, RelightParams, ScalingParams};
use std::error::Error;
use std::fs::File;
use std::path::Path;
use std::process::ExitCode;

/// Linear grey behind frames without a background.
const BACKDROP: f32 = 0.06;

pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;

/// Does the work of the arguments. An error is one line, and the exit code.
pub(crate) fn run(work: impl FnOnce(&[&str]) -> Outcome<()>) -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    exit(work(&arguments))
}

pub(crate) fn exit(result: Outcome<()>) -> ExitCode {
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

/// Light from all around.
pub(crate) fn light_around(environment: Environment) -> Illumination {
    Illumination {
        environment: Some(environment.into()),
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
    let params = Params {
        relight,
        scaling,
        ..Params::default()
    };
    let request = Request::relight(params, light);
    let outcome = Engine::cpu().run(&request, frame, &Run::new())?;
    let color = outcome.color.expect("light makes a picture");
    Ok(over_backdrop(&color, frame))
}

/// The colour of planes that `change` makes of these.
pub(crate) fn each(color: &ColorPlanes, change: impl Fn(&Plane) -> Plane) -> ColorPlanes {
    let [r, g, b] = [&color.r, &color.g, &color.b].map(change);
    ColorPlanes { r, g, b }
}

/// A premultiplied picture over the backdrop.
pub(crate) fn over_backdrop(color: &ColorPlanes, frame: &Frame) -> ColorPlanes {
    let alpha = |x, y| frame.alpha.as_ref().map_or(1.0, |a| a.at(x, y));
    each(color, |plane| {
        Plane::from_fn(plane.width(), plane.height(), |x, y| {
            plane.at(x, y) + (1.0 - alpha(x, y)) * BACKDROP
        })
    })
}

/// Pictures of one size in rows of `columns`.
pub(crate) fn grid(pictures: &[ColorPlanes], columns: usize) -> ColorPlanes {
    let (width, height) = (pictures[0].r.width(), pictures[0].r.height());
    let rows = pictures.len().div_ceil(columns);
    let channels: [fn(&ColorPlanes) -> &Plane; 3] = [|c| &c.r, |c| &c.g, |c| &c.b];
    let [r, g, b] = channels.map(|channel| {
        Plane::from_fn(width * columns, height * rows, |x, y| {
            let picture = pictures.get(x / width + columns * (y / height));
            picture.map_or(0.0, |picture| channel(picture).at(x % width, y % height))
        })
    });
    ColorPlanes { r, g, b }
}

/// Writes a picture of linear light in the format of its name.
pub(crate) fn write(path: &str, color: &ColorPlanes) -> relievo::Result<()> {
    write_as(path, color, ViewTransform::Srgb)
}

pub(crate) fn write_as(
    path: &str,
    color: &ColorPlanes,
    view: ViewTransform,
) -> relievo::Result<()> {
    let path = Path::new(path);
    let format = PictureFormat::of_path(path).unwrap_or(PictureFormat::Png);
    write_atomically(path, Replace::IfWritable, |w| {
        write_picture(w, path, format, &Picture::of(color, view))
    })
}

/// Red, green and blue, sRGB-encoded in 8 bits.
pub(crate) fn rgb(color: &ColorPlanes) -> RgbImage {
    let (width, height) = (color.r.width() as u32, color.r.height() as u32);
    let samples = pixels(&Picture::of(color, ViewTransform::Srgb)).concat();
    let picture = RgbaImage::from_raw(width, height, samples).expect("four to a pixel");
    DynamicImage::from(picture).to_rgb8()
}

/// Whether the name is that of a JPEG file.
pub(crate) fn is_jpeg(path: &Path) -> bool {
    PictureFormat::of_path(path) == Some(PictureFormat::Jpeg)
}

pub(crate) fn write_jpeg(path: &Path, picture: &DynamicImage, quality: u8) -> Outcome<()> {
    let file = File::create(path)?;
    picture.write_with_encoder(JpegEncoder::new_with_quality(file, quality))?;
    Ok(())
}

/// Writes an array of NumPy: the kind of its samples, its shape, and their bytes.
pub(crate) fn write_npy(path: &Path, kind: &str, shape: &[usize], samples: &[u8]) -> Outcome<()> {
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
    // With ten bytes before it, the header ends at a multiple of 64.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = length - 1).bytes());
    bytes.extend(samples);
    Ok(std::fs::write(path, bytes)?)
}
