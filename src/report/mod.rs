//! Error against run time of each setting, on a frame and on exact scenes.
//!
//! Everything is measured against a reference in double precision (`reference.rs`); that of the frame's shape starts
//! from the samples in its files (`surface.rs`). Errors of slopes and of their derivatives are relative to the largest
//! |g| before diffusion; times are of the stages, without reading and writing files.

#![cfg_attr(
    not(feature = "cli"),
    allow(
        dead_code,
        reason = "scenes are for anyone, reports for the command line"
    )
)]

pub(crate) mod advice;
pub(crate) mod answers;
mod asked;
pub mod coherence;
pub(crate) mod compare;
mod drawing;
mod engine;
mod exact_gaps;
pub(crate) mod html;
pub(crate) mod light;
pub mod light_reference;
mod machine;
pub(crate) mod markdown;
mod mirrors;
mod numbers;
pub(crate) mod pareto;
pub(crate) mod plots;
mod reference;
mod relief;
pub mod scenes;
pub(crate) mod stability;
pub(crate) mod surface;
pub(crate) mod sweeps;
pub mod timing;
mod weight;
pub(crate) mod work;

pub(crate) use self::asked::{Asked, Extent};
use crate::Result;
use crate::params::{Scale, ShapeParams};
use crate::plan::{Decision, Goal};
use machine::Machine;
use scenes::Scene;
use serde::Serialize;
use stability::CaseResult;
use surface::Surface;
use sweeps::solver::{SceneSweep, Subject};
use sweeps::{directions, precision, rim, run, solver};
use timing::{Times, Utilisation};

/// A stage of the full descriptor.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct StageRow {
    pub stage: &'static str,
    pub times: Times,
    pub megapixels_per_second: f64,
    pub utilisation: Option<Utilisation>,
}

/// All measurements; what goes beyond the frame is there if it was asked for.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Report {
    pub version: &'static str,
    /// Whether this is an optimised build; times of others mean little.
    pub optimised: bool,
    pub machine: Machine,
    /// The given shape parameters.
    pub shape: ShapeParams,
    /// What the first page says about the frame.
    pub answers: answers::Answers,
    /// Stages of a curvature picture, kept or dropped, and why.
    pub decisions: Vec<Decision>,
    /// Stages of the full descriptor on the frame.
    pub stages: Vec<StageRow>,
    /// Solvers and tolerances on the frame.
    pub frame: SceneSweep,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub scenes: Vec<SceneSweep>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<run::RunRow>,
    pub precision: Vec<precision::PrecisionRow>,
    /// Step and rounding for the surface's own directions, on an ellipsoid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directions: Option<directions::Sweep>,
    /// Foreshortening and the floor of n_z on a ball.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rim_of_ball: Vec<rim::BallRow>,
    /// The same on the frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rim_of_frame: Vec<rim::FrameRow>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<light::LightReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawing: Option<drawing::DrawingReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirrors: Option<mirrors::MirrorReport>,
    /// Height and occlusion.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relief: Option<relief::ReliefReport>,
    /// Drawings of a sequence, if the report covers one; not set by [`run`].
    pub coherence: Option<coherence::Coherence>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stability: Vec<CaseResult>,
}

/// Measures everything on the frame and on exact scenes.
///
/// # Errors
/// [`crate::Error::BadParameter`] for a parameter outside its range.
pub(crate) fn run(asked: Asked) -> Result<Report> {
    let Asked {
        frame,
        shape,
        extent,
        beyond,
        progress,
        ..
    } = asked;
    shape.validate()?;
    progress("the machine's bandwidth and arithmetic");
    let machine = Machine::measured();
    progress("stages");
    let decisions = timing::plan(Goal::Display, frame, shape)?
        .decisions()
        .to_vec();
    let stages = stages(&asked, &machine)?;
    let (swept, scenes) = sweeps(&asked, &machine)?;
    let precision = precision(&asked)?;
    asked.progress("what there is to warn of");
    let answers = answers::of(&asked, &swept)?;
    let runs = match beyond {
        true => runs(&asked)?,
        false => Vec::new(),
    };
    let directions = beyond.then(|| {
        progress("ellipsoid: directions");
        let (width, height) = scene_size(extent);
        directions::sweep(&Scene::ellipsoid(width, height), asked.effort())
    });
    let (rim_of_ball, rim_of_frame) = match beyond {
        true => {
            asked.progress("foreshortening and min_nz");
            (rim::on_ball()?, rim::on_frame(frame, &shape)?)
        }
        false => Default::default(),
    };
    let light = beyond.then(|| light::run(&asked)).transpose()?;
    let drawing = beyond.then(|| drawing::run(&asked)).transpose()?;
    let mirrors = beyond.then(|| mirrors::run(extent, progress)).transpose()?;
    let relief = beyond.then(|| {
        progress("height and occlusion");
        relief::run(extent)
    });
    let stability = match beyond {
        true => {
            progress("stiff and extreme cases");
            stability::all().iter().map(stability::Case::run).collect()
        }
        false => Vec::new(),
    };
    Ok(Report {
        version: env!("CARGO_PKG_VERSION"),
        optimised: !cfg!(debug_assertions),
        machine,
        shape,
        answers,
        decisions,
        stages,
        frame: swept,
        scenes,
        runs,
        precision,
        directions: directions.transpose()?,
        rim_of_ball,
        rim_of_frame,
        light,
        drawing,
        mirrors,
        relief,
        coherence: None,
        stability,
    })
}

/// Solvers and tolerances on the frame and on exact scenes.
fn sweeps(asked: &Asked, machine: &Machine) -> Result<(SceneSweep, Vec<SceneSweep>)> {
    let effort = asked.effort();
    let sweep = |subject: &Subject, scales: &[Scale]| {
        solver::sweep(subject, scales, effort, machine, asked.progress)
    };
    let subject = Subject {
        name: asked.name,
        about: "the frame",
        frame: asked.frame,
        surface: asked.surface,
        shape: asked.shape,
        closed_form: None,
    };
    let frame = sweep(&subject, &frame_scales(asked.shape.scale, asked.extent))?;
    let (width, height) = scene_size(asked.extent);
    let all = match asked.beyond {
        true => Scene::all(width, height),
        false => Vec::new(),
    };
    let mut scenes = Vec::new();
    for scene in &all {
        let closed_form = |x: usize, y: usize, time: f64| scene.exact_trace(x, y, time);
        let subject = Subject {
            name: scene.name,
            about: scene.about,
            frame: &scene.frame,
            surface: &Surface::of(&scene.frame),
            shape: scene.shape(asked.shape.tolerance),
            closed_form: Some(&closed_form),
        };
        scenes.push(sweep(&subject, scene_scales(asked.extent))?);
    }
    Ok((frame, scenes))
}

fn runs(asked: &Asked) -> Result<Vec<run::RunRow>> {
    let (frame, shape, effort) = (asked.frame, asked.shape, asked.effort());
    asked.progress("threads");
    let mut rows = run::threads(frame, shape, effort)?;
    asked.progress("tiles and sweeps per pass");
    let scales = frame_scales(shape.scale, asked.extent);
    rows.extend(run::tiles_and_passes(frame, shape, &scales, effort)?);
    Ok(rows)
}

fn precision(asked: &Asked) -> Result<Vec<precision::PrecisionRow>> {
    asked.progress("half and byte input");
    let mut rows = precision::sweep(asked.name, asked.frame, asked.surface, asked.shape)?;
    if !asked.beyond {
        return Ok(rows);
    }
    let (width, height) = scene_size(asked.extent);
    let shape = ShapeParams {
        foreshortening: 0.0,
        ..asked.shape
    };
    let ball = Scene::ball(width, height);
    rows.extend(precision::sweep(
        ball.name,
        &ball.frame,
        &Surface::of(&ball.frame),
        shape,
    )?);
    Ok(rows)
}

fn scene_size(extent: Extent) -> (usize, usize) {
    match extent {
        Extent::Full => (480, 360),
        Extent::Quick => (320, 240),
    }
}

/// The given scale first.
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

fn scene_scales(extent: Extent) -> &'static [Scale] {
    match extent {
        Extent::Full => &[Scale::Iterations(50), Scale::Sigma(6.0), Scale::Sigma(20.0)],
        Extent::Quick => &[Scale::Sigma(6.0)],
    }
}

fn stages(asked: &Asked, machine: &Machine) -> Result<Vec<StageRow>> {
    let (frame, shape) = (asked.frame, asked.shape);
    let plan = timing::plan(Goal::Layers, frame, shape)?;
    let (_, measured) = timing::measure(&plan, frame, asked.effort());
    let (pixels, covered) = (frame.mask.width() * frame.mask.height(), frame.mask.count());
    let row = |(stage, times): (&'static str, Times)| StageRow {
        stage,
        times,
        megapixels_per_second: times.megapixels_per_second(pixels),
        utilisation: work::of_stage(stage, &shape, &plan.sweeps)
            .map(|work| Utilisation::of(work, covered, times, machine)),
    };
    let all = ("all", measured.whole);
    // With one scale the stage for further ones takes no time.
    let at_work =
        |(stage, _): &(&'static str, Times)| *stage != "more-scales" || !plan.more_px.is_empty();
    let stages = measured.stages.into_iter().filter(at_work);
    Ok(stages.chain([all]).map(row).collect())
}
