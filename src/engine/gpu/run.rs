//! One frame, or a strip of it, on its way through the kernels.

use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::device::Device;
use crate::engine::gpu::recorder::{Programs, Recorder, Timings};
use crate::engine::gpu::surface::{Surface, Upload};
use crate::error::Result;
use crate::frame::{Plane, Vector2Planes};
use std::ops::Range;

/// Bytes of a buffer that nothing is written to.
pub(crate) const NOWHERE: u64 = 16;

/// What is being recorded.
pub(crate) struct Run<'a> {
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) recorder: Recorder<'a>,
    pub(crate) surface: Surface,
    /// The numbers that are chosen from the whole picture: gain and white level.
    pub(crate) chosen: wgpu::Buffer,
    /// What was copied to the device while kernels were recorded.
    held: Vec<wgpu::Buffer>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(
        device: &'a Device,
        programs: &'a Programs,
        buffers: &'a Buffers,
        surface: Surface,
        chosen: [f32; 2],
    ) -> Self {
        let upload = Upload { device, buffers };
        Self {
            device,
            buffers,
            recorder: Recorder::new(device, programs, buffers),
            surface,
            chosen: upload.bytes(bytemuck::cast_slice(&chosen)),
            held: Vec::new(),
        }
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
    pub(crate) fn hold(&mut self, numbers: &[f32]) -> wgpu::Buffer {
        self.hold_bytes(bytemuck::cast_slice(numbers))
    }

    /// Copies whatever it is to the device.
    pub(crate) fn hold_bytes(&mut self, bytes: &[u8]) -> wgpu::Buffer {
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
        self.buffers.take_back_copied(copied.chain([self.chosen]));
        Ok(done)
    }
}
