//! Latency of a change: from one parameter to pixels for a display, for a frame whose shape is cached.
//!
//! `cargo run --release -p examples --example live -- render.exr` prints the median and the longest of a few dozen changes.

mod common;

use common::light_from;
use relievo::engine::{Engine, Request, Run, Session};
use relievo::frame::Frame;
use relievo::io::inputs::{Inputs, LightInputs};
use relievo::io::picture::{Picture, ViewTransform, pixels};
use relievo::io::{self, Needs};
use relievo::params::{Params, Scale};
use std::time::Instant;

/// Number of changes of each kind.
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
    println!(
        "{} x {}, {} covered, {} threads",
        frame.data_window.width(),
        frame.data_window.height(),
        frame.mask.count(),
        rayon::current_num_threads()
    );
    let has_picture = frame.color.is_some();
    let mut live = Session::new(Engine::cpu(), frame);
    timed(&mut live, "a light", |live, i| {
        let light = light_from(90.0 + i as f32, 40.0);
        let request = Request::relight(Params::default(), &light);
        live.run(&request, &Run::new()).map(|_| ())
    })?;
    timed(&mut live, "the scale, in light", |live, i| {
        let mut params = Params::default();
        params.shape.scale = Scale::Iterations(10 + i);
        let light = light_from(90.0, 40.0);
        live.run(&Request::relight(params, &light), &Run::new())
            .map(|_| ())
    })?;
    if has_picture {
        timed(&mut live, "radiance scaling", |live, i| {
            let mut params = Params::default();
            params.scaling.scaling = 0.5 + 0.05 * i as f32;
            live.run(&Request::enhance(params), &Run::new()).map(|_| ())
        })?;
    }
    Ok(())
}

/// Makes `change` again and again, and pixels of each.
fn timed(
    live: &mut Session<Frame>,
    what: &str,
    change: impl Fn(&mut Session<Frame>, u32) -> relievo::Result<()>,
) -> relievo::Result<()> {
    change(live, CHANGES)?;
    let counts = live.counts().clone();
    let mut seconds = Vec::new();
    for i in 0..CHANGES {
        let start = Instant::now();
        change(live, i)?;
        let color = live.outcome().color.as_ref().expect("a picture was made");
        let shown = pixels(&Picture {
            alpha: live.held().alpha.as_ref(),
            ..Picture::of(color, ViewTransform::Srgb)
        });
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
