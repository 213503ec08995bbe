//! One frame on its way through the kernels.

use crate::engine::cpu::execution::Execution;
use crate::engine::gpu::buffers::{Buffers, Purpose};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::made::{Made, Shape};
use crate::engine::gpu::recorder::{KERNELS, Recorder, Submitted, Timings};
use crate::engine::gpu::surface::{SurfaceBuffers, Upload};
use crate::engine::outcome::add_timings;
use crate::error::Result;
use crate::frame::{Frame, Plane, Vector2Planes};
use crate::light::relight::gpu_lights::Light;
use crate::line::hatching::gpu_texture::TextureCache;
use crate::plan::Plan;
use std::time::Instant;

/// Bytes of a placeholder buffer that is never written.
pub(crate) const NOWHERE: u64 = 16;

/// A run while it is being recorded.
pub(crate) struct Recording<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    /// New light, if the frame gets any.
    pub(crate) light: Option<&'a Light<'a>>,
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) recorder: Recorder<'a>,
    pub(crate) surface: SurfaceBuffers,
    pub(crate) made: Made,
    /// The CPU run, for automatic choices, and for stages or parts of them without kernels. Its outcome is the result.
    pub(crate) host: Execution<'a>,
    /// The stroke texture cached from earlier runs.
    pub(crate) texture: &'a TextureCache,
    /// The submission in progress, if the run is observed.
    pub(super) at_work: Option<Submitted<'a>>,
    /// Timings of submissions waited for so far.
    pub(crate) waited: Timings,
    /// Buffers uploaded during recording.
    pub(crate) held: Vec<wgpu::Buffer>,
}

impl<'a> Recording<'a> {
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

    /// Reads buffers after the work recorded so far. If the device fails, they are 0, and so does the run.
    pub(crate) fn read<const N: usize>(&mut self, wanted: [&wgpu::Buffer; N]) -> [Vec<f32>; N] {
        match self.recorder.read(&wanted) {
            Ok((read, times)) => {
                add_timings(&mut self.waited, &times);
                read.try_into().expect("all that is wanted is read")
            }
            Err(error) => {
                self.recorder.failed = Some(error);
                wanted.map(|buffer| vec![0.0; buffer.size() as usize / 4])
            }
        }
    }

    /// [`Recording::read`] of planes.
    pub(crate) fn read_planes<const N: usize>(&mut self, wanted: [&wgpu::Buffer; N]) -> [Plane; N] {
        let [width, height] = self.surface.size.map(|side| side as usize);
        self.read(wanted)
            .map(|samples| Plane::from_samples(width, height, samples))
    }

    /// Has the CPU make an automatic choice, within a stage that has been reported.
    pub(crate) fn choose(&mut self, choose: fn(&mut Execution)) {
        let watch = std::mem::take(&mut self.host.watch);
        choose(&mut self.host);
        self.host.watch = watch;
    }

    /// The gain of curvature; 0 in a plan without.
    pub(crate) fn gain(&self) -> f32 {
        self.host.outcome.gain.unwrap_or(0.0)
    }

    /// Replaces the shape.
    pub(crate) fn change_shape(&mut self, change: impl FnOnce(&mut Self, Shape) -> Shape) {
        let shape = self.made.shape.take().expect("edges come first");
        self.made.shape = Some(change(self, shape));
    }

    /// A buffer of this many bytes with undefined contents.
    pub(crate) fn take(&self, bytes: u64) -> wgpu::Buffer {
        self.buffers.take(self.device, bytes, Purpose::Kernels)
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
    pub(crate) fn read_all(&mut self, wanted: &[&wgpu::Buffer]) -> Result<Vec<Vec<f32>>> {
        let (read, times) = self.recorder.read(wanted)?;
        if let Some(last) = self.at_work.take() {
            add_timings(&mut self.waited, &last.read()?.1.unwrap_or_default());
        }
        add_timings(&mut self.waited, &times);
        Ok(read)
    }

    /// Ends the run; its buffers are reused.
    pub(crate) fn finish(self) -> Finished<'a> {
        let copied = self.surface.into_buffers().chain(self.held);
        self.buffers.recycle_as(Purpose::Upload, copied);
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
    pub(crate) host: Execution<'a>,
}
