//! Cartoons of warped light: [LW] figure 10.
//!
//! Top: light warping with more contrast, in natural light and in that of a single lamp. Bottom: the same in few
//! tones. Concavities darken, so that they read as lines.
//!
//! `cargo run --release -p examples --example cartoon -- IN.exr OUT.png [ENVIRONMENT]`

mod common;

use common::{Outcome, light_around, light_from};
use relievo::io::read_environment;
use relievo::params::{Method, RelightParams, SampleCount, ScalingParams, WarpingParams};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [picture, output, environment @ ..] => cartoon(picture, output, environment.first()),
        _ => Err("usage: cartoon IN.exr OUT.png [ENVIRONMENT]".into()),
    })
}

fn cartoon(picture: &str, output: &str, environment: Option<&&str>) -> Outcome<()> {
    let frame = common::load(picture, None)?;
    let natural = light_around(match environment {
        Some(path) => read_environment(Path::new(path))?,
        None => common::room::room(256),
    });
    let minimal = light_from(120.0, 40.0);
    let mut cells = Vec::new();
    for tones in [None, Some(3)] {
        for light in [&natural, &minimal] {
            let params = exaggerated(tones);
            cells.push(common::relit(
                &frame,
                light,
                params,
                ScalingParams::default(),
            )?);
        }
    }
    common::write(output, &common::grid(&cells, 2))?;
    Ok(())
}

/// Strong warping and contrast; many samples, as tones show every step between them.
fn exaggerated(toon_levels: Option<u32>) -> RelightParams {
    RelightParams {
        method: Method::Warp,
        warping: WarpingParams {
            warp: 6.0,
            contrast: -0.7,
        },
        toon_levels,
        toon_softness: 0.1,
        samples: SampleCount::Fixed(500),
        ..RelightParams::default()
    }
}
