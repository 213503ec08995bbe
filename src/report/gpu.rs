//! A device compared with the CPU: its times, with copies to and from it separate, its errors, and the differences of
//! its products from the CPU's.

use super::engine::{
    Inputs, KERNELS, Outcome, Product, READ_BACK, RECORD, Session, UPLOAD, hatch_plan, relight_plan,
};
use super::timing::{self, Effort, Timed, Times};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame};
use crate::light::lights::{DirectionalLight, Illumination};
use crate::params::{LineParams, Material, Method, RelightParams, ShapeParams};
use crate::plan::{Available, Goal, Plan};
use serde::Serialize;
use std::cell::RefCell;
use std::time::{Duration, Instant};

/// Pixels times sweeps above which a setting that was not requested is skipped on software devices: a third of a
/// second.
const MOST_UPDATES_IN_SOFTWARE: usize = 4_000_000;

/// Goals whose products are compared, besides relit pictures and drawings.
const GOALS: [Goal; 3] = [Goal::Layers, Goal::Display, Goal::Enhance];

/// The light for comparing relit pictures.
pub(crate) fn lamp() -> Illumination {
    Illumination {
        directional: vec![DirectionalLight::white([120.0, 40.0])],
        ..Illumination::default()
    }
}

/// The device measured by a report.
#[allow(
    dead_code,
    reason = "a build without devices measures none, and one with them knows of them"
)]
pub(crate) enum Device<'a> {
    /// Built without device support.
    Unknown,
    /// Why there are no measurements.
    NotMeasured(String),
    /// Measured.
    Measured(Gpu<'a>),
}

/// Runs a plan, with these lights if it relights.
pub(crate) type Run<'a> = &'a (dyn Fn(&Plan, &Frame, &Illumination) -> Result<Outcome> + 'a);

/// A device to measure.
pub(crate) struct Gpu<'a> {
    pub name: String,
    pub is_software: bool,
    /// Whether its failure fails the report; otherwise it is left out.
    pub is_required: bool,
    run: Run<'a>,
    failed: RefCell<Option<Error>>,
}

/// Times of a plan over several runs on a device.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct GpuTimed {
    #[serde(flatten)]
    pub parts: GpuParts,
    /// Total time, including the recording of commands.
    pub whole: Times,
}

/// Times of the parts of a run.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct GpuParts {
    /// Copies to the device.
    pub upload: Times,
    /// Its kernels by stage, in order; all together on a device without a clock per stage.
    pub stages: Vec<StageTimes>,
    /// All kernels.
    pub compute: Times,
    /// Copies from the device.
    pub read_back: Times,
}

/// The time of a stage.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct StageTimes {
    pub stage: &'static str,
    pub times: Times,
}

/// Difference of the products of one kind from the CPU's.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct ProductRow {
    pub product: Product,
    /// The largest difference, relative to the largest value of its plane.
    pub difference: f64,
    pub frame: String,
    pub tolerance: f64,
    pub is_within: bool,
}

impl<'a> Gpu<'a> {
    /// A device of this name, with `run` to run plans; an outcome's timings are named as in
    /// [`crate::engine::device_times`].
    #[cfg_attr(
        not(feature = "gpu"),
        allow(dead_code, reason = "a build without devices measures none")
    )]
    pub(crate) fn new(name: String, is_software: bool, is_required: bool, run: Run<'a>) -> Self {
        Self {
            name,
            is_software,
            is_required,
            run,
            failed: RefCell::new(None),
        }
    }

    /// Whether `plan`, which was not requested, is short enough.
    pub(crate) fn can_afford(&self, plan: &Plan, frame: &Frame) -> bool {
        let updates = plan.sweeps.count() * frame.mask.count();
        !self.is_software || updates <= MOST_UPDATES_IN_SOFTWARE
    }

    /// Runs `plan`; `None` once the device has failed.
    pub(crate) fn run(&self, plan: &Plan, frame: &Frame, light: &Illumination) -> Option<Outcome> {
        if self.failed.borrow().is_some() {
            return None;
        }
        let ran = (self.run)(plan, frame, light);
        ran.map_err(|error| *self.failed.borrow_mut() = Some(error))
            .ok()
    }

    /// Runs `plan` once to warm up, then the number of times given by `effort`.
    pub(crate) fn measure(
        &self,
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
        effort: Effort,
    ) -> Option<GpuTimed> {
        self.run(plan, frame, light)?;
        let mut runs = Vec::new();
        let start = Instant::now();
        while runs.len() < 2 || runs.len() < effort.runs && start.elapsed() < effort.limit {
            runs.push(self.run(plan, frame, light)?.timings);
        }
        // A run in strips, after running out of memory, differs from the others.
        let names = |run: &timing::Timings| run.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        let usual = names(&runs[runs.len() - 1]);
        runs.retain(|run| names(run) == usual);
        Some(GpuTimed::of(&runs))
    }

    /// Differences of the products of frames from the CPU's: the largest of each kind.
    pub(crate) fn products(
        &self,
        frames: &[(&str, &Frame, ShapeParams)],
    ) -> Result<Vec<ProductRow>> {
        let mut rows: Vec<ProductRow> = Vec::new();
        for (name, frame, shape) in frames {
            let frame = with_picture(frame);
            for plan in plans(&frame, *shape)? {
                let Some(found) = self.run(&plan, &frame, &lamp()) else {
                    return Ok(rows);
                };
                let expected = run_on_cpu(&plan, &frame);
                for (product, apart) in differences(&plan, &found, &expected) {
                    add(&mut rows, product, apart, name);
                }
            }
        }
        Ok(rows)
    }

    /// The reason of its failure, if it failed.
    ///
    /// # Errors
    /// The failure, if the device is required.
    pub(crate) fn failure(&self) -> Result<Option<String>> {
        match self.failed.take() {
            Some(error) if self.is_required => Err(error),
            failed => Ok(failed.map(|error| error.to_string())),
        }
    }
}

impl GpuTimed {
    fn of(runs: &[timing::Timings]) -> Self {
        let Timed { stages, whole } = Timed::of(runs);
        let is_kernel = |stage: &str| ![UPLOAD, RECORD, READ_BACK].contains(&stage);
        let time_of = |name: &str| {
            let found = stages.iter().find(|(stage, _)| *stage == name);
            found.map_or_else(|| Times::of(vec![0.0]), |(_, times)| *times)
        };
        let of_kernels = |run: &timing::Timings| -> Duration {
            let kernels = run.iter().filter(|(stage, _)| is_kernel(stage));
            kernels.map(|(_, time)| *time).sum()
        };
        let computed = runs.iter().map(|run| of_kernels(run).as_secs_f64());
        Self {
            parts: GpuParts {
                upload: time_of(UPLOAD),
                read_back: time_of(READ_BACK),
                compute: Times::of(computed.collect()),
                stages: stages
                    .iter()
                    .filter(|(stage, _)| is_kernel(stage))
                    .map(|&(stage, times)| StageTimes { stage, times })
                    .collect(),
            },
            whole,
        }
    }
}

impl GpuParts {
    /// Whether the device has a clock for each stage.
    pub(crate) fn has_clock(&self) -> bool {
        !self.stages.iter().any(|stage| stage.stage == KERNELS)
    }

    /// The time of the diffusion; of all kernels on a device without a clock per stage.
    pub(crate) fn diffusion(&self) -> Times {
        let mut stages = self.stages.iter();
        let diffusion = stages.find(|stage| stage.stage == "diffusion");
        diffusion.map_or(self.compute, |stage| stage.times)
    }
}

/// The frame with a picture for enhancement: lit from the eye, in three colours.
pub(super) fn with_picture(frame: &Frame) -> Frame {
    let lit = |share: f32| frame.normal.z.map(|z| share * z.max(0.0));
    Frame {
        color: Some(ColorPlanes {
            r: lit(0.8),
            g: lit(0.7),
            b: lit(0.5),
        }),
        ..frame.clone()
    }
}

/// The plans whose products are compared.
fn plans(frame: &Frame, shape: ShapeParams) -> Result<Vec<Plan>> {
    let mut relight = RelightParams {
        method: Method::Both,
        ..RelightParams::default()
    };
    relight.material.material = Material::BlinnPhong;
    let shapes = GOALS.map(|goal| timing::plan(goal, frame, shape));
    let mut plans = shapes.into_iter().collect::<Result<Vec<_>>>()?;
    plans.push(relight_plan(frame, shape, relight, &lamp())?);
    plans.push(hatch_plan(
        Available::in_frame(frame),
        shape,
        LineParams::default(),
    )?);
    Ok(plans)
}

fn run_on_cpu(plan: &Plan, frame: &Frame) -> Outcome {
    Session::default().run(plan, frame, Inputs::lit_by(&lamp()))
}

/// Differences of the products of `plan` computed by both backends; infinite if one is missing.
fn differences(
    plan: &Plan,
    found: &Outcome,
    expected: &Outcome,
) -> impl Iterator<Item = (Product, f64)> {
    let (is_drawn, of_layers) = (plan.drawing.is_some(), plan.wants(Product::MappedCurvature));
    let is_meant = move |product: &Product| match product {
        Product::Strokes | Product::Contours | Product::Interior => is_drawn,
        Product::Picture => !is_drawn && !of_layers,
        _ => of_layers,
    };
    let kinds = Product::all().filter(is_meant);
    kinds.filter_map(move |product| {
        let [found, expected] = [found, expected].map(|outcome| {
            let all = outcome.products();
            all.filter(|(kind, _)| *kind == product).collect::<Vec<_>>()
        });
        if found.len() != expected.len() {
            return Some((product, f64::INFINITY));
        }
        let pairs = found.into_iter().zip(expected);
        let apart = pairs.map(|((_, found), (_, expected))| product.difference(&found, &expected));
        Some((product, apart.reduce(f64::max)?))
    })
}

fn add(rows: &mut Vec<ProductRow>, product: Product, apart: f64, frame: &str) {
    let tolerance = product.tolerance();
    let new = ProductRow {
        product,
        difference: apart,
        frame: frame.into(),
        tolerance,
        is_within: apart <= tolerance,
    };
    match rows.iter_mut().find(|row| row.product == product) {
        Some(row) if row.difference < apart => *row = new,
        Some(_) => {}
        None => rows.push(new),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scenes::Scene;
    use std::cell::Cell;

    fn ms(time: u64) -> Duration {
        Duration::from_millis(time)
    }

    /// Runs plans on the CPU, with times named like those of a device.
    fn device(plan: &Plan, frame: &Frame, _: &Illumination) -> Result<Outcome> {
        let mut outcome = run_on_cpu(plan, frame);
        let times = [
            (UPLOAD, 1),
            (RECORD, 2),
            ("diffusion", 4),
            ("trace", 8),
            (READ_BACK, 16),
        ];
        outcome.timings = times.map(|(name, time)| (name, ms(time))).into();
        Ok(outcome)
    }

    fn frame() -> Frame {
        Scene::waves(40, 30).frame
    }

    #[test]
    fn kernels_are_timed_apart_from_copies() {
        let gpu = Gpu::new("test".into(), true, true, &device);
        let frame = frame();
        let plan = timing::plan(Goal::Display, &frame, ShapeParams::default()).unwrap();
        let timed = gpu
            .measure(&plan, &frame, &lamp(), Effort::new(3, 1000))
            .unwrap();
        let parts = &timed.parts;
        let least = [parts.upload, parts.compute, parts.read_back, timed.whole].map(|t| t.min);
        for (found, expected) in least.into_iter().zip([0.001, 0.012, 0.016, 0.031]) {
            assert!((found - expected).abs() < 1e-9, "{least:?}");
        }
        assert_eq!(timed.whole.runs, 3);
        assert_eq!(timed.parts.diffusion().min, 0.004);
        let names: Vec<_> = parts.stages.iter().map(|stage| stage.stage).collect();
        assert_eq!(names, ["diffusion", "trace"]);
    }

    #[test]
    fn every_product_is_compared_and_differences_show() {
        let frame = frame();
        let frames = [("waves", &frame, ShapeParams::default())];
        let same = Gpu::new("test".into(), true, true, &device);
        let rows = same.products(&frames).unwrap();
        // The trace is only intermediate: a run that ends in layers has the Hessian.
        let made = Product::all().filter(|product| !product.row().on_request);
        assert_eq!(rows.len(), made.count() - 1);
        assert!(
            rows.iter()
                .all(|row| row.is_within && row.difference == 0.0)
        );
        let off = |plan: &Plan, frame: &Frame, _: &Illumination| {
            let mut outcome = run_on_cpu(plan, frame);
            if let Some(gradient) = &mut outcome.shape.gradient {
                gradient.y.row_mut(7)[9] += 0.5;
            }
            outcome.shape.hessian = None;
            Ok(outcome)
        };
        let rows = Gpu::new("test".into(), true, true, &off)
            .products(&frames)
            .unwrap();
        let outside: Vec<_> = rows.iter().filter(|row| !row.is_within).collect();
        let kinds: Vec<_> = outside.iter().map(|row| row.product).collect();
        assert_eq!(kinds, [Product::Gradient, Product::Hessian]);
        assert!(outside[0].difference > 0.1 && outside[1].difference.is_infinite());
    }

    #[test]
    fn a_device_that_fails_runs_no_more() {
        for is_required in [false, true] {
            let asked = Cell::new(0);
            let fails = |plan: &Plan, frame: &Frame, light: &Illumination| {
                asked.set(asked.get() + 1);
                match asked.get() {
                    1 => device(plan, frame, light),
                    _ => Err(Error::Gpu {
                        device: "test".into(),
                        found: "was lost".into(),
                    }),
                }
            };
            let gpu = Gpu::new("test".into(), true, is_required, &fails);
            let frame = frame();
            let plan = timing::plan(Goal::Display, &frame, ShapeParams::default()).unwrap();
            assert!(
                gpu.measure(&plan, &frame, &lamp(), Effort::new(3, 1000))
                    .is_none()
            );
            let frames = [("waves", &frame, ShapeParams::default())];
            assert!(gpu.products(&frames).unwrap().is_empty());
            assert_eq!(asked.get(), 2);
            match gpu.failure() {
                Ok(Some(why)) => assert!(!is_required && why.contains("lost")),
                Err(error) => assert!(is_required, "{error}"),
                other => panic!("{other:?}"),
            }
        }
    }
}
