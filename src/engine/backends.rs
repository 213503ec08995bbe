//! The engine: runs plans on the CPU, or on a GPU that was requested or found.

use crate::engine::cpu;
#[cfg(feature = "cli")]
use crate::engine::cpu::row_layers::RowLayers;
use crate::engine::cpu::runner::RunFrame;
#[cfg(feature = "gpu")]
use crate::engine::gpu;
#[cfg(feature = "gpu")]
use crate::engine::gpu::{AdapterKind, Device};
use crate::engine::inputs::PlanInputs;
use crate::engine::part::FramePart;
use crate::engine::request::Request;
use crate::engine::run::Run;
use crate::error::{Error, Result};
use crate::frame::{Frame, Vector2Planes};
#[cfg(feature = "gpu")]
use crate::gpu::fault::RunFault;
use crate::params::{LineParams, RunOptions};
use crate::plan::outcome::Outcome;
#[cfg(feature = "gpu")]
use crate::plan::stage::Stage;
use crate::plan::{Available, Plan};
use crate::product::Product;
use std::borrow::Cow;

/// Runs requests and plans on the backends of this machine, one at a time. Memory of outcomes returned by
/// [`recycle`](Engine::recycle) is reused; the last prepared environment and the last stroke texture are cached.
#[derive(Debug, Default)]
pub struct Engine {
    cpu: cpu::Runner,
    #[cfg(feature = "gpu")]
    device: OnDevice,
}

/// Name of device work in [`Progress`](crate::engine::Progress).
#[cfg(feature = "gpu")]
const DEVICE: &str = "device";

/// Use of a device.
#[cfg(feature = "gpu")]
#[derive(Debug)]
enum OnDevice {
    /// None; with the reason, if one was looked for.
    No(Option<Error>),
    /// Chosen automatically: the CPU takes over if it fails.
    Maybe(gpu::DeviceRunner),
    /// Asked for: its failure is an error.
    Only(gpu::DeviceRunner),
}

impl Engine {
    /// CPU only.
    pub fn cpu() -> Self {
        Self::default()
    }

    /// A hardware GPU, if there is one and the crate was built with the feature `gpu`; the CPU if the device fails. As on
    /// [`Engine::gpu`], the CPU also runs what the device cannot.
    pub fn auto() -> Self {
        Self {
            cpu: cpu::Runner::default(),
            #[cfg(feature = "gpu")]
            device: match Device::open(AdapterKind::Hardware) {
                Ok(device) => OnDevice::Maybe(gpu::DeviceRunner::new(device)),
                Err(why) => OnDevice::No(Some(why)),
            },
        }
    }

    /// Any device, software included. Plans that it has no kernels for, and frames that it cannot hold, are run by the
    /// CPU, with a line to [`Run::warn`]; so are the stages without kernels of the others.
    ///
    /// # Errors
    /// [`Error::NoGpu`] if there is none, and in a build without the feature `gpu`.
    #[cfg(feature = "gpu")]
    pub fn gpu() -> Result<Self> {
        Device::open(AdapterKind::Any).map(Self::on)
    }

    /// As [`Engine::gpu`], with the given device.
    #[cfg(feature = "gpu")]
    pub fn on(device: Device) -> Self {
        Self {
            cpu: cpu::Runner::default(),
            device: OnDevice::Only(gpu::DeviceRunner::new(device)),
        }
    }

    /// Any device, software included.
    ///
    /// # Errors
    /// [`Error::NoGpu`] if there is none, and in a build without the feature `gpu`.
    #[cfg(not(feature = "gpu"))]
    pub fn gpu() -> Result<Self> {
        Err(Error::NoGpu {
            found: "this program was built without it".into(),
            remedy: "build it with --features gpu, or use --backend cpu",
        })
    }

    /// Whether it has a device to run on.
    #[cfg(feature = "cli")]
    pub(crate) fn has_device(&self) -> bool {
        #[cfg(feature = "gpu")]
        return !matches!(self.device, OnDevice::No(_));
        #[cfg(not(feature = "gpu"))]
        false
    }

    /// Adds the CPU as fallback for a device that fails.
    #[must_use]
    pub fn or_cpu(self) -> Self {
        #[cfg(feature = "gpu")]
        if let OnDevice::Only(gpu) = self.device {
            return Self {
                device: OnDevice::Maybe(gpu),
                ..self
            };
        }
        self
    }

    /// Sets options of the CPU: they change run time, never a bit of the result.
    #[must_use]
    pub fn with_options(mut self, options: RunOptions) -> Self {
        self.cpu.options = options;
        self
    }

    /// Runs `request` on `frame`.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a parameter outside its range, [`Error::Unfit`] for a picture that the frame lacks, and
    /// those of [`Engine::execute`].
    pub fn run(&self, request: &Request, frame: &Frame, run: &Run) -> Result<Outcome> {
        let times = request.times(frame)?;
        let given = request.inputs.specular;
        let scene = given.filter(|_| times != 1.0);
        let scene = scene.map(|scene| run.install(|| scene.enlarged(frame, times)));
        let frame = match times == 1.0 {
            true => Cow::Borrowed(frame),
            false => Cow::Owned(run.enlarged(frame, times)?),
        };
        let available = Available::in_frame(&frame);
        let plan = request.clone().fitted(&frame, times).plan(available)?;
        let light = request.light(available);
        let inputs = PlanInputs {
            illumination: Some(&light),
            specular: scene.as_ref().or(given),
            ..request.inputs
        };
        let frame = RunFrame::Shared(&frame);
        self.execute_to(&plan, frame, inputs, run, |frame, outcome| {
            outcome.complete(&plan, frame, times, &request.params);
        })
    }

    /// Runs `plan` on `frame`.
    ///
    /// # Errors
    /// [`Error::Unfit`] if the plan was made for other inputs; [`Error::Cancelled`]; and errors of a device that fails,
    /// where the CPU is not its fallback.
    pub fn execute(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        run: &Run,
    ) -> Result<Outcome> {
        self.execute_to(plan, RunFrame::Shared(frame), inputs, run, |_, _| ())
    }

    /// As [`Engine::execute`], with what is done to the outcome of the part of the frame that is run.
    fn execute_to(
        &self,
        plan: &Plan,
        mut held: RunFrame,
        inputs: PlanInputs,
        run: &Run,
        complete: impl FnOnce(&Frame, &mut Outcome),
    ) -> Result<Outcome> {
        let frame = held.get();
        let window = run.region.unwrap_or(frame.data_window);
        run.begin([window.height(), window.width()])?;
        // A tile is run with as much of its repetition around it as the plan reaches.
        let tile = frame.is_tile().then_some(frame.data_window);
        let Some(region) = run.region.or(tile) else {
            let mut outcome = run.install(|| match run.max_memory {
                Some(most) => self.execute_in_strips(plan, held.get(), inputs, run, most),
                None => self.execute_here(plan, held.again(), inputs, run),
            })?;
            complete(held.get(), &mut outcome);
            run.finish(held.get(), &outcome)?;
            return Ok(outcome);
        };
        let part = FramePart::around(region, plan, frame, inputs)?;
        let inputs = part.inputs(inputs);
        let mut outcome = run.install(|| {
            self.execute_here(&part.plan, RunFrame::Shared(&part.frame), inputs, run)
        })?;
        outcome.crop(part.frame.data_window, region);
        let frame = frame.crop(region);
        complete(&frame, &mut outcome);
        run.finish(&frame, &outcome)?;
        Ok(outcome)
    }

    /// Runs the whole frame on the caller's threads.
    pub(super) fn execute_here(
        &self,
        plan: &Plan,
        frame: RunFrame,
        inputs: PlanInputs,
        run: &Run,
    ) -> Result<Outcome> {
        match self.on_device(plan, frame.get(), inputs, run)? {
            Some(outcome) => Ok(outcome),
            None => self
                .cpu
                .execute_watched(plan, frame, inputs, run.watch(), None),
        }
    }

    /// As [`Engine::execute`], bit for bit, with less memory where the CPU does it. For a picture or a drawing the outcome
    /// lacks the shape, that of a drawing also the picture of its tone, and the frame loses planes that no stage reads any
    /// more: all but the mask and the planes of settings, of light, and of the picture where none is drawn.
    ///
    /// # Errors
    /// As [`Engine::execute`].
    pub fn execute_sparingly(
        &self,
        plan: &Plan,
        frame: &mut Frame,
        inputs: PlanInputs,
        run: &Run,
    ) -> Result<Outcome> {
        self.execute_to(plan, RunFrame::Own(frame), inputs, run, |_, _| ())
    }

    /// The result of the device; `None` if the CPU must run the plan. A lost device is reported once.
    ///
    /// # Errors
    /// If the device fails and there is no fallback.
    #[cfg(feature = "gpu")]
    pub(crate) fn on_device(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        run: &Run,
    ) -> Result<Option<Outcome>> {
        run.watch().check()?;
        let (gpu, is_required) = match &self.device {
            OnDevice::Only(gpu) => (gpu, true),
            OnDevice::Maybe(gpu) => (gpu, false),
            OnDevice::No(Some(why)) => {
                run.warning(&format!("{why}; the CPU does it"));
                return Ok(None);
            }
            OnDevice::No(None) => return Ok(None),
        };
        if let Some(what) = gpu::DeviceRunner::lacks(plan) {
            if is_required {
                run.warning(&format!(
                    "the GPU has no kernels for {what}; the CPU does it"
                ));
            }
            return Ok(None);
        }
        if gpu.device().is_lost() && !is_required {
            return Ok(None);
        }
        run.watch().begins(DEVICE, 0.0);
        match gpu.attempt(plan, frame, inputs, run.watch()) {
            Ok(outcome) => {
                if is_required {
                    say_left_to_cpu(plan, run);
                }
                Ok(Some(outcome))
            }
            Err(RunFault::TooLarge(error)) => {
                run.warning(&format!("{error}: the CPU did it"));
                Ok(None)
            }
            // The CPU would fail with the same error.
            Err(RunFault::Other(error @ (Error::Unfit { .. } | Error::Cancelled))) => Err(error),
            Err(RunFault::Other(error)) if is_required => Err(error),
            Err(RunFault::Other(error)) => {
                let how_long = match gpu.device().is_lost() {
                    true => "the CPU does it from here on",
                    false => "the CPU did it",
                };
                run.warning(&format!("{error}: {how_long}"));
                Ok(None)
            }
        }
    }

    /// Without the feature `gpu` nothing runs on a device.
    #[cfg(not(feature = "gpu"))]
    pub(crate) fn on_device(
        &self,
        _: &Plan,
        _: &Frame,
        _: PlanInputs,
        _: &Run,
    ) -> Result<Option<Outcome>> {
        Ok(None)
    }

    /// Directions that strokes follow with `params`, computed on the CPU, one field for each of
    /// [`StrokeDirections`](crate::params::StrokeDirections): unit vectors in the picture, x right, y up, opposite
    /// directions being equal; 0 outside the mask. Where `plan` traces mirrors and lenses, the directions of the
    /// reflected or refracted surface.
    ///
    /// # Errors
    /// [`Error::Unfit`] if the plan finds no edges, at which strokes stop, or traces mirrors without a scene.
    pub fn stroke_fields(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        params: &LineParams,
    ) -> Result<Vec<Vector2Planes>> {
        if !plan.wants(Product::Conductance) {
            return Err(Error::Unfit {
                found: "the plan finds no edges, at which strokes stop".into(),
                remedy: "make it for layers or for a drawing",
            });
        }
        if plan.specular.is_some() && inputs.specular.is_none() {
            return Err(Error::Unfit {
                found: "the plan traces mirrors and lenses, and no scene is given".into(),
                remedy: "give what they show with the inputs",
            });
        }
        Ok(self.cpu.stroke_fields(plan, frame, inputs, params))
    }

    /// The runner of the CPU.
    pub(crate) fn cpu_runner(&self) -> &cpu::Runner {
        &self.cpu
    }

    /// Drops the prepared environment, so that benchmarks measure its preparation again.
    pub fn forget_environment(&self) {
        self.cpu.forget_environment();
    }

    /// Reclaims the memory of an outcome.
    pub fn recycle(&self, outcome: Outcome) {
        self.cpu.recycle(outcome);
    }
}

#[cfg(feature = "cli")]
impl Engine {
    /// As [`Engine::execute`], with stages left where the CPU does it: they run on rows, while these are written.
    ///
    /// # Errors
    /// As [`Engine::execute`].
    pub(crate) fn execute_for_rows<'a>(
        &'a self,
        plan: &'a Plan,
        frame: &Frame,
        inputs: PlanInputs,
        run: &Run,
    ) -> Result<RowLayers<'a>> {
        let whole = |outcome| RowLayers::whole(&self.cpu, plan, outcome);
        if frame.is_tile() {
            return self.execute(plan, frame, inputs, run).map(whole);
        }
        run.begin([frame.mask.height(), frame.mask.width()])?;
        run.install(|| match self.on_device(plan, frame, inputs, run)? {
            Some(outcome) => Ok(whole(outcome)),
            None => self.cpu.execute_for_rows(plan, frame, inputs, run.watch()),
        })
    }

    /// Frees the memory kept for further runs, as before the last result is written.
    pub(crate) fn release_spare_memory(&self) {
        self.cpu.memory.release();
    }
}

#[cfg(feature = "gpu")]
impl Default for OnDevice {
    fn default() -> Self {
        Self::No(None)
    }
}

/// Says which stages the CPU runs beside the device.
#[cfg(feature = "gpu")]
fn say_left_to_cpu(plan: &Plan, run: &Run) {
    let is_kept = |stage: &&&Stage| stage.steps.iter().any(|step| plan.runs(step.name));
    let left = gpu::DeviceRunner::left_to_cpu(plan);
    let names: Vec<_> = left
        .iter()
        .filter(is_kept)
        .map(|stage| stage.name)
        .collect();
    if !names.is_empty() {
        run.warning(&format!(
            "on the CPU, without kernels: {}",
            names.join(", ")
        ));
    }
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::frame::{ColorPlanes, LightGroup, Plane};
    use crate::kernel::cancel::CancelToken;
    use crate::params::{LineParams, ScalingParams, ShapeParams, Style};
    use crate::plan::watch::Progress;
    use crate::plan::{Available, Goal, Tone};
    use crate::scenes::Scene;
    use glam::Vec3;
    use std::sync::Mutex;

    /// A lost device, for tests; `None` on machines without a device.
    fn lost() -> Option<gpu::DeviceRunner> {
        let device = gpu::to_test_on(Device::open(AdapterKind::Any))?;
        device.lose();
        Some(gpu::DeviceRunner::new(device))
    }

    fn engine(device: OnDevice) -> Engine {
        Engine {
            cpu: cpu::Runner::default(),
            device,
        }
    }

    fn waves() -> (Plan, Frame) {
        let frame = Scene::waves(60, 50).frame;
        let available = Available::in_frame(&frame);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = Plan::new(Goal::Display, available, shape, scaling).unwrap();
        (plan, frame)
    }

    #[test]
    fn where_a_device_was_chosen_its_loss_is_said_once_and_the_picture_is_the_same() {
        let Some(gpu) = lost() else { return };
        let name = gpu.device().name();
        let engine = engine(OnDevice::Maybe(gpu));
        let (plan, frame) = waves();
        let expected = cpu::run(&plan, &frame).unwrap();
        let said = Mutex::new(Vec::new());
        for _ in 0..3 {
            let warn = |text: &str| said.lock().unwrap().push(text.to_string());
            let run = Run::new().warn(&warn);
            let found = engine.execute(&plan, &frame, PlanInputs::default(), &run);
            let found = found.unwrap();
            for ((product, found), (_, expected)) in found.products().zip(expected.products()) {
                assert_eq!(product.difference(&found, &expected), 0.0);
            }
        }
        let said = said.into_inner().unwrap();
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with(&name) && said[0].contains("was lost"));
        assert!(said[0].contains("the CPU does it") && said[0].lines().count() == 1);
    }

    #[test]
    fn what_the_cpu_does_for_a_device_is_said_in_a_line() {
        let open = || gpu::to_test_on(Device::open(AdapterKind::Any));
        let (Some(whole), Some(small)) = (open(), open()) else {
            return;
        };
        let mut frame = Scene::waves(60, 50).frame;
        let gray = Plane::from_fn(60, 50, |x, y| 0.2 + 0.01 * ((x + y) % 50) as f32);
        let light = ColorPlanes {
            r: gray.clone(),
            g: gray.clone(),
            b: gray,
        };
        frame.color = Some(light.clone());
        let mut grouped = frame.clone();
        grouped.light.groups = vec![LightGroup {
            name: "key".into(),
            light,
            to_light: vec![Vec3::Z],
        }];
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = |goal, frame| Plan::new(goal, Available::in_frame(frame), shape, scaling);
        let mut line = LineParams::default();
        line.strokes.style = Style::Pen;
        let available = Available::in_frame(&frame);
        let drawing = Plan::new(Goal::Hatch(Tone::Picture, line), available, shape, scaling);
        let whole = Engine::on(whole);
        // Vectors of two take 24,000 bytes.
        let small = Engine::on(small.limited_to(23_999));
        for (engine, plan, frame, expected) in [
            (&whole, plan(Goal::Enhance, &frame), &frame, None),
            (
                &whole,
                plan(Goal::Enhance, &grouped),
                &grouped,
                Some("light groups"),
            ),
            (&whole, drawing, &frame, Some("tonal-art-map")),
            (
                &small,
                plan(Goal::Enhance, &frame),
                &frame,
                Some("a picture of 60x50"),
            ),
        ] {
            let (plan, said) = (plan.unwrap(), Mutex::new(Vec::new()));
            let warn = |text: &str| said.lock().unwrap().push(text.to_string());
            let run = Run::new().warn(&warn);
            let found = engine
                .execute(&plan, frame, PlanInputs::default(), &run)
                .unwrap();
            let said = said.into_inner().unwrap();
            assert_eq!(said.len(), expected.iter().count(), "{said:?}");
            let is_said = |what: &str| said[0].contains(what) && said[0].contains("the CPU");
            assert!(expected.is_none_or(is_said), "{said:?}");
            let made = cpu::run(&plan, frame).unwrap();
            for (product, a) in found.products() {
                let b = made.planes(product);
                assert!(
                    product.difference(&a, &b) <= product.tolerance(),
                    "{product:?}"
                );
            }
        }
    }

    /// On a device each stage is reported before it is recorded; a run cancelled there ends there, and the next run
    /// matches an uncancelled one.
    #[test]
    fn a_run_on_a_device_ends_at_the_stage_at_which_it_is_cancelled() {
        let Some(device) = gpu::to_test_on(Device::open(AdapterKind::Any)) else {
            return;
        };
        let (plan, frame) = waves();
        let engine = Engine::on(device);
        let run = |cancel_at: Option<&str>| {
            let (token, said) = (CancelToken::new(), Mutex::new(Vec::new()));
            let tell = |at: Progress| {
                said.lock().unwrap().push(at);
                if cancel_at == Some(at.stage) {
                    token.cancel();
                }
            };
            let run = Run::new().progress(&tell).cancel(&token);
            let made = engine.execute(&plan, &frame, PlanInputs::default(), &run);
            (made, said.into_inner().unwrap())
        };
        let (whole, said) = run(None);
        let whole = whole.unwrap();
        let stages: Vec<_> = said.iter().map(|at| at.stage).collect();
        let (own, ends) = (&stages[1..stages.len() - 1], [stages[0], "done"]);
        assert_eq!((own, ends), (&plan.stages()[..], [DEVICE, "done"]));
        assert!(said.is_sorted_by(|a, b| a.done <= b.done), "{said:?}");
        for stage in plan.stages() {
            let (stopped, said) = run(Some(stage));
            assert!(matches!(stopped, Err(Error::Cancelled)), "{stage}");
            let last = said.last().map(|at| at.stage);
            assert_eq!(last, Some(stage));
            let again = run(None).0.unwrap();
            for ((product, a), (_, b)) in again.products().zip(whole.products()) {
                assert_eq!(product.difference(&a, &b), 0.0, "{product:?} after {stage}");
            }
        }
    }

    #[test]
    fn where_a_device_was_asked_for_its_loss_is_an_error_that_fails_the_run() {
        let Some(gpu) = lost() else { return };
        let engine = engine(OnDevice::Only(gpu));
        let (plan, frame) = waves();
        for _ in 0..2 {
            let warn = |text: &str| panic!("{text}");
            let run = Run::new().warn(&warn);
            let done = engine.execute(&plan, &frame, PlanInputs::default(), &run);
            let error = done.unwrap_err();
            assert!(matches!(error, Error::Gpu { .. }), "{error}");
        }
    }
}
