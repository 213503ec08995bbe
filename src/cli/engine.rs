//! What runs plans: the CPU, or a device where one was asked for or found.

use super::args::BackendArg;
use super::job::Job;
use crate::backend::cpu;
use crate::backend::cpu::Outcome;
#[cfg(feature = "gpu")]
use crate::backend::gpu;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene};
use crate::light::lights::Illumination;
use crate::plan::Plan;

/// The backends of a run.
pub(super) struct Engine {
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
            return Err(Error::NoGpu {
                found: "this program was built without it".into(),
                remedy: "build it with --features gpu, or use --backend cpu",
            });
        }
        Ok(Self {
            cpu: cpu::Runner::default(),
            #[cfg(feature = "gpu")]
            device: OnDevice::of(backend)?,
        })
    }

    /// Runs `plan` on `frame`.
    ///
    /// # Errors
    /// Where the device fails, or lacks kernels, and nothing else may do it.
    #[cfg(feature = "gpu")]
    pub(super) fn run(&self, job: &Job, plan: &Plan, frame: &Frame) -> Result<Outcome> {
        let on_device = |gpu: &gpu::Runner| gpu.run(plan, frame);
        self.by_either(job, plan, on_device, || self.cpu.run(plan, frame))
    }

    /// Runs `plan`, which lights `frame` anew; mirrors and lenses show what is in `scene`.
    ///
    /// # Errors
    /// As [`Engine::run`].
    #[cfg(feature = "gpu")]
    pub(super) fn relight(
        &self,
        job: &Job,
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
        scene: Option<&SpecularScene>,
    ) -> Result<Outcome> {
        let on_device = |gpu: &gpu::Runner| gpu.relight(plan, frame, light);
        let on_cpu = || relight_on_cpu(&self.cpu, plan, frame, light, scene);
        self.by_either(job, plan, on_device, on_cpu)
    }

    /// Has `plan` run by the device, where there is one that has kernels for it, else by the CPU.
    #[cfg(feature = "gpu")]
    fn by_either(
        &self,
        job: &Job,
        plan: &Plan,
        on_device: impl FnOnce(&gpu::Runner) -> Result<Outcome>,
        on_cpu: impl FnOnce() -> Outcome,
    ) -> Result<Outcome> {
        match &self.device {
            OnDevice::Only(gpu) if gpu::Runner::can_run(plan) => return on_device(gpu),
            OnDevice::Only(_) => return Err(no_kernels()),
            OnDevice::Maybe(gpu) if gpu::Runner::can_run(plan) => match on_device(gpu) {
                Ok(outcome) => return Ok(outcome),
                Err(error) => job.warn(&format!("{error}: the CPU did it")),
            },
            OnDevice::No(Some(why)) => job.warn(&format!("{why}; the CPU does it")),
            OnDevice::Maybe(_) | OnDevice::No(None) => {}
        }
        Ok(on_cpu())
    }

    /// Runs `plan` on `frame`.
    #[cfg(not(feature = "gpu"))]
    pub(super) fn run(&self, _job: &Job, plan: &Plan, frame: &Frame) -> Result<Outcome> {
        Ok(self.cpu.run(plan, frame))
    }

    /// Runs `plan`, which lights `frame` anew; mirrors and lenses show what is in `scene`.
    #[cfg(not(feature = "gpu"))]
    pub(super) fn relight(
        &self,
        _job: &Job,
        plan: &Plan,
        frame: &Frame,
        light: &Illumination,
        scene: Option<&SpecularScene>,
    ) -> Result<Outcome> {
        Ok(relight_on_cpu(&self.cpu, plan, frame, light, scene))
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

/// Refuses a device for what has no kernels.
pub(super) fn refuse_gpu(backend: BackendArg) -> Result<()> {
    match backend {
        BackendArg::Gpu => Err(no_kernels()),
        BackendArg::Auto | BackendArg::Cpu => Ok(()),
    }
}

fn no_kernels() -> Error {
    Error::BadParameter {
        name: "--backend",
        found: "is gpu, which has no kernels for this".into(),
        remedy: "leave it out: auto takes the GPU for what it can do, and the CPU for the rest"
            .into(),
    }
}
