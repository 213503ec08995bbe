//! The two parameters of radiance scaling: the parameter grid of [RS] figure 3.
//!
//! Columns: no scaling, then invariant points of 0.5, 0.01 and 0.99. At 0.5 convexities and concavities gain alike;
//! near 0 convexities only brighten; near 1 they only darken, and gradients reverse. Rows: scaling of 1 and of 2. The
//! paper's 10 and 20 are for unscaled curvature per pixel; with the automatic gain 1 is clearly visible and 2 harsh.
//!
//! `cargo run --release -p examples --example scaling_grid -- IN OUT.png [NORMALS]`

mod common;

use common::{Outcome, light_from};
use relievo::params::{Method, RelightParams, ScalingParams};
use std::process::ExitCode;

const INVARIANT_POINTS: [f32; 3] = [0.5, 0.01, 0.99];

fn main() -> ExitCode {
    common::run(|arguments| match arguments {
        [picture, output, normal @ ..] => cells(picture, output, normal.first().copied()),
        _ => Err("usage: scaling_grid IN OUT.png [NORMALS]".into()),
    })
}

fn cells(picture: &str, output: &str, normal: Option<&str>) -> Outcome<()> {
    let frame = common::load(picture, normal)?;
    let light = light_from(120.0, 45.0);
    let relight = RelightParams {
        method: Method::Scale,
        ..RelightParams::default()
    };
    let mut cells = Vec::new();
    for scaling in [1.0, 2.0] {
        let plain = (0.0, ScalingParams::default().invariant_point);
        let scaled = INVARIANT_POINTS.map(|invariant_point| (scaling, invariant_point));
        for (scaling, invariant_point) in std::iter::once(plain).chain(scaled) {
            let params = ScalingParams {
                scaling,
                invariant_point,
                ..ScalingParams::default()
            };
            cells.push(common::relit(&frame, &light, relight, params)?);
        }
    }
    common::write(output, &common::grid(&cells, 1 + INVARIANT_POINTS.len()))?;
    Ok(())
}
