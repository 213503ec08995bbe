//! Error against run time of the shape stages, on a surface whose curvature is known.
//!
//! `cargo run --release --example measure -- [WIDTH HEIGHT [REPEATS]]`
//!
//! The surface is `h = a sin(kx) sin(ky)`, seen orthographically: its gradient's divergence after N
//! diffusion steps is `-2 a k^2 sin(kx) sin(ky)` times the decay of that wave, which is known too.

use relievo::backend::cpu::{self, Outcome};
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, Source, Vector3Planes, Window};
use relievo::params::{Scale, ScalingParams, ShapeParams, Solver};
use relievo::plan::{Available, Goal, Plan};
use std::time::Duration;

/// Wave number per pixel: waves of 64 pixels, whose peaks and troughs lie on the borders' mirrors.
const K: f64 = 2.0 * std::f64::consts::PI / 64.0;
/// Height of the waves in pixels: slopes up to 1/2.
const A: f64 = 5.0;

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
        let available = Available::in_frame(&frame);
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default())?;
        let runs: Vec<Outcome> = (0..=repeats).map(|_| cpu::run(&plan, &frame)).collect();
        let (mean, largest) = errors(&runs[0], &shape, steps);
        let label = format!("{steps} | {solver:?} | {mean:.1e} | {largest:.1e}");
        print_stages(&label, &runs[1..], width * height);
    }
    Ok(())
}

fn waves(width: usize, height: usize) -> Frame {
    let normal = |axis: usize| {
        Plane::from_fn(width, height, move |x, y| {
            let (sx, cx) = (K * (x as f64 + 0.5)).sin_cos();
            // y points up, rows run down.
            let (sy, cy) = (-K * (y as f64 + 0.5)).sin_cos();
            let n = glam::DVec3::new(-A * K * cx * sy, -A * K * sx * cy, 1.0).normalize();
            n[axis] as f32
        })
    };
    let grey = Plane::from_fn(width, height, |x, y| 0.2 + 0.1 * ((x ^ y) & 7) as f32 / 7.0);
    Frame {
        data_window: Window::from_size(width, height),
        display_window: Window::from_size(width, height),
        pixel_aspect: 1.0,
        mask: Mask::full(width, height),
        normal: Vector3Planes {
            x: normal(0),
            y: normal(1),
            z: normal(2),
        },
        normal_length: None,
        depth: Some(Plane::filled(width, height, 10.0)),
        occlusion: None,
        importance: None,
        color: Some(ColorPlanes {
            r: grey.clone(),
            g: grey.clone(),
            b: grey,
        }),
        alpha: None,
        camera: None,
        source: Source::default(),
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
    let step = 1.0 - 4.0 * f64::from(shape.time_step) * (1.0 - K.cos());
    let peak = 2.0 * A * K * K;
    let decayed = peak * step.powi(steps as i32);
    let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for y in 64..trace.height().saturating_sub(64) {
        for x in 64..trace.width().saturating_sub(64) {
            let (sx, sy) = ((K * (x as f64 + 0.5)).sin(), (-K * (y as f64 + 0.5)).sin());
            let error = (f64::from(trace.at(x, y)) + decayed * sx * sy).abs() / peak;
            sum += error;
            largest = largest.max(error);
            count += 1;
        }
    }
    (sum / f64::from(count.max(1)), largest)
}

fn print_stages(label: &str, runs: &[Outcome], pixels: usize) {
    let row = |stage: &str, mut times: Vec<Duration>| {
        times.sort();
        let (min, median) = (times[0].as_secs_f64(), times[times.len() / 2].as_secs_f64());
        println!(
            "| {label} | {stage} | {:.2} | {:.2} | {:.1} |",
            1e3 * min,
            1e3 * median,
            pixels as f64 / 1e6 / median
        );
    };
    for (i, (stage, _)) in runs[0].timings.iter().enumerate() {
        row(stage, runs.iter().map(|run| run.timings[i].1).collect());
    }
    row(
        "all",
        runs.iter()
            .map(|run| run.timings.iter().map(|(_, t)| *t).sum())
            .collect(),
    );
}
