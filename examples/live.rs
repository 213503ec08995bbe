//! How soon a change is seen: from one parameter to pixels for a display, of a frame whose shape is kept.
//!
//! `cargo run --release --example live -- render.exr` prints the median and the longest of a few dozen changes.

use relievo::engine::cpu::{LiveRunner, Outcome};
use relievo::frame::Frame;
use relievo::io::inputs::{Inputs, LightInputs};
use relievo::io::picture::{Picture, ViewTransform, pixels};
use relievo::io::{self, Needs};
use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
use relievo::params::{RelightParams, Scale, ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, LightKinds, Plan};
use std::time::Instant;

/// Changes that are made of each kind.
const CHANGES: u32 = 30;

fn main() -> relievo::Result<()> {
    let path = std::env::args_os().nth(1);
    let path = path.unwrap_or("fixtures/bust.exr".into());
    let inputs = Inputs {
        picture: path.into(),
        light: Some(LightInputs::default()),
        ..Inputs::default()
    };
    let needs = Needs {
        color_if_any: true,
        ..Needs::default()
    };
    let frame = io::load(&inputs, needs)?.frame;
    let window = frame.data_window;
    println!(
        "{} x {}, {} covered, {} threads",
        window.width(),
        window.height(),
        frame.mask.count(),
        rayon::current_num_threads()
    );
    let available = Available::in_frame(&frame);
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let mut live = LiveRunner::new(frame);

    timed(&mut live, "a light", |live, i| {
        let light = lit_from(90.0 + i as f32);
        let kinds = LightKinds::in_light(&light);
        let plan = Plan::relight(available, shape, scaling, RelightParams::default(), kinds)?;
        live.relight(&plan, &light, None);
        Ok(())
    })?;
    timed(&mut live, "the scale, in light", |live, i| {
        let light = lit_from(90.0);
        let kinds = LightKinds::in_light(&light);
        let scale = Scale::Iterations(10 + i);
        let shape = ShapeParams { scale, ..shape };
        let plan = Plan::relight(available, shape, scaling, RelightParams::default(), kinds)?;
        live.relight(&plan, &light, None);
        Ok(())
    })?;
    if available.color {
        timed(&mut live, "radiance scaling", |live, i| {
            let scaling = ScalingParams {
                scaling: 0.5 + 0.05 * i as f32,
                ..scaling
            };
            live.run(&Plan::new(Goal::Enhance, available, shape, scaling)?);
            Ok(())
        })?;
    }
    Ok(())
}

fn lit_from(azimuth: f32) -> Illumination {
    Illumination {
        directional: vec![DirectionalLight {
            to_light: direction_of(azimuth, 40.0),
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    }
}

/// Makes `change` again and again, and pixels of each.
fn timed(
    live: &mut LiveRunner<Frame>,
    what: &str,
    change: impl Fn(&mut LiveRunner<Frame>, u32) -> relievo::Result<()>,
) -> relievo::Result<()> {
    change(live, CHANGES)?;
    let counts = live.counts().clone();
    let mut seconds = Vec::new();
    for i in 0..CHANGES {
        let start = Instant::now();
        change(live, i)?;
        let shown = shown(live.outcome(), live.held());
        seconds.push(start.elapsed().as_secs_f64());
        assert!(!shown.is_empty());
    }
    seconds.sort_by(f64::total_cmp);
    let ran = live.counts().iter();
    let ran = ran.filter(|(name, count)| counts.get(*name) != Some(count));
    let ran: Vec<_> = ran.map(|(name, _)| *name).collect();
    let (median, longest) = (seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
    println!(
        "{what}: {:.1} ms, {:.1} at the most ({})",
        1e3 * median,
        1e3 * longest,
        ran.join(", ")
    );
    Ok(())
}

fn shown(outcome: &Outcome, frame: &Frame) -> Vec<[u8; 4]> {
    pixels(&Picture {
        color: outcome.color.as_ref().expect("a picture was made"),
        alpha: frame.alpha.as_ref(),
        grey: false,
        bits: 8,
        transform: ViewTransform::Srgb,
    })
}
