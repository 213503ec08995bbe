//! The device that a report measures beside the CPU.

use crate::command::args::BackendArg;
#[cfg(feature = "gpu")]
use crate::engine::{Engine, Inputs, Run};
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::frame::Frame;
#[cfg(feature = "gpu")]
use crate::light::lights::Illumination;
#[cfg(feature = "gpu")]
use crate::plan::Plan;
use crate::report::gpu;

/// Device information for a report.
#[cfg(not(feature = "gpu"))]
pub(super) struct ReportDevice;

#[cfg(not(feature = "gpu"))]
impl ReportDevice {
    /// # Errors
    /// [`crate::Error::NoGpu`] if a device is required: this build supports none.
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

/// Device information for a report.
#[cfg(feature = "gpu")]
pub(super) enum ReportDevice {
    /// Nothing, and why.
    None(String),
    /// Opened, with an engine on it.
    Opened {
        engine: Box<Engine>,
        name: String,
        is_software: bool,
        is_required: bool,
    },
}

#[cfg(feature = "gpu")]
impl ReportDevice {
    /// # Errors
    /// [`crate::Error::NoGpu`] if a device is required and there is none.
    pub(super) fn of(backend: BackendArg) -> Result<Self> {
        use crate::engine::gpu::device::{Choice, Device};
        let opened = match backend {
            BackendArg::Cpu => return Ok(Self::None("the backend asked for is the CPU".into())),
            BackendArg::Gpu => Device::open(Choice::Any)?,
            BackendArg::Auto => match Device::open(Choice::Hardware) {
                Ok(device) => device,
                Err(why) => return Ok(Self::None(why.to_string())),
            },
        };
        Ok(Self::Opened {
            name: opened.name(),
            is_software: opened.is_software(),
            engine: Engine::on(opened.timed_apart()).into(),
            is_required: backend == BackendArg::Gpu,
        })
    }

    /// Measures with it.
    pub(super) fn measured<T>(&self, measure: impl FnOnce(gpu::Device) -> Result<T>) -> Result<T> {
        match self {
            Self::None(why) => measure(gpu::Device::NotMeasured(why.clone())),
            Self::Opened {
                engine,
                name,
                is_software,
                is_required,
            } => {
                let run = |plan: &Plan, frame: &Frame, light: &Illumination| {
                    engine.execute(plan, frame, Inputs::lit_by(light), &Run::new())
                };
                measure(gpu::Device::Measured(gpu::Gpu::new(
                    name.clone(),
                    *is_software,
                    *is_required,
                    &run,
                )))
            }
        }
    }
}
