//! One frame on its way through the kernels.

use crate::engine::cpu::run::Run as HostRun;
use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::device::Device;
use crate::engine::gpu::made::{Made, Shape};
use crate::engine::gpu::recorder::{KERNELS, RECORD, Recorder, Submitted, Timings};
use crate::engine::gpu::surface::{Picture, SurfaceBuffers, Upload};
use crate::engine::outcome::add_timings;
use crate::error::Result;
use crate::frame::{Frame, Vector2Planes};
use crate::light::relight::gpu_lights::Light;
use crate::line::hatching::gpu_texture::TextureCache;
use crate::plan::Plan;
use std::time::Instant;

/// Bytes of a placeholder buffer that is never written.
pub(crate) const NOWHERE: u64 = 16;

/// A run while it is being recorded.
pub(crate) struct Run<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    /// New light, if the frame gets any.
    pub(crate) light: Option<&'a Light<'a>>,
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) recorder: Recorder<'a>,
    pub(crate) surface: SurfaceBuffers,
    /// Numbers chosen from the whole picture: gain and white level.
    pub(crate) chosen: wgpu::Buffer,
    pub(crate) made: Made,
    /// The CPU run, for stages or parts of them without kernels. Its outcome is the result.
    pub(crate) host: HostRun<'a>,
    /// The stroke texture cached from earlier runs.
    pub(crate) texture: &'a TextureCache,
    /// The submission in progress, if the run is observed.
    at_work: Option<Submitted<'a>>,
    /// Timings of submissions waited for so far.
    pub(crate) waited: Timings,
    /// Buffers uploaded during recording.
    pub(crate) held: Vec<wgpu::Buffer>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(
        (device, buffers): (&'a Device, &'a Buffers),
        recorder: Recorder<'a>,
        texture: &'a TextureCache,
        host: HostRun<'a>,
        light: Option<&'a Light<'a>>,
        surface: SurfaceBuffers,
        chosen: [f32; 2],
    ) -> Self {
        let upload = Upload { device, buffers };
        Self {
            plan: host.plan,
            frame: host.frame,
            light,
            made: Made::default(),
            host,
            texture,
            device,
            buffers,
            recorder,
            surface,
            chosen: upload.bytes(bytemuck::cast_slice(&chosen)),
            at_work: None,
            waited: Timings::new(),
            held: Vec::new(),
        }
    }

    /// Submits the recorded work once the previous submission has finished.
    pub(super) fn hand_over(&mut self) -> Result<()> {
        let before = self.at_work.replace(self.recorder.submit(&[]));
        let start = Instant::now();
        if let Some(before) = before {
            let (_, times) = before.read()?;
            let times = times.unwrap_or_else(|| vec![(KERNELS, start.elapsed())]);
            add_timings(&mut self.waited, &times);
        }
        Ok(())
    }

    /// Replaces the shape.
    pub(crate) fn change_shape(&mut self, change: impl FnOnce(&mut Self, Shape) -> Shape) {
        let shape = self.made.shape.take().expect("edges come first");
        self.made.shape = Some(change(self, shape));
    }

    /// Changes the picture in place, using the shape.
    pub(crate) fn change_picture(&mut self, change: impl FnOnce(&mut Self, &Shape, &Picture)) {
        let shape = self.made.shape.take().expect("scaling takes the shape");
        let picture = self.made.picture.take().expect("enhancing takes a picture");
        change(self, &shape, &picture);
        (self.made.shape, self.made.picture) = (Some(shape), Some(picture));
    }

    /// A buffer of this many bytes with undefined contents.
    pub(crate) fn take(&self, bytes: u64) -> wgpu::Buffer {
        self.buffers.take(self.device, bytes)
    }

    pub(crate) fn copy_of(&mut self, buffer: &wgpu::Buffer) -> wgpu::Buffer {
        let copy = self.take(buffer.size());
        self.recorder.copy(buffer, &copy);
        copy
    }

    /// Copies numbers to the device.
    pub(crate) fn uploaded(&mut self, numbers: &[f32]) -> wgpu::Buffer {
        let buffer = self.upload().bytes(bytemuck::cast_slice(numbers));
        self.held.push(buffer.clone());
        buffer
    }

    pub(crate) fn upload(&self) -> Upload<'_> {
        Upload {
            device: self.device,
            buffers: self.buffers,
        }
    }

    /// Copies a vector field to the device, x and y.
    pub(crate) fn hold_field(
        &mut self,
        Vector2Planes { x, y }: &Vector2Planes,
    ) -> [wgpu::Buffer; 2] {
        [x, y].map(|plane| self.uploaded(plane.samples()))
    }

    /// Runs the recorded work and returns the contents of `wanted`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device fails.
    pub(crate) fn read(&mut self, wanted: &[&wgpu::Buffer]) -> Result<Vec<Vec<f32>>> {
        let (read, times) = self.recorder.run(wanted)?;
        if let Some(last) = self.at_work.take() {
            add_timings(&mut self.waited, &last.read()?.1.unwrap_or_default());
        }
        add_timings(&mut self.waited, &times);
        Ok(read)
    }

    /// Ends the run; its buffers are reused.
    pub(crate) fn finish(self) -> Finished<'a> {
        let copied = self.surface.into_buffers().chain(self.held);
        self.buffers.recycle_copied(copied.chain([self.chosen]));
        Finished {
            made: self.made,
            timings: self.waited,
            host: self.host,
        }
    }
}

/// The end of a run.
pub(crate) struct Finished<'a> {
    pub(crate) made: Made,
    pub(crate) timings: Timings,
    /// The CPU run.
    pub(crate) host: HostRun<'a>,
}
