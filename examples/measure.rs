//! Error against run time of the shape stages, on a surface whose curvature is known.
//!
//! `cargo run --release --example measure -- [WIDTH HEIGHT [REPEATS]]`
//!
//! The surface is `h = a cos(kx) cos(ky)`, seen orthographically: its gradient's divergence after N
//! diffusion steps is `-2 a k^2 cos(kx) cos(ky)` times the decay of that wave, which is known too.

use relievo::backend::cpu::Outcome;
use relievo::frame::{ColorPlanes, Frame, Mask, Plane};
use relievo::params::{Scale, ScalingParams, ShapeParams, Solver};
use relievo::plan::{Available, Goal, Plan};
use relievo::report::scenes::{HEIGHT, Scene, WAVE};
use relievo::report::timing::{Effort, Timed, Times, measure};
use std::time::Duration;

/// The stages from normals and depth to curvature.
const SHAPE: [&str; 3] = ["edges-and-gradient", "diffusion", "trace"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<usize> = std::env::args()
        .skip(1)
        .map(|a| a.parse())
        .collect::<Result<_, _>>()?;
    let (width, height, repeats) = match numbers[..] {
        [] => (1920, 1080, 7),
        [width, height] => (width, height, 7),
        [width, height, repeats] if repeats > 0 => (width, height, repeats),
        _ => return Err("usage: measure [WIDTH HEIGHT [REPEATS]]".into()),
    };
    let frame = waves(width, height);
    println!(
        "{width}x{height}, {} threads, {repeats} runs\n",
        rayon::current_num_threads()
    );
    println!(
        "| steps | solver | mean error | largest error | stage | min ms | median ms | Mpix/s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let runs = [
        (0, Solver::Explicit),
        (10, Solver::Explicit),
        (50, Solver::Explicit),
        (50, Solver::Chebyshev),
        (200, Solver::Explicit),
        (200, Solver::Chebyshev),
    ];
    for (steps, solver) in runs {
        let shape = ShapeParams {
            scale: Scale::Iterations(steps),
            solver,
            foreshortening: 1.0,
            ..ShapeParams::default()
        };
        let (outcome, timed) = run(&frame, shape, repeats)?;
        let (mean, largest) = errors(&outcome, &shape, steps);
        let label = format!("{steps} | {solver:?} | {mean:.1e} | {largest:.1e}");
        print_stages(&label, &timed, width * height);
    }
    // A tenth of the frame shows a surface: what is empty costs next to nothing.
    let shape = ShapeParams {
        scale: Scale::Iterations(50),
        foreshortening: 1.0,
        ..ShapeParams::default()
    };
    let (_, timed) = run(&covered_in_part(frame, 0.1), shape, repeats)?;
    let label = "50, 10 % covered | Chebyshev | | ";
    print_stages(label, &timed, width * height);
    Ok(())
}

fn run(
    frame: &Frame,
    shape: ShapeParams,
    repeats: usize,
) -> Result<(Outcome, Timed), relievo::Error> {
    let available = Available::in_frame(frame);
    let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default())?;
    let effort = Effort {
        runs: repeats,
        limit: Duration::MAX,
    };
    Ok(measure(&plan, frame, effort))
}

/// The frame with a disc in its middle covered that takes `share` of it.
fn covered_in_part(frame: Frame, share: f64) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let radius = (share * (width * height) as f64 / std::f64::consts::PI).sqrt();
    let (x0, y0) = (0.5 * width as f64, 0.5 * height as f64);
    let inside = |x: usize, y: usize| (x as f64 - x0).hypot(y as f64 - y0) < radius;
    Frame {
        mask: Mask::new(Plane::from_fn(width, height, inside)),
        ..frame
    }
}

/// The waves of the report, with a picture to be enhanced.
fn waves(width: usize, height: usize) -> Frame {
    let grey = Plane::from_fn(width, height, |x, y| 0.2 + 0.1 * ((x ^ y) & 7) as f32 / 7.0);
    Frame {
        color: Some(ColorPlanes {
            r: grey.clone(),
            g: grey.clone(),
            b: grey,
        }),
        ..Scene::waves(width, height).frame
    }
}

/// Mean and largest error of the trace, relative to its largest value, a wave away from the border.
fn errors(outcome: &Outcome, shape: &ShapeParams, steps: u32) -> (f64, f64) {
    let trace = outcome
        .shape
        .trace
        .as_ref()
        .expect("enhancing needs the trace");
    // Each step multiplies a product of waves by 1 - 4 dt (1 - cos k).
    let step = 1.0 - 4.0 * f64::from(shape.time_step) * (1.0 - WAVE.cos());
    let peak = 2.0 * HEIGHT * WAVE * WAVE;
    let decayed = peak * step.powi(steps as i32);
    let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for y in 64..trace.height().saturating_sub(64) {
        for x in 64..trace.width().saturating_sub(64) {
            let [cx, cy] = [x, y].map(|i| (WAVE * (i as f64 + 0.5)).cos());
            let error = (f64::from(trace.at(x, y)) + decayed * cx * cy).abs() / peak;
            sum += error;
            largest = largest.max(error);
            count += 1;
        }
    }
    (sum / f64::from(count.max(1)), largest)
}

fn print_stages(label: &str, timed: &Timed, pixels: usize) {
    let row = |stage: &str, times: Times| {
        println!(
            "| {label} | {stage} | {:.2} | {:.2} | {:.1} |",
            1e3 * times.min,
            1e3 * times.median,
            times.megapixels_per_second(pixels)
        );
    };
    for (stage, times) in &timed.stages {
        row(stage, *times);
    }
    let of_shape = |time: fn(&Times) -> f64| -> f64 {
        let stages = timed
            .stages
            .iter()
            .filter(|(stage, _)| SHAPE.contains(stage));
        stages.map(|(_, times)| time(times)).sum()
    };
    let (min, median) = (of_shape(|t| t.min), of_shape(|t| t.median));
    row(
        "shape",
        Times {
            min,
            median,
            ..timed.whole
        },
    );
    row("all", timed.whole);
}
