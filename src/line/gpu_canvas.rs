//! A drawing on a device, as its stages hand it on to one another and as it is read.
//!
//! What follows something from pixel to pixel is left to the CPU: lines along edges and inside surfaces (while the device
//! makes strokes), the texture's strokes, and where the texture has moved to. What those stages make lies on the canvas of
//! the CPU's own run, by their own passes. Strips are not drawn here at all: lines and directions spread across them, so the
//! CPU has to make most of such a drawing, and a pass for the rest saves less than carrying directions and ink to and fro.

use crate::engine::cpu::run::Run as HostRun;
use crate::engine::gpu::constants::WHITE;
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::line::contours::gpu::PendingReadback;
use crate::line::direction_field::gpu::StrokeFields;
use crate::line::drawing::{Tone, finish};
use crate::line::hatching::gpu::Hatched;

/// What is of a drawing on the device; what the CPU has of it lies on the canvas of its own run.
#[derive(Default)]
pub(crate) struct DeviceCanvas<'a> {
    /// Edges on their way to the CPU, which follows them.
    pub(crate) edges: Option<Result<PendingReadback<'a>>>,
    /// The directions of strokes.
    pub(crate) fields: Option<StrokeFields>,
    /// The strokes.
    pub(crate) hatched: Option<Hatched>,
    /// How much of the paper lines along edges cover.
    pub(crate) contours: Option<wgpu::Buffer>,
}

impl DeviceCanvas<'_> {
    /// What is read, in the order in which [`DeviceCanvas::put`] takes it.
    pub(crate) fn wanted(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let fields = self.fields.iter().map(|fields| &fields.further);
        let hatched = self.hatched.iter().flat_map(|h| [&h.chosen, &h.ink]);
        fields.chain(hatched).chain(&self.contours)
    }

    /// Puts the drawing together of what was read and of what lies on the canvas of the CPU. Whether surfaces fell apart
    /// into no more patches than there was room for; else directions are missing, and the CPU has to draw.
    pub(crate) fn put(
        &self,
        host: &mut HostRun,
        frame: &Frame,
        read: &mut impl Iterator<Item = Vec<f32>>,
    ) -> bool {
        let Some(fields) = &self.fields else {
            return true;
        };
        let mut next = || read.next().expect("all that is wanted is read");
        if next()[0].to_bits() > fields.room {
            return false;
        }
        let plane = |samples| Plane::from_samples(frame.mask.width(), frame.mask.height(), samples);
        let (chosen, ink) = (next(), plane(next()));
        if let Some((covered, _)) = &mut host.canvas.contours {
            *covered = plane(next());
        }
        let tone = Tone::on_paper(chosen[WHITE as usize]);
        finish(host, tone, ink, Vec::new());
        true
    }

    /// All of its buffers.
    pub(crate) fn into_buffers(self) -> impl Iterator<Item = wgpu::Buffer> {
        let fields = self.fields.into_iter().flat_map(StrokeFields::into_buffers);
        let hatched = self.hatched.into_iter().flat_map(|h| [h.densities, h.ink]);
        fields.chain(hatched).chain(self.contours)
    }
}
