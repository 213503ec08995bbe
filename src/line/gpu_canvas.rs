//! A drawing on a device, as passed between its stages and read back.
//!
//! Work that follows something from pixel to pixel is left to the CPU: lines along edges and inside surfaces (while the
//! device makes strokes), the texture's strokes, and the movement of the texture. The results of those stages are on
//! the canvas of the CPU's own run, by their own passes. Strips are not drawn here at all: lines and directions spread
//! across them, so the CPU has to make most of such a drawing, and a pass for the rest saves less than transferring
//! directions and ink costs.

use crate::engine::gpu::recorder::Submitted;
use crate::error::Result;

/// The part of a drawing on the device; the CPU's part is on the canvas of its own run.
#[derive(Default)]
pub(crate) struct DeviceCanvas<'a> {
    /// Edges being read back for the CPU, which follows them.
    pub(crate) edges: Option<Result<PendingReadback<'a>>>,
    /// The directions of strokes.
    pub(crate) fields: Option<StrokeFields>,
    /// The strokes.
    pub(crate) hatched: Option<Hatched>,
    /// Coverage of the paper by lines along edges.
    pub(crate) contours: Option<wgpu::Buffer>,
}

impl DeviceCanvas<'_> {
    /// The buffers to read back, in the order expected by [`DeviceCanvas::put`].
    pub(crate) fn wanted(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let fields = self.fields.iter().map(|fields| &fields.further);
        let hatched = self.hatched.iter().map(|h| &h.ink);
        fields.chain(hatched).chain(&self.contours)
    }

    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let fields = self.fields.into_iter().flat_map(StrokeFields::into_buffers);
        let hatched = self.hatched.into_iter().flat_map(|h| [h.densities, h.ink]);
        fields.chain(hatched).chain(self.contours)
    }
}

/// Edges being read back from the device.
pub(crate) enum PendingReadback<'d> {
    /// In lists, with these numbers of cracks and creases.
    Listed(Submitted<'d>, [usize; 2]),
    /// As planes of weights: too many for lists.
    InPlanes(Submitted<'d>),
}

/// Directions of strokes on the device.
pub(crate) struct StrokeFields {
    /// Unit directions in the picture, x right and y up, of each family: their x, and their y.
    pub(crate) directions: Vec<[wgpu::Buffer; 2]>,
    /// Number of patches after the first ones of all cells.
    pub(crate) further: wgpu::Buffer,
    /// Room for patches: beyond it, directions are missing.
    pub(crate) room: u32,
}

impl StrokeFields {
    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let directions = self.directions.into_iter().flatten();
        directions.chain([self.further])
    }
}

/// Strokes on the device.
pub(crate) struct Hatched {
    /// The luminance of paper white.
    pub(crate) white: f32,
    pub(crate) densities: wgpu::Buffer,
    /// Coverage of the paper by strokes.
    pub(crate) ink: wgpu::Buffer,
}
