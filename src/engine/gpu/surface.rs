//! A frame on the device.

use crate::engine::gpu::buffers::{Buffers, Purpose};
use crate::engine::gpu::device::Device;
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::diffusion::importance::Levels;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::shape::edges::SilhouetteSource;
use rayon::prelude::*;

/// A picture on the device: red, green and blue.
pub(crate) type Picture = [wgpu::Buffer; 3];

/// Input buffers of shape.
pub(crate) struct SurfaceBuffers {
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// The mask, in words of 32 pixels.
    pub(crate) covered: wgpu::Buffer,
    pub(crate) normal: [wgpu::Buffer; 3],
    pub(crate) normal_length: Option<wgpu::Buffer>,
    /// Depth, or an occlusion map.
    pub(crate) map: Option<wgpu::Buffer>,
    /// Levels of importance, if the sweeps are weighted by them.
    pub(crate) importance: Option<Importance>,
}

/// Importance, quantised to levels.
pub(crate) struct Importance {
    /// The level of each pixel.
    pub(crate) levels: wgpu::Buffer,
    /// Number of levels.
    pub(crate) count: u32,
    /// For every term, the weight of every level.
    pub(crate) weights: Vec<f32>,
}

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
        let buffer = self.buffers.take(self.device, size, Purpose::Upload);
        self.device.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// The channels of a picture.
    pub(crate) fn color(self, color: &ColorPlanes) -> Picture {
        [&color.r, &color.g, &color.b].map(|plane| self.plane(plane))
    }

    fn coverage(self, mask: &Mask) -> wgpu::Buffer {
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

    fn importance(self, frame: &Frame, sweeps: &DiffusionSchedule) -> Option<Importance> {
        let levels = Levels::of(frame, sweeps)?;
        let numbers = levels.plane.map(u32::from);
        let kept = levels
            .weights
            .iter()
            .map(|of_term| &of_term[..levels.count]);
        Some(Importance {
            levels: self.bytes(bytemuck::cast_slice(numbers.samples())),
            count: levels.count as u32,
            weights: kept.flatten().copied().collect(),
        })
    }

    /// Uploads the planes of `frame` that `plan` needs.
    pub(crate) fn surface(self, plan: &Plan, frame: &Frame) -> SurfaceBuffers {
        let map = match SilhouetteSource::of(plan) {
            _ if !plan.wants(Product::Conductance) => None,
            SilhouetteSource::Depth => frame.depth.as_ref(),
            SilhouetteSource::Occlusion => frame.occlusion.as_ref(),
            SilhouetteSource::Border => None,
        };
        let normal = &frame.normal;
        SurfaceBuffers {
            size: [frame.mask.width() as u32, frame.mask.height() as u32],
            covered: self.coverage(&frame.mask),
            normal: [&normal.x, &normal.y, &normal.z].map(|plane| self.plane(plane)),
            normal_length: frame.normal_length.as_ref().map(|plane| self.plane(plane)),
            map: map.map(|plane| self.plane(plane)),
            importance: self.importance(frame, &plan.sweeps),
        }
    }
}

impl SurfaceBuffers {
    /// Bytes of a plane of numbers.
    pub(crate) fn plane_bytes(&self) -> u64 {
        4 * u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let importance = self.importance.map(|importance| importance.levels);
        std::iter::once(self.covered)
            .chain(self.normal)
            .chain(self.normal_length)
            .chain(self.map)
            .chain(importance)
    }
}

/// Separates the components of interleaved vectors.
pub(crate) fn deinterleave<const N: usize>(samples: &[f32]) -> [Vec<f32>; N] {
    let (vectors, _) = samples.as_chunks::<N>();
    std::array::from_fn(|i| vectors.par_iter().map(|vector| vector[i]).collect())
}
