//! Memory on the device: buffers of finished runs, used again.

use super::device::Device;
use std::sync::{Mutex, PoisonError};

/// Buffers to be used again.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    /// What kernels write. It may go from one kernel to a later one of the same run.
    work: Pool,
    /// What is copied to the device. Copies come before all kernels of a run, so none of it may have been a kernel's
    /// before in the same run.
    copied: Pool,
    /// What is read after a run.
    readable: Pool,
}

/// What a buffer of kernels is used for.
const OF_KERNELS: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE
    .union(wgpu::BufferUsages::COPY_SRC)
    .union(wgpu::BufferUsages::COPY_DST);

/// What one that is read is used for.
const TO_READ: wgpu::BufferUsages =
    wgpu::BufferUsages::MAP_READ.union(wgpu::BufferUsages::COPY_DST);

impl Buffers {
    /// A buffer of this many bytes for kernels to write, whose contents mean nothing.
    pub(super) fn take(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.work.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes to be copied to.
    pub(super) fn take_to_copy(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.copied.take(device, bytes, OF_KERNELS)
    }

    /// A buffer of this many bytes to be copied to on the device, and read.
    pub(super) fn take_to_read(&self, device: &Device, bytes: u64) -> wgpu::Buffer {
        self.readable.take(device, bytes, TO_READ)
    }

    /// Takes buffers that [`Buffers::take`] gave and that no kernel recorded later needs.
    pub(super) fn take_back(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.work.take_back(buffers);
    }

    /// Takes buffers that [`Buffers::take_to_copy`] gave, after the run.
    pub(super) fn take_back_copied(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.copied.take_back(buffers);
    }

    /// Takes buffers that [`Buffers::take_to_read`] gave, read and unmapped.
    pub(super) fn take_back_read(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        self.readable.take_back(buffers);
    }

    /// Forgets all: what a run that failed gave back may be no buffers.
    pub(super) fn forget(&self) {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(|pool| pool.keep(|_| false));
    }

    /// Whether there is none to be used again.
    #[cfg(test)]
    pub(super) fn is_empty(&self) -> bool {
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().all(|pool| {
            pool.0
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .is_empty()
        })
    }

    /// Forgets buffers that a picture of this many pixels has no use for.
    pub(super) fn keep_for(&self, pixels: u64) {
        let is_of_use = |size: u64| {
            let is_plane = [1, 2, 3, 4]
                .iter()
                .any(|samples| size == 4 * samples * pixels);
            size < pixels || is_plane
        };
        let pools = [&self.work, &self.copied, &self.readable];
        pools.into_iter().for_each(|pool| pool.keep(is_of_use));
    }
}

#[derive(Debug, Default)]
struct Pool(Mutex<Vec<wgpu::Buffer>>);

impl Pool {
    fn take(&self, device: &Device, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let bytes = bytes.max(4).next_multiple_of(4);
        let mut spare = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = spare.iter().position(|buffer| buffer.size() == bytes) {
            return spare.swap_remove(at);
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
    fn take_back(&self, buffers: impl IntoIterator<Item = wgpu::Buffer>) {
        let mut spare = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for buffer in buffers {
            if !spare.contains(&buffer) {
                spare.push(buffer);
            }
        }
    }

    /// Keeps buffers of sizes of which that holds.
    fn keep(&self, is_of_use: impl Fn(u64) -> bool) {
        let mut spare = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        spare.retain(|buffer| is_of_use(buffer.size()));
    }
}
