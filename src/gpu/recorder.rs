//! Records kernels and their inputs in order of execution.

use crate::error::{Error, Result};
use crate::gpu::buffers::{BufferUse, Buffers};
use crate::gpu::device::Device;
use crate::gpu::kernels::Kernel;
use crate::gpu::wait::wait_for;
use crate::kernel::timings::add_timings;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// Name in timings of copies to the device.
pub(crate) const UPLOAD: &str = "upload";

/// Of recording commands for it.
pub(crate) const RECORD: &str = "record";

/// Of all kernels together, on a device without a clock per stage.
pub(crate) const KERNELS: &str = "kernels";

/// Of copies from it.
pub(crate) const READ_BACK: &str = "read-back";

/// Compiled kernels, by name and switches.
type Compiled = HashMap<(&'static str, Vec<(&'static str, bool)>), wgpu::ComputePipeline>;

/// Kernels compiled so far.
#[derive(Debug, Default)]
pub(crate) struct Programs(Mutex<Compiled>);

impl Programs {
    /// Drops all kernels: those compiled in a failed run may be invalid.
    pub(crate) fn forget(&self) {
        let mut compiled = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        compiled.clear();
    }

    fn of(
        &self,
        device: &wgpu::Device,
        kernel: &Kernel,
        switches: &[(&'static str, bool)],
    ) -> wgpu::ComputePipeline {
        let mut compiled = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (kernel.name, switches.to_vec());
        if let Some(pipeline) = compiled.get(&key) {
            return pipeline.clone();
        }
        let label = Some(kernel.name);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(kernel.source().into()),
        });
        let constants: Vec<_> = switches
            .iter()
            .map(|&(name, on)| (name, f64::from(u8::from(on))))
            .collect();
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                // Kernels write workgroup memory before reading it.
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        compiled.insert(key, pipeline.clone());
        pipeline
    }
}

/// The time of each stage, in order.
pub(crate) type StageTimings = Vec<(&'static str, Duration)>;

/// Maximum number of kernels timed in a run: each takes two of a set's queries.
const MAX_TIMED: u32 = wgpu::QUERY_SET_MAX_QUERIES / 2;

/// Records kernels and runs them.
pub(crate) struct Recorder<'d> {
    device: &'d Device,
    programs: &'d Programs,
    buffers: &'d Buffers,
    encoder: wgpu::CommandEncoder,
    /// The clock, and the stage of each pair of timestamps.
    clock: Option<(wgpu::QuerySet, Vec<&'static str>)>,
    /// When the first kernel was recorded.
    start: Option<Instant>,
    /// Why the recorded work cannot run.
    pub(crate) failed: Option<Error>,
}

impl<'d> Recorder<'d> {
    pub(crate) fn new(device: &'d Device, programs: &'d Programs, buffers: &'d Buffers) -> Self {
        let clock = device.tick_ns.map(|_| {
            let set = device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2 * MAX_TIMED,
            });
            (set, Vec::new())
        });
        Self {
            device,
            programs,
            buffers,
            encoder: device.device.create_command_encoder(&Default::default()),
            clock,
            start: None,
            failed: None,
        }
    }

    /// Runs a kernel over this many workgroups, with a uniform block of these `bytes` and these buffers.
    pub(crate) fn dispatch(
        &mut self,
        stage: &'static str,
        (kernel, switches): (&Kernel, &[(&'static str, bool)]),
        bytes: &[u8],
        buffers: &[wgpu::Buffer],
        groups: [u32; 2],
    ) {
        self.start.get_or_insert_with(Instant::now);
        let device = &self.device.device;
        let pipeline = self.programs.of(device, kernel, switches);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM,
            mapped_at_creation: true,
        });
        match uniform.slice(..).get_mapped_range_mut() {
            Ok(mut range) => range.copy_from_slice(bytes),
            // Buffers are mapped at creation, so this one was never created.
            Err(error) => {
                self.failed.get_or_insert_with(|| self.device.error(error));
                return;
            }
        }
        uniform.unmap();
        let bound = std::iter::once(&uniform).chain(buffers);
        let entries: Vec<_> = (0..)
            .zip(bound)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        // Out of timestamp slots: report no timings.
        self.clock = self
            .clock
            .take()
            .filter(|(_, stages)| (stages.len() as u32) < MAX_TIMED);
        let timestamp_writes = self.clock.as_mut().map(|(set, stages)| {
            let index = 2 * stages.len() as u32;
            stages.push(stage);
            wgpu::ComputePassTimestampWrites {
                query_set: set,
                beginning_of_pass_write_index: Some(index),
                end_of_pass_write_index: Some(index + 1),
            }
        });
        let mut pass = self
            .encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(stage),
                timestamp_writes,
            });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], 1);
    }

    /// Copies a buffer.
    pub(crate) fn copy(&mut self, from: &wgpu::Buffer, to: &wgpu::Buffer) {
        self.encoder
            .copy_buffer_to_buffer(from, 0, to, 0, from.size());
    }

    /// Runs the work recorded so far, waits for it and returns the contents of `wanted`, with the times of recording, of each
    /// stage if the device has a clock, else of all kernels, and of read-back.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device fails.
    pub(crate) fn read(
        &mut self,
        wanted: &[&wgpu::Buffer],
    ) -> Result<(Vec<Vec<f32>>, StageTimings)> {
        let recorded = self
            .start
            .take()
            .map_or(Duration::ZERO, |start| start.elapsed());
        let start = Instant::now();
        let (read, stages) = self.submit(wanted).read()?;
        let waited = start.elapsed();
        let mut timings = vec![(RECORD, recorded)];
        let stages = stages.unwrap_or_else(|| vec![(KERNELS, waited)]);
        // Time not spent in kernels is copying and waiting.
        let computed = stages.iter().map(|(_, time)| *time).sum();
        let read_back = waited.saturating_sub(computed);
        timings.extend(stages);
        timings.push((READ_BACK, read_back));
        Ok((read, timings))
    }

    /// Submits the recorded work and continues recording; the contents of `wanted` can then be read.
    pub(crate) fn submit(&mut self, wanted: &[&wgpu::Buffer]) -> Submitted<'d> {
        let device = &self.device.device;
        let readable = |size: u64| self.buffers.take(self.device, size, BufferUse::ReadBack);
        let mut to_read: Vec<wgpu::Buffer> = Vec::new();
        for buffer in wanted {
            let target = readable(buffer.size());
            self.copy(buffer, &target);
            to_read.push(target);
        }
        let mut timed = None;
        if let Some((set, stages)) = self.clock.take() {
            let readings = 2 * stages.len() as u32;
            let size = u64::from(readings.max(1)) * 8;
            let resolved = device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            self.encoder
                .resolve_query_set(&set, 0..readings, &resolved, 0);
            let target = readable(size);
            self.encoder
                .copy_buffer_to_buffer(&resolved, 0, &target, 0, size);
            to_read.push(target);
            timed = Some(stages);
        }
        let next = Self::new(self.device, self.programs, self.buffers);
        let recorded = std::mem::replace(self, next);
        let submission = self.device.queue.submit([recorded.encoder.finish()]);
        Submitted {
            device: self.device,
            buffers: self.buffers,
            submission,
            to_read,
            timed,
            failed: recorded.failed,
        }
    }
}

/// Commands submitted to a device.
pub(crate) struct Submitted<'d> {
    device: &'d Device,
    buffers: &'d Buffers,
    submission: wgpu::SubmissionIndex,
    /// Copies of the wanted buffers, then of the timestamps.
    to_read: Vec<wgpu::Buffer>,
    /// The stages timed, if the device has a clock.
    timed: Option<Vec<&'static str>>,
    /// Why the submission failed.
    failed: Option<Error>,
}

impl Submitted<'_> {
    /// Waits for this submission, not for later ones; returns the wanted contents, and the time of each stage if the
    /// device has a clock.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device fails.
    pub(crate) fn read(mut self) -> Result<(Vec<Vec<f32>>, Option<StageTimings>)> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        wait(self.device, &self.to_read, self.submission)?;
        let times = match self.timed.zip(self.device.tick_ns) {
            Some((stages, tick_ns)) => {
                let clock = self.to_read.pop().expect("the clock is read last");
                let readings = contents(self.device, &clock)?;
                self.buffers.recycle_as(BufferUse::ReadBack, [clock]);
                Some(times(&stages, &readings, tick_ns))
            }
            None => None,
        };
        let numbers = self.to_read.par_iter();
        let numbers = numbers.map(|buffer| contents(self.device, buffer));
        let numbers = numbers.collect::<Result<_>>()?;
        self.buffers.recycle_as(BufferUse::ReadBack, self.to_read);
        Ok((numbers, times))
    }
}

/// Waits until the buffers filled by a submission are mapped.
fn wait(
    device: &Device,
    buffers: &[wgpu::Buffer],
    submission: wgpu::SubmissionIndex,
) -> Result<()> {
    let (sender, receiver) = mpsc::channel();
    for buffer in buffers {
        let sender = sender.clone();
        buffer
            .slice(..)
            .map_async(wgpu::MapMode::Read, move |mapped| {
                // A dropped receiver means that nobody waits for the result.
                let _ = sender.send(mapped);
            });
    }
    wait_for(&device.device, Some(submission)).map_err(|error| device.error(error))?;
    for _ in buffers {
        // Errors were reported while waiting.
        let mapped = receiver.try_recv().map_err(|error| device.error(error))?;
        mapped.map_err(|error| device.error(error))?;
    }
    Ok(())
}

/// The contents of a mapped buffer, read once.
fn contents<T: bytemuck::AnyBitPattern>(device: &Device, buffer: &wgpu::Buffer) -> Result<Vec<T>> {
    let range = buffer.slice(..).get_mapped_range();
    let range = range.map_err(|error| device.error(error))?;
    // Mapped memory is aligned to 8 bytes.
    let numbers = bytemuck::cast_slice(&range).to_vec();
    drop(range);
    buffer.unmap();
    Ok(numbers)
}

/// The time of each stage, summed over its passes, in order of their first pass.
fn times(stages: &[&'static str], readings: &[u64], tick_ns: f32) -> StageTimings {
    let mut times = StageTimings::new();
    for (&stage, pair) in stages.iter().zip(readings.chunks_exact(2)) {
        let ticks = pair[1].saturating_sub(pair[0]);
        let time = Duration::from_nanos((ticks as f64 * f64::from(tick_ns)) as u64);
        add_timings(&mut times, &[(stage, time)]);
    }
    times
}
