//! The device: found among the adapters of this machine, asked for what it can do.

use crate::error::{Error, Result};
use std::sync::{Arc, Mutex, PoisonError};

/// Which adapters will do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice {
    /// Any, one in software where there is no other.
    Any,
    /// Hardware alone: software is no faster than the CPU backend.
    Hardware,
}

/// Storage buffers that a kernel takes at the most.
const STORAGE_BUFFERS: u32 = 16;

/// An adapter that has been opened.
#[derive(Debug)]
pub struct Device {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// The most bytes that a plane may have.
    pub(super) plane_bytes: u64,
    /// Nanoseconds of a tick of its clock, where it has one.
    pub(super) tick_ns: Option<f32>,
    /// Why it was lost, once it was.
    lost: Arc<Mutex<Option<String>>>,
}

impl Device {
    /// Opens the best adapter there is: a card before what is built in, and that before software.
    ///
    /// # Errors
    /// [`Error::NoGpu`] where there is none of that choice, or it lacks what the kernels take.
    pub fn open(choice: Choice) -> Result<Self> {
        pollster::block_on(Self::opened(choice))
    }

    async fn opened(choice: Choice) -> Result<Self> {
        // Vulkan, Metal and DirectX 12; OpenGL has no use here.
        let backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let mut adapters = instance.enumerate_adapters(backends).await;
        adapters.retain(|adapter| {
            choice == Choice::Any || adapter.get_info().device_type != wgpu::DeviceType::Cpu
        });
        adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
        let Some(adapter) = adapters.first() else {
            return Err(none(choice));
        };
        Self::of(adapter).await
    }

    async fn of(adapter: &wgpu::Adapter) -> Result<Self> {
        let info = adapter.get_info();
        let limits = adapter.limits();
        if limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            return Err(Error::NoGpu {
                found: format!(
                    "{} takes {} buffers at a time, and {STORAGE_BUFFERS} are needed",
                    info.name, limits.max_storage_buffers_per_shader_stage
                ),
                remedy: "use --backend cpu",
            });
        }
        let plane_bytes = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let clock = wgpu::Features::TIMESTAMP_QUERY;
        let request = wgpu::DeviceDescriptor {
            label: Some("relievo"),
            required_features: adapter.features() & clock,
            required_limits: limits,
            ..wgpu::DeviceDescriptor::default()
        };
        let opened = adapter.request_device(&request).await;
        let (device, queue) = opened.map_err(|error| Error::NoGpu {
            found: format!("{} cannot be opened: {}", info.name, one_line(&error)),
            remedy: "use --backend cpu",
        })?;
        let lost = Arc::new(Mutex::new(None));
        let told = lost.clone();
        device.set_device_lost_callback(move |_, why| {
            *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(one_line(&why));
        });
        let has_clock = device.features().contains(clock);
        Ok(Self {
            plane_bytes,
            tick_ns: has_clock.then(|| queue.get_timestamp_period()),
            device,
            queue,
            info,
            lost,
        })
    }

    /// Its name and what speaks to it: `NVIDIA H200 (Vulkan)`.
    pub fn name(&self) -> String {
        format!("{} ({:?})", self.info.name, self.info.backend)
    }

    /// Whether it computes in software.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The same, as if it took planes of no more than this many bytes: larger pictures go in strips.
    pub fn limited_to(self, plane_bytes: u64) -> Self {
        Self {
            plane_bytes: plane_bytes.min(self.plane_bytes),
            ..self
        }
    }

    /// What went wrong, as an error; that the device was lost, if it was.
    pub(super) fn error(&self, found: impl std::fmt::Display) -> Error {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        let found = match lost.as_ref() {
            Some(why) => format!("was lost ({why})"),
            None => one_line(&found),
        };
        Error::Gpu {
            device: self.name(),
            found,
        }
    }
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

fn none(choice: Choice) -> Error {
    Error::NoGpu {
        found: match choice {
            Choice::Any => "no adapter was found".into(),
            Choice::Hardware => "no adapter in hardware was found".into(),
        },
        remedy: "install a driver (Debian: libvulkan1 and mesa-vulkan-drivers, or the vendor's), or use --backend cpu",
    }
}

/// A message of several lines in one.
pub(super) fn one_line(text: &impl std::fmt::Display) -> String {
    let text = text.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
