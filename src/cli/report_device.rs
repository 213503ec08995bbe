//! The device that a report measures beside the CPU.

use super::args::BackendArg;
#[cfg(feature = "gpu")]
use crate::engine::Inputs;
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::frame::Frame;
#[cfg(feature = "gpu")]
use crate::light::lights::Illumination;
#[cfg(feature = "gpu")]
use crate::plan::Plan;
use crate::report::gpu;

/// What a report is to know of a device.
#[cfg(not(feature = "gpu"))]
pub(super) struct ReportDevice;

#[cfg(not(feature = "gpu"))]
impl ReportDevice {
    /// # Errors
    /// [`crate::Error::NoGpu`] where there has to be a device: this build knows of none.
    pub(super) fn of(backend: BackendArg) -> Result<Self> {
        match backend {
            BackendArg::Gpu => backend.engine().map(|_| Self),
            BackendArg::Auto | BackendArg::Cpu => Ok(Self),
        }
    }

    /// Measures with it.
    pub(super) fn measured<T>(&self, measure: impl FnOnce(gpu::Device) -> Result<T>) -> Result<T> {
        measure(gpu::Device::Unknown)
    }
}

/// What a report is to know of a device.
#[cfg(feature = "gpu")]
pub(super) enum ReportDevice {
    /// Nothing, and why.
    None(String),
    /// What it takes.
    Runner {
        runner: Box<crate::engine::gpu::runner::Runner>,
        is_required: bool,
    },
}

#[cfg(feature = "gpu")]
impl ReportDevice {
    /// # Errors
    /// [`crate::Error::NoGpu`] where there has to be a device and is none.
    pub(super) fn of(backend: BackendArg) -> Result<Self> {
        use crate::engine::gpu::device::{Choice, Device};
        use crate::engine::gpu::runner::Runner;
        let opened = match backend {
            BackendArg::Cpu => return Ok(Self::None("the backend asked for is the CPU".into())),
            BackendArg::Gpu => Device::open(Choice::Any)?,
            BackendArg::Auto => match Device::open(Choice::Hardware) {
                Ok(device) => device,
                Err(why) => return Ok(Self::None(why.to_string())),
            },
        };
        Ok(Self::Runner {
            runner: Box::new(Runner::new(opened.timed_apart())),
            is_required: backend == BackendArg::Gpu,
        })
    }

    /// Measures with it.
    pub(super) fn measured<T>(&self, measure: impl FnOnce(gpu::Device) -> Result<T>) -> Result<T> {
        match self {
            Self::None(why) => measure(gpu::Device::NotMeasured(why.clone())),
            Self::Runner {
                runner,
                is_required,
            } => {
                let device = runner.device();
                let run = |plan: &Plan, frame: &Frame, light: &Illumination| {
                    runner.execute(plan, frame, Inputs::lit_by(light))
                };
                measure(gpu::Device::Measured(gpu::Gpu::new(
                    device.name(),
                    device.is_software(),
                    *is_required,
                    &run,
                )))
            }
        }
    }
}
