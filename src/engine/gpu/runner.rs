//! The GPU as a caller sees it: plans run one after another, in memory that is kept on the device.

use crate::engine::cpu;
use crate::engine::device_times::{READ_BACK, UPLOAD};
use crate::engine::gpu::buffers::Buffers;
use crate::engine::gpu::constants::{GAIN, WHITE};
use crate::engine::gpu::device::Device;
use crate::engine::gpu::enhance::known_white_level;
use crate::engine::gpu::fault::{Fault, in_memory, watched};
use crate::engine::gpu::hatching::TextureCache;
use crate::engine::gpu::light::{Light, MapCache};
use crate::engine::gpu::light_layers::{TermWhites, levels_of};
use crate::engine::gpu::patches::largest_buffer;
use crate::engine::gpu::recorder::{Programs, add_timings};
use crate::engine::gpu::relight::frame_lit;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::shape::{Curvatures, Shape};
use crate::engine::gpu::strips::Strips;
use crate::engine::gpu::surface::Upload;
use crate::engine::gpu::wait::wait_for;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::{Outcome, ScaleShape};
use crate::error::{Error, Result};
use crate::frame::CurvaturePlanes;
use crate::frame::{ColorPlanes, Frame, Plane, SymmetricPlanes, Vector2Planes};
use crate::light::prepared_environment::EnvironmentCache;
use crate::params::Adaptive;
use crate::plan::{Goal, Plan, Stage};
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// Samples of a pixel in the widest buffers: those of layers, of the descriptor and of light.
pub(crate) const WIDEST: u64 = 4;

/// Stages that change the picture.
pub(crate) const SCALES: [Stage; 4] = [
    Stage::RadianceScaling,
    Stage::LightLobes,
    Stage::LightGroups,
    Stage::AmbientOcclusion,
];

/// Runs plans on a device, one after another. Results agree with those of the CPU within a few roundings.
#[derive(Debug)]
pub struct Runner {
    device: Device,
    programs: Programs,
    pub(crate) buffers: Buffers,
    /// The texture of strokes.
    pub(crate) texture: TextureCache,
    /// What makes the parts of drawings that have no kernels.
    pub(crate) host: cpu::Runner,
    pub(crate) environment: EnvironmentCache,
    pub(crate) maps: MapCache,
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
            environment: EnvironmentCache::default(),
            maps: MapCache::default(),
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

    /// What of `plan` has no kernels, in a few words; `None` where all of it has.
    pub fn lacks(plan: &Plan) -> Option<&'static str> {
        let relighting = plan.relighting.as_ref();
        let is_traced = relighting.is_some_and(|relighting| relighting.traced);
        if is_traced || plan.has(Stage::SpecularTrace) {
            Some("mirrors and lenses that show what is traced")
        } else if relighting.is_some_and(|relighting| relighting.grain) {
            Some("a grain along the curvature")
        } else {
            None
        }
    }

    /// Runs `plan` on `frame`: the picture, or the layers of the descriptor, or a drawing and its tone where that was made.
    /// What is made of an environment is kept for the next run in the same one.
    ///
    /// Where the whole frame is too much for the device's memory it goes in strips. Of drawings the CPU finds strokes that
    /// are lines, the lines along edges, where strokes of a sequence have moved to, and in strips the directions of
    /// strokes. What was run before, and failed, changes nothing; on a device that was lost all fails.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the device is lost, has too little memory, or takes no picture as large as the environment;
    /// [`Error::Unfit`] if the plan was made for other inputs, or [`Runner::can_run`] is false.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        if let Some(what) = Self::lacks(plan) {
            return Err(Error::Unfit {
                found: format!("the GPU has no kernels for {what}"),
                remedy: "run it on the CPU",
            });
        }
        inputs.check(plan, frame)?;
        let whole = row_bytes(plan, frame) * frame.mask.height() as u64;
        in_memory(self.device.plane_bytes.min(whole), |plane_bytes| {
            self.attempt(plan, frame, inputs, plane_bytes)
        })
    }

    /// A run with planes of no more than so many bytes.
    pub(crate) fn attempt(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        plane_bytes: u64,
    ) -> std::result::Result<Outcome, Fault> {
        self.guarded(|| {
            if plan.goal != Goal::Relight {
                return self.run_parts(plan, frame, None, inputs, plane_bytes);
            }
            let illumination = inputs.illumination;
            let illumination = illumination.expect("new light is planned with its lights");
            let light = self.light(plan, frame, illumination)?;
            let mut outcome = self.run_parts(plan, frame, Some(&light), inputs, plane_bytes)?;
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
        if done.is_err() {
            self.buffers.forget();
            self.programs.forget();
            self.maps.forget();
            self.texture.forget();
            // Memory is free when nothing uses it any more; that a lost device does not answer was told.
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
        plane_bytes: u64,
    ) -> std::result::Result<Outcome, Fault> {
        let height = frame.mask.height();
        let most_rows = self.most_rows(plan, frame, plane_bytes)?;
        let is_whole = most_rows >= height as u64;
        let drawing = plan.drawing.as_ref();
        match drawing {
            // Lines are placed when all of the tone is there, as that of a drawing in strips is.
            Some(params)
                if is_whole
                    && !plan.has(Stage::Streamlines)
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
            Some(_) => plan.clone().without_directions().reach(),
            None => plan.reach(),
        };
        let Some(strips) = Strips::new(reach, height, most_rows as usize) else {
            return Err(Fault::Strips(self.device.error(format_args!(
                "takes {most_rows} rows of this picture at a time, and its scale asks for {reach} to each side"
            ))));
        };
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
    pub(crate) fn start(&self, plan: &Plan, frame: &Frame) -> Run<'_> {
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
        Run::new(&self.device, &self.programs, &self.buffers, surface, chosen)
    }

    /// Runs `plan` on a frame whose planes the device takes: on these rows of the one that the light was made for.
    pub(crate) fn run_whole(
        &self,
        plan: &Plan,
        frame: &Frame,
        light: Option<&Light>,
        rows: Range<usize>,
    ) -> Result<Outcome> {
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let start = Instant::now();
        let mut picture = match light {
            Some(light) => light.albedo(self.upload(), plan, frame, &rows),
            None if plan.goal == Goal::Enhance => self.upload().picture(frame),
            None => None,
        };
        let is_copied = picture.is_some();
        let mut run = self.start(plan, frame);
        let uploaded = start.elapsed();

        let shape = plan.has(Stage::Conductance).then(|| {
            let shape = run.find_shape(plan, frame);
            run.choose_gain(plan, &shape);
            shape
        });
        let mut layers = Vec::new();
        let mut term_whites = TermWhites::new();
        match (plan.goal, &shape) {
            (Goal::Layers, Some(shape)) => layers = layers_of(&mut run, plan, frame, shape),
            (Goal::Display, Some(shape)) => picture = Some(run.display(shape)),
            (Goal::Enhance, Some(shape)) => {
                let picture = picture.as_ref().expect("enhancing takes a picture");
                run.scale(plan, frame, shape, picture);
                term_whites = run.scale_layers(plan, frame, shape, picture);
            }
            _ => {}
        }
        if let Some(light) = light {
            picture = Some(run.relight(plan, frame, light, shape.as_ref(), picture));
        }
        let numbers = run.chosen.clone();
        let mut wanted = vec![&numbers];
        wanted.extend(picture.iter().flatten());
        wanted.extend(&layers);
        wanted.extend(term_whites.iter().map(|(_, white)| white));
        let (read, timings) = run.finish(&wanted)?;

        let mut read = read.into_iter();
        let chosen = read.next().expect("what was chosen is read first");
        let mut outcome = Outcome::default();
        outcome.timings.push((UPLOAD, uploaded));
        outcome.timings.extend(timings);
        let start = Instant::now();
        if plan.goal != Goal::Layers && picture.is_some() {
            let mut plane = || {
                let samples = read.next().expect("a picture has three planes");
                Plane::from_samples(width, height, samples)
            };
            let [r, g, b] = [plane(), plane(), plane()];
            let is_made = plan.goal != Goal::Enhance || SCALES.iter().any(|&stage| plan.has(stage));
            outcome.color = is_made.then_some(ColorPlanes { r, g, b });
            if let (Some(color), Goal::Relight) = (&mut outcome.color, plan.goal) {
                frame_lit(color, frame);
            }
            outcome.term_white_levels = levels_of(&term_whites, read.by_ref());
        }
        if plan.goal == Goal::Layers {
            describe(&mut outcome, plan, frame, read);
        }
        add_timings(&mut outcome.timings, &[(READ_BACK, start.elapsed())]);
        if plan.has(Stage::Trace) || plan.has(Stage::Hessian) {
            outcome.gain = Some(chosen[GAIN as usize]);
        }
        if plan.has(Stage::RadianceScaling) {
            outcome.white_level = Some(chosen[WHITE as usize]);
        }
        let picture = picture.into_iter().flatten();
        match is_copied {
            true => self.buffers.take_back_copied(picture),
            false => self.buffers.recycle(picture),
        }
        self.buffers.recycle(layers);
        if let Some(shape) = shape {
            self.buffers.recycle(shape.into_buffers());
        }
        Ok(outcome)
    }
}

/// Puts what was read of the layers into the outcome, in the order of [`layers_of`].
fn describe(
    outcome: &mut Outcome,
    plan: &Plan,
    frame: &Frame,
    mut read: impl Iterator<Item = Vec<f32>>,
) {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let mut next = || read.next().expect("every layer is read");
    let plane = |samples| Plane::from_samples(width, height, samples);
    let pair = |samples: Vec<f32>| {
        let [x, y] = apart::<2>(&samples).map(plane);
        Vector2Planes { x, y }
    };
    let shape = &mut outcome.shape;
    let conductance = plane(next());
    let weights = pair(next());
    (shape.silhouette, shape.crease) = (Some(weights.x), Some(weights.y));
    shape.gradient = Some(pair(next()));
    let [xx, xy, yy] = [plane(next()), plane(next()), plane(next())];
    shape.hessian = Some(SymmetricPlanes { xx, xy, yy });
    let curvatures = |samples: Vec<f32>| {
        let [u, v, mean, kappa] = apart::<4>(&samples).map(plane);
        (CurvaturePlanes { u, v, mean }, kappa)
    };
    let (first, kappa) = curvatures(next());
    (shape.curvatures, shape.kappa) = (Some(first), Some(kappa));
    shape.direction_view = Some(pair(next()));
    for &sigma_px in &plan.more_px {
        let (curvatures, kappa) = curvatures(next());
        shape.more_scales.push(ScaleShape {
            sigma_px,
            curvatures,
            kappa,
        });
    }
    if plan.has(Stage::NormalRays) {
        let [x, y] = [plane(next()), plane(next())];
        shape.direction = Some(Vector2Planes { x, y });
    }
    shape.conductance = Some(conductance);
}

/// Bytes of a row of the widest plane that `plan` makes of `frame`: vectors of two, only of layers wider ones.
fn row_bytes(plan: &Plan, frame: &Frame) -> u64 {
    let has_layers = plan.has(Stage::LightLobes) || plan.has(Stage::LightGroups);
    let widest = match plan.goal == Goal::Layers || has_layers {
        true => WIDEST,
        false => 2,
    };
    4 * widest * frame.mask.width() as u64
}

/// The buffers of all layers, in order; those that `shape` keeps are shared with it.
fn layers_of(run: &mut Run, plan: &Plan, frame: &Frame, shape: &Shape) -> Vec<wgpu::Buffer> {
    let hessian = shape.hessian.as_ref().expect("layers take the Hessian");
    let Curvatures {
        curvature,
        direction,
    } = run.curvatures(hessian);
    let entries = hessian.entries.as_ref().expect("layers take its entries");
    let mut layers = vec![
        shape.conductance.clone(),
        shape.weights.clone().expect("layers take the weights"),
        shape.gradient.clone(),
    ];
    layers.extend(entries.iter().cloned());
    layers.extend([curvature, direction]);
    for gradient in &shape.more_gradients {
        let hessian = run.hessian(plan, gradient, &shape.conductance, true);
        layers.push(run.curvatures(&hessian).curvature);
    }
    if plan.has(Stage::NormalRays) {
        layers.extend(run.surface_directions(plan, frame, &shape.conductance));
    }
    layers
}

/// The components of vectors that stand one after the other.
pub(crate) fn apart<const N: usize>(samples: &[f32]) -> [Vec<f32>; N] {
    let (vectors, _) = samples.as_chunks::<N>();
    std::array::from_fn(|i| vectors.par_iter().map(|vector| vector[i]).collect())
}
