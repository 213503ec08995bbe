//! One frame on its way through the kernels.

use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::gpu::buffers::{BufferUse, Buffers};
use crate::gpu::constants::GROUP;
use crate::gpu::device::Device;
use crate::gpu::kernels::Kernel;
use crate::gpu::recorder::{KERNELS, Recorder, StageTimings, Submitted};
use crate::gpu::surface::Upload;
use crate::gpu::uniforms::{Uniforms, bytes_of};
use crate::kernel::shelf::Lent;
use crate::kernel::timings::add_timings;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use std::collections::BTreeMap;
use std::time::Instant;

/// Bytes of a placeholder buffer that is never written.
pub(crate) const NOWHERE: u64 = 16;

/// The planes of a picture.
pub(crate) const PICTURE: [&str; 3] = ["red", "green", "blue"];

/// A run while it is being recorded.
pub(crate) struct Recording<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    /// What is on the device already: new light, and textures of strokes from earlier runs.
    pub(crate) lent: Lent<'a>,
    pub(crate) device: &'a Device,
    pub(crate) buffers: &'a Buffers,
    pub(crate) recorder: Recorder<'a>,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// Planes by the names that they have in kernels, and what they were taken for.
    pub(crate) planes: BTreeMap<&'static str, (wgpu::Buffer, BufferUse)>,
    /// Gradients and curvatures at further scales.
    pub(crate) more_gradients: Vec<wgpu::Buffer>,
    pub(crate) more_curvatures: Vec<wgpu::Buffer>,
    /// The CPU run, for automatic choices, and for stages or parts of them without kernels. Its outcome is the result.
    pub(crate) host: Execution<'a>,
    /// The submission in progress, if the run is observed.
    pub(crate) at_work: Option<Submitted<'a>>,
    /// Timings of submissions waited for so far.
    pub(crate) waited: StageTimings,
    /// Buffers uploaded during recording.
    pub(crate) held: Vec<wgpu::Buffer>,
}

impl<'a> Recording<'a> {
    /// Submits the recorded work once the previous submission has finished.
    pub(crate) fn hand_over(&mut self) -> Result<()> {
        let before = self.at_work.replace(self.recorder.submit(&[]));
        let start = Instant::now();
        if let Some(before) = before {
            let (_, times) = before.read()?;
            let times = times.unwrap_or_else(|| vec![(KERNELS, start.elapsed())]);
            add_timings(&mut self.waited, &times);
        }
        Ok(())
    }

    /// Reads buffers after the work recorded so far. If the device fails, they are 0, and so does the run.
    pub(crate) fn read<const N: usize>(&mut self, wanted: [&wgpu::Buffer; N]) -> [Vec<f32>; N] {
        match self.recorder.read(&wanted) {
            Ok((read, times)) => {
                add_timings(&mut self.waited, &times);
                read.try_into().expect("all that is wanted is read")
            }
            Err(error) => {
                self.recorder.failed = Some(error);
                wanted.map(|buffer| vec![0.0; buffer.size() as usize / 4])
            }
        }
    }

    /// [`Recording::read`] of planes.
    pub(crate) fn read_planes<const N: usize>(&mut self, wanted: [&wgpu::Buffer; N]) -> [Plane; N] {
        let [width, height] = self.size.map(|side| side as usize);
        self.read(wanted)
            .map(|samples| Plane::from_samples(width, height, samples))
    }

    /// Has the CPU make an automatic choice, within a stage that has been reported.
    pub(crate) fn choose(&mut self, choose: fn(&mut Execution)) {
        let watch = std::mem::take(&mut self.host.watch);
        choose(&mut self.host);
        self.host.watch = watch;
    }

    /// The gain of curvature; 0 in a plan without.
    pub(crate) fn gain(&self) -> f32 {
        self.host.made.outcome.gain.unwrap_or(0.0)
    }

    /// Whether there is a plane of this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.planes.contains_key(name)
    }

    /// The plane of this name.
    ///
    /// # Panics
    /// If no stage before has made it.
    pub(crate) fn plane(&self, name: &str) -> wgpu::Buffer {
        let (plane, _) = self.planes.get(name).expect(name);
        plane.clone()
    }

    /// Names a plane that kernels made, in place of another of this name.
    pub(crate) fn put(&mut self, name: &'static str, plane: wgpu::Buffer) {
        self.drop_plane(name);
        self.planes.insert(name, (plane, BufferUse::Kernels));
    }

    /// Copies a plane of the frame to the device, unless one of this name is there; whether one is.
    pub(crate) fn upload_as(&mut self, name: &'static str, plane: Option<&Plane>) -> bool {
        if let Some(plane) = plane.filter(|_| !self.has(name)) {
            let plane = self.upload().plane(plane);
            self.planes.insert(name, (plane, BufferUse::Upload));
        }
        self.has(name)
    }

    /// [`Recording::upload_as`] of the channels of a picture.
    pub(crate) fn upload_picture(&mut self, ColorPlanes { r, g, b }: &ColorPlanes) {
        for (name, plane) in PICTURE.into_iter().zip([r, g, b]) {
            self.upload_as(name, Some(plane));
        }
    }

    /// Copies the planes that shape is found from.
    pub(crate) fn upload_surface(&mut self) {
        let frame = self.frame;
        let covered = self.upload().coverage(&frame.mask);
        self.planes.insert("covered", (covered, BufferUse::Upload));
        let normal = &frame.normal;
        self.upload_as("normal_x", Some(&normal.x));
        self.upload_as("normal_y", Some(&normal.y));
        self.upload_as("normal_z", Some(&normal.z));
        self.upload_as("normal_length", frame.normal_length.as_ref());
    }

    /// Gives up a plane that no later kernel takes.
    pub(crate) fn drop_plane(&mut self, name: &str) {
        match self.planes.remove(name) {
            Some((plane, BufferUse::Kernels)) => self.buffers.recycle([plane]),
            // Copies precede all kernels of a run, so the memory is not free before its end.
            Some((plane, _)) => self.held.push(plane),
            None => {}
        }
    }

    /// Runs a kernel over all pixels. Its buffers are those named, or else planes of their names; planes that it writes are
    /// made if they are not there.
    pub(crate) fn over_pixels(
        &mut self,
        stage: &'static str,
        kernel: (&Kernel, &[(&'static str, bool)]),
        params: &impl Uniforms,
        named: &[(&str, &wgpu::Buffer)],
    ) {
        let [width, height] = self.size;
        let rows = height.div_ceil(kernel.0.rows);
        let groups = [width.div_ceil(GROUP[0]), rows.div_ceil(GROUP[1])];
        self.dispatch(stage, kernel, params, named, groups);
    }

    /// [`Recording::over_pixels`] over this many workgroups.
    pub(crate) fn dispatch<U: Uniforms>(
        &mut self,
        stage: &'static str,
        (kernel, switches): (&Kernel, &[(&'static str, bool)]),
        params: &U,
        named: &[(&str, &wgpu::Buffer)],
        groups: [u32; 2],
    ) {
        debug_assert!(kernel.takes::<U>(), "{} is given its own", kernel.name);
        let mut nowhere = Vec::new();
        let bound = kernel.bindings().map(|binding| {
            let is_named = |(name, _): &&(&str, &wgpu::Buffer)| *name == binding.name;
            if let Some((_, buffer)) = named.iter().find(is_named) {
                return (*buffer).clone();
            }
            if let Some((plane, _)) = self.planes.get(binding.name) {
                return plane.clone();
            }
            match (binding.is_written, binding.is_optional) {
                (true, false) => {
                    let plane = self.take(binding.element_bytes() * self.pixels());
                    self.put(binding.name, plane.clone());
                    plane
                }
                (true, true) => {
                    nowhere.push(self.take(NOWHERE));
                    nowhere[nowhere.len() - 1].clone()
                }
                (false, true) => self.plane("covered"),
                (false, false) => panic!("{} takes {}", kernel.name, binding.name),
            }
        });
        let bound: Vec<_> = bound.collect();
        let bytes = bytes_of(self.size, params);
        let kernel = (kernel, switches);
        self.recorder
            .dispatch(stage, kernel, &bytes, &bound, groups);
        self.buffers.recycle(nowhere);
    }

    fn pixels(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// A plane of vectors of this many numbers, with undefined contents.
    pub(crate) fn take_plane(&self, components: u64) -> wgpu::Buffer {
        self.take(4 * components * self.pixels())
    }

    /// A buffer of this many bytes with undefined contents.
    pub(crate) fn take(&self, bytes: u64) -> wgpu::Buffer {
        self.buffers.take(self.device, bytes, BufferUse::Kernels)
    }

    pub(crate) fn copy_of(&mut self, buffer: &wgpu::Buffer) -> wgpu::Buffer {
        let copy = self.take(buffer.size());
        self.recorder.copy(buffer, &copy);
        copy
    }

    /// Copies numbers to the device.
    pub(crate) fn uploaded(&mut self, numbers: &[f32]) -> wgpu::Buffer {
        let buffer = self.upload().bytes(bytemuck::cast_slice(numbers));
        self.held.push(buffer.clone());
        buffer
    }

    pub(crate) fn upload(&self) -> Upload<'_> {
        Upload {
            device: self.device,
            buffers: self.buffers,
        }
    }

    /// Copies a vector field to the device, x and y.
    pub(crate) fn hold_field(
        &mut self,
        Vector2Planes { x, y }: &Vector2Planes,
    ) -> [wgpu::Buffer; 2] {
        [x, y].map(|plane| self.uploaded(plane.samples()))
    }

    /// Runs the recorded work and returns the contents of `wanted`.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`] if the device fails.
    pub(crate) fn read_all(&mut self, wanted: &[&wgpu::Buffer]) -> Result<Vec<Vec<f32>>> {
        let (read, times) = self.recorder.read(wanted)?;
        if let Some(last) = self.at_work.take() {
            add_timings(&mut self.waited, &last.read()?.1.unwrap_or_default());
        }
        add_timings(&mut self.waited, &times);
        Ok(read)
    }

    /// Ends the run, whose buffers are reused: its timings, and the CPU run.
    pub(crate) fn finish(mut self) -> (StageTimings, Execution<'a>) {
        let names: Vec<_> = self.planes.keys().copied().collect();
        names.iter().for_each(|name| self.drop_plane(name));
        let further = self.more_gradients.into_iter().chain(self.more_curvatures);
        self.buffers.recycle(further);
        self.buffers.recycle_as(BufferUse::Upload, self.held);
        (self.waited, self.host)
    }
}
