//! Error against run time: what each setting costs and what it gives, on a frame and on exact scenes.
//!
//! Everything is measured against a reference in double precision ([`mod@reference`]) that starts from the
//! same input. Errors of slopes and of their derivatives are told relative to the largest |g| before
//! diffusion; times are of the stages, without reading and writing.

pub(crate) mod advice;
pub mod coherence;
pub mod compare;
mod drawing;
mod engine;
pub(crate) mod gpu;
pub mod light;
pub mod light_reference;
mod machine;
pub(crate) mod markdown;
mod mirrors;
pub mod pareto;
mod pictures;
pub(crate) mod plots;
mod reference;
pub mod scenes;
pub mod stability;
pub mod sweeps;
pub mod timing;
pub mod work;

use crate::Result;
use crate::frame::Frame;
use crate::params::{Scale, ShapeParams};
use crate::plan::{Decision, Goal};
use gpu::{Device, Gpu, GpuReport};
use machine::Machine;
use scenes::Scene;
use serde::Serialize;
use stability::CaseResult;
use sweeps::{directions, precision, rim, run, solver};
use timing::{Effort, Times, Utilisation};

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// All scales, scenes of 480x360.
    Full,
    /// The scale asked for and one more, scenes of 320x240, fewer runs.
    Quick,
}

/// A stage of the whole descriptor.
#[derive(Debug, Clone, Serialize)]
pub struct StageRow {
    /// Its name.
    pub stage: &'static str,
    /// Its time.
    pub times: Times,
    /// Megapixels of the frame per second.
    pub megapixels_per_second: f64,
    /// Its share of the machine, for a stage with a model of its work.
    pub utilisation: Option<Utilisation>,
}

/// Everything that was measured.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// Whether the program was built with optimisation; times of one that was not mean little.
    pub optimised: bool,
    /// The machine.
    pub machine: Machine,
    /// How shape was asked to be found.
    pub shape: ShapeParams,
    /// Stages of a picture of the curvature, run or left out, and why.
    pub decisions: Vec<Decision>,
    /// Stages of the whole descriptor on the frame.
    pub stages: Vec<StageRow>,
    /// Solvers and tolerances on the frame.
    pub frame: solver::SceneSweep,
    /// The same on exact scenes.
    pub scenes: Vec<solver::SceneSweep>,
    /// Ways of running.
    pub runs: Vec<run::Row>,
    /// Precision of the input.
    pub precision: Vec<precision::Row>,
    /// Step and rounding of the surface's own directions on an ellipsoid.
    pub directions: directions::Sweep,
    /// Foreshortening and the floor of n_z on a ball.
    pub rim_of_ball: Vec<rim::BallRow>,
    /// The same on the frame.
    pub rim_of_frame: Vec<rim::FrameRow>,
    /// Light.
    pub light: light::LightReport,
    /// Drawings.
    pub drawing: drawing::DrawingReport,
    /// Mirrors.
    pub mirrors: mirrors::MirrorReport,
    /// A device beside the CPU; `None` in a build that knows of none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gpu: Option<GpuReport>,
    /// Drawings of a sequence, where the report is of one; [`run`] leaves it open.
    pub coherence: Option<coherence::Coherence>,
    /// Stiff and extreme cases.
    pub stability: Vec<CaseResult>,
}

/// Measures everything on `frame`, called `name`, and on exact scenes, a device beside the CPU where there is one.
/// `progress` is told what is done next.
///
/// # Errors
/// [`crate::Error::BadParameter`] for a parameter outside its range, and those of a device that is required.
pub fn run(
    name: &str,
    frame: &Frame,
    shape: ShapeParams,
    extent: Extent,
    device: Device,
    progress: &dyn Fn(&str),
) -> Result<Report> {
    shape.validate()?;
    progress("the machine's bandwidth and arithmetic");
    let machine = Machine::measured();
    let effort = effort(extent);
    let gpu = match &device {
        Device::Measured(gpu) => Some(gpu),
        Device::Unknown | Device::NotMeasured(_) => None,
    };
    // Without foreshortening no stage asks for the camera; a command would not even look for it.
    let lean = Frame {
        camera: frame.camera.filter(|_| shape.foreshortening != 0.0),
        ..frame.clone()
    };
    progress(&format!("{name}: stages"));
    let display = timing::plan(Goal::Display, &lean, shape)?;
    let stages = stages(&lean, shape, effort, &machine)?;
    let subject = solver::Subject {
        name: name.into(),
        about: "the frame".into(),
        frame: &lean,
        shape,
        closed_form: None,
        gpu,
    };
    let scales = frame_scales(shape.scale, extent);
    let swept = solver::sweep(&subject, &scales, effort, &machine, progress)?;
    let scene_frames = scenes_of(extent);
    let scenes = exact_scenes(
        &scene_frames,
        shape,
        extent,
        effort,
        &machine,
        gpu,
        progress,
    )?;
    if gpu.is_some() {
        progress("the device's products and pictures beside the CPU's");
    }
    let gpu = measured(&device, &subject, &scene_frames, effort)?;
    drop(scene_frames);
    progress(&format!("{name}: threads"));
    let mut runs = run::threads(&lean, shape, effort)?;
    progress(&format!("{name}: tiles and sweeps per pass"));
    runs.extend(run::tiles_and_passes(&lean, shape, &scales, effort)?);
    progress(&format!("{name}: half and byte input"));
    let mut rounded = precision::sweep(name, &lean, shape)?;
    let (width, height) = scene_size(extent);
    let ball = Scene::ball(width, height);
    rounded.extend(precision::sweep(
        "ball",
        &ball.frame,
        ShapeParams {
            foreshortening: 0.0,
            ..shape
        },
    )?);
    drop(lean);
    progress("ellipsoid: directions");
    let directions = directions::sweep(&Scene::ellipsoid(width, height), effort)?;
    progress(&format!("{name}: foreshortening and min_nz"));
    let (rim_of_ball, rim_of_frame) = (rim::on_ball()?, rim::on_frame(frame, &shape)?);
    let light = light::run(name, frame, shape, extent, progress)?;
    let drawing = drawing::run(name, frame, shape, extent, progress)?;
    let mirrors = mirrors::run(extent, progress)?;
    progress("stiff and extreme cases");
    Ok(Report {
        version: env!("CARGO_PKG_VERSION"),
        optimised: !cfg!(debug_assertions),
        machine,
        shape,
        decisions: display.decisions().to_vec(),
        stages,
        frame: swept,
        scenes,
        runs,
        precision: rounded,
        directions,
        rim_of_ball,
        rim_of_frame,
        light,
        drawing,
        mirrors,
        gpu,
        coherence: None,
        stability: stability::all().iter().map(stability::Case::run).collect(),
    })
}

fn effort(extent: Extent) -> Effort {
    match extent {
        Extent::Full => Effort::new(7, 250),
        Extent::Quick => Effort::new(5, 150),
    }
}

fn scene_size(extent: Extent) -> (usize, usize) {
    match extent {
        Extent::Full => (480, 360),
        Extent::Quick => (320, 240),
    }
}

/// The scale asked for first.
fn frame_scales(asked_for: Scale, extent: Extent) -> Vec<Scale> {
    let more: &[Scale] = match extent {
        Extent::Full => &[
            Scale::Iterations(50),
            Scale::Iterations(200),
            Scale::Sigma(6.0),
            Scale::Sigma(20.0),
        ],
        Extent::Quick => &[Scale::Sigma(6.0)],
    };
    let more = more.iter().copied().filter(|&scale| scale != asked_for);
    std::iter::once(asked_for).chain(more).collect()
}

fn scenes_of(extent: Extent) -> Vec<Scene> {
    let (width, height) = scene_size(extent);
    Scene::all(width, height)
}

/// How the shape of an exact scene is found, but for its scale.
fn shape_of(scene: &Scene, tolerance: f32) -> ShapeParams {
    ShapeParams {
        foreshortening: scene.foreshortening,
        tolerance,
        ..ShapeParams::default()
    }
}

/// What is known of a device after all frames were measured on it, and how far it is from the CPU.
fn measured(
    device: &Device,
    subject: &solver::Subject,
    scenes: &[Scene],
    effort: Effort,
) -> Result<Option<GpuReport>> {
    let gpu = match device {
        Device::Unknown => return Ok(None),
        Device::NotMeasured(why) => return Ok(Some(GpuReport::NotMeasured(why.clone()))),
        Device::Measured(gpu) => gpu,
    };
    let scenes = scenes.iter().map(|scene| {
        let shape = shape_of(scene, subject.shape.tolerance);
        (scene.name, &scene.frame, shape)
    });
    let own = (subject.name.as_str(), subject.frame, subject.shape);
    let frames: Vec<_> = std::iter::once(own).chain(scenes).collect();
    let products = gpu.products(&frames)?;
    let pictures = pictures::rows(gpu, subject.frame, subject.shape, effort)?;
    gpu.report(products, pictures).map(Some)
}

fn exact_scenes(
    scenes: &[Scene],
    shape: ShapeParams,
    extent: Extent,
    effort: Effort,
    machine: &Machine,
    gpu: Option<&Gpu>,
    progress: &dyn Fn(&str),
) -> Result<Vec<solver::SceneSweep>> {
    let scales: &[Scale] = match extent {
        Extent::Full => &[Scale::Iterations(50), Scale::Sigma(6.0), Scale::Sigma(20.0)],
        Extent::Quick => &[Scale::Sigma(6.0)],
    };
    let sweep = |scene: &Scene| {
        let closed_form = |x: usize, y: usize, time: f64| scene.exact_trace(x, y, time);
        let subject = solver::Subject {
            name: scene.name.into(),
            about: scene.about.into(),
            frame: &scene.frame,
            shape: shape_of(scene, shape.tolerance),
            closed_form: Some(&closed_form),
            gpu,
        };
        solver::sweep(&subject, scales, effort, machine, progress)
    };
    scenes.iter().map(sweep).collect()
}

fn stages(
    frame: &Frame,
    shape: ShapeParams,
    effort: Effort,
    machine: &Machine,
) -> Result<Vec<StageRow>> {
    let plan = timing::plan(Goal::Layers, frame, shape)?;
    let (_, measured) = timing::measure(&plan, frame, effort);
    let (pixels, covered) = (frame.mask.width() * frame.mask.height(), frame.mask.count());
    let row = |(stage, times): (&'static str, Times)| StageRow {
        stage,
        times,
        megapixels_per_second: times.megapixels_per_second(pixels),
        utilisation: work::of_stage(stage, &shape, &plan.sweeps)
            .map(|work| Utilisation::of(work, covered, times, machine)),
    };
    let all = ("all", measured.whole);
    // With one scale the stage of further ones does nothing, in no time.
    let at_work =
        |(stage, _): &(&'static str, Times)| *stage != "more-scales" || !plan.more_px.is_empty();
    let stages = measured.stages.into_iter().filter(at_work);
    Ok(stages.chain([all]).map(row).collect())
}
