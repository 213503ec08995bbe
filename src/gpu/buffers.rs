//! Device memory: buffers of finished runs, reused.

use crate::gpu::device::Device;
use std::sync::{Mutex, MutexGuard, PoisonError};
use wgpu::BufferUsages;

/// Buffers for reuse.
#[derive(Debug, Default)]
pub(crate) struct Buffers(Mutex<Vec<Spare>>);

/// The use of a buffer, which it keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BufferUse {
    /// Written by kernels. A buffer may pass from one kernel to a later one of the same run.
    Kernels,
    /// Uploaded to the device. Copies precede all kernels of a run, so a buffer must not have been used by a kernel
    /// earlier in the same run.
    Upload,
    /// Copied to on the device, and read back.
    ReadBack,
}

/// An unused buffer.
#[derive(Debug)]
struct Spare {
    buffer: wgpu::Buffer,
    purpose: BufferUse,
    /// Whether it was returned since the last run began.
    is_fresh: bool,
}

impl Buffers {
    /// A buffer of this many bytes, with undefined contents.
    pub(crate) fn take(&self, device: &Device, bytes: u64, purpose: BufferUse) -> wgpu::Buffer {
        let size = bytes.max(4).next_multiple_of(4);
        let mut spare = self.spare();
        let fits = |spare: &Spare| spare.purpose == purpose && spare.buffer.size() == size;
        if let Some(at) = spare.iter().position(fits) {
            return spare.swap_remove(at).buffer;
        }
        drop(spare);
        let usage = match purpose {
            BufferUse::Kernels | BufferUse::Upload => {
                BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST
            }
            BufferUse::ReadBack => BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        };
        device.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// Reclaims buffers of kernels that none recorded later needs.
    pub(crate) fn recycle(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.recycle_as(BufferUse::Kernels, buffers);
    }

    /// Reclaims buffers taken for this purpose: uploaded ones after the run, others read and unmapped. A buffer returned
    /// by several owners is kept only once.
    pub(crate) fn recycle_as(
        &self,
        purpose: BufferUse,
        buffers: impl IntoIterator<Item = wgpu::Buffer>,
    ) {
        let mut spare = self.spare();
        for buffer in buffers {
            if !spare.iter().any(|spare| spare.buffer == buffer) {
                spare.push(Spare {
                    buffer,
                    purpose,
                    is_fresh: true,
                });
            }
        }
    }

    /// Drops all buffers: those returned by a failed run may be invalid.
    pub(crate) fn forget(&self) {
        self.spare().clear();
    }

    /// Whether no buffer is left for reuse.
    #[cfg(test)]
    pub(crate) fn is_empty(&self) -> bool {
        self.spare().is_empty()
    }

    /// Drops buffers that the last run did not use: pictures, and lists along their lines, differ in size.
    pub(crate) fn begin_run(&self) {
        let mut spare = self.spare();
        spare.retain(|spare| spare.is_fresh);
        spare.iter_mut().for_each(|spare| spare.is_fresh = false);
    }

    fn spare(&self) -> MutexGuard<'_, Vec<Spare>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
