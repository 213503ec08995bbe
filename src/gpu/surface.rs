//! A frame on the device.

use crate::frame::{Mask, Plane};
use crate::gpu::buffers::{BufferUse, Buffers};
use crate::gpu::device::Device;
use rayon::prelude::*;

/// Uploads planes.
#[derive(Clone, Copy)]
pub(crate) struct Upload<'a> {
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
}

impl Upload<'_> {
    pub(crate) fn plane(self, plane: &Plane) -> wgpu::Buffer {
        self.bytes(bytemuck::cast_slice(plane.samples()))
    }

    pub(crate) fn bytes(self, bytes: &[u8]) -> wgpu::Buffer {
        let size = bytes.len() as u64;
        let buffer = self.buffers.take(self.device, size, BufferUse::Upload);
        self.device.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    pub(crate) fn coverage(self, mask: &Mask) -> wgpu::Buffer {
        let words: Vec<u32> = (0..mask.height())
            .flat_map(|y| {
                mask.row(y).chunks(32).map(|pixels| {
                    let bits = pixels.iter().enumerate();
                    bits.fold(0, |word, (i, &covered)| word | u32::from(covered) << i)
                })
            })
            .collect();
        self.bytes(bytemuck::cast_slice(&words))
    }
}

/// Separates the components of interleaved vectors.
pub(crate) fn deinterleave<const N: usize>(samples: &[f32]) -> [Vec<f32>; N] {
    let (vectors, _) = samples.as_chunks::<N>();
    std::array::from_fn(|i| vectors.par_iter().map(|vector| vector[i]).collect())
}
