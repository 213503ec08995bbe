//! Before, after, and the curvature that made the difference: the picture at the top of the README.
//!
//! `cargo run --release -p examples --example before_after -- IN.exr OUT.png`

mod common;

use common::{Outcome, each, grid, load, over_backdrop, write};
use relievo::engine::{Engine, Request, Run};
use relievo::io::srgb;
use relievo::params::Params;
use std::process::ExitCode;

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [picture, output] => strip(picture, output),
        _ => Err("usage: before_after IN.exr OUT.png".into()),
    })
}

fn strip(picture: &str, output: &str) -> Outcome<()> {
    let frame = load(picture, None)?;
    let before = frame.color.as_ref().ok_or("the input has no picture")?;
    let [after, display] = [Request::enhance, Request::display].map(|request| {
        let outcome = Engine::cpu().run(&request(Params::default()), &frame, &Run::new())?;
        Ok::<_, relievo::Error>(outcome.color)
    });
    let after = over_backdrop(&after?.ok_or("no picture was made")?, &frame);
    // The display is sRGB-encoded already; the strip is encoded as a whole.
    let linear =
        |plane: &_| relievo::frame::Plane::map(plane, |v| srgb::decoded(f64::from(v)) as f32);
    let curvature = each(&display?.ok_or("no picture was made")?, linear);
    write(
        output,
        &grid(&[over_backdrop(before, &frame), after, curvature], 3),
    )?;
    Ok(())
}
