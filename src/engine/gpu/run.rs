//! One frame, or a strip of it, on its way through the kernels.

use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::device::Device;
use crate::engine::gpu::made::{Made, Shape};
use crate::engine::gpu::recorder::{Programs, Recorder, Timings};
use crate::engine::gpu::surface::{Picture, SurfaceBuffers, Upload};
use crate::error::Result;
use crate::frame::{Frame, Plane, Vector2Planes};
use crate::light::relight::gpu_lights::Light;
use crate::plan::Plan;
use std::ops::Range;

/// Bytes of a buffer that nothing is written to.
pub(crate) const NOWHERE: u64 = 16;

/// A run while it is being recorded.
pub(crate) struct Run<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    /// New light, where the frame gets any.
    pub(crate) light: Option<&'a Light<'a>>,
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) recorder: Recorder<'a>,
    pub(crate) surface: SurfaceBuffers,
    /// The numbers that are chosen from the whole picture: gain and white level.
    pub(crate) chosen: wgpu::Buffer,
    pub(crate) made: Made,
    /// Buffers uploaded while kernels were recorded.
    held: Vec<wgpu::Buffer>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(
        (plan, frame): (&'a Plan, &'a Frame),
        device: &'a Device,
        programs: &'a Programs,
        buffers: &'a Buffers,
        surface: SurfaceBuffers,
        chosen: [f32; 2],
    ) -> Self {
        let upload = Upload { device, buffers };
        Self {
            plan,
            frame,
            light: None,
            made: Made::default(),
            device,
            buffers,
            recorder: Recorder::new(device, programs, buffers),
            surface,
            chosen: upload.bytes(bytemuck::cast_slice(&chosen)),
            held: Vec::new(),
        }
    }

    /// The shape alone, as far as the gain takes it.
    pub(crate) fn find_shape(&mut self) -> Shape {
        let (plan, frame) = (self.plan, self.frame);
        let edges = self.edges(plan, frame);
        let diffused = self.with_diffusion(edges);
        self.with_hessian(diffused)
    }

    /// Goes on with the shape.
    pub(crate) fn change_shape(&mut self, change: impl FnOnce(&mut Self, Shape) -> Shape) {
        let shape = self.made.shape.take().expect("edges come first");
        self.made.shape = Some(change(self, shape));
    }

    /// Changes the picture in place, by the shape.
    pub(crate) fn change_picture(&mut self, change: impl FnOnce(&mut Self, &Shape, &Picture)) {
        let shape = self.made.shape.take().expect("scaling takes the shape");
        let picture = self.made.picture.take().expect("enhancing takes a picture");
        change(self, &shape, &picture);
        (self.made.shape, self.made.picture) = (Some(shape), Some(picture));
    }

    /// A buffer of this many bytes, whose contents mean nothing.
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
        self.uploaded_bytes(bytemuck::cast_slice(numbers))
    }

    /// Copies whatever it is to the device.
    pub(crate) fn uploaded_bytes(&mut self, bytes: &[u8]) -> wgpu::Buffer {
        let buffer = self.upload().bytes(bytes);
        self.held.push(buffer.clone());
        buffer
    }

    /// Copies rows of a plane to the device.
    pub(crate) fn hold_rows(&mut self, plane: &Plane, rows: &Range<usize>) -> wgpu::Buffer {
        let buffer = self.upload().rows_of(plane, rows);
        self.held.push(buffer.clone());
        buffer
    }

    fn upload(&self) -> Upload<'_> {
        Upload {
            device: self.device,
            buffers: self.buffers,
        }
    }

    /// Copies rows of a field of vectors to the device, x and y.
    pub(crate) fn hold_field(
        &mut self,
        Vector2Planes { x, y }: &Vector2Planes,
        rows: &Range<usize>,
    ) -> [wgpu::Buffer; 2] {
        [x, y].map(|plane| self.hold_rows(plane, rows))
    }

    /// Runs what was recorded, and hands out what `wanted` then hold, with the time of each stage.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] where the device fails.
    pub(crate) fn finish(self, wanted: &[&wgpu::Buffer]) -> Result<(Vec<Vec<f32>>, Timings)> {
        let done = self.recorder.run(wanted)?;
        let copied = self.surface.into_buffers().chain(self.held);
        self.buffers.recycle_copied(copied.chain([self.chosen]));
        Ok(done)
    }
}
