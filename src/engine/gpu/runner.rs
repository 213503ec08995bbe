//! The GPU from the caller's side: plans run one after another, in memory kept on the device.

use crate::engine::cpu;
use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::run::Run as HostRun;
use crate::engine::cpu::runner::taken_by;
use crate::engine::device_times::{READ_BACK, UPLOAD};
use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::fault::{Fault, in_memory, watched};
use crate::engine::gpu::made::{Layer, Made};
use crate::engine::gpu::recorder::{Programs, Recorder};
use crate::engine::gpu::run::{Finished, Run};
use crate::engine::gpu::surface::{Upload, WIDEST, deinterleave};
use crate::engine::gpu::wait::wait_for;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::outcome::add_timings;
use crate::engine::tiles::Strips;
use crate::engine::watch::Watch;
use crate::error::{Error, Result};
use crate::frame::{Frame, Plane};
use crate::light::enhancement::Subject;
use crate::light::layers::gpu::levels_of;
use crate::light::radiance_scaling::gpu::known_white_level;
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::{Light, LightCache};
use crate::line::hatching::gpu_texture::TextureCache;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::resolve::running;
use crate::plan::stage::Stage;
use crate::plan::stages::DRAWING;
use crate::product::Product;
use std::ops::Range;
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

    /// Whether all stages of `plan` have kernels.
    pub fn can_run(plan: &Plan) -> bool {
        Self::lacks(plan).is_none()
    }

    /// The part of `plan` without kernels, in a few words; `None` if there is none.
    pub fn lacks(plan: &Plan) -> Option<&'static str> {
        running(plan).find_map(|stage| (stage.gpu_lacks)(plan))
    }

    /// Runs `plan` on `frame`: the picture, or the layers of the descriptor, or a drawing and, if computed, its tone.
    /// The prepared environment is cached for the next run with the same one.
    ///
    /// A frame too large for the device's memory is processed in strips. Of a drawing the device finds edges and tone,
    /// and draws strokes of a texture if it can hold the whole frame; the CPU does the rest. Failed runs do not affect
    /// later ones; on a lost device all runs fail.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost, is out of memory, or cannot hold a picture as large as the environment;
    /// [`Error::Unfit`] if the plan was made for other inputs, or [`Runner::can_run`] is false.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        self.execute_watched(plan, frame, inputs, Watch::default())
    }

    /// [`Runner::execute`] that can be cancelled before each strip.
    ///
    /// # Errors
    /// As [`Runner::execute`]; [`Error::Cancelled`].
    pub(crate) fn execute_watched(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        watch: Watch,
    ) -> Result<Outcome> {
        if let Some(what) = Self::lacks(plan) {
            return Err(Error::Unfit {
                found: format!("the GPU has no kernels for {what}"),
                remedy: "run it on the CPU",
            });
        }
        inputs.check(plan, frame)?;
        let whole = row_bytes(plan, frame) * frame.mask.height() as u64;
        in_memory(self.device.plane_bytes.min(whole), |plane_bytes| {
            self.attempt(plan, frame, inputs, plane_bytes, watch)
        })
    }

    /// A run with planes of at most `plane_bytes`.
    pub(crate) fn attempt(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        plane_bytes: u64,
        watch: Watch,
    ) -> std::result::Result<Outcome, Fault> {
        let memory = &self.host.memory.for_run(watch.token());
        let beside = Beside {
            inputs,
            light: None,
            memory,
            watch,
        };
        self.guarded(|| {
            if plan.relighting.is_none() {
                return self.run_parts(plan, frame, beside, plane_bytes);
            }
            let illumination = inputs.illumination;
            let illumination = illumination.expect("new light is planned with its lights");
            let light = self
                .light
                .light(&self.device, plan, frame, illumination, watch)?;
            let beside = Beside {
                light: Some(&light),
                ..beside
            };
            let mut outcome = self.run_parts(plan, frame, beside, plane_bytes)?;
            outcome.environment_gain = light.around.gain();
            outcome.timings.splice(0..0, light.timings);
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

    /// Maximum number of rows of a frame on the device at a time, with planes of at most `plane_bytes`.
    ///
    /// # Errors
    /// If the rows are too long for the device.
    fn most_rows(&self, plan: &Plan, frame: &Frame, plane_bytes: u64) -> Result<u64> {
        let width = frame.mask.width();
        let [most_columns, most_rows] = self.device.most_pixels;
        if width as u64 > most_columns {
            let found = format_args!("takes {most_columns} columns at a time, not {width}");
            return Err(self.device.error(found));
        }
        Ok(most_rows.min(plane_bytes / row_bytes(plan, frame).max(1)))
    }

    fn run_parts(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        plane_bytes: u64,
    ) -> std::result::Result<Outcome, Fault> {
        let height = frame.mask.height();
        let most_rows = self.most_rows(plan, frame, plane_bytes)?;
        let drawing = plan.drawing.as_ref();
        if most_rows >= height as u64 {
            let stages: Vec<_> = running(plan).collect();
            return Ok(self.run_stages(plan, &stages, frame, beside, 0..height)?);
        }
        let reach = match drawing {
            // A drawing's directions are found on the whole frame.
            Some(_) => plan.clone().without(Product::Direction).reach(),
            None => plan.reach(),
        };
        if plan.tile.is_some() && most_rows < height as u64 {
            return Err(Fault::Strips(self.device.error(format_args!(
                "takes {most_rows} rows of this picture at a time, and a tile is diffused as a whole"
            ))));
        }
        let Some(strips) = Strips::new(reach, height, most_rows as usize) else {
            return Err(Fault::Strips(self.device.error(format_args!(
                "takes {most_rows} rows of this picture at a time, and its scale asks for {reach} to each side"
            ))));
        };
        let strips = strips.watched(beside.watch);
        let outcome = self.run_strips(plan, frame, beside, &strips)?;
        Ok(match drawing {
            Some(_) => self.drawn_by_host(plan, frame, beside, outcome)?,
            None => outcome,
        })
    }

    /// The CPU run for a frame.
    fn host_run<'a>(&'a self, plan: &'a Plan, frame: &'a Frame, beside: Beside<'a>) -> HostRun<'a> {
        HostRun {
            memory: beside.memory,
            watch: beside.watch,
            ..HostRun::new(&self.host, plan, frame, beside.inputs)
        }
    }

    /// Draws on the CPU, with tone and edges from the device.
    fn drawn_by_host(
        &self,
        plan: &Plan,
        frame: &Frame,
        beside: Beside,
        made: Outcome,
    ) -> Result<Outcome> {
        let mut run = HostRun {
            outcome: made,
            ..self.host_run(plan, frame, beside)
        };
        run.go_through(DRAWING)?;
        Ok(run.outcome)
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
        if self.device.is_timed_apart {
            self.device.queue.submit([]);
            // If waiting fails, so does the run.
            let _ = wait_for(&self.device.device, None);
        }
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

    /// Runs the stages of `plan` for shape and picture on a strip, given by its rows in the frame that the light was
    /// prepared for. Reads back the shape that the plan asks for and that drawing needs.
    pub(crate) fn run_strip(
        &self,
        plan: &Plan,
        strip: &Frame,
        beside: Beside,
        rows: Range<usize>,
    ) -> Result<Outcome> {
        let stages: Vec<_> = running(plan).filter(|stage| !draws(stage)).collect();
        self.run_stages(plan, &stages, strip, beside, rows)
    }

    /// Runs stages on a frame that fits the device, given by its rows in the frame that the light was prepared for.
    fn run_stages(
        &self,
        plan: &Plan,
        stages: &[&'static Stage],
        frame: &Frame,
        beside: Beside,
        rows: Range<usize>,
    ) -> Result<Outcome> {
        let start = Instant::now();
        let copied = match beside.light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None if plan.makes_picture() && !plan.display => self.upload().picture(frame),
            None => None,
        };
        let is_copied = copied.is_some();
        let mut run = self.start(plan, frame, beside);
        run.made.picture = copied;
        run.host.outcome.timings.push((UPLOAD, start.elapsed()));
        run.record(stages)?;
        run.read_results(beside.light.is_some())?;
        run.go_on(stages)?;
        let Finished {
            mut made,
            timings,
            host,
        } = run.finish();
        let mut outcome = host.outcome;
        add_timings(&mut outcome.timings, &timings);
        let picture = made.picture.take().into_iter().flatten();
        self.buffers.recycle_either(picture, is_copied);
        self.buffers.recycle(made.into_buffers());
        Ok(outcome)
    }
}

/// Whether a stage is one of a drawing: the CPU runs these.
fn draws(stage: &Stage) -> bool {
    DRAWING.iter().any(|drawing| drawing.name == stage.name)
}

/// The layers to read back from the device: those requested, and those that stages take on the CPU.
fn layers_read(made: &Made, plan: &Plan) -> Vec<Layer> {
    let mut layers = made.layers();
    if !plan.wants(Product::Curvature) {
        let on_cpu = running(plan).filter(|stage| draws(stage) || stage.after_gpu.is_some());
        let taken = taken_by(on_cpu, plan);
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

/// Bytes per row of the widest plane that `plan` computes for `frame`: vectors of two; wider ones for layers only.
fn row_bytes(plan: &Plan, frame: &Frame) -> u64 {
    let has_layers = matches!(plan.scaled(), Some(Subject::Lobes | Subject::Groups));
    let widest = match plan.wants(Product::Curvature) || has_layers {
        true => WIDEST,
        false => 2,
    };
    4 * widest * frame.mask.width() as u64
}

impl Run<'_> {
    /// Records stages one after another, up to those of a drawing.
    ///
    /// If the run is observed, each stage is submitted as soon as it is recorded, and the previous one is waited for:
    /// progress then follows the device, and a cancelled run leaves at most two stages to finish.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), checked before each of them; [`crate::Error::Gpu`] if the device
    /// fails.
    fn record(&mut self, stages: &[&'static Stage]) -> Result<()> {
        let watch = self.host.watch;
        let recorded = stages.iter().take_while(|stage| !draws(stage));
        for (done, stage) in recorded.enumerate() {
            watch.check()?;
            watch.begins(stage.name, done as f32 / stages.len() as f32);
            (stage.gpu)(self);
            if watch.looks_on() {
                self.hand_over()?;
            }
        }
        watch.check()
    }

    /// Reads the results recorded so far into the outcome of the CPU run: the picture, in new light if it `is_lit`, the
    /// layers, and what was chosen.
    fn read_results(&mut self, is_lit: bool) -> Result<()> {
        let (plan, frame) = (self.plan, self.frame);
        let layers = layers_read(&self.made, plan);
        let picture = self.made.picture.clone().filter(|_| plan.makes_picture());
        let chosen = self.chosen.clone();
        let whites = std::mem::take(&mut self.made.term_whites);
        let mut wanted = vec![&chosen];
        wanted.extend(picture.iter().flatten());
        wanted.extend(layers.iter().flat_map(|layer| &layer.buffers));
        wanted.extend(whites.iter().map(|(_, white)| white));
        let read = self.read(&wanted)?;

        let start = Instant::now();
        let mut read = read.into_iter();
        let chosen = read.next().expect("what was chosen is read first");
        let outcome = &mut self.host.outcome;
        if picture.is_some() {
            let mut planes = read.by_ref().map(|samples| plane(frame, samples));
            outcome.put(Product::Picture, &mut planes);
        }
        if let Some(color) = outcome.color.as_mut().filter(|_| is_lit) {
            frame_lit(color, frame);
        }
        put_layers(outcome, plan, frame, &layers, read.by_ref());
        outcome.term_white_levels = levels_of(&whites, read);
        if plan.wants_curvature() {
            outcome.gain = Some(chosen[GAIN as usize]);
        }
        if plan.scaled() == Some(Subject::Picture) {
            outcome.white_level = Some(chosen[WHITE as usize]);
        }
        add_timings(&mut self.waited, &[(READ_BACK, start.elapsed())]);
        Ok(())
    }

    /// What follows in stages once results are read back, the drawing above all.
    ///
    /// # Errors
    /// As [`Run::record`].
    fn go_on(&mut self, stages: &[&'static Stage]) -> Result<()> {
        let watch = self.host.watch;
        for (done, stage) in stages.iter().enumerate() {
            watch.check()?;
            if draws(stage) {
                watch.begins(stage.name, done as f32 / stages.len() as f32);
            }
            match stage.after_gpu {
                Some(pass) => pass(self)?,
                None if draws(stage) => (stage.cpu)(&mut self.host),
                None => (),
            }
        }
        watch.check()
    }
}
