//! The GPU from the caller's side: plans run one after another, in memory kept on the device.

use crate::engine::cpu;
use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::run::Run as HostRun;
use crate::engine::device_times::{READ_BACK, UPLOAD};
use crate::engine::gpu::buffers::{Buffers, Purpose};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::fault::{Fault, in_memory, watched};
use crate::engine::gpu::made::{Layer, Made};
use crate::engine::gpu::recorder::{Programs, Recorder, Timings};
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
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::{Light, LightCache};
use crate::line::direction_field::gpu_patches::largest_buffer;
use crate::line::gpu_canvas::DeviceCanvas;
use crate::line::hatching::gpu_texture::TextureCache;
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

/// Stages of a plan that run on the device.
#[derive(Clone, Copy, PartialEq)]
enum Share {
    All,
    /// Stages of the shape and the picture; the CPU draws.
    ButDrawing,
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
    /// A frame too large for the device's memory is processed in strips. For drawings the CPU finds the lines along
    /// edges and inside surfaces, and where the strokes of a sequence have moved; it draws everything, with tone and
    /// edges from the device, where drawing needs the whole frame at once and the device cannot hold it: lines are
    /// placed relative to others, and directions spread over surfaces, across all strips. Failed runs do not affect
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
        let is_drawn_here = drawing.is_none_or(|params| {
            !params.strokes.style.is_laid() && largest_buffer(&params.field, frame) <= plane_bytes
        });
        if most_rows >= height as u64 && is_drawn_here {
            let whole = self.run_stages((plan, Share::All), frame, beside, 0..height)?;
            if let Some(outcome) = whole {
                return Ok(outcome);
            }
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
        let surface = self.upload().surface(plan, frame);
        if self.device.is_timed_apart {
            self.device.queue.submit([]);
            // If waiting fails, so does the run.
            let _ = wait_for(&self.device.device, None);
        }
        Run {
            plan,
            frame,
            light: beside.light,
            device: &self.device,
            buffers: &self.buffers,
            recorder: Recorder::new(&self.device, &self.programs, &self.buffers),
            surface,
            made: Made::default(),
            canvas: DeviceCanvas::default(),
            host: self.host_run(plan, frame, beside),
            texture: &self.texture,
            at_work: None,
            waited: Timings::new(),
            held: Vec::new(),
        }
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
        let made = self.run_stages((plan, Share::ButDrawing), strip, beside, rows)?;
        Ok(made.expect("only a drawing is too much"))
    }

    /// Runs stages on a frame that fits the device, given by its rows in the frame that the light was prepared for.
    /// `None` if a drawing's surfaces split into more patches than there is room for.
    fn run_stages(
        &self,
        (plan, share): (&Plan, Share),
        frame: &Frame,
        beside: Beside,
        rows: Range<usize>,
    ) -> Result<Option<Outcome>> {
        let start = Instant::now();
        let (stages, left): (Vec<_>, Vec<_>) = running(plan).partition(|stage| {
            let draws = DRAWING.iter().any(|drawing| drawing.name == stage.name);
            share == Share::All || !draws
        });
        let draws = plan.drawing.is_some() && share == Share::All;
        let copied = match beside.light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None if draws || plan.makes_picture() && !plan.display => self.upload().picture(frame),
            None => None,
        };
        let purpose = match copied {
            Some(_) => Purpose::Upload,
            None => Purpose::Kernels,
        };
        let mut run = self.start(plan, frame, beside);
        run.made.picture = copied;
        let uploaded = start.elapsed();
        run.go_through(&stages)?;

        let mut made = std::mem::take(&mut run.made);
        let canvas = std::mem::take(&mut run.canvas);
        let layers = layers_read(&made, plan, &left);
        let picture = made.picture.take();
        let is_shown = plan.makes_picture();
        let mut wanted = Vec::new();
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
        let mut outcome = Outcome::default();
        if is_shown && picture.is_some() {
            let mut planes = read.by_ref().map(|samples| plane(frame, samples));
            outcome.put(Product::Picture, &mut planes);
        }
        if let (Some(color), Some(_)) = (&mut outcome.color, beside.light) {
            frame_lit(color, frame);
        }
        put_layers(&mut outcome, plan, frame, &layers, read.by_ref());
        let is_drawn = canvas.put(&mut host, frame, &mut read);
        outcome.drawing = host.outcome.drawing.take();
        outcome.line_levels = host.outcome.line_levels;
        outcome.gain = host.outcome.gain;
        outcome.white_level = host.outcome.white_level;
        outcome.term_white_levels = std::mem::take(&mut host.outcome.term_white_levels);
        outcome.timings.push((UPLOAD, uploaded));
        add_timings(&mut outcome.timings, &host.outcome.timings);
        add_timings(&mut outcome.timings, &timings);
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        let picture = picture.into_iter().flatten();
        self.buffers.recycle_as(purpose, picture);
        let rest = made.into_buffers().chain(canvas.into_buffers());
        self.buffers.recycle(rest);
        Ok(is_drawn.then_some(outcome))
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
            (stage.gpu)(self);
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
