//! The device: adapter selection and capabilities.

use crate::error::{Error, Result};
use crate::gpu::limits;
use crate::gpu::wait::look_after;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The process that loaded the drivers: they do not work in those that are forked off it.
static LOADED_BY: OnceLock<u32> = OnceLock::new();

/// Which adapters are acceptable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdapterKind {
    /// Any; software if there is no hardware.
    Any,
    /// Hardware only: software is no faster than the CPU backend.
    Hardware,
    /// Software only.
    #[cfg(test)]
    Software,
}

/// An opened adapter.
#[derive(Debug)]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// Maximum number of bytes of a plane.
    pub(crate) plane_bytes: u64,
    /// Maximum columns and rows of a picture.
    pub(crate) most_pixels: [u64; 2],
    /// Nanoseconds per tick of the device clock, if it has one.
    pub(crate) tick_ns: Option<f32>,
    /// Why the device was lost, if it was.
    lost: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens the best adapter: discrete before integrated, and software last.
    ///
    /// # Errors
    /// [`Error::NoGpu`] if none matches the choice, or it lacks features that the kernels need; and in a process that was
    /// forked off one that has looked for a device.
    pub fn open(choice: AdapterKind) -> Result<Self> {
        pollster::block_on(Self::opened(choice, |_| ()))
    }

    /// Opens the same adapter with changed limits.
    pub(crate) async fn opened(choice: AdapterKind, change: fn(&mut wgpu::Limits)) -> Result<Self> {
        let this = std::process::id();
        if *LOADED_BY.get_or_init(|| this) != this {
            return Err(Error::NoGpu {
                found: "its driver belongs to the process that this one was forked off".into(),
                remedy: "start processes by spawn or forkserver, or use --backend cpu",
            });
        }
        // Vulkan, Metal and DirectX 12; OpenGL is not used.
        let backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let mut adapters = instance.enumerate_adapters(backends).await;
        adapters.retain(|adapter| {
            let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
            match choice {
                AdapterKind::Any => true,
                AdapterKind::Hardware => !is_software,
                #[cfg(test)]
                AdapterKind::Software => is_software,
            }
        });
        adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
        let Some(adapter) = adapters.first() else {
            return Err(none(choice));
        };
        let mut limits = adapter.limits();
        change(&mut limits);
        Self::of(adapter, limits).await
    }

    /// Opens an adapter as if it had only these limits.
    async fn of(adapter: &wgpu::Adapter, limits: wgpu::Limits) -> Result<Self> {
        let info = adapter.get_info();
        if let Some(lacking) = limits::lacking(&limits) {
            return Err(Error::NoGpu {
                found: format!("{} {lacking}", info.name),
                remedy: "use --backend cpu",
            });
        }
        let plane_bytes = limits::plane_bytes(&limits);
        let most_pixels = limits::most_pixels(limits.max_compute_workgroups_per_dimension);
        let request = wgpu::DeviceDescriptor {
            label: Some("relievo"),
            required_features: limits::wanted_features(adapter.features()),
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&request).await;
        let (device, queue) = opened.map_err(|error| Error::NoGpu {
            found: format!("{} cannot be opened: {}", info.name, one_line(&error)),
            remedy: "use --backend cpu",
        })?;
        let lost = Arc::new(Mutex::new(None));
        let why_lost = lost.clone();
        device.set_device_lost_callback(move |reason, why| {
            let why = match one_line(&why) {
                nothing if nothing.is_empty() => format!("{reason:?}").to_lowercase(),
                why => why,
            };
            *why_lost.lock().unwrap_or_else(PoisonError::into_inner) = Some(why);
        });
        let clock = wgpu::Features::TIMESTAMP_QUERY;
        let has_clock = device.features().contains(clock);
        Ok(Self {
            plane_bytes,
            most_pixels,
            tick_ns: has_clock.then(|| queue.get_timestamp_period()),
            device,
            queue,
            info,
            lost,
        })
    }

    /// Name and API: `NVIDIA H200 (Vulkan)`.
    pub fn name(&self) -> String {
        format!("{} ({:?})", self.info.name, self.info.backend)
    }

    /// Whether it computes in software.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Limits planes to this many bytes: the CPU runs larger pictures.
    pub fn limited_to(self, plane_bytes: u64) -> Self {
        Self {
            plane_bytes: plane_bytes.min(self.plane_bytes),
            ..self
        }
    }

    /// Whether it was lost: nothing runs on it any more.
    pub fn is_lost(&self) -> bool {
        self.lost().is_some()
    }

    fn lost(&self) -> Option<String> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.clone()
    }

    /// Loses the device, as after a driver reset.
    #[cfg(test)]
    pub(crate) fn lose(&self) {
        self.device.destroy();
    }

    /// The failure as an error: device lost, if it was.
    pub(crate) fn error(&self, found: impl std::fmt::Display) -> Error {
        look_after(&self.device);
        let found = match self.lost() {
            Some(why) => format!("was lost ({why})"),
            None => one_line(&found),
        };
        Error::Gpu {
            device: self.name(),
            found,
        }
    }
}

/// The device for tests; `None` where there is none, with a note, and a panic on machines that must have one.
#[cfg(test)]
pub(crate) fn to_test_on<T>(opened: Result<T>) -> Option<T> {
    if let Err(error) = &opened {
        assert!(std::env::var_os("RELIEVO_NEEDS_GPU").is_none(), "{error}");
        println!("SKIPPED: {error}");
    }
    opened.ok()
}

/// The order in which adapters are tried.
fn rank(info: &wgpu::AdapterInfo) -> u32 {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

fn none(choice: AdapterKind) -> Error {
    Error::NoGpu {
        found: match choice {
            AdapterKind::Hardware => "no adapter in hardware was found".into(),
            _ => "no adapter was found".into(),
        },
        remedy: "install a driver (Debian: libvulkan1 and mesa-vulkan-drivers, or the vendor's), or use --backend cpu",
    }
}

/// A multi-line message as one line.
pub(crate) fn one_line(text: &impl std::fmt::Display) -> String {
    let text = text.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
