//! Error against run time of the stages of shape, of light and of drawings, on known surfaces.
//!
//! `cargo run --release --example measure -- [WIDTH HEIGHT [REPEATS]]`
//!
//! The surface is `h = a cos(kx) cos(ky)`, seen orthographically: its gradient's divergence after N diffusion steps is
//! `-2 a k^2 cos(kx) cos(ky)` times the decay of that wave, which is also known. Light is compared with double
//! precision at some hundred pixels, the ink of drawings with the tone requested.

use relievo::engine::{Engine, Inputs, Outcome, Run};
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, REC709_LUMINANCE, SymmetricPlanes};
use relievo::light::irradiance::irradiance;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::light::median_cut::median_cut;
use relievo::params::{
    Adaptive, AlbedoSource, LineParams, Material, MaterialParams, Method, RelightParams, Samples,
    Scale, ScalingParams, ShapeParams, Solver, StrokeDirections, StrokeParams, StrokeScale, Style,
    Tangent, ToneParams,
};
use relievo::plan::{Available, Goal, LightKinds, Plan, ToneFrom};
use relievo::report::light_reference::{
    Pixel, Settings, hessian, irradiance as exact_irradiance, lit, sigma,
};
use relievo::report::scenes::{HEIGHT, Scene, WAVE, environment};
use relievo::report::timing::{Effort, Timed, Times, measure, measure_runs};
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
    // A tenth of the frame shows a surface: empty parts cost next to nothing.
    let shape = ShapeParams {
        scale: Scale::Iterations(50),
        foreshortening: 1.0,
        ..ShapeParams::default()
    };
    let (_, timed) = run(&covered_in_part(frame, 0.1), shape, repeats)?;
    let label = "50, 10 % covered | Chebyshev | | ";
    print_stages(label, &timed, width * height);
    print_light(&Scene::waves(width, height).frame, repeats)?;
    print_drawings(width, height, repeats)
}

/// The time of drawings beside the error of their tone, which is a half: of waves without an edge, and of a scene that
/// is full of them; and of drawings as they are by default, at sizes for print too.
fn print_drawings(
    width: usize,
    height: usize,
    repeats: usize,
) -> Result<(), Box<dyn std::error::Error>> {
    println!("\n| scene | drawing | size | error of tone |{}", columns());
    println!("|---|---|---|---|{}", "---|".repeat(DRAWING.len()));
    let strokes = StrokeParams {
        scale: StrokeScale::Factor(1.0),
        ..StrokeParams::default()
    };
    let pen = LineParams {
        tone: ToneParams {
            white_point: Adaptive::Fixed(1.0),
            black_point: 0.0,
            gamma: 1.0,
            ..ToneParams::default()
        },
        directions: StrokeDirections::Max,
        interior: None,
        strokes,
        ..LineParams::default()
    };
    let of_strokes = |strokes| LineParams { strokes, ..pen };
    let two_sets = of_strokes(StrokeParams { sets: 2, ..strokes });
    let crossed = LineParams {
        directions: StrokeDirections::Both,
        ..pen
    };
    let pencil = of_strokes(StrokeParams {
        style: Style::Pencil,
        ..strokes
    });
    let plain = [
        ("pen alone", pen),
        ("2 sets", two_sets),
        ("crossed", crossed),
        ("pencil", pencil),
    ];
    for scene in [Scene::waves(width, height), Scene::barriers(width, height)] {
        let (name, frame) = (scene.name, half_bright(scene.frame));
        for (drawing, line) in plain {
            let label = format!("{name} | {drawing}");
            print_drawing(&label, &frame, ToneFrom::Picture, line, repeats)?;
        }
    }
    for (width, height) in [(width, height), (3840, 2160), (2480, 3508)] {
        let frame = half_bright(waves(width, height));
        let line = LineParams::default();
        print_drawing(
            "waves | default",
            &frame,
            ToneFrom::Shape(None),
            line,
            repeats,
        )?;
    }
    Ok(())
}

/// The stages of a drawing whose times are printed.
const DRAWING: [(&str, &[&str]); 6] = [
    ("shape min ms", &SHAPE),
    ("tone", &["shape-tone"]),
    ("lines", &["interior"]),
    ("directions", &["direction-field"]),
    ("strokes", &["hatching"]),
    ("contours", &["contours"]),
];

fn columns() -> String {
    DRAWING
        .iter()
        .map(|(name, _)| format!(" {name} |"))
        .collect()
}

/// The frame with a picture that is half as bright as white all over.
fn half_bright(frame: Frame) -> Frame {
    let half = Plane::filled(frame.mask.width(), frame.mask.height(), 0.5);
    let [r, g, b] = [(); 3].map(|()| half.clone());
    Frame {
        color: Some(ColorPlanes { r, g, b }),
        ..frame
    }
}

fn print_drawing(
    label: &str,
    frame: &Frame,
    tone: ToneFrom,
    line: LineParams,
    repeats: usize,
) -> Result<(), relievo::Error> {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::hatch(Available::in_frame(frame), shape, scaling, tone, line)?;
    let engine = Engine::cpu();
    let effort = Effort {
        runs: repeats,
        limit: Duration::MAX,
    };
    let draw = || {
        let outcome = engine.execute(&plan, frame, Inputs::default(), &Run::new());
        outcome.expect("the plan was made for the frame")
    };
    let (outcome, timed) = measure_runs(&engine, effort, draw);
    let drawing = outcome.drawing.expect("a drawing was planned");
    let covered = |plane: &Plane| {
        let covered = frame.mask.plane().samples().iter().zip(plane.samples());
        let covered = covered.filter(|(covered, _)| **covered);
        covered.map(|(_, &ink)| f64::from(ink)).sum::<f64>() / frame.mask.count() as f64
    };
    let error = covered(&drawing.hatching) - drawing.asked.as_ref().map_or(0.5, covered);
    let times = DRAWING.map(|(_, stages)| {
        let times = stages.iter().filter_map(|stage| timed.stage(stage));
        format!(
            " {:.1} |",
            1e3 * times.map(|times| times.min).fold(0.0, |a, b| a + b)
        )
    });
    let (width, height) = (frame.mask.width(), frame.mask.height());
    println!(
        "| {label} | {width}x{height} | {error:+.4} |{}",
        times.concat()
    );
    Ok(())
}

/// The time of new light beside its error.
fn print_light(frame: &Frame, repeats: usize) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "\n| light | method | largest error | light min ms | median ms | environment ms | Mpix/s |"
    );
    println!("|---|---|---|---|---|---|---|");
    let environment = environment();
    let one = [DirectionalLight {
        to_light: glam::Vec3::new(-0.6, 0.6, 0.53).normalize(),
        intensity: [1.0; 3],
    }];
    let many = median_cut(&environment, 54);
    use Method::{Both, Plain, Scale, Warp};
    for (lights, material, method) in [
        (&one[..], Material::Phong, Plain),
        (&one, Material::Phong, Scale),
        (&many, Material::Lambert, Warp),
        (&many, Material::BlinnPhong, Plain),
        (&many, Material::BlinnPhong, Warp),
        (&many, Material::BlinnPhong, Both),
        (&many, Material::AshikhminShirley, Warp),
    ] {
        let light = Illumination {
            directional: lights.to_vec(),
            ..Illumination::default()
        };
        let name = match lights.len() {
            1 => format!("1 light, {material:?}"),
            count => format!("{count} lights, {material:?}"),
        };
        let mut lighting = Lighting {
            frame,
            light,
            params: white(material, method, Samples::Auto),
        };
        let exact = |pixel: &Pixel, settings: &Settings| lit(pixel, lights, settings);
        lighting.print(&name, repeats, exact)?;
        if material == Material::AshikhminShirley {
            lighting.params.material.coat = [10.0, 300.0];
            lighting.print(&format!("{name}, brushed"), repeats, exact)?;
        }
    }
    let prefiltered = Lighting {
        frame,
        light: Illumination {
            environment: Some(environment.clone().into()),
            ..Illumination::default()
        },
        params: white(Material::Lambert, Scale, Samples::Fixed(0)),
    };
    let largest = largest_irradiance(&environment);
    let exact = |pixel: &Pixel, s: &Settings| {
        let shown = exact_irradiance(&environment, pixel.normal);
        let trace = pixel.hessian[0] + pixel.hessian[2];
        let x = f64::from(s.scaling.scaling) * (-s.gain * trace).tanh();
        let d = luminance(shown) / largest;
        Some(shown.map(|c| c * sigma(d, x, s.scaling.invariant_point.into())))
    };
    prefiltered.print("environment, prefiltered, Lambert", repeats, exact)
}

/// White of one material with gains of 1, without ambient light.
fn white(material: Material, method: Method, samples: Samples) -> RelightParams {
    RelightParams {
        method,
        samples,
        albedo: AlbedoSource::White,
        environment_gain: Adaptive::Fixed(1.0),
        material: MaterialParams {
            material,
            ambient: 0.0,
            diffuse_gain: 1.0,
            specular_gain: Some(1.0),
            tangent: Tangent::Degrees(0.0),
            ..MaterialParams::default()
        },
        ..RelightParams::default()
    }
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    let [wr, wg, wb] = REC709_LUMINANCE.map(f64::from);
    wr * r + wg * g + wb * b
}

/// The luminance of the brightest pixel of the map of irradiance: found in single precision, computed in double.
fn largest_irradiance(environment: &relievo::light::environment::Environment) -> f64 {
    let map = irradiance(environment);
    let pixels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    // Only the side facing the viewer is visible.
    let pixels = pixels.filter(|&(x, y)| map.direction(x, y).z >= 0.0);
    let at = |(x, y): (usize, usize)| luminance(map.pixel(x, y).map(f64::from));
    let brightest = pixels.max_by(|a, b| at(*a).total_cmp(&at(*b)));
    let (x, y) = brightest.expect("a map has pixels");
    luminance(exact_irradiance(
        environment,
        map.direction(x, y).as_dvec3(),
    ))
}

/// Number of pixels at which light is compared with double precision.
const CHECKED: usize = 300;

struct Lighting<'a> {
    frame: &'a Frame,
    light: Illumination,
    params: RelightParams,
}

impl Lighting<'_> {
    /// Prints the times of light and its largest error relative to the largest value, at some pixels.
    fn print(
        &self,
        name: &str,
        repeats: usize,
        exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let (frame, scaling) = (self.frame, ScalingParams::default());
        let shape = ShapeParams::default();
        let kinds = LightKinds::in_light(&self.light);
        let available = Available::in_frame(frame);
        let plan = Plan::relight(available, shape, scaling, self.params, kinds)?;
        let engine = Engine::cpu();
        let relit = || engine.execute(&plan, frame, Inputs::lit_by(&self.light), &Run::new());
        let mut outcome = relit()?;
        let (mut times, mut once) = (Vec::new(), Vec::new());
        for _ in 0..repeats {
            engine.recycle(outcome);
            engine.forget_environment();
            outcome = relit()?;
            let stage = |name: &str| {
                let mut timings = outcome.timings.iter();
                timings
                    .find(|(stage, _)| *stage == name)
                    .map(|(_, time)| time.as_secs_f64())
            };
            times.extend(stage("relight"));
            once.extend(stage("environment"));
        }
        let error = self.error(&outcome, &hessian(frame, shape)?, &scaling, exact);
        let times = Times::of(times);
        let once = match once.is_empty() {
            true => String::new(),
            false => format!("{:.1}", 1e3 * Times::of(once).min),
        };
        let pixels = frame.mask.width() * frame.mask.height();
        println!(
            "| {name} | {:?} | {error:.1e} | {:.2} | {:.2} | {once} | {:.1} |",
            self.params.method,
            1e3 * times.min,
            1e3 * times.median,
            times.megapixels_per_second(pixels)
        );
        Ok(())
    }

    fn error(
        &self,
        outcome: &Outcome,
        hessian: &SymmetricPlanes,
        scaling: &ScalingParams,
        exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]>,
    ) -> f64 {
        let gain = outcome.gain.unwrap_or(0.0);
        let settings = Settings {
            method: self.params.method,
            alpha: f64::from(self.params.warping.warp * gain),
            gain: gain.into(),
            scaling,
            material: &self.params.material,
        };
        let color = outcome.color.as_ref().expect("light makes a picture");
        let diffuse = match self.light.environment {
            Some(_) => f64::from(self.params.material.diffuse_gain),
            None => 1.0,
        };
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for at in some_covered(&self.frame.mask) {
            let pixel = Pixel::of(self.frame, hessian, at, 0.0);
            let Some(exact) = exact(&pixel, &settings) else {
                continue;
            };
            for (plane, exact) in [&color.r, &color.g, &color.b].into_iter().zip(exact) {
                let exact = diffuse * exact;
                worst = worst.max((f64::from(plane.at(at[0], at[1])) - exact).abs());
                largest = largest.max(exact);
            }
        }
        worst / largest
    }
}

/// Up to [`CHECKED`] covered pixels, spread evenly in the order of rows.
fn some_covered(mask: &Mask) -> impl Iterator<Item = [usize; 2]> {
    let step = mask.count().div_ceil(CHECKED).max(1);
    let pixels = (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| [x, y]));
    let covered = pixels.filter(|&[x, y]| mask.at(x, y));
    covered.skip(step / 2).step_by(step)
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

/// The frame with only a disc in its middle covered, which takes `share` of it.
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
