//! A raking light that circles over a photo, as an animated PNG: a conservator's torch.
//!
//! `cargo run --release -p examples --example turntable -- PHOTO NORMALS OUT.png [FRAMES]`

mod common;

use relievo::engine::{Engine, Request, Run, Session};
use relievo::frame::Frame;
use relievo::params::{Method, Params, RelightParams, ScalingParams, ShapeParams};
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;

/// Degrees of the light above the picture.
const ELEVATION: f32 = 20.0;
/// Seconds that the light takes to come round.
const SECONDS: u16 = 4;

fn main() -> ExitCode {
    common::exit(run())
}

fn run() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [photo, normal, output, frames @ ..] = arguments.as_slice() else {
        return Err("usage: turntable PHOTO NORMALS OUT.png [FRAMES]".into());
    };
    let count = match frames.first().map(|text| text.parse()) {
        None => 36,
        Some(Ok(count @ 1..=3600)) => count,
        Some(_) => return Err("FRAMES: give a whole number from 1 to 3600".into()),
    };
    let frame = common::load(photo, Some(normal))?;
    let mut bytes = Vec::new();
    write_turns(&mut bytes, &frame, count)?;
    std::fs::write(output, bytes)?;
    Ok(())
}

/// One picture per direction of the light. The shape is found once.
fn write_turns(w: impl Write, frame: &Frame, count: u16) -> Result<(), Box<dyn Error>> {
    let params = RelightParams {
        method: Method::Both,
        ..RelightParams::default()
    };
    let (width, height) = (frame.mask.width() as u32, frame.mask.height() as u32);
    let mut encoder = png::Encoder::new(w, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_animated(count.into(), 0)?;
    encoder.set_frame_delay(SECONDS, count)?;
    let mut writer = encoder.write_header()?;
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let mut session = Session::new(Engine::cpu(), frame);
    for turn in 0..count {
        let azimuth = 360.0 * f32::from(turn) / f32::from(count);
        let light = common::light_from(azimuth, ELEVATION);
        let request = Request::relight(
            Params {
                relight: params,
                ..Params::of(shape, scaling)
            },
            &light,
        );
        let outcome = session.run(&request, &Run::new())?;
        let color = outcome.color.as_ref().expect("light makes a picture");
        writer.write_image_data(&common::codes(&common::over_backdrop(color, frame)))?;
    }
    writer.finish()?;
    Ok(())
}
