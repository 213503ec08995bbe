//! Device memory: buffers of finished runs, reused.

use crate::engine::gpu::device::Device;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Buffers for reuse.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    /// Written by kernels. A buffer may pass from one kernel to a later one of the same run.
    work: Pool,
    /// Uploaded to the device. Copies precede all kernels of a run, so a buffer must not have been used by a kernel
    /// earlier in the same run.
    copied: Pool,
    /// Read back after a run.
    readable: Pool,
}

/// Usages of a kernel buffer.
const OF_KERNELS: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);

/// Usages of a read-back buffer.
const TO_READ: wgpu::BufferUsages =
    wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

impl Buffers {
    /// A buffer of this many bytes for kernels to write, with undefined contents.
    pub(crate) fn take(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.work.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes for upload.
    pub(crate) fn take_to_copy(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.copied.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes for copying on the device and reading back.
    pub(crate) fn take_to_read(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.readable.take(device, bytes, TO_READ)
    }

    /// Reclaims buffers from [`Buffers::take`] that no kernel recorded later needs.
    pub(crate) fn recycle(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.work.recycle(buffers);
    }

    /// Reclaims buffers from [`Buffers::take_to_copy`] if `is_copied`, else from [`Buffers::take`].
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

    /// Reclaims buffers from [`Buffers::take_to_copy`], after the run.
    pub(crate) fn recycle_copied(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.copied.recycle(buffers);
    }

    /// Reclaims buffers from [`Buffers::take_to_read`], read and unmapped.
    pub(crate) fn take_back_read(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.readable.recycle(buffers);
    }

    /// Drops all buffers: those returned by a failed run may be invalid.
    pub(crate) fn forget(&self) {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(Pool::forget);
    }

    /// Whether no buffer is left for reuse.
    #[cfg(test)]
    pub(crate) fn is_empty(&self) -> bool {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().all(|pool| pool.spare().is_empty())
    }

    /// Drops buffers that the last run did not use: pictures differ in size.
    pub(crate) fn begin_run(&self) {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(Pool::begin_run);
    }
}

/// An unused buffer.
#[derive(Debug)]
struct Spare {
    buffer: wgpu::Buffer,
    /// Whether it was returned since the last run began.
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

    /// A buffer returned by several owners is kept only once.
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
