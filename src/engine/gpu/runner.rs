//! The GPU from the caller's side: plans run one after another, in memory kept on the device.

use crate::engine::cpu;
use crate::engine::cpu::runner::taken_by;
use crate::engine::inputs::PlanInputs;
use crate::error::{Error, Result};
use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane};
use crate::gpu::buffers::Buffers;
use crate::gpu::device::Device;
use crate::gpu::fault::{RunFault, watched};
use crate::gpu::recorder::{Programs, READ_BACK, Recorder, StageTimings, UPLOAD};
use crate::gpu::surface::deinterleave;
use crate::gpu::wait::wait_for;
use crate::kernel::last::Last;
use crate::kernel::shelf::Lent;
use crate::kernel::timings::add_timings;
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::{Light, LightCache};
use crate::line::hatching::gpu_texture::DeviceTexture;
use crate::line::tonal_art_map::TonalArtMap;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::outcome::Outcome;
use crate::plan::recording::{PICTURE, Recording};
use crate::plan::stage::{DevicePlanes, Stage};
use crate::plan::watch::Watch;
use crate::product::Product;
use crate::shape::curvature::gpu::DESCRIBED;
use std::collections::BTreeMap;
use std::time::Instant;

/// Inputs of a run other than plan and frame.
#[derive(Clone, Copy)]
pub(crate) struct DeviceInputs<'a> {
    inputs: PlanInputs<'a>,
    light: Option<&'a Light>,
    /// Memory for the parts run on the CPU.
    memory: &'a Memory,
    watch: Watch<'a>,
}

/// Runs plans on a device, one after another. Results agree with those of the CPU within a few roundings.
#[derive(Debug)]
pub struct DeviceRunner {
    pub(crate) device: Device,
    pub(crate) programs: Programs,
    pub(crate) buffers: Buffers,
    /// The texture of strokes.
    pub(crate) texture: Last<TonalArtMap, DeviceTexture>,
    /// Runs the parts of drawings without kernels.
    host: cpu::Runner,
    light: LightCache,
}

impl DeviceRunner {
    /// A runner on this device.
    pub fn new(device: Device) -> Self {
        Self {
            device,
            programs: Programs::default(),
            buffers: Buffers::default(),
            texture: Last::default(),
            host: cpu::Runner::default(),
            light: LightCache::default(),
        }
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// What `plan` takes that the device cannot do, in a few words; `None` if there is nothing.
    pub fn lacks(plan: &Plan) -> Option<&'static str> {
        let mut stages = plan.stages.iter();
        stages.find_map(|stage| (stage.gpu_lacks)(plan))
    }

    /// Stages of `plan` that the CPU runs while the device runs the others.
    pub(crate) fn left_to_cpu(plan: &Plan) -> Vec<&'static Stage> {
        let is_left = |stage: &&'static Stage| stage.gpu.is_none() && stage.after_gpu.is_none();
        plan.stages.iter().copied().filter(is_left).collect()
    }

    /// Runs `plan` on `frame`: the picture, or the layers of the descriptor, or a drawing and, if computed, its tone.
    /// The prepared environment is cached for the next run with the same one.
    ///
    /// Of a drawing the device finds edges and tone, and draws strokes of a texture; the CPU does the rest. Failed runs do
    /// not affect later ones; on a lost device all runs fail.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost, or too small for the frame or for its environment; [`Error::Unfit`] if the
    /// plan was made for other inputs, or [`DeviceRunner::lacks`] something.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: PlanInputs) -> Result<Outcome> {
        let done = self.attempt(plan, frame, inputs, Watch::default());
        done.map_err(RunFault::into_error)
    }

    /// [`DeviceRunner::execute`] that can be cancelled before each stage.
    ///
    /// # Errors
    /// [`RunFault::TooLarge`] if the device cannot hold the frame; [`RunFault::Other`] as [`DeviceRunner::execute`], and
    /// [`Error::Cancelled`].
    pub(crate) fn attempt(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
        watch: Watch,
    ) -> std::result::Result<Outcome, RunFault> {
        if let Some(what) = Self::lacks(plan) {
            return Err(RunFault::Other(Error::Unfit {
                found: format!("the GPU has no kernels for {what}"),
                remedy: "run it on the CPU",
            }));
        }
        inputs.check(plan, frame)?;
        self.check_size(plan, frame)?;
        let memory = &self.host.memory.for_run(watch.token());
        self.guarded(|| {
            let lit = plan.relighting().and(inputs.illumination);
            let light = lit.map(|lit| self.light.light(&self.device, plan, frame, lit, watch));
            let light = light.transpose()?;
            let beside = DeviceInputs {
                inputs,
                light: light.as_ref(),
                memory,
                watch,
            };
            let mut outcome = self.run(plan, frame, beside)?;
            if let Some(light) = light {
                outcome.environment_gain = light.around().gain();
                outcome.takes_picture = plan.relighting().is_some_and(|lit| lit.takes_picture());
                if let Some(lit) = plan.relighting() {
                    outcome.casts_shadows = lit.casting.choices();
                }
                outcome.light_choice = light.around().choice();
                outcome.timings.splice(0..0, light.timings);
            }
            Ok(outcome)
        })
    }

    /// Does `work` on a device that is not lost; after a failure all cached device objects are dropped.
    fn guarded<T>(
        &self,
        work: impl FnOnce() -> std::result::Result<T, RunFault>,
    ) -> std::result::Result<T, RunFault> {
        if self.device.is_lost() {
            return Err(self.device.error("is gone").into());
        }
        let done = watched(&self.device, work);
        let is_fault = !matches!(done, Ok(_) | Err(RunFault::Other(Error::Cancelled)));
        if is_fault {
            self.buffers.forget();
            self.programs.forget();
            self.light.forget_maps();
            self.texture.forget();
            // Memory is released once unused; a lost device has been reported already.
            let _ = wait_for(&self.device.device, None);
        }
        done
    }

    /// # Errors
    /// [`RunFault::TooLarge`] if planes of the frame exceed the limits of the device.
    fn check_size(&self, plan: &Plan, frame: &Frame) -> std::result::Result<(), RunFault> {
        let [width, height] = [frame.mask.width() as u64, frame.mask.height() as u64];
        let planes = 4 * widest(plan) * width * height;
        let [columns, rows] = self.device.most_pixels;
        let fits = planes <= self.device.plane_bytes;
        match fits && width <= columns && height <= rows {
            true => Ok(()),
            false => Err(RunFault::TooLarge(
                self.device
                    .error(format_args!("cannot hold a picture of {width}x{height}")),
            )),
        }
    }

    /// The CPU run for a frame.
    fn host_run<'a>(
        &'a self,
        plan: &'a Plan,
        frame: &'a Frame,
        beside: DeviceInputs<'a>,
    ) -> Execution<'a> {
        Execution {
            memory: beside.memory,
            watch: beside.watch,
            ..Execution::new(&self.host, plan, frame, beside.inputs.given())
        }
    }

    /// Uploads the inputs of `plan` from `frame`, and starts recording.
    pub(crate) fn start<'a>(
        &'a self,
        plan: &'a Plan,
        frame: &'a Frame,
        beside: DeviceInputs<'a>,
    ) -> Recording<'a> {
        self.buffers.begin_run();
        let mut run = Recording {
            plan,
            frame,
            lent: Lent::of(beside.light, Some(&self.texture)),
            device: &self.device,
            buffers: &self.buffers,
            recorder: Recorder::new(&self.device, &self.programs, &self.buffers),
            size: [frame.mask.width() as u32, frame.mask.height() as u32],
            planes: BTreeMap::new(),
            more_gradients: Vec::new(),
            more_curvatures: Vec::new(),
            host: self.host_run(plan, frame, beside),
            at_work: None,
            waited: StageTimings::new(),
            held: Vec::new(),
        };
        run.upload_surface();
        run
    }

    /// Runs `plan` on a frame that fits the device.
    fn run(&self, plan: &Plan, frame: &Frame, beside: DeviceInputs) -> Result<Outcome> {
        let start = Instant::now();
        let mut run = self.start(plan, frame, beside);
        let copied = match beside.light {
            Some(light) => light.albedo(plan, frame),
            None if plan.makes_picture() && !plan.display => frame.color.as_ref(),
            None => None,
        };
        if let Some(color) = copied {
            run.upload_picture(color);
        }
        run.host
            .made
            .outcome
            .timings
            .push((UPLOAD, start.elapsed()));
        run.record(&plan.stages)?;
        run.read_results(beside.light.is_some())?;
        run.go_on(&plan.stages)?;
        let (timings, host) = run.finish();
        let mut outcome = host.made.outcome;
        add_timings(&mut outcome.timings, &timings);
        Ok(outcome)
    }
}

/// The layers to read back from the device: those requested, and those that stages take on the CPU.
fn layers_read(run: &Recording) -> Vec<(&'static [Product], Vec<wgpu::Buffer>)> {
    let plan = run.plan;
    let stages = plan.stages.iter().copied();
    let on_cpu = stages.filter(|stage| stage.gpu.is_none() || stage.after_gpu.is_some());
    let taken = taken_by(&on_cpu.collect::<Vec<_>>(), plan);
    let is_read = |product: &Product| plan.wants(Product::Curvature) || taken.contains(product);
    let made = plan.stages.iter().flat_map(|stage| stage.gpu_planes);
    let layers = made.copied().filter(|(products, names)| {
        products.iter().any(is_read) && names.iter().all(|name| run.has(name))
    });
    let layer = |(products, names): DevicePlanes| {
        let planes = names.iter().map(|name| run.plane(name));
        (products, planes.collect())
    };
    let further = run.more_curvatures.iter();
    let further = further.map(|plane| (DESCRIBED, vec![plane.clone()]));
    layers.map(layer).chain(further).collect()
}

fn plane(frame: &Frame, samples: Vec<f32>) -> Plane {
    Plane::from_samples(frame.mask.width(), frame.mask.height(), samples)
}

/// Stores planes read back in the outcome: each product at the first scale, then those of further scales.
fn put_layers(
    outcome: &mut Outcome,
    plan: &Plan,
    frame: &Frame,
    layers: &[(&[Product], Vec<wgpu::Buffer>)],
    mut read: impl Iterator<Item = Vec<f32>>,
) {
    let mut sigmas = plan.more_px.iter();
    for (products, buffers) in layers {
        let components = products.iter().map(|p| p.row().components.len());
        let components: usize = components.sum();
        let samples = read.by_ref().take(buffers.len());
        let planes = samples.flat_map(|samples| match components / buffers.len() {
            1 => vec![samples],
            2 => deinterleave::<2>(&samples).into(),
            _ => deinterleave::<4>(&samples).into(),
        });
        let mut planes = planes.map(|samples| plane(frame, samples));
        let is_there = |product: &Product| !outcome.planes(*product).is_empty();
        match products.iter().any(is_there) {
            true => outcome.put_scale(*sigmas.next().expect("a scale each"), &mut planes),
            false => products
                .iter()
                .for_each(|&product| outcome.put(product, &mut planes)),
        }
    }
}

/// Samples per pixel of the widest buffer that `plan` computes.
fn widest(plan: &Plan) -> u64 {
    match plan.wants(Product::Curvature) {
        true => 4,
        false => 2,
    }
}

impl Recording<'_> {
    /// Records stages one after another, up to the first that the CPU runs.
    ///
    /// If the run is observed, each stage is submitted as soon as it is recorded, and the previous one is waited for:
    /// progress then follows the device, and a cancelled run leaves at most two stages to finish.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), checked before each of them; [`crate::Error::Gpu`] if the device
    /// fails.
    fn record(&mut self, stages: &[&'static Stage]) -> Result<()> {
        let watch = self.host.watch;
        let recorded = stages.iter().map_while(|stage| Some((stage, stage.gpu?)));
        for (done, (stage, record)) in recorded.enumerate() {
            watch.check()?;
            watch.begins(stage.name, done as f32 / stages.len() as f32);
            record(self);
            if watch.looks_on() {
                self.hand_over()?;
            }
        }
        watch.check()
    }

    /// Reads the results recorded so far into the outcome of the CPU run: the picture, in new light if it `is_lit`, and
    /// the layers.
    fn read_results(&mut self, is_lit: bool) -> Result<()> {
        let (plan, frame) = (self.plan, self.frame);
        let layers = layers_read(self);
        let makes_picture = plan.makes_picture() && self.has(PICTURE[0]);
        let picture = makes_picture.then(|| PICTURE.map(|name| self.plane(name)));
        let mut wanted: Vec<_> = picture.iter().flatten().collect();
        wanted.extend(layers.iter().flat_map(|(_, planes)| planes));
        let read = self.read_all(&wanted)?;

        let start = Instant::now();
        let mut read = read.into_iter();
        let outcome = &mut self.host.made.outcome;
        if picture.is_some() {
            let mut planes = read.by_ref().map(|samples| plane(frame, samples));
            outcome.put(Product::Picture, &mut planes);
        }
        if let Some(color) = outcome.color.as_mut().filter(|_| is_lit) {
            frame_lit(color, frame);
        }
        put_layers(outcome, plan, frame, &layers, read);
        add_timings(&mut self.waited, &[(READ_BACK, start.elapsed())]);
        Ok(())
    }

    /// What follows in stages once results are read back, the drawing above all.
    ///
    /// # Errors
    /// As [`Recording::record`].
    fn go_on(&mut self, stages: &[&'static Stage]) -> Result<()> {
        let watch = self.host.watch;
        for (done, stage) in stages.iter().enumerate() {
            watch.check()?;
            match (stage.after_gpu, stage.gpu) {
                (Some(pass), recorded) => {
                    if recorded.is_none() {
                        watch.begins(stage.name, done as f32 / stages.len() as f32);
                    }
                    pass(self)?;
                }
                (None, None) => (stage.cpu)(&mut self.host),
                (None, Some(_)) => (),
            }
        }
        watch.check()
    }
}
