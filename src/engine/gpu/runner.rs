//! The GPU from the caller's side: plans run one after another, in memory kept on the device.

use crate::engine::cpu;
use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::run::Run as HostRun;
use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::fault::{Fault, watched};
use crate::engine::gpu::made::{Layer, Made};
use crate::engine::gpu::recorder::{Programs, READ_BACK, Recorder, UPLOAD};
use crate::engine::gpu::run::{Finished, Run};
use crate::engine::gpu::surface::{Upload, deinterleave};
use crate::engine::gpu::wait::wait_for;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::outcome::add_timings;
use crate::engine::watch::Watch;
use crate::error::{Error, Result};
use crate::frame::{Frame, Plane};
use crate::light::enhancement::Subject;
use crate::light::radiance_scaling::gpu::known_white_level;
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::{Light, LightCache};
use crate::line::direction_field::gpu_patches::largest_buffer;
use crate::line::hatching::gpu_texture::TextureCache;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::resolve::running;
use crate::plan::stage::Stage;
use crate::plan::stages::DRAWING;
use crate::product::Product;
use std::time::Instant;

/// Inputs of a run other than plan and frame.
#[derive(Clone, Copy)]
pub(crate) struct Beside<'a> {
    inputs: Inputs<'a>,
    light: Option<&'a Light<'a>>,
    /// Memory for the parts run on the CPU.
    memory: &'a Memory,
    watch: Watch<'a>,
}

#[cfg(test)]
impl<'a> Beside<'a> {
    /// No inputs, no light and no observer.
    pub(crate) fn nothing(memory: &'a Memory) -> Self {
        Self {
            inputs: Inputs::default(),
            light: None,
            memory,
            watch: Watch::default(),
        }
    }
}

/// Runs plans on a device, one after another. Results agree with those of the CPU within a few roundings.
#[derive(Debug)]
pub struct Runner {
    pub(crate) device: Device,
    pub(crate) programs: Programs,
    pub(crate) buffers: Buffers,
    /// The texture of strokes.
    pub(crate) texture: TextureCache,
    /// Runs the parts of drawings without kernels.
    host: cpu::Runner,
    light: LightCache,
}

impl Runner {
    /// A runner on this device.
    pub fn new(device: Device) -> Self {
        Self {
            device,
            programs: Programs::default(),
            buffers: Buffers::default(),
            texture: TextureCache::default(),
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
        running(plan).find_map(|stage| (stage.gpu_lacks)(plan))
    }

    /// Stages of `plan` that the CPU runs while the device runs the others.
    pub(crate) fn left_to_cpu(plan: &Plan) -> Vec<&'static Stage> {
        let is_left = |stage: &&'static Stage| stage.gpu.is_none() || follows(plan, stage);
        running(plan).filter(is_left).collect()
    }

    /// Runs `plan` on `frame`: the picture, or the layers of the descriptor, or a drawing and, if computed, its tone.
    /// The prepared environment is cached for the next run with the same one.
    ///
    /// The CPU finds the lines along edges and inside surfaces of a drawing, and where the strokes of a sequence have
    /// moved; strokes that are lines it lays in the tone and along the edges from the device. Failed runs do not affect
    /// later ones; on a lost device all runs fail.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost, or too small for the frame or for its environment; [`Error::Unfit`] if the
    /// plan was made for other inputs, or [`Runner::lacks`] something.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        let done = self.attempt(plan, frame, inputs, Watch::default());
        done.map_err(Fault::into_error)
    }

    /// [`Runner::execute`] that can be cancelled before each stage.
    ///
    /// # Errors
    /// [`Fault::TooLarge`] if the device cannot hold the frame; [`Fault::Other`] as [`Runner::execute`], and
    /// [`Error::Cancelled`].
    pub(crate) fn attempt(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        watch: Watch,
    ) -> std::result::Result<Outcome, Fault> {
        if let Some(what) = Self::lacks(plan) {
            return Err(Fault::Other(Error::Unfit {
                found: format!("the GPU has no kernels for {what}"),
                remedy: "run it on the CPU",
            }));
        }
        inputs.check(plan, frame)?;
        self.check_size(plan, frame)?;
        let memory = &self.host.memory.for_run(watch.token());
        self.guarded(|| {
            let lit = plan.relighting.as_ref().and(inputs.illumination);
            let light = lit.map(|lit| self.light.light(&self.device, plan, frame, lit, watch));
            let light = light.transpose()?;
            let beside = Beside {
                inputs,
                light: light.as_ref(),
                memory,
                watch,
            };
            let mut outcome = self.run(plan, frame, beside)?;
            if let Some(light) = light {
                outcome.environment_gain = light.around.gain();
                outcome.timings.splice(0..0, light.timings);
            }
            Ok(outcome)
        })
    }

    /// Does `work` on a device that is not lost; after a failure all cached device objects are dropped.
    fn guarded<T>(
        &self,
        work: impl FnOnce() -> std::result::Result<T, Fault>,
    ) -> std::result::Result<T, Fault> {
        if self.device.is_lost() {
            return Err(self.device.error("is gone").into());
        }
        let done = watched(&self.device, work);
        let is_fault = !matches!(done, Ok(_) | Err(Fault::Other(Error::Cancelled)));
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
    /// [`Fault::TooLarge`] if planes of the frame exceed the limits of the device.
    fn check_size(&self, plan: &Plan, frame: &Frame) -> std::result::Result<(), Fault> {
        let [width, height] = [frame.mask.width() as u64, frame.mask.height() as u64];
        let planes = 4 * widest(plan) * width * height;
        let patches = plan.drawing.as_ref().filter(|_| draws(plan));
        let patches = patches.map_or(0, |params| largest_buffer(&params.field, frame));
        let [columns, rows] = self.device.most_pixels;
        let fits = planes.max(patches) <= self.device.plane_bytes;
        match fits && width <= columns && height <= rows {
            true => Ok(()),
            false => Err(Fault::TooLarge(
                self.device
                    .error(format_args!("cannot hold a picture of {width}x{height}")),
            )),
        }
    }

    /// The CPU run for a frame.
    fn host_run<'a>(&'a self, plan: &'a Plan, frame: &'a Frame, beside: Beside<'a>) -> HostRun<'a> {
        HostRun {
            memory: beside.memory,
            watch: beside.watch,
            ..HostRun::new(&self.host, plan, frame, beside.inputs)
        }
    }

    pub(crate) fn upload(&self) -> Upload<'_> {
        Upload {
            device: &self.device,
            buffers: &self.buffers,
        }
    }

    /// Uploads the inputs of `plan` from `frame`, and starts recording.
    pub(crate) fn start<'a>(
        &'a self,
        plan: &'a Plan,
        frame: &'a Frame,
        beside: Beside<'a>,
    ) -> Run<'a> {
        self.buffers.begin_run();
        let mut chosen = [0.0; 2];
        chosen[WHITE as usize] = known_white_level(plan, frame).unwrap_or(1.0);
        if let Adaptive::Fixed(gain) = plan.scaling.curvature_gain {
            chosen[GAIN as usize] = gain;
        }
        let surface = self.upload().surface(plan, frame);
        let host = self.host_run(plan, frame, beside);
        let place = (&self.device, &self.buffers);
        let recorder = Recorder::new(&self.device, &self.programs, &self.buffers);
        Run::new(
            place,
            recorder,
            &self.texture,
            host,
            beside.light,
            surface,
            chosen,
        )
    }

    /// Runs `plan` on a frame that fits the device; the CPU draws where strokes are lines.
    fn run(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
    ) -> std::result::Result<Outcome, Fault> {
        let start = Instant::now();
        let (stages, left): (Vec<_>, Vec<_>) =
            running(plan).partition(|stage| !follows(plan, stage));
        let copied = match beside.light {
            Some(light) => light.albedo(plan, frame),
            None if draws(plan) || plan.makes_picture() && !plan.display => frame.color.as_ref(),
            None => None,
        };
        let copied = copied.map(|color| self.upload().color(color));
        let is_copied = copied.is_some();
        let mut run = self.start(plan, frame, beside);
        run.made.picture = copied;
        let uploaded = start.elapsed();
        run.go_through(&stages)?;

        let mut made = std::mem::take(&mut run.made);
        let canvas = std::mem::take(&mut run.canvas);
        let layers = layers_read(&made, plan, &left);
        let picture = made.picture.take();
        let is_shown = plan.makes_picture();
        let numbers = run.chosen.clone();
        let mut wanted = vec![&numbers];
        wanted.extend(picture.iter().flatten().filter(|_| is_shown));
        wanted.extend(layers.iter().flat_map(|layer| &layer.buffers));
        wanted.extend(canvas.wanted());
        let Finished {
            read,
            timings,
            mut host,
        } = run.finish(&wanted)?;

        let start = Instant::now();
        let mut read = read.into_iter();
        let chosen = read.next().expect("what was chosen is read first");
        let mut outcome = Outcome::default();
        if is_shown && picture.is_some() {
            let mut planes = read.by_ref().map(|samples| plane(frame, samples));
            outcome.put(Product::Picture, &mut planes);
        }
        if let (Some(color), Some(_)) = (&mut outcome.color, beside.light) {
            frame_lit(color, frame);
        }
        put_layers(&mut outcome, plan, frame, &layers, read.by_ref());
        if !canvas.put(&mut host, frame, &mut read) {
            let found = "has no room for the patches of these surfaces";
            return Err(Fault::TooLarge(self.device.error(found)));
        }
        outcome.drawing = host.outcome.drawing.take();
        outcome.line_levels = host.outcome.line_levels;
        outcome.timings.push((UPLOAD, uploaded));
        add_timings(&mut outcome.timings, &host.outcome.timings);
        add_timings(&mut outcome.timings, &timings);
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        if plan.wants_curvature() {
            outcome.gain = Some(chosen[GAIN as usize]);
        }
        if plan.scaled() == Some(Subject::Picture) {
            outcome.white_level = Some(chosen[WHITE as usize]);
        }
        let picture = picture.into_iter().flatten();
        self.buffers.recycle_either(picture, is_copied);
        let rest = made.into_buffers().chain(canvas.into_buffers());
        self.buffers.recycle(rest);
        if left.is_empty() {
            return Ok(outcome);
        }
        let mut run = HostRun {
            outcome,
            ..self.host_run(plan, frame, beside)
        };
        run.go_through(left)?;
        Ok(run.outcome)
    }
}

/// The layers to read back from the device: those requested, and those needed by the stages `left` to the CPU.
fn layers_read(made: &Made, plan: &Plan, left: &[&'static Stage]) -> Vec<Layer> {
    let taken: Vec<Product> = left.iter().flat_map(|stage| (stage.takes)(plan)).collect();
    let mut layers = made.layers();
    if !plan.wants(Product::Curvature) {
        layers.retain(|layer| layer.products.iter().any(|product| taken.contains(product)));
    }
    layers
}

fn plane(frame: &Frame, samples: Vec<f32>) -> Plane {
    Plane::from_samples(frame.mask.width(), frame.mask.height(), samples)
}

/// Stores the layers read back in the outcome: each product at the first scale, then those of further scales.
fn put_layers(
    outcome: &mut Outcome,
    plan: &Plan,
    frame: &Frame,
    layers: &[Layer],
    mut read: impl Iterator<Item = Vec<f32>>,
) {
    let mut sigmas = plan.more_px.iter();
    for layer in layers {
        let components = layer.products.iter();
        let components: usize = components.map(|p| p.row().components.len()).sum();
        let samples = read.by_ref().take(layer.buffers.len());
        let planes = samples.flat_map(|samples| match components / layer.buffers.len() {
            1 => vec![samples],
            2 => deinterleave::<2>(&samples).into(),
            _ => deinterleave::<4>(&samples).into(),
        });
        let mut planes = planes.map(|samples| plane(frame, samples));
        let is_there = |product: &Product| !outcome.planes(*product).is_empty();
        match layer.products.iter().any(is_there) {
            true => outcome.put_scale(*sigmas.next().expect("a scale each"), &mut planes),
            false => layer
                .products
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

/// Whether the device draws. Strokes that are lines are placed one after the other, on the CPU.
fn draws(plan: &Plan) -> bool {
    let drawing = plan.drawing.as_ref();
    drawing.is_some_and(|params| !params.strokes.style.is_laid())
}

/// Whether the CPU runs this stage after all that the device does.
fn follows(plan: &Plan, stage: &Stage) -> bool {
    !draws(plan) && DRAWING.iter().any(|drawing| drawing.name == stage.name)
}

impl Run<'_> {
    /// Records stages one after another; then the CPU does its part of them while the device works.
    ///
    /// If the run is observed, each stage is submitted as soon as it is recorded, and the previous one is waited for:
    /// progress then follows the device, and a cancelled run leaves at most two stages to finish.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), checked before each of them; [`crate::Error::Gpu`] if the device
    /// fails.
    pub(crate) fn go_through(&mut self, stages: &[&'static Stage]) -> Result<()> {
        let watch = self.host.watch;
        let (mut done, mut next) = (0.0, Vec::new());
        for stage in stages {
            watch.check()?;
            watch.begins(stage.name, done);
            match (stage.gpu, stage.beside_gpu) {
                (Some(record), _) => record(self),
                (None, Some(_)) => {}
                (None, None) => (stage.cpu)(&mut self.host),
            }
            if watch.looks_on() {
                self.hand_over()?;
            }
            next.extend(stage.beside_gpu);
            done += 1.0 / stages.len() as f32;
        }
        watch.check()?;
        if !next.is_empty() && !watch.looks_on() {
            self.hand_over()?;
        }
        for beside in next {
            watch.check()?;
            beside(self)?;
        }
        Ok(())
    }
}
