//! A raking light that circles over a photo, as an animated PNG: a conservator's torch.
//!
//! `cargo run --release -p examples --example turntable -- PHOTO NORMALS OUT.png [FRAMES]`

mod common;

use common::{Outcome, light_from, over_backdrop, rgb};
use relievo::engine::{Engine, Request, Run, Session};
use relievo::frame::Frame;
use relievo::params::{Method, Params};
use std::io::Write;
use std::process::ExitCode;

/// Degrees of the light above the picture.
const ELEVATION: f32 = 20.0;
/// Seconds that the light takes to come round.
const SECONDS: u16 = 4;

fn main() -> ExitCode {
    common::run(|arguments| {
        let [photo, normal, output, frames @ ..] = arguments else {
            return Err("usage: turntable PHOTO NORMALS OUT.png [FRAMES]".into());
        };
        let count = match frames.first().map(|text| text.parse()) {
            None => 36,
            Some(Ok(count @ 1..=3600)) => count,
            Some(_) => return Err("FRAMES: give a whole number from 1 to 3600".into()),
        };
        let mut bytes = Vec::new();
        write_turns(&mut bytes, &common::load(photo, Some(normal))?, count)?;
        Ok(std::fs::write(output, bytes)?)
    })
}

/// One picture per direction of the light. The shape is found once.
fn write_turns(w: impl Write, frame: &Frame, count: u16) -> Outcome<()> {
    let mut params = Params::default();
    params.relight.method = Method::Both;
    let (width, height) = (frame.mask.width() as u32, frame.mask.height() as u32);
    let mut encoder = png::Encoder::new(w, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_animated(count.into(), 0)?;
    encoder.set_frame_delay(SECONDS, count)?;
    let mut writer = encoder.write_header()?;
    let mut session = Session::new(Engine::cpu(), frame);
    for turn in 0..count {
        let light = light_from(360.0 * f32::from(turn) / f32::from(count), ELEVATION);
        let outcome = session.run(&Request::relight(params, &light), &Run::new())?;
        let color = outcome.color.as_ref().expect("light makes a picture");
        writer.write_image_data(&rgb(&over_backdrop(color, frame)))?;
    }
    writer.finish()?;
    Ok(())
}
