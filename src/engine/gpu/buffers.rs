//! Memory on the device: buffers of finished runs, used again.

use crate::engine::gpu::device::Device;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers to be used again.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// Written by kernels. It may go from one kernel to a later one of the same run.
    work: Pool,
    /// Uploaded to the device. Copies come before all kernels of a run, so none of it may have been a kernel's
    /// before in the same run.
    copied: Pool,
    /// Read back after a run.
    readable: Pool,
}

/// Usages of a buffer of kernels.
const OF_KERNELS: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);

/// Usages of a buffer that is read back.
const TO_READ: wgpu::BufferUsages =
    wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

impl Buffers {
    /// A buffer of this many bytes for kernels to write, whose contents mean nothing.
    pub(crate) fn take(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.work.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes to be copied to.
    pub(crate) fn take_to_copy(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.copied.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes to be copied to on the device, and read.
    pub(crate) fn take_to_read(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.readable.take(device, bytes, TO_READ)
    }

    /// Takes buffers that [`Buffers::take`] gave and that no kernel recorded later needs.
    pub(crate) fn recycle(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.work.recycle(buffers);
    }

    /// Takes buffers that were copied to from the host, or not.
    pub(crate) fn recycle_either(
        &self,
        buffers: impl IntoIterator<Item = wgpu::Buffer>,
        is_copied: bool,
    ) {
        match is_copied {
            true => self.recycle_copied(buffers),
            false => self.recycle(buffers),
        }
    }

    /// Takes buffers that [`Buffers::take_to_copy`] gave, after the run.
    pub(crate) fn recycle_copied(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.copied.recycle(buffers);
    }

    /// Takes buffers that [`Buffers::take_to_read`] gave, read and unmapped.
    pub(crate) fn take_back_read(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.readable.recycle(buffers);
    }

    /// Forgets all: what a run that failed gave back may be no buffers.
    pub(crate) fn forget(&self) {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(Pool::forget);
    }

    /// Whether no buffer is left to reuse.
    #[cfg(test)]
    pub(crate) fn is_empty(&self) -> bool {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().all(|pool| pool.spare().is_empty())
    }

    /// Forgets what the last run had no use for: pictures, and lists along their lines, differ in size.
    pub(crate) fn begin_run(&self) {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(Pool::begin_run);
    }
}

/// A buffer that is not in use.
#[derive(Debug)]
struct Spare {
    buffer: wgpu::Buffer,
    /// Whether it was given back since the last run began.
    is_fresh: bool,
}

#[derive(Debug, Default)]
struct Pool(Mutex<Vec<Spare>>);

impl Pool {
    fn take(&self, device: &Device, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let bytes = bytes.max(4).next_multiple_of(4);
        let mut spare = self.spare();
        if let Some(at) = spare.iter().position(|spare| spare.buffer.size() == bytes) {
            return spare.swap_remove(at).buffer;
        }
        drop(spare);
        device.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes,
            usage,
            mapped_at_creation: false,
        })
    }

    /// One that several hands held is kept only once.
    fn recycle(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        let mut spare = self.spare();
        for buffer in buffers {
            if !spare.iter().any(|spare| spare.buffer == buffer) {
                spare.push(Spare {
                    buffer,
                    is_fresh: true,
                });
            }
        }
    }

    fn begin_run(&self) {
        let mut spare = self.spare();
        spare.retain(|spare| spare.is_fresh);
        spare.iter_mut().for_each(|spare| spare.is_fresh = false);
    }

    fn forget(&self) {
        self.spare().clear();
    }

    fn spare(&self) -> MutexGuard<'_, Vec<Spare>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
