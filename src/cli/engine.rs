//! What runs plans: the CPU, or a device where one was asked for or found.

use super::args::BackendArg;
use super::job::Job;
use crate::engine::cpu;
use crate::engine::cpu::DrawingInputs;
#[cfg(feature = "gpu")]
use crate::engine::gpu;
use crate::engine::outcome::Outcome;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene};
use crate::light::lights::Illumination;
use crate::plan::Plan;

/// The backends of a run; the CPU alone by default.
#[derive(Default)]
pub(crate) struct Engine {
    pub(super) cpu: cpu::Runner,
    #[cfg(feature = "gpu")]
    device: OnDevice,
}

/// How far a device is used.
#[cfg(feature = "gpu")]
enum OnDevice {
    /// Not at all; why, where one was looked for.
    No(Option<Error>),
    /// For what it has kernels for; the CPU does the rest.
    Maybe(gpu::Runner),
    /// For everything.
    Only(gpu::Runner),
}

impl Engine {
    /// The backends that were asked for.
    ///
    /// # Errors
    /// [`Error::NoGpu`] where there has to be a device and is none.
    pub(super) fn new(backend: BackendArg) -> Result<Self> {
        #[cfg(not(feature = "gpu"))]
        if backend == BackendArg::Gpu {
            return Err(built_without_gpu());
        }
        Ok(Self {
            cpu: cpu::Runner::default(),
            #[cfg(feature = "gpu")]
            device: OnDevice::of(backend)?,
        })
    }

    /// The same for a window, in which the CPU does what the device has no kernels for, whatever was asked for.
    ///
    /// # Errors
    /// As [`Engine::new`].
    #[cfg(feature = "view")]
    pub(super) fn for_window(backend: BackendArg) -> Result<Self> {
        let engine = Self::new(backend)?;
        #[cfg(feature = "gpu")]
        let engine = Self {
            device: match engine.device {
                OnDevice::Only(gpu) => OnDevice::Maybe(gpu),
                other => other,
            },
            ..engine
        };
        Ok(engine)
    }

    /// Runs `plan` on `frame`.
    ///
    /// # Errors
    /// As [`Engine::run_on_device`].
    pub(super) fn run(&self, job: &Job, plan: &Plan, frame: &Frame) -> Result<Outcome> {
        let done = self.run_on_device(&|text| job.warn(text), plan, frame)?;
        Ok(done.unwrap_or_else(|| self.cpu.run(plan, frame)))
    }

    /// Runs `plan`, which lights `frame` anew; mirrors and lenses show what is in `scene`.
    ///
    /// # Errors
    /// As [`Engine::run_on_device`].
    pub(super) fn relight(
        &self,
        job: &Job,
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
        scene: Option<&SpecularScene>,
    ) -> Result<Outcome> {
        let done = self.relight_on_device(&|text| job.warn(text), plan, frame, light)?;
        Ok(done.unwrap_or_else(|| relight_on_cpu(&self.cpu, plan, frame, light, scene)))
    }

    /// Runs `plan`, which draws `frame`.
    ///
    /// # Errors
    /// As [`Engine::run_on_device`].
    pub(super) fn draw(
        &self,
        job: &Job,
        plan: &Plan,
        frame: &mut Frame,
        inputs: DrawingInputs,
    ) -> Result<Outcome> {
        let done = self.draw_on_device(&|text| job.warn(text), plan, frame, inputs)?;
        Ok(done.unwrap_or_else(|| self.cpu.draw_sparingly(plan, frame, inputs)))
    }
}

/// What a device does; `None` where the CPU is to do it, which `warn` may be told of. Of a device that was lost it is said
/// once.
///
/// # Errors
/// Where the device fails, or lacks kernels, and nothing else may do it.
#[cfg(feature = "gpu")]
impl Engine {
    /// Runs `plan` on `frame`.
    pub(super) fn run_on_device(
        &self,
        warn: &dyn Fn(&str),
        plan: &Plan,
        frame: &Frame,
    ) -> Result<Option<Outcome>> {
        self.on_device(warn, plan, |gpu| gpu.run(plan, frame))
    }

    /// Runs `plan`, which lights `frame` anew.
    pub(super) fn relight_on_device(
        &self,
        warn: &dyn Fn(&str),
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
    ) -> Result<Option<Outcome>> {
        self.on_device(warn, plan, |gpu| gpu.relight(plan, frame, light))
    }

    /// Runs `plan`, which draws `frame`.
    pub(super) fn draw_on_device(
        &self,
        warn: &dyn Fn(&str),
        plan: &Plan,
        frame: &Frame,
        inputs: DrawingInputs,
    ) -> Result<Option<Outcome>> {
        self.on_device(warn, plan, |gpu| gpu.draw(plan, frame, inputs))
    }

    fn on_device(
        &self,
        warn: &dyn Fn(&str),
        plan: &Plan,
        run: impl FnOnce(&gpu::Runner) -> Result<Outcome>,
    ) -> Result<Option<Outcome>> {
        let gpu = match &self.device {
            OnDevice::Only(gpu) => {
                return match gpu::Runner::lacks(plan) {
                    None => run(gpu).map(Some),
                    Some(what) => Err(no_kernels(what)),
                };
            }
            OnDevice::Maybe(gpu) => gpu,
            OnDevice::No(Some(why)) => {
                warn(&format!("{why}; the CPU does it"));
                return Ok(None);
            }
            OnDevice::No(None) => return Ok(None),
        };
        if gpu.device().is_lost() || !gpu::Runner::can_run(plan) {
            return Ok(None);
        }
        run(gpu).map(Some).or_else(|error| {
            let how_long = match gpu.device().is_lost() {
                true => "the CPU does it from here on",
                false => "the CPU did it",
            };
            warn(&format!("{error}: {how_long}"));
            Ok(None)
        })
    }
}

/// Without kernels nothing is done on a device.
#[cfg(not(feature = "gpu"))]
impl Engine {
    pub(super) fn run_on_device(
        &self,
        _: &dyn Fn(&str),
        _: &Plan,
        _: &Frame,
    ) -> Result<Option<Outcome>> {
        Ok(None)
    }

    pub(super) fn relight_on_device(
        &self,
        _: &dyn Fn(&str),
        _: &Plan,
        _: &Frame,
        _: &Illumination,
    ) -> Result<Option<Outcome>> {
        Ok(None)
    }

    pub(super) fn draw_on_device(
        &self,
        _: &dyn Fn(&str),
        _: &Plan,
        _: &Frame,
        _: DrawingInputs,
    ) -> Result<Option<Outcome>> {
        Ok(None)
    }
}

/// New light by the CPU.
pub(super) fn relight_on_cpu(
    cpu: &cpu::Runner,
    plan: &Plan,
    frame: &Frame,
    light: &Illumination,
    scene: Option<&SpecularScene>,
) -> Outcome {
    match scene {
        Some(scene) => cpu.relight_specular(plan, frame, light, scene),
        None => cpu.relight(plan, frame, light),
    }
}

#[cfg(feature = "gpu")]
impl Default for OnDevice {
    fn default() -> Self {
        Self::No(None)
    }
}

#[cfg(feature = "gpu")]
impl OnDevice {
    fn of(backend: BackendArg) -> Result<Self> {
        use gpu::{Choice, Device};
        Ok(match backend {
            BackendArg::Cpu => Self::No(None),
            BackendArg::Gpu => Self::Only(gpu::Runner::new(Device::open(Choice::Any)?)),
            BackendArg::Auto => match Device::open(Choice::Hardware) {
                Ok(device) => Self::Maybe(gpu::Runner::new(device)),
                Err(why) => Self::No(Some(why)),
            },
        })
    }
}

/// Says how to come by a build with kernels.
#[cfg(not(feature = "gpu"))]
pub(super) fn built_without_gpu() -> Error {
    Error::NoGpu {
        found: "this program was built without it".into(),
        remedy: "build it with --features gpu, or use --backend cpu",
    }
}

#[cfg(feature = "gpu")]
fn no_kernels(what: &str) -> Error {
    Error::BadParameter {
        name: "--backend",
        found: format!("is gpu, which has no kernels for {what}"),
        remedy: "leave it out: auto takes the GPU for what it can do, and the CPU for the rest"
            .into(),
    }
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::engine::gpu::device::{Choice, Device};
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::{Available, Goal};
    use crate::report::scenes::Scene;
    use std::cell::RefCell;

    /// A device that has been lost; `None` where there is none to lose.
    fn lost() -> Option<gpu::Runner> {
        let device = gpu::to_test_on(Device::open(Choice::Any))?;
        device.lose();
        Some(gpu::Runner::new(device))
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
        let expected = cpu::run(&plan, &frame);
        let said = RefCell::new(Vec::new());
        for _ in 0..3 {
            let warn = |text: &str| said.borrow_mut().push(text.to_string());
            let found = engine.run_on_device(&warn, &plan, &frame).unwrap();
            let found = found.unwrap_or_else(|| engine.cpu.run(&plan, &frame));
            for ((product, found), (_, expected)) in found.products().zip(expected.products()) {
                assert_eq!(product.apart(&found, &expected), 0.0);
            }
        }
        let said = said.into_inner();
        assert_eq!(said.len(), 1, "{said:?}");
        assert!(said[0].starts_with(&name) && said[0].contains("was lost"));
        assert!(said[0].contains("the CPU does it") && said[0].lines().count() == 1);
    }

    #[test]
    fn where_a_device_was_asked_for_its_loss_is_an_error_that_fails_the_run() {
        let Some(gpu) = lost() else { return };
        let engine = engine(OnDevice::Only(gpu));
        let (plan, frame) = waves();
        for _ in 0..2 {
            let warn = |text: &str| panic!("{text}");
            let error = engine.run_on_device(&warn, &plan, &frame).unwrap_err();
            assert!(matches!(error, Error::Gpu { .. }), "{error}");
            assert_eq!(crate::cli::message::exit_code(&error), 1);
        }
    }
}
