//! The GPU as a caller sees it: plans run one after another, in memory that is kept on the device.

use crate::engine::cpu;
use crate::engine::device_times::{READ_BACK, UPLOAD};
use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::fault::{Fault, in_memory, watched};
use crate::engine::gpu::made::Layer;
use crate::engine::gpu::recorder::Programs;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::surface::{Upload, WIDEST, deinterleave};
use crate::engine::gpu::wait::wait_for;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::outcome::add_timings;
use crate::engine::run::Watch;
use crate::engine::tiles::Strips;
use crate::error::{Error, Result};
use crate::frame::{Frame, Plane};
use crate::light::enhancement::Subject;
use crate::light::layers::gpu::levels_of;
use crate::light::radiance_scaling::gpu::known_white_level;
use crate::light::relight::gpu::frame_lit;
use crate::light::relight::gpu_lights::{Light, LightCache};
use crate::line::direction_field::gpu_patches::largest_buffer;
use crate::line::hatching::gpu::TextureCache;
use crate::params::Adaptive;
use crate::plan::Plan;
use crate::plan::resolve::running;
use crate::product::Product;
use std::ops::Range;
use std::time::Instant;

/// Runs plans on a device, one after another. Results agree with those of the CPU within a few roundings.
#[derive(Debug)]
pub struct Runner {
    device: Device,
    programs: Programs,
    pub(crate) buffers: Buffers,
    /// The texture of strokes.
    pub(crate) texture: TextureCache,
    /// The CPU runner, for parts of drawings without kernels.
    pub(crate) host: cpu::Runner,
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

    /// Runs `plan` on `frame`: the picture, or the layers of the descriptor, or a drawing and its tone where that was made.
    /// The prepared environment is cached for the next run with the same one.
    ///
    /// Where the whole frame is too much for the device's memory it goes in strips. Of drawings the CPU finds strokes that
    /// are lines, the lines along edges, where strokes of a sequence have moved to, and in strips the directions of
    /// strokes. What was run before, and failed, changes nothing; on a device that was lost all fails.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost, has too little memory, or takes no picture as large as the environment;
    /// [`Error::Unfit`] if the plan was made for other inputs, or [`Runner::can_run`] is false.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        self.execute_watched(plan, frame, inputs, Watch::default())
    }

    /// [`Runner::execute`] that may be ended before each strip.
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

    /// A run with planes of no more than so many bytes.
    pub(crate) fn attempt(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        plane_bytes: u64,
        watch: Watch,
    ) -> std::result::Result<Outcome, Fault> {
        self.guarded(|| {
            if plan.relighting.is_none() {
                return self.run_parts(plan, frame, None, inputs, (plane_bytes, watch));
            }
            let illumination = inputs.illumination;
            let illumination = illumination.expect("new light is planned with its lights");
            let light = self
                .light
                .light(&self.device, plan, frame, illumination, watch)?;
            let mut outcome =
                self.run_parts(plan, frame, Some(&light), inputs, (plane_bytes, watch))?;
            outcome.environment_gain = light.around.gain();
            outcome.timings.splice(0..0, light.timings);
            Ok(outcome)
        })
    }

    /// Does `work` on a device that is there; where it fails nothing of it is kept.
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
            // Memory is free once nothing uses it; that a lost device does not answer has been reported.
            let _ = wait_for(&self.device.device, None);
        }
        done
    }

    /// How many rows of a frame go on the device at a time, with planes of no more than so many bytes.
    ///
    /// # Errors
    /// Where they are too long for it.
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
        light: Option<&Light>,
        inputs: Inputs,
        (plane_bytes, watch): (u64, Watch),
    ) -> std::result::Result<Outcome, Fault> {
        let height = frame.mask.height();
        let most_rows = self.most_rows(plan, frame, plane_bytes)?;
        let is_whole = most_rows >= height as u64;
        let drawing = plan.drawing.as_ref();
        match drawing {
            // Lines are placed when all of the tone is there, as that of a drawing in strips is.
            Some(params)
                if is_whole
                    && !params.strokes.style.is_laid()
                    && largest_buffer(&params.field, frame) <= plane_bytes =>
            {
                let drawn = self.draw_whole(plan, frame, params, light, inputs)?;
                if let Some(outcome) = drawn {
                    return Ok(outcome);
                }
            }
            None if is_whole => return Ok(self.run_whole(plan, frame, light, 0..height)?),
            _ => {}
        }
        let reach = match drawing {
            // The directions of a drawing are found on the whole.
            Some(_) => plan.clone().without(Product::Direction).reach(),
            None => plan.reach(),
        };
        let Some(strips) = Strips::new(reach, height, most_rows as usize) else {
            return Err(Fault::Strips(self.device.error(format_args!(
                "takes {most_rows} rows of this picture at a time, and its scale asks for {reach} to each side"
            ))));
        };
        let strips = strips.watched(watch);
        Ok(match drawing {
            Some(params) => self.draw_strips(plan, frame, params, light, inputs, &strips)?,
            None => self.run_strips(plan, frame, light, &strips)?,
        })
    }

    pub(crate) fn upload(&self) -> Upload<'_> {
        Upload {
            device: &self.device,
            buffers: &self.buffers,
        }
    }

    /// Copies what `plan` takes of `frame` to the device, and begins to record.
    pub(crate) fn start<'a>(&'a self, plan: &'a Plan, frame: &'a Frame) -> Run<'a> {
        self.buffers.begin_run();
        let mut chosen = [0.0; 2];
        chosen[WHITE as usize] = known_white_level(plan, frame).unwrap_or(1.0);
        if let Adaptive::Fixed(gain) = plan.scaling.curvature_gain {
            chosen[GAIN as usize] = gain;
        }
        let surface = self.upload().surface(plan, frame);
        if self.device.is_timed_apart {
            self.device.queue.submit([]);
            // Where it fails, so does the run.
            let _ = wait_for(&self.device.device, None);
        }
        Run::new(
            (plan, frame),
            &self.device,
            &self.programs,
            &self.buffers,
            surface,
            chosen,
        )
    }

    /// Runs `plan` on a frame whose planes the device takes: on these rows of the one that the light was made for.
    pub(crate) fn run_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        light: Option<&Light>,
        rows: Range<usize>,
    ) -> Result<Outcome> {
        let start = Instant::now();
        let copied = match light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None if plan.makes_picture() && !plan.display => self.upload().picture(frame),
            None => None,
        };
        let is_copied = copied.is_some();
        let mut run = self.start(plan, frame);
        (run.light, run.made.picture) = (light, copied);
        let uploaded = start.elapsed();
        running(plan).for_each(|stage| (stage.gpu)(&mut run));

        let mut made = std::mem::take(&mut run.made);
        let layers = match plan.wants(Product::Curvature) {
            true => made.layers(),
            false => Vec::new(),
        };
        let picture = made.picture.take();
        let numbers = run.chosen.clone();
        let mut wanted = vec![&numbers];
        wanted.extend(picture.iter().flatten());
        wanted.extend(layers.iter().flat_map(|layer| &layer.buffers));
        wanted.extend(made.term_whites.iter().map(|(_, white)| white));
        let (read, timings) = run.finish(&wanted)?;

        let mut read = read.into_iter();
        let chosen = read.next().expect("what was chosen is read first");
        let mut outcome = Outcome::default();
        outcome.timings.push((UPLOAD, uploaded));
        outcome.timings.extend(timings);
        let start = Instant::now();
        if picture.is_some() {
            let mut planes = read.by_ref().map(|samples| plane(frame, samples));
            outcome.put(Product::Picture, &mut planes);
        }
        if let (Some(color), Some(_)) = (&mut outcome.color, light) {
            frame_lit(color, frame);
        }
        put_layers(&mut outcome, plan, frame, &layers, read.by_ref());
        outcome.term_white_levels = levels_of(&made.term_whites, read);
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        if plan.wants_curvature() {
            outcome.gain = Some(chosen[GAIN as usize]);
        }
        if plan.scaled() == Some(Subject::Picture) {
            outcome.white_level = Some(chosen[WHITE as usize]);
        }
        let picture = picture.into_iter().flatten();
        self.buffers.recycle_either(picture, is_copied);
        self.buffers.recycle(made.into_buffers());
        Ok(outcome)
    }
}

fn plane(frame: &Frame, samples: Vec<f32>) -> Plane {
    Plane::from_samples(frame.mask.width(), frame.mask.height(), samples)
}

/// Puts what was read of the layers into the outcome: each product once, then those of further scales.
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

/// Bytes of a row of the widest plane that `plan` makes of `frame`: vectors of two, only of layers wider ones.
fn row_bytes(plan: &Plan, frame: &Frame) -> u64 {
    let has_layers = matches!(plan.scaled(), Some(Subject::Lobes | Subject::Groups));
    let widest = match plan.wants(Product::Curvature) || has_layers {
        true => WIDEST,
        false => 2,
    };
    4 * widest * frame.mask.width() as u64
}
