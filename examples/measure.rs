//! Error and run time of shape, light and drawings, on known surfaces: one table.
//!
//! `cargo run --release -p examples --example measure -- [mirrors|strokes|warping|WIDTH Scene::HEIGHT [ROUNDS]]`
//!
//! The surface is `h = a cos(kx) cos(ky)`, seen orthographically: its gradient's divergence after N diffusion steps is
//! `-2 a k^2 cos(kx) cos(ky)` times the decay of that wave, which is also known. Light is compared with double
//! precision at some hundred pixels, the ink of drawings with the tone requested.
//!
//! All cases run in turn, round after round, so that load on the machine slows all of them alike. Times are those of
//! later frames of a sequence, whose memory is there.
//!
//! `mirrors`, `strokes` and `warping` in place of numbers give other tables of the guide: of mirrors in a known room, of
//! how strokes follow their field, and of both equations of light warping.
//!
//! `RELIEVO_PEER` may hold a command that times another program on the same waves, run once in every round. In it
//! `{dir}` stands for a folder with `normal.npy` and `depth.npy`. It prints a line of JSON for each stage, with `stage`
//! and `median_s`. What it leaves in `{dir}/out_gs.npy`, the gradient after 50 explicit steps of 1/4 with a margin all
//! around, is compared too.

use glam::DVec2;
use relievo::engine::{Engine, Outcome, PlanInputs, Request, Run};
use relievo::frame::{
    ColorPlanes, Frame, Mask, Plane, SpecularScene, SymmetricPlanes, Vector2Planes,
};
use relievo::light::irradiance::irradiance;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::light::median_cut::median_cut;
use relievo::params::{
    Adaptive, LineParams, Material, Method, Params, RelightParams, SampleCount, Scale,
    ScalingParams, ShapeParams, Solver, SpecularParams, StrokeDirections, StrokeParams,
    StrokeScale, Style, ToneParams,
};
use relievo::plan::{Available, Goal, Plan, Tone};
use relievo::scenes::light_reference::{
    Pixel, Settings, irradiance as exact_irradiance, lit, sigma, white,
};
use relievo::scenes::{Scene, environment};
use std::path::Path;
use std::process::Command;
use std::rc::Rc;

#[path = "measure/mirrors.rs"]
mod mirrors;
#[path = "measure/room.rs"]
mod room;
#[path = "measure/shadows.rs"]
mod shadows;
#[path = "measure/strokes.rs"]
mod strokes;
#[path = "measure/warping.rs"]
mod warping;

/// The Hessian of a frame's height, which relighting does not output.
fn hessian(frame: &Frame, shape: ShapeParams) -> Outcomes<SymmetricPlanes> {
    let params = Params {
        shape,
        ..Params::default()
    };
    let layers = Engine::cpu().run(&Request::new(Goal::LAYERS, params), frame, &Run::new())?;
    Ok(layers.shape.hessian.ok_or("layers hold it")?)
}

type Outcomes<T> = Result<T, Box<dyn std::error::Error>>;

/// The variable with the command of another program.
const PEER: &str = "RELIEVO_PEER";

/// Stages by the names that they have in the table.
type Parts = &'static [(&'static str, &'static [&'static str])];

/// The stages from normals and depth to curvature.
const SHAPE: &[&str] = &["edges-and-gradient", "diffusion", "curvature"];

const SHAPE_PARTS: Parts = &[("diffusion", &["diffusion"]), ("shape", SHAPE)];

const LIGHT_PARTS: Parts = &[
    ("light", &["relight"]),
    ("environment, once", &["environment"]),
];

const DRAWING_PARTS: Parts = &[
    ("shape", SHAPE),
    ("tone", &["shape-tone"]),
    ("lines", &["interior"]),
    ("directions", &["direction-field"]),
    ("strokes", &["hatching"]),
    ("contours", &["contours"]),
];

fn main() -> Outcomes<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        Some("mirrors") => mirrors::print(),
        Some("strokes") => strokes::print(),
        Some("warping") => warping::print(),
        _ => print_cases(&arguments),
    }
}

/// The table of all cases.
fn print_cases(arguments: &[String]) -> Outcomes<()> {
    let usage = "usage: measure [mirrors|strokes|warping|WIDTH Scene::HEIGHT [ROUNDS]]";
    let numbers = arguments.iter().map(|a| a.parse().map_err(|_| usage));
    let numbers: Vec<usize> = numbers.collect::<Result<_, _>>()?;
    let (width, height, rounds) = match numbers[..] {
        [] => (1920, 1080, 7),
        [width, height] => (width, height, 7),
        [width, height, rounds] if rounds > 0 => (width, height, rounds),
        _ => return Err(usage.into()),
    };
    let mut cases = shape_cases(width, height)?;
    cases.extend(light_cases(width, height)?);
    cases.extend(shadows::cases(width, height)?);
    cases.extend(drawing_cases(width, height)?);
    let mut peer = match std::env::var(PEER) {
        Ok(command) => Some(Peer::new(command, &waves(width, height))?),
        Err(_) => None,
    };
    let engine = Engine::cpu();
    for round in 0..rounds {
        let mut size = 0;
        for case in &mut cases {
            // Memory of another size is of no use.
            if case.frame.mask.width() * case.frame.mask.height() != size {
                size = case.frame.mask.width() * case.frame.mask.height();
                engine.recycle(case.outcome(&engine)?);
            }
            case.run(&engine)?;
        }
        if let Some(peer) = &mut peer {
            peer.run()?;
        }
        eprintln!("round {} of {rounds}", round + 1);
    }
    println!(
        "{width}x{height}, {} threads, medians of {rounds} rounds\n",
        rayon::current_num_threads()
    );
    println!("| case | error | ms | half of the rounds within | of which |");
    println!("|---|---|---|---|---|");
    cases.iter().for_each(Case::print);
    if let Some(peer) = &peer {
        peer.print();
    }
    Ok(())
}

/// The error of an outcome, as the table has it.
type Judge = Box<dyn Fn(&Outcome) -> Outcomes<String>>;

/// A plan to be measured.
struct Case {
    name: String,
    frame: Rc<Frame>,
    plan: Plan,
    light: Illumination,
    parts: Parts,
    judge: Judge,
    error: Option<String>,
    /// Of each round, all stages, and each part.
    seconds: Vec<Vec<f64>>,
}

impl Case {
    fn new(name: String, frame: &Rc<Frame>, plan: Plan, parts: Parts, judge: Judge) -> Self {
        Self {
            name,
            frame: frame.clone(),
            plan,
            light: Illumination::default(),
            parts,
            judge,
            error: None,
            seconds: vec![Vec::new(); 1 + parts.len()],
        }
    }

    fn outcome(&self, engine: &Engine) -> Result<Outcome, relievo::Error> {
        engine.forget_environment();
        let inputs = PlanInputs::lit_by(&self.light);
        engine.execute(&self.plan, &self.frame, inputs, &Run::new())
    }

    fn run(&mut self, engine: &Engine) -> Outcomes<()> {
        let outcome = self.outcome(engine)?;
        if self.error.is_none() {
            self.error = Some((self.judge)(&outcome)?);
        }
        let of = |stages: Option<&[&str]>| -> f64 {
            let timings = outcome.timings.iter();
            let timings = timings.filter(|(stage, _)| stages.is_none_or(|s| s.contains(stage)));
            timings.map(|(_, time)| time.as_secs_f64()).sum()
        };
        let parts = self.parts.iter().map(|(_, stages)| Some(*stages));
        for (seconds, stages) in self
            .seconds
            .iter_mut()
            .zip(std::iter::once(None).chain(parts))
        {
            seconds.push(of(stages));
        }
        engine.recycle(outcome);
        Ok(())
    }

    fn print(&self) {
        let parts = self.parts.iter().zip(&self.seconds[1..]);
        let parts: Vec<_> = parts
            .map(|((name, _), seconds)| (name, quartiles(seconds)[1]))
            .filter(|(_, median)| *median > 0.0)
            .map(|(name, median)| format!("{name} {}", ms(median)))
            .collect();
        let error = self.error.as_deref().unwrap_or_default();
        print_row(&self.name, error, &self.seconds[0], &parts.join(", "));
    }
}

fn print_row(name: &str, error: &str, seconds: &[f64], parts: &str) {
    let [lower, median, upper] = quartiles(seconds).map(ms);
    println!("| {name} | {error} | {median} | {lower} to {upper} | {parts} |");
}

/// A row of a table that runs across.
fn print_cells(name: &str, cells: impl IntoIterator<Item = impl ToString>) {
    let cells: Vec<String> = cells.into_iter().map(|cell| cell.to_string()).collect();
    println!("| {name} | {} |", cells.join(" | "));
}

/// The quartiles of some values.
fn quartiles(values: &[f64]) -> [f64; 3] {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[quarter * (values.len() - 1) / 4])
}

fn ms(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    match ms {
        100.0.. => format!("{ms:.0}"),
        10.0.. => format!("{ms:.1}"),
        _ => format!("{ms:.2}"),
    }
}

/// Shape and radiance scaling of waves, by steps and solver; errors are mean and largest ones of the trace, relative to
/// its peak.
fn shape_cases(width: usize, height: usize) -> Outcomes<Vec<Case>> {
    let frame = Rc::new(waves(width, height));
    let case = |name: String, frame: &Rc<Frame>, steps: u32, solver| -> Outcomes<Case> {
        let shape = ShapeParams {
            scale: Scale::Iterations(steps),
            solver,
            foreshortening: 1.0,
            ..ShapeParams::default()
        };
        let available = Available::in_frame(frame);
        let plan = Plan::new(Goal::Enhance, available, shape, ScalingParams::default())?;
        let mask = frame.mask.clone();
        let judge = move |outcome: &Outcome| {
            let (mean, largest) = errors(outcome, &mask, &shape, steps);
            Ok(format!("{mean:.1e}, {largest:.1e}"))
        };
        Ok(Case::new(name, frame, plan, SHAPE_PARTS, Box::new(judge)))
    };
    let mut cases = Vec::new();
    for (steps, solver) in [
        (0, Solver::Explicit),
        (10, Solver::Explicit),
        (50, Solver::Explicit),
        (50, Solver::Chebyshev),
        (200, Solver::Explicit),
        (200, Solver::Chebyshev),
    ] {
        let name = format!("{steps} steps, {solver:?}");
        cases.push(case(name, &frame, steps, solver)?);
    }
    let part = Rc::new(covered_in_part(waves(width, height), 0.1));
    let name = "50 steps, a tenth covered".into();
    cases.push(case(name, &part, 50, Solver::Chebyshev)?);
    Ok(cases)
}

/// Drawings of a tone that is a half: of waves without an edge, and of a scene that is full of them; and drawings as
/// they are by default, at sizes for print too. Errors are those of the mean tone.
fn drawing_cases(width: usize, height: usize) -> Outcomes<Vec<Case>> {
    let pen = pen();
    let strokes = pen.strokes;
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
        ("pen", pen),
        ("pen, two sets", two_sets),
        ("pen, crossed", crossed),
        ("pencil", pencil),
    ];
    let mut cases = Vec::new();
    for scene in [Scene::waves(width, height), Scene::barriers(width, height)] {
        let (name, frame) = (scene.name, Rc::new(half_bright(scene.frame)));
        for (drawing, line) in plain {
            let name = format!("{name}, {drawing}");
            cases.push(drawing_case(name, &frame, Tone::Picture, line)?);
        }
    }
    for (width, height) in [(width, height), (3840, 2160), (2480, 3508)] {
        let frame = Rc::new(half_bright(waves(width, height)));
        let name = format!("waves, default, {width}x{height}");
        let (tone, line) = (Tone::Shape(None), LineParams::default());
        cases.push(drawing_case(name, &frame, tone, line)?);
    }
    Ok(cases)
}

/// Strokes of one direction at scale 1, as dark as the picture.
fn pen() -> LineParams {
    LineParams {
        tone: ToneParams {
            white_point: Adaptive::Fixed(1.0),
            black_point: 0.0,
            gamma: 1.0,
            ..ToneParams::default()
        },
        directions: StrokeDirections::Max,
        interior: None,
        strokes: StrokeParams {
            scale: StrokeScale::Factor(1.0),
            ..StrokeParams::default()
        },
        ..LineParams::default()
    }
}

/// The directions that strokes with `line` follow in a picture, by a mirror if there is one.
fn stroke_field(
    frame: &Frame,
    line: &LineParams,
    mirror: Option<(&SpecularScene, SpecularParams)>,
) -> Outcomes<Vector2Planes> {
    let available = Available {
        specular: mirror.map(|(_, params)| params),
        ..Available::in_frame(frame)
    };
    let inputs = PlanInputs {
        specular: mirror.map(|(scene, _)| scene),
        ..PlanInputs::default()
    };
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::new(Goal::Hatch(Tone::Picture, *line), available, shape, scaling)?;
    let fields = Engine::cpu().stroke_fields(&plan, frame, inputs, line)?;
    Ok(fields.into_iter().next().ok_or("strokes follow a field")?)
}

fn direction_at(field: &Vector2Planes, [x, y]: [usize; 2]) -> DVec2 {
    DVec2::new(field.x.at(x, y).into(), field.y.at(x, y).into())
}

fn drawing_case(name: String, frame: &Rc<Frame>, tone: Tone, line: LineParams) -> Outcomes<Case> {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let plan = Plan::new(
        Goal::Hatch(tone, line),
        Available::in_frame(frame),
        shape,
        scaling,
    )?;
    let mask = frame.mask.clone();
    let judge = move |outcome: &Outcome| {
        let drawing = outcome.drawing.as_ref().ok_or("a drawing was planned")?;
        let mean = |plane: &Plane| {
            let covered = mask.plane().samples().iter().zip(plane.samples());
            let covered = covered.filter(|(covered, _)| **covered);
            covered.map(|(_, &ink)| f64::from(ink)).sum::<f64>() / mask.count() as f64
        };
        let asked = drawing.asked.as_ref().map_or(0.5, mean);
        Ok(format!("{:+.4}", mean(&drawing.hatching) - asked))
    };
    Ok(Case::new(name, frame, plan, DRAWING_PARTS, Box::new(judge)))
}

/// New light on white waves; errors are the largest at some pixels, relative to the brightest.
fn light_cases(width: usize, height: usize) -> Outcomes<Vec<Case>> {
    let frame = Rc::new(Scene::waves(width, height).frame);
    let environment = environment();
    let one = [DirectionalLight {
        to_light: glam::Vec3::new(-0.6, 0.6, 0.53).normalize(),
        intensity: [1.0; 3],
    }];
    let many = median_cut(&environment, 54);
    use Method::{Both, Plain, Scale, Warp};
    let mut cases = Vec::new();
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
        let lights: Rc<[DirectionalLight]> = lights.into();
        let exact = move |pixel: &Pixel, settings: &Settings| lit(pixel, &lights, settings);
        let mut params = white(material, method, SampleCount::Auto);
        cases.push(light_case(&name, &frame, &light, params, exact.clone())?);
        if material == Material::AshikhminShirley {
            params.material.coat = [10.0, 300.0];
            let name = format!("{name}, brushed");
            cases.push(light_case(&name, &frame, &light, params, exact)?);
        }
    }
    let light = Illumination {
        environment: Some(environment.clone().into()),
        ..Illumination::default()
    };
    let largest = largest_irradiance(&environment);
    let exact = move |pixel: &Pixel, s: &Settings| {
        let shown = exact_irradiance(&environment, pixel.normal);
        let trace = pixel.hessian[0] + pixel.hessian[2];
        let x = f64::from(s.scaling.scaling) * (-s.gain * trace).tanh();
        let d = luminance(shown) / largest;
        Some(shown.map(|c| c * sigma(d, x, s.scaling.invariant_point.into())))
    };
    let params = white(Material::Lambert, Scale, SampleCount::Fixed(0));
    let name = "environment, prefiltered, Lambert";
    cases.push(light_case(name, &frame, &light, params, exact)?);
    Ok(cases)
}

fn light_case(
    name: &str,
    frame: &Rc<Frame>,
    light: &Illumination,
    params: RelightParams,
    exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]> + 'static,
) -> Outcomes<Case> {
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    let available = Available::in_frame(frame).lit_by(light);
    let plan = Plan::new(Goal::Relight(params), available, shape, scaling)?;
    let has_environment = light.environment.is_some();
    let lit = frame.clone();
    let judge = move |outcome: &Outcome| {
        let hessian = hessian(&lit, shape)?;
        let error = light_error(&lit, &hessian, &params, has_environment, outcome, &exact);
        Ok(format!("{error:.1e}"))
    };
    let name = format!("{name}, {:?}", params.method);
    let case = Case::new(name, frame, plan, LIGHT_PARTS, Box::new(judge));
    Ok(Case {
        light: light.clone(),
        ..case
    })
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    let [wr, wg, wb] = ColorPlanes::REC709_LUMINANCE.map(f64::from);
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

/// The largest error of light relative to the largest value, at some pixels.
fn light_error(
    frame: &Frame,
    hessian: &SymmetricPlanes,
    params: &RelightParams,
    has_environment: bool,
    outcome: &Outcome,
    exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]>,
) -> f64 {
    let gain = outcome.gain.unwrap_or(0.0);
    let settings = Settings {
        method: params.method,
        alpha: f64::from(params.warping.warp * gain),
        gain: gain.into(),
        scaling: &ScalingParams::default(),
        material: &params.material,
    };
    let color = outcome.color.as_ref().expect("light makes a picture");
    let diffuse = match has_environment {
        true => f64::from(params.material.diffuse_gain),
        false => 1.0,
    };
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for at in some_covered(&frame.mask, CHECKED) {
        let pixel = Pixel::of(frame, hessian, at, 0.0);
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

/// Up to `count` covered pixels, spread evenly in the order of rows.
fn some_covered(mask: &Mask, count: usize) -> impl Iterator<Item = [usize; 2]> {
    let step = mask.count().div_ceil(count).max(1);
    let pixels = (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| [x, y]));
    let covered = pixels.filter(|&[x, y]| mask.at(x, y));
    covered.skip(step / 2).step_by(step)
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

/// Pixels of a wave.
const MARGIN: usize = 64;

/// What a step of diffusion multiplies a product of waves by: `1 - 4 dt (1 - cos k)`.
fn decay(time_step: f64) -> f64 {
    1.0 - 4.0 * time_step * (1.0 - Scene::WAVE.cos())
}

/// Mean and largest error of the trace, relative to its largest value, a wave away from borders.
fn errors(outcome: &Outcome, mask: &Mask, shape: &ShapeParams, steps: u32) -> (f64, f64) {
    let trace = outcome
        .shape
        .trace
        .as_ref()
        .expect("enhancing needs the trace");
    let peak = 2.0 * Scene::HEIGHT * Scene::WAVE * Scene::WAVE;
    let decayed = peak * decay(shape.time_step.into()).powi(steps as i32);
    let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for y in MARGIN..trace.height().saturating_sub(MARGIN) {
        let span = mask.span(y);
        for x in span.start + MARGIN..span.end.saturating_sub(MARGIN) {
            // The border of a disc is nearer above and below.
            if !(mask.at(x, y - MARGIN) && mask.at(x, y + MARGIN)) {
                continue;
            }
            let [cx, cy] = [x, y].map(|i| (Scene::WAVE * (i as f64 + 0.5)).cos());
            let error = (f64::from(trace.at(x, y)) + decayed * cx * cy).abs() / peak;
            sum += error;
            largest = largest.max(error);
            count += 1;
        }
    }
    (sum / f64::from(count.max(1)), largest)
}

/// Another program, timed by a command.
struct Peer {
    command: String,
    folder: tempfile::TempDir,
    /// The gradient after 50 steps that it should find, and its largest component.
    exact: [Vec<f32>; 2],
    width: usize,
    /// Seconds of each round, by stage.
    stages: Vec<(String, Vec<f64>)>,
}

impl Peer {
    fn new(command: String, frame: &Frame) -> Outcomes<Self> {
        let folder = tempfile::tempdir()?;
        let (normal, size) = (&frame.normal, [frame.mask.height(), frame.mask.width()]);
        let normals = normal.x.samples().iter().zip(normal.y.samples());
        let normals = normals.zip(normal.z.samples());
        let interleaved: Vec<f32> = normals.flat_map(|((&x, &y), &z)| [x, y, z]).collect();
        let depth = frame.depth.as_ref().ok_or("waves have depth")?;
        write_npy(
            &folder.path().join("normal.npy"),
            &[size[0], size[1], 3],
            &interleaved,
        )?;
        write_npy(&folder.path().join("depth.npy"), &size, depth.samples())?;
        let left = decay(0.25).powi(50) as f32;
        let exact = [&normal.x, &normal.y].map(|component| {
            let slopes = component.samples().iter().zip(normal.z.samples());
            slopes.map(|(n, z)| -left * n / z).collect()
        });
        Ok(Self {
            command: command.replace("{dir}", &folder.path().display().to_string()),
            folder,
            exact,
            width: size[1],
            stages: Vec::new(),
        })
    }

    fn run(&mut self) -> Outcomes<()> {
        let output = Command::new("sh").args(["-c", &self.command]).output()?;
        if !output.status.success() {
            return Err(format!("{PEER}: {}", String::from_utf8_lossy(&output.stderr)).into());
        }
        for line in String::from_utf8(output.stdout)?.lines() {
            let told: serde_json::Value = serde_json::from_str(line)?;
            let (Some(stage), Some(seconds)) = (told["stage"].as_str(), told["median_s"].as_f64())
            else {
                return Err(format!("{PEER}: no stage and median_s in {line}").into());
            };
            match self.stages.iter_mut().find(|(known, _)| known == stage) {
                Some((_, all)) => all.push(seconds),
                None => self.stages.push((stage.into(), vec![seconds])),
            }
        }
        Ok(())
    }

    /// The largest error of its gradient, relative to the largest slope, a wave away from borders.
    fn error(&self) -> Outcomes<f64> {
        let bytes = std::fs::read(self.folder.path().join("out_gs.npy"))?;
        let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        let (samples, _) = bytes[10 + header..].as_chunks::<4>();
        let height = self.exact[0].len() / self.width;
        // As wide a margin at every side: (w + 2m) (h + 2m) samples of each component.
        let is_it = |m: &usize| 2 * (self.width + 2 * m) * (height + 2 * m) == samples.len();
        let margin = (0..MARGIN)
            .find(is_it)
            .ok_or("out_gs.npy has another size")?;
        let stride = self.width + 2 * margin;
        let (mut worst, mut largest) = (0.0_f32, 0.0_f32);
        for (samples, exact) in samples.chunks(samples.len() / 2).zip(&self.exact) {
            for y in MARGIN..height.saturating_sub(MARGIN) {
                for x in MARGIN..self.width.saturating_sub(MARGIN) {
                    let found = samples[(y + margin) * stride + x + margin];
                    let exact = exact[y * self.width + x];
                    worst = worst.max((f32::from_le_bytes(found) - exact).abs());
                    largest = largest.max(exact.abs());
                }
            }
        }
        Ok((worst / largest).into())
    }

    fn print(&self) {
        let error = self
            .error()
            .map_or_else(|why| why.to_string(), |error| format!("{error:.1e}"));
        for (stage, seconds) in &self.stages {
            print_row(&format!("{PEER}, {stage}"), &error, seconds, "");
        }
    }
}

/// Writes an array of single precision in NumPy's format.
fn write_npy(path: &Path, shape: &[usize], samples: &[f32]) -> std::io::Result<()> {
    let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({shape}), }}");
    // With ten bytes before it, the header ends at a multiple of 64.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = length - 1).bytes());
    bytes.extend(samples.iter().flat_map(|v| v.to_le_bytes()));
    std::fs::write(path, bytes)
}
