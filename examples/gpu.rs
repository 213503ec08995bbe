//! The GPU beside the CPU on one frame: `cargo run --release -p examples --features gpu --example gpu -- [FRAME.exr] [WIDTH
//! HEIGHT]`.
//!
//! Prints, for each size of features, for new light and for drawings, the difference from the CPU's results and the
//! time of each stage, with the bytes that an ideal pass would move in that time. Without a file, waves of that size,
//! 1920x1080 by default.

use relievo::engine::gpu::{AdapterKind, Device};
use relievo::engine::{self, Engine, Run};
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use relievo::io::inputs::Inputs;
use relievo::io::{Needs, load};
use relievo::light::environment::Environment;
use relievo::light::lights::{DirectionalLight, Illumination, direction_of};
use relievo::params::{
    Adaptive, AlbedoSource, LineParams, Material, Method, RelightParams, SampleCount, Scale,
    ScalingParams, ShapeParams, Solver, StrokeDirections, StrokeScale, Style,
};
use relievo::plan::{Available, Goal, Plan, Tone};
use relievo::product::Product;
use std::time::{Duration, Instant};

/// Number of runs; the quickest counts.
const RUNS: usize = 9;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut frame = match arguments.as_slice() {
        [] => waves(1920, 1080),
        [width, height] => waves(width.parse()?, height.parse()?),
        [path] => {
            let inputs = Inputs {
                picture: path.into(),
                ..Inputs::default()
            };
            let needs = Needs {
                color: true,
                ..Needs::default()
            };
            load(&inputs, needs)?.frame
        }
        _ => return Err("give FRAME.exr, or WIDTH HEIGHT, or nothing".into()),
    };
    let device = Device::open(AdapterKind::Any)?;
    let (width, height) = (frame.mask.width(), frame.mask.height());
    println!("{}, {width}x{height}", device.name());
    let engine = Engine::on(device);
    let shape = ShapeParams {
        scale: Scale::Iterations(0),
        ..ShapeParams::default()
    };
    let given = ScalingParams {
        curvature_gain: Adaptive::Fixed(8.0),
        white_level: Adaptive::Fixed(1.0),
        ..ScalingParams::default()
    };
    let available = Available::in_frame(&frame);
    let plan = Plan::new(Goal::Enhance, available, shape, given)?;
    let name = "no diffusion, gain and white level given";
    measure(name, &engine, &plan, &frame, None)?;
    for (name, scale, solver) in [
        ("no diffusion", Scale::Iterations(0), Solver::Chebyshev),
        ("10 steps", Scale::Iterations(10), Solver::Chebyshev),
        (
            "50 steps, explicit",
            Scale::Iterations(50),
            Solver::Explicit,
        ),
        (
            "50 steps, Chebyshev",
            Scale::Iterations(50),
            Solver::Chebyshev,
        ),
    ] {
        let shape = ShapeParams {
            scale,
            solver,
            ..ShapeParams::default()
        };
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default())?;
        measure(name, &engine, &plan, &frame, None)?;
    }
    let lamp = Illumination {
        directional: vec![DirectionalLight {
            to_light: direction_of(120.0, 40.0),
            intensity: [1.0; 3],
        }],
        ..Illumination::default()
    };
    let room = Illumination {
        environment: Some(sky().into()),
        ..Illumination::default()
    };
    for (name, method, light) in [
        ("scaling under a lamp, 10 steps", Method::Scale, &lamp),
        ("warping of 54 lights, 10 steps", Method::Warp, &room),
        ("both, 10 steps", Method::Both, &room),
    ] {
        let plan = lighting(&frame, method, light)?;
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
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = Plan::new(Goal::Hatch(Tone::Picture, line), available, shape, scaling)?;
        let name = format!("hatching with contours, {name}");
        measure(&name, &engine, &plan, &frame, None)?;
    }
    Ok(())
}

/// A glossy white surface in new light.
fn lighting(frame: &Frame, method: Method, light: &Illumination) -> relievo::Result<Plan> {
    let shape = ShapeParams {
        scale: Scale::Iterations(10),
        ..ShapeParams::default()
    };
    let mut relight = RelightParams {
        method,
        albedo: AlbedoSource::White,
        samples: SampleCount::Fixed(54),
        ..RelightParams::default()
    };
    relight.material.material = Material::BlinnPhong;
    Plan::new(
        Goal::Relight(relight),
        Available::in_frame(frame).lit_by(light),
        shape,
        ScalingParams::default(),
    )
}

fn measure(
    name: &str,
    engine: &Engine,
    plan: &Plan,
    frame: &Frame,
    light: Option<&Illumination>,
) -> relievo::Result<()> {
    let on_cpu = Engine::cpu();
    let inputs = engine::PlanInputs {
        illumination: light,
        ..engine::PlanInputs::default()
    };
    let by_cpu = || on_cpu.execute(plan, frame, inputs, &Run::new());
    let by_device = || engine.execute(plan, frame, inputs, &Run::new());
    let (found, expected) = (by_device()?, by_cpu()?);
    println!("\n{name}:");
    for product in [Product::Picture, Product::Strokes, Product::Contours] {
        let [found, expected] = [&found, &expected].map(|outcome| outcome.planes(product));
        if !expected.is_empty() {
            println!(
                "  {product:?} {:.1e} apart",
                product.difference(&found, &expected)
            );
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
    println!(
        "  CPU backend {:.1} ms; device {:.1} ms, {processor:.3} s of processors",
        ms(whole[0]),
        ms(whole[1])
    );
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

/// An environment with a bright side.
fn sky() -> Environment {
    let blank = Environment::from_fn(256, 128, |_, _| [0.0; 3]);
    Environment::from_fn(256, 128, |x, y| {
        let toward = blank
            .direction(x, y)
            .dot(glam::Vec3::new(0.6, 0.5, 0.62))
            .max(0.0);
        [0.2 + 3.0 * toward.powi(8), 0.2 + 2.5 * toward.powi(8), 0.4]
    })
}

/// Waves of 64 pixels under a soft light.
fn waves(width: usize, height: usize) -> Frame {
    let turn = std::f64::consts::TAU / 64.0;
    let normal = Vector3Planes::from_fn(width, height, |x, y| {
        let (x, y) = (turn * x as f64, turn * y as f64);
        glam::DVec3::new(0.5 * x.sin() * y.cos(), -0.5 * x.cos() * y.sin(), 1.0).normalize()
    });
    let lit = normal.z.map(|z| 0.8 * z);
    let mut frame = Frame::of_normals(normal, Mask::full(width, height));
    frame.depth = Some(Plane::filled(width, height, 5.0));
    frame.color = Some(ColorPlanes {
        r: lit.clone(),
        g: lit.clone(),
        b: lit,
    });
    frame
}

/// Depths of plates of 160 pixels, one before the other: edges for contours to follow.
fn plates(width: usize, height: usize) -> Plane {
    Plane::from_fn(width, height, |x, y| {
        5.0 + 2.0 * ((x / 160 + y / 160) % 2) as f32
    })
}
