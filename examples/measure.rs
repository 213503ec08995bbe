//! Error and run time of shape, light and drawings, on known surfaces: one table.
//!
//! `cargo run --release -p examples --example measure -- [mirrors|strokes|warping|WIDTH HEIGHT [ROUNDS]]`
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

use common::{Outcome as Outcomes, light_around, write_npy};
use glam::DVec2;
use rayon::prelude::*;
use relievo::engine::{Engine, Outcome, PlanInputs, Request, Run};
use relievo::frame::{ColorPlanes, Frame, Mask, Plane, SpecularScene, Vector2Planes};
use relievo::light::environment::Environment;
use relievo::light::irradiance::irradiance;
use relievo::light::lights::{DirectionalLight, Illumination};
use relievo::light::median_cut::median_cut;
use relievo::params::{
    Adaptive, LineParams, Material, Method, Params, RelightParams, SampleCount, Scale,
    ScalingParams, ShapeParams, Solver, SpecularParams, StrokeDirections, StrokeScale, Style,
};
use relievo::plan::{Available, Goal, Plan, Tone};
use relievo::scenes::frames::{grey, masked};
use relievo::scenes::light_reference::{
    Pixel, Settings, irradiance as exact_irradiance, lit, sigma, white,
};
use relievo::scenes::{Scene, environment};
use std::process::Command;
use std::rc::Rc;

mod common;
mod measure {
    pub(crate) mod mirrors;
    mod room;
    pub(crate) mod shadows;
    pub(crate) mod strokes;
    pub(crate) mod warping;
}

use measure::{mirrors, shadows, strokes, warping};

/// The variable with the command of another program.
const PEER: &str = "RELIEVO_PEER";

/// Stages by the names that they have in the table.
type Parts = &'static [(&'static str, &'static [&'static str])];

/// A plan with the usual settings of shape and scaling.
fn plan(goal: Goal, frame: &Frame, light: &Illumination) -> Outcomes<Plan> {
    let available = Available::in_frame(frame).lit_by(light);
    let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
    Ok(Plan::new(goal, available, shape, scaling)?)
}

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
    let usage = "usage: measure [mirrors|strokes|warping|WIDTH HEIGHT [ROUNDS]]";
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

type Judge = Box<dyn Fn(&Outcome) -> Outcomes<String>>;

/// A plan to be measured.
struct Case {
    name: String,
    frame: Rc<Frame>,
    plan: Plan,
    light: Illumination,
    parts: Parts,
    /// The error of an outcome, as the table has it.
    judge: Judge,
    error: Option<String>,
    /// Of each round, all stages, and each part.
    seconds: Vec<Vec<f64>>,
}

impl Case {
    fn new(
        name: String,
        frame: &Rc<Frame>,
        plan: Plan,
        light: &Illumination,
        parts: Parts,
        judge: impl Fn(&Outcome) -> Outcomes<String> + 'static,
    ) -> Self {
        Self {
            name,
            frame: frame.clone(),
            plan,
            light: light.clone(),
            parts,
            judge: Box::new(judge),
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
        let parts = std::iter::once(None).chain(parts);
        for (seconds, stages) in self.seconds.iter_mut().zip(parts) {
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
        let dark = Illumination::default();
        Ok(Case::new(name, frame, plan, &dark, SHAPE_PARTS, judge))
    };
    use Solver::{Chebyshev, Explicit};
    let rows = [
        (0, Explicit),
        (10, Explicit),
        (50, Explicit),
        (50, Chebyshev),
        (200, Explicit),
        (200, Chebyshev),
    ];
    let rows = rows.into_iter().map(|(steps, solver)| {
        let name = format!("{steps} steps, {solver:?}");
        case(name, &frame, steps, solver)
    });
    let mut cases: Vec<Case> = rows.collect::<Outcomes<_>>()?;
    let part = Rc::new(covered_in_part(waves(width, height), 0.1));
    let name = "50 steps, a tenth covered".into();
    cases.push(case(name, &part, 50, Chebyshev)?);
    Ok(cases)
}

/// Drawings of a tone that is a half: of waves without an edge, and of a scene that is full of them; and drawings as
/// they are by default, at sizes for print too. Errors are those of the mean tone.
fn drawing_cases(width: usize, height: usize) -> Outcomes<Vec<Case>> {
    let plain: [(_, fn(&mut LineParams)); 4] = [
        ("pen", |_| ()),
        ("pen, two sets", |line| line.strokes.sets = 2),
        ("pen, crossed", |line| {
            line.directions = StrokeDirections::Both
        }),
        ("pencil", |line| line.strokes.style = Style::Pencil),
    ];
    let mut cases = Vec::new();
    for scene in [Scene::waves(width, height), Scene::barriers(width, height)] {
        let (name, frame) = (scene.name, Rc::new(grey(scene.frame, 0.5)));
        for (drawing, change) in plain {
            let name = format!("{name}, {drawing}");
            let mut line = pen();
            change(&mut line);
            cases.push(drawing_case(name, &frame, Tone::Picture, line)?);
        }
    }
    for (width, height) in [(width, height), (3840, 2160), (2480, 3508)] {
        let frame = Rc::new(grey(waves(width, height), 0.5));
        let name = format!("waves, default, {width}x{height}");
        let (tone, line) = (Tone::Shape(None), LineParams::default());
        cases.push(drawing_case(name, &frame, tone, line)?);
    }
    Ok(cases)
}

/// Strokes of one direction at scale 1, as dark as the picture.
fn pen() -> LineParams {
    let mut line = LineParams {
        directions: StrokeDirections::Max,
        interior: None,
        ..LineParams::default()
    };
    line.tone.white_point = Adaptive::Fixed(1.0);
    (line.tone.black_point, line.tone.gamma) = (0.0, 1.0);
    line.strokes.scale = StrokeScale::Factor(1.0);
    line
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
    let dark = Illumination::default();
    let plan = plan(Goal::Hatch(tone, line), frame, &dark)?;
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
    Ok(Case::new(name, frame, plan, &dark, DRAWING_PARTS, judge))
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
        let lights = lights.to_vec();
        let exact = move |pixel: &Pixel, settings: &Settings| lit(pixel, &lights, settings);
        let mut params = white(material, method, SampleCount::Auto);
        cases.push(light_case(&name, &frame, &light, params, exact.clone())?);
        if material == Material::AshikhminShirley {
            params.material.coat = [10.0, 300.0];
            let name = format!("{name}, brushed");
            cases.push(light_case(&name, &frame, &light, params, exact)?);
        }
    }
    let light = light_around(environment.clone());
    let largest = largest_irradiance(&environment);
    let params = white(Material::Lambert, Scale, SampleCount::Fixed(0));
    let diffuse = f64::from(params.material.diffuse_gain);
    let exact = move |pixel: &Pixel, s: &Settings| {
        let shown = exact_irradiance(&environment, pixel.normal);
        let trace = pixel.hessian[0] + pixel.hessian[2];
        let x = f64::from(s.scaling.scaling) * (-s.gain * trace).tanh();
        let d = luminance(shown) / largest;
        Some(shown.map(|c| diffuse * c * sigma(d, x, s.scaling.invariant_point.into())))
    };
    let name = "environment, prefiltered, Lambert";
    cases.push(light_case(name, &frame, &light, params, exact)?);
    Ok(cases)
}

fn light_case(
    name: &str,
    frame: &Rc<Frame>,
    light: &Illumination,
    params: RelightParams,
    exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]> + Sync + 'static,
) -> Outcomes<Case> {
    let plan = plan(Goal::Relight(params), frame, light)?;
    let lit = frame.clone();
    let judge = move |outcome: &Outcome| {
        let gain = outcome.gain.unwrap_or(0.0);
        let known = exact_colors(&lit, &params, gain, CHECKED, &exact)?;
        let worst = errors_of_colors(outcome, &known).fold(0.0, f64::max);
        let colors = known.iter().flat_map(|(_, color)| *color);
        Ok(format!("{:.1e}", worst / colors.fold(0.0, f64::max)))
    };
    let name = format!("{name}, {:?}", params.method);
    Ok(Case::new(name, frame, plan, light, LIGHT_PARTS, judge))
}

fn luminance([r, g, b]: [f64; 3]) -> f64 {
    let [wr, wg, wb] = ColorPlanes::REC709_LUMINANCE.map(f64::from);
    wr * r + wg * g + wb * b
}

/// The luminance of the brightest pixel of the map of irradiance: found in single precision, computed in double.
fn largest_irradiance(environment: &Environment) -> f64 {
    let map = irradiance(environment);
    let pixels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    // Only the side facing the viewer is visible.
    let pixels = pixels.filter(|&(x, y)| map.direction(x, y).z >= 0.0);
    let at = |(x, y): (usize, usize)| luminance(map.pixel(x, y).map(f64::from));
    let brightest = pixels.max_by(|a, b| at(*a).total_cmp(&at(*b)));
    let (x, y) = brightest.expect("a map has pixels");
    let toward = map.direction(x, y).as_dvec3();
    luminance(exact_irradiance(environment, toward))
}

/// Number of pixels at which light is compared with double precision.
const CHECKED: usize = 300;

/// A pixel and its colour.
type Known = ([usize; 2], [f64; 3]);

/// Up to `count` pixels of a frame in new light, in double precision.
fn exact_colors(
    frame: &Frame,
    params: &RelightParams,
    gain: f32,
    count: usize,
    exact: impl Fn(&Pixel, &Settings) -> Option<[f64; 3]> + Sync,
) -> Outcomes<Vec<Known>> {
    // Relighting outputs no Hessian.
    let layers = Engine::cpu().run(&Request::layers(Params::default()), frame, &Run::new())?;
    let hessian = layers.shape.hessian.ok_or("layers hold it")?;
    let settings = Settings {
        method: params.method,
        alpha: f64::from(params.warping.warp * gain),
        gain: gain.into(),
        scaling: &ScalingParams::default(),
        material: &params.material,
    };
    let pixels: Vec<_> = some_covered(&frame.mask, count).collect();
    let known = pixels.into_par_iter().filter_map(|at| {
        let pixel = Pixel::of(frame, &hessian, at, 0.0);
        Some((at, exact(&pixel, &settings)?))
    });
    Ok(known.collect())
}

/// The largest error of a channel at each pixel.
fn errors_of_colors(outcome: &Outcome, known: &[Known]) -> impl Iterator<Item = f64> {
    let color = outcome.color.as_ref().expect("light makes a picture");
    known.iter().map(move |([x, y], exact)| {
        let found = [&color.r, &color.g, &color.b].map(|plane| f64::from(plane.at(*x, *y)));
        let apart = (0..3).map(|c| (found[c] - exact[c]).abs());
        apart.fold(0.0, f64::max)
    })
}

/// Up to `count` covered pixels, spread evenly in the order of rows.
fn some_covered(mask: &Mask, count: usize) -> impl Iterator<Item = [usize; 2]> {
    let step = mask.count().div_ceil(count).max(1);
    let pixels = (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| [x, y]));
    let covered = pixels.filter(|&[x, y]| mask.at(x, y));
    covered.skip(step / 2).step_by(step)
}

/// The frame with only a disc in its middle covered, which takes `share` of it.
fn covered_in_part(frame: Frame, share: f64) -> Frame {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let radius = (share * (width * height) as f64 / std::f64::consts::PI).sqrt();
    let (x0, y0) = (0.5 * width as f64, 0.5 * height as f64);
    masked(frame, |x, y| (x as f64 - x0).hypot(y as f64 - y0) < radius)
}

/// The waves of the report, with a picture to be enhanced.
fn waves(width: usize, height: usize) -> Frame {
    let grey = Plane::from_fn(width, height, |x, y| 0.2 + 0.1 * ((x ^ y) & 7) as f32 / 7.0);
    Frame {
        color: Some(ColorPlanes::grey(grey)),
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
    let trace = outcome.shape.trace.as_ref();
    let trace = trace.expect("enhancing needs the trace");
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
        let write = |name, shape: &[usize], samples: &[f32]| {
            let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
            write_npy(&folder.path().join(name), "<f4", shape, &bytes)
        };
        write("normal.npy", &[size[0], size[1], 3], &interleaved)?;
        write("depth.npy", &size, depth.samples())?;
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
        let error = match self.error() {
            Ok(error) => format!("{error:.1e}"),
            Err(why) => why.to_string(),
        };
        for (stage, seconds) in &self.stages {
            print_row(&format!("{PEER}, {stage}"), &error, seconds, "");
        }
    }
}
