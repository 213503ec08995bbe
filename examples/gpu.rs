//! The GPU beside the CPU on one frame: `cargo run --release -p examples --features gpu --example gpu -- [FRAME.exr] [WIDTH
//! HEIGHT]`.
//!
//! Prints, for each size of features, for new light and for drawings, the difference from the CPU's results and the
//! time of each stage, with the bytes that an ideal pass would move in that time. Without a file, waves of that size,
//! 1920x1080 by default.

mod common;

use common::{light_around, light_from};
use relievo::engine::gpu::{AdapterKind, Device};
use relievo::engine::{Engine, PlanInputs, Run};
use relievo::frame::{ColorPlanes, Frame, Plane};
use relievo::light::lights::Illumination;
use relievo::params::{
    Adaptive, AlbedoSource, LineParams, Material, Method, RelightParams, SampleCount, Scale,
    ScalingParams, ShapeParams, Solver, StrokeDirections, StrokeScale, Style,
};
use relievo::plan::{Available, Goal, Plan, Tone};
use relievo::product::Product;
use relievo::scenes::{Scene, environment};
use std::time::{Duration, Instant};

/// Number of runs; the quickest counts.
const RUNS: usize = 9;

fn main() -> common::Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut frame = match arguments.as_slice() {
        [] => waves(1920, 1080),
        [width, height] => waves(width.parse()?, height.parse()?),
        [path] => common::load(path, None)?,
        _ => return Err("give FRAME.exr, or WIDTH HEIGHT, or nothing".into()),
    };
    let device = Device::open(AdapterKind::Any)?;
    let (width, height) = (frame.mask.width(), frame.mask.height());
    println!("{}, {width}x{height}", device.name());
    let engine = Engine::on(device);
    let available = Available::in_frame(&frame);
    let usual = ScalingParams::default();
    let given = ScalingParams {
        curvature_gain: Adaptive::Fixed(8.0),
        white_level: Adaptive::Fixed(1.0),
        ..usual
    };
    use Solver::{Chebyshev, Explicit};
    for (name, steps, solver, scaling) in [
        (
            "no diffusion, gain and white level given",
            0,
            Chebyshev,
            given,
        ),
        ("no diffusion", 0, Chebyshev, usual),
        ("10 steps", 10, Chebyshev, usual),
        ("50 steps, explicit", 50, Explicit, usual),
        ("50 steps, Chebyshev", 50, Chebyshev, usual),
    ] {
        let shape = ShapeParams {
            solver,
            ..after_steps(steps)
        };
        let plan = Plan::new(Goal::Enhance, available, shape, scaling)?;
        measure(name, &engine, &plan, &frame, None)?;
    }
    let (lamp, room) = (light_from(120.0, 40.0), light_around(environment()));
    for (name, method, light) in [
        ("scaling under a lamp, 10 steps", Method::Scale, &lamp),
        ("warping of 54 lights, 10 steps", Method::Warp, &room),
        ("both, 10 steps", Method::Both, &room),
    ] {
        // A glossy white surface.
        let mut relight = RelightParams {
            method,
            albedo: AlbedoSource::White,
            samples: SampleCount::Fixed(54),
            ..RelightParams::default()
        };
        relight.material.material = Material::BlinnPhong;
        let available = available.lit_by(light);
        let plan = Plan::new(Goal::Relight(relight), available, after_steps(10), usual)?;
        measure(name, &engine, &plan, &frame, Some(light))?;
    }
    if !matches!(arguments.as_slice(), [_]) {
        frame.depth = Some(plates(width, height));
    }
    for (name, style) in [("pen", Style::Pen), ("pencil", Style::Pencil)] {
        let mut line = LineParams {
            directions: StrokeDirections::Max,
            interior: None,
            ..LineParams::default()
        };
        line.strokes.style = style;
        line.strokes.scale = StrokeScale::Factor(1.0);
        let goal = Goal::Hatch(Tone::Picture, line);
        let plan = Plan::new(goal, available, ShapeParams::default(), usual)?;
        let name = format!("hatching with contours, {name}");
        measure(&name, &engine, &plan, &frame, None)?;
    }
    Ok(())
}

fn after_steps(steps: u32) -> ShapeParams {
    ShapeParams {
        scale: Scale::Iterations(steps),
        ..ShapeParams::default()
    }
}

fn measure(
    name: &str,
    engine: &Engine,
    plan: &Plan,
    frame: &Frame,
    light: Option<&Illumination>,
) -> relievo::Result<()> {
    let on_cpu = Engine::cpu();
    let inputs = PlanInputs {
        illumination: light,
        ..PlanInputs::default()
    };
    let by_cpu = || on_cpu.execute(plan, frame, inputs, &Run::new());
    let by_device = || engine.execute(plan, frame, inputs, &Run::new());
    let (found, expected) = (by_device()?, by_cpu()?);
    println!("\n{name}:");
    for product in [Product::Picture, Product::Strokes, Product::Contours] {
        let [found, expected] = [&found, &expected].map(|outcome| outcome.planes(product));
        if !expected.is_empty() {
            let apart = product.difference(&found, &expected);
            println!("  {product:?} {apart:.1e} apart");
        }
    }
    let mut stages: Vec<(&str, Duration)> = Vec::new();
    let mut whole = [Duration::MAX; 2];
    let mut processor = f64::INFINITY;
    for _ in 0..RUNS {
        let start = Instant::now();
        on_cpu.recycle(by_cpu()?);
        whole[0] = whole[0].min(start.elapsed());
        let (start, before) = (Instant::now(), processor_seconds());
        let timings = by_device()?.timings;
        whole[1] = whole[1].min(start.elapsed());
        processor = processor.min(processor_seconds() - before);
        stages.resize(timings.len(), ("", Duration::MAX));
        for (least, (stage, time)) in stages.iter_mut().zip(timings) {
            *least = (stage, least.1.min(time));
        }
    }
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let [cpu, device] = whole.map(ms);
    println!("  CPU backend {cpu:.1} ms; device {device:.1} ms, {processor:.3} s of processors");
    for (stage, time) in stages {
        println!("  {stage:20} {:9.3} ms", ms(time));
    }
    Ok(())
}

/// CPU time of this process over all processors, in seconds; 0 if the system does not provide it.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks = ticks.filter_map(|field| field.parse::<f64>().ok());
    // Hundredths of a second, on every Linux there is.
    ticks.sum::<f64>() / 100.0
}

/// Waves of 64 pixels under a soft light.
fn waves(width: usize, height: usize) -> Frame {
    let frame = Scene::waves(width, height).frame;
    let lit = frame.normal.z.map(|z| 0.8 * z);
    Frame {
        color: Some(ColorPlanes::grey(lit)),
        ..frame
    }
}

/// Depths of plates of 160 pixels, one before the other: edges for contours to follow.
fn plates(width: usize, height: usize) -> Plane {
    Plane::from_fn(width, height, |x, y| {
        5.0 + 2.0 * ((x / 160 + y / 160) % 2) as f32
    })
}
