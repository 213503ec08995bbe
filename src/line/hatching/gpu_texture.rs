//! Textures of strokes on a device.

use crate::gpu::surface::Upload;
use crate::line::tonal_art_map::{MapTexels, TonalArtMap};

/// A texture of strokes on the device.
#[derive(Debug, Clone)]
pub(crate) struct DeviceTexture {
    pub(super) texels: wgpu::Buffer,
    pub(super) thresholds: wgpu::Buffer,
    pub(super) size: [u32; 2],
    /// 0 for strokes, which are inked by thresholds of their own.
    pub(super) slices: u32,
}

impl DeviceTexture {
    /// A copy of `map` on the device.
    pub(crate) fn new(map: &TonalArtMap, upload: Upload) -> Self {
        let size = map.period();
        let (texels, slices) = match map.texels() {
            MapTexels::Strokes(words) => (upload.bytes(bytemuck::cast_slice(&words)), 0),
            MapTexels::Slices(samples) => {
                let slices = samples.len() / (size[0] * size[1]);
                (upload.bytes(bytemuck::cast_slice(&samples)), slices as u32)
            }
        };
        Self {
            texels,
            thresholds: upload.bytes(bytemuck::cast_slice(map.response.thresholds())),
            size: size.map(|texels| texels as u32),
            slices,
        }
    }
}
