//! The plan on the CPU: rows in parallel by rayon, the same bits for any number of threads.

pub(crate) mod frame_cache;
#[cfg(feature = "gpu")]
pub(crate) mod gpu_support;
pub(crate) mod memory;
pub(crate) mod percentile;
pub(crate) mod rows;
pub(crate) mod runner;
pub(crate) mod simd;
pub(crate) mod sparing;
pub(crate) mod strips;

use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::rows::ROWS_PER_TASK;
pub use crate::engine::cpu::runner::Runner;
pub use crate::engine::cpu::strips::{StripChoice, StripSearch};
use crate::engine::inputs::Inputs;
pub use crate::engine::outcome::{Drawing, Outcome, ScaleShape, Shape};
use crate::engine::run::Watch;
use crate::error::Result;
use crate::fast_math::Function;
pub use crate::frame::CurvaturePlanes;
use crate::frame::{ColorPlanes, Frame, Plane, SymmetricPlanes, Vector2Planes};
use crate::light::layers::TermScaling;
use crate::light::layers::cpu as light_layers;
use crate::light::layers::cpu::Curvature;
use crate::light::layers::terms::light_terms;
use crate::light::radiance_scaling::cpu as light;
use crate::line::normal_rays::cpu as normal_rays;
pub use crate::line::texture_coordinates::cpu::SequenceInputs;
pub use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::params::Adaptive;
use crate::plan::{Goal, Plan, Stage};
use crate::shape::auto_levels::cpu as statistics;
use crate::shape::curvature::cpu as passes;
use crate::shape::curvature_display::curvature_display;
use crate::shape::diffusion::cpu as diffusion;
use crate::shape::edges::cpu as edges;
use crate::shape::edges::cpu::Weights;
use rayon::prelude::*;
use std::time::Instant;

/// Runs a plan that takes nothing beside `frame`, in the rayon pool of the caller.
///
/// # Errors
/// As [`Runner::execute`].
pub fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    Runner::default().execute(plan, frame, Inputs::default())
}

/// Runs an elementary function over a row in the widest vectors that this machine has, as the stages do.
pub fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    simd::Simd::widest().map_row(function, out, x);
}

/// Bits of the widest vectors that this machine has.
pub fn vector_bits() -> u32 {
    simd::Simd::widest().bits()
}

/// The Hessian per pixel of the reference.
fn hessian_at(factor: f64, per_pixel: SymmetricPlanes) -> SymmetricPlanes {
    SymmetricPlanes {
        xx: per_reference_pixel(per_pixel.xx, factor),
        xy: per_reference_pixel(per_pixel.xy, factor),
        yy: per_reference_pixel(per_pixel.yy, factor),
    }
}

/// Derivatives per pixel of the reference: the one place where curvature meets the factor of resolution.
fn per_reference_pixel(mut per_pixel: Plane, factor: f64) -> Plane {
    if factor != 1.0 {
        let factor = factor as f32;
        let width = per_pixel.width();
        let rows = per_pixel.samples_mut().par_chunks_mut(width);
        rows.with_min_len(ROWS_PER_TASK)
            .for_each(|row| row.iter_mut().for_each(|v| *v *= factor));
    }
    per_pixel
}

const WITH_A_PICTURE: &str = "radiance scaling needs a picture";

pub(crate) struct Run<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    pub(crate) runner: &'a Runner,
    pub(crate) watch: Watch<'a>,
    /// What earlier runs of this frame have left, where any is kept.
    pub(crate) kept: Option<&'a mut FrameCache>,
    pub(crate) outcome: Outcome,
}

impl<'a> Run<'a> {
    pub(crate) fn new(runner: &'a Runner, plan: &'a Plan, frame: &'a Frame) -> Self {
        Self {
            plan,
            frame,
            runner,
            watch: Watch::default(),
            kept: None,
            outcome: Outcome::default(),
        }
    }
}

impl Run<'_> {
    pub(crate) fn timed<T>(&mut self, name: &'static str, pass: impl FnOnce() -> T) -> T {
        let (passed, planned) = (self.outcome.timings.len(), self.plan.stages().len());
        self.watch
            .begins(name, passed as f32 / planned.max(1) as f32);
        let start = Instant::now();
        let result = pass();
        self.outcome.timings.push((name, start.elapsed()));
        result
    }

    /// What is kept, by `take`; else what `pass` makes.
    pub(crate) fn kept_or<T>(
        &mut self,
        take: impl FnOnce(&mut FrameCache) -> Option<T>,
        name: &'static str,
        pass: impl FnOnce() -> T,
    ) -> T {
        match self.kept.as_deref_mut().and_then(take) {
            Some(kept) => kept,
            None => self.timed(name, pass),
        }
    }

    /// Brings out the shape in the picture, as far as that is planned.
    pub(crate) fn enhance(&mut self) {
        let plan = self.plan;
        if plan.has(Stage::RadianceScaling) {
            self.scale_radiance();
        }
        if plan.has(Stage::LightLobes) {
            self.scale_lobes();
        }
        if plan.has(Stage::LightGroups) {
            self.scale_groups();
        }
        if plan.has(Stage::AmbientOcclusion) {
            self.scale_by_occlusion();
        }
    }

    /// The shape, where it is planned at all.
    pub(crate) fn find_planned_shape(&mut self) {
        if self.plan.has(Stage::Conductance) {
            self.find_shape();
        }
    }

    pub(crate) fn find_shape(&mut self) {
        let plan = self.plan;
        let (edges, undiffused) = self.find_edges();
        let mut gradients = self.find_gradients(undiffused, &edges.conductance);
        let gradient = gradients.remove(0);
        if plan.has(Stage::Curvatures) {
            self.describe(&gradient, &edges.conductance);
            self.describe_more(gradients, &edges.conductance);
        } else if plan.goal == Goal::Relight {
            self.prepare_light(&gradient, &edges.conductance);
        } else if plan.has(Stage::Hessian) {
            self.find_hessian(&gradient, &edges.conductance);
        } else if plan.has(Stage::Trace) {
            self.find_trace(&gradient, &edges.conductance);
        }
        if plan.has(Stage::CurvatureDisplay) {
            self.display(&edges.conductance);
        }
        let shape = &mut self.outcome.shape;
        shape.silhouette = edges.silhouette;
        shape.crease = edges.crease;
        shape.conductance = Some(edges.conductance);
        shape.gradient = Some(gradient);
    }

    /// Edges, and the gradient before diffusion unless it is kept.
    pub(crate) fn find_edges(&mut self) -> (Weights, Option<Vector2Planes>) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let wanted = plan.keeps_edge_weights();
        let kept = self.kept.as_deref_mut();
        if let Some(weights) = kept.and_then(|kept| kept.take_weights(wanted)) {
            return (weights, None);
        }
        // What is kept may be asked for later.
        let with_weights = wanted || self.kept.is_some();
        let (mut weights, gradient) = self.timed("edges-and-gradient", || {
            edges::edges_with_weights(plan, frame, with_weights, memory)
        });
        if let Some(kept) = &mut self.kept {
            kept.keep_unwanted(&mut weights, wanted);
            kept.undiffused.put(gradient.clone());
        }
        (weights, Some(gradient))
    }

    /// The gradient at the scales wanted.
    pub(crate) fn find_gradients(
        &mut self,
        undiffused: Option<Vector2Planes>,
        conductance: &Plane,
    ) -> Vec<Vector2Planes> {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let kept = self.kept.as_deref_mut();
        if let Some(gradient) = kept.and_then(|kept| kept.gradient.take()) {
            return vec![gradient];
        }
        let kept = self.kept.as_deref();
        let undiffused = undiffused.or_else(|| kept?.undiffused.get().cloned());
        let undiffused = undiffused.expect("the gradient is kept with its edges");
        if plan.has(Stage::Diffusion) {
            return self.timed("diffusion", || {
                diffusion::diffusion(
                    undiffused,
                    conductance,
                    frame,
                    &plan.sweeps,
                    &self.runner.options,
                    memory,
                )
            });
        }
        let more = vec![undiffused.clone(); plan.more_px.len()];
        std::iter::once(undiffused).chain(more).collect()
    }

    /// The sum of the curvatures, and its gain.
    pub(crate) fn find_trace(&mut self, gradient: &Vector2Planes, conductance: &Plane) {
        let (plan, mask, memory) = (self.plan, &self.frame.mask, &self.runner.memory);
        let kept = |kept: &mut FrameCache| kept.trace.take();
        let trace = self.kept_or(kept, "trace", || {
            let trace = passes::trace(gradient, conductance, mask, memory);
            per_reference_pixel(trace, plan.resolution_factor)
        });
        self.choose_gain(&trace, conductance);
        self.outcome.shape.trace = Some(trace);
    }

    /// The Hessian where the direction of light counts, and its trace for the gain.
    pub(crate) fn find_hessian(&mut self, gradient: &Vector2Planes, conductance: &Plane) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let kept = |kept: &mut FrameCache| kept.hessian.take().zip(kept.trace.take());
        let (hessian, trace) = self.kept_or(kept, "hessian", || {
            let hessian = passes::hessian(gradient, conductance, &frame.mask, memory);
            let hessian = hessian_at(plan.resolution_factor, hessian);
            let trace = passes::trace_of(&hessian, &frame.mask, memory);
            (hessian, trace)
        });
        self.choose_gain(&trace, conductance);
        self.outcome.shape.trace = Some(trace);
        self.outcome.shape.hessian = Some(hessian);
    }

    /// Everything that the layers of the descriptor hold beyond gradient and weights.
    pub(crate) fn describe(&mut self, gradient: &Vector2Planes, conductance: &Plane) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let (mask, factor) = (&frame.mask, plan.resolution_factor);
        let kept = |kept: &mut FrameCache| kept.hessian.take();
        let hessian = self.kept_or(kept, "hessian", || {
            hessian_at(factor, passes::hessian(gradient, conductance, mask, memory))
        });
        let kept = |kept: &mut FrameCache| kept.curvatures.take();
        let curvatures = self.kept_or(kept, "curvatures", || {
            passes::curvatures(&hessian, mask, memory)
        });
        let kept = |kept: &mut FrameCache| kept.direction_view.take();
        let direction_view = self.kept_or(kept, "directions", || {
            passes::directions(&hessian, mask, memory)
        });
        let kept = |kept: &mut FrameCache| kept.rays.take();
        let direction = plan.has(Stage::NormalRays).then(|| {
            self.kept_or(kept, "normal-rays", || {
                normal_rays::directions(plan, frame, conductance, memory)
            })
        });
        let trace = curvatures.trace();
        let gain = self.choose_gain(&trace, conductance);
        self.outcome.shape.kappa = Some(passes::mapped_curvature(&trace, gain, mask, memory));
        self.outcome.shape.hessian = Some(hessian);
        self.outcome.shape.curvatures = Some(curvatures);
        self.outcome.shape.direction = direction;
        self.outcome.shape.direction_view = Some(direction_view);
    }

    /// Curvature at the scales beyond the first, mapped by the same gain.
    pub(crate) fn describe_more(&mut self, gradients: Vec<Vector2Planes>, conductance: &Plane) {
        let mask = &self.frame.mask;
        let gain = self
            .outcome
            .gain
            .expect("the gain is chosen at the first scale");
        let (plan, memory) = (self.plan, &self.runner.memory);
        let scales = self.timed("more-scales", || {
            let scales = gradients.into_iter().zip(&plan.more_px);
            let described = scales.map(|(gradient, &sigma_px)| {
                let hessian = passes::hessian(&gradient, conductance, mask, memory);
                let hessian = hessian_at(plan.resolution_factor, hessian);
                let curvatures = passes::curvatures(&hessian, mask, memory);
                let trace = curvatures.trace();
                ScaleShape {
                    sigma_px,
                    kappa: passes::mapped_curvature(&trace, gain, mask, memory),
                    curvatures,
                }
            });
            described.collect()
        });
        self.outcome.shape.more_scales = scales;
    }

    pub(crate) fn choose_gain(&mut self, trace: &Plane, conductance: &Plane) -> f32 {
        let factor = self.plan.resolution_factor as f32;
        let gain = match self.plan.scaling.curvature_gain {
            Adaptive::Fixed(gain) => gain,
            Adaptive::Auto => {
                let kept = |kept: &mut FrameCache| kept.gain.get().copied();
                let gain = self.kept_or(kept, "auto-gain", || {
                    statistics::curvature_gain(trace, conductance, factor)
                });
                if let Some(kept) = &mut self.kept {
                    kept.gain.put(gain);
                }
                gain
            }
        };
        self.outcome.gain = Some(gain);
        gain
    }

    pub(crate) fn display(&mut self, conductance: &Plane) {
        let gain = self
            .outcome
            .gain
            .expect("the gain is chosen before the display");
        let trace = self
            .outcome
            .shape
            .trace
            .as_ref()
            .expect("the display needs the trace");
        let start = Instant::now();
        let color = curvature_display(
            trace,
            conductance,
            &self.frame.mask,
            gain,
            &self.runner.memory,
        );
        self.outcome.timings.push(("display", start.elapsed()));
        self.outcome.color = Some(color);
    }

    /// How the radiance of the picture is scaled, by white level and gain.
    pub(crate) fn scaler(&mut self) -> light::Scaler {
        let (plan, frame) = (self.plan, self.frame);
        let color = frame.color.as_ref().expect(WITH_A_PICTURE);
        let weights = frame.luminance_weights();
        let is_occlusion = frame.light.picture_is_occlusion;
        let mut params = plan.scaling;
        if is_occlusion {
            params.scaling = params.magnitudes().ambient;
        }
        let white = match params.white_level {
            Adaptive::Fixed(level) => level,
            // What arrives of ambient light is a share of 1.
            Adaptive::Auto if is_occlusion => 1.0,
            Adaptive::Auto => {
                let kept = |kept: &mut FrameCache| kept.white;
                let white = self.kept_or(kept, "auto-white", || {
                    statistics::white_level(color, weights, &frame.mask)
                });
                if let Some(kept) = &mut self.kept {
                    kept.white = Some(white);
                }
                white
            }
        };
        let gain = self
            .outcome
            .gain
            .expect("the gain is chosen before scaling");
        self.outcome.white_level = Some(white);
        light::Scaler {
            params,
            gain,
            white,
            weights,
        }
    }

    pub(crate) fn scale_radiance(&mut self) {
        let scaler = self.scaler();
        let (frame, memory) = (self.frame, &self.runner.memory);
        let color = frame.color.as_ref().expect(WITH_A_PICTURE);
        let trace = self
            .outcome
            .shape
            .trace
            .take()
            .expect("scaling needs the trace");
        let scaled = self.timed("radiance-scaling", || {
            scaler.scale(color, &trace, &frame.mask, memory)
        });
        self.outcome.shape.trace = Some(trace);
        self.outcome.color = Some(scaled);
    }

    pub(crate) fn scale_lobes(&mut self) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        let terms = light_terms(&frame.light.lobes, &plan.scaling);
        let levels = || light_layers::white_levels(&terms, frame, &plan.scaling, memory);
        let whites = match plan.has(Stage::AutoWhite) {
            true => self.kept_or(|kept| kept.term_whites.get().cloned(), "auto-white", levels),
            false => levels(),
        };
        if let Some(kept) = &mut self.kept {
            kept.term_whites.put(whites.clone());
        }
        self.with_curvature("light-lobes", |_, curvature| {
            light_layers::scale_lobes(&terms, &whites, frame, &plan.scaling, curvature, memory)
        });
        self.outcome.term_white_levels = whites;
    }

    pub(crate) fn scale_groups(&mut self) {
        let (plan, frame, memory) = (self.plan, self.frame, &self.runner.memory);
        self.with_curvature("light-groups", |_, curvature| {
            light_layers::scale_groups(frame, &plan.scaling, curvature, memory)
        });
    }

    /// Scales the picture, enhanced or not, by its ambient occlusion.
    pub(crate) fn scale_by_occlusion(&mut self) {
        let (plan, frame) = (self.plan, self.frame);
        let occlusion = frame.light.occlusion.as_ref();
        let occlusion = occlusion.expect("the plan has seen occlusion");
        let by = TermScaling {
            magnitude: plan.scaling.magnitudes().ambient,
            invariant_point: plan.scaling.invariant_point,
            white: 1.0,
            weights: frame.luminance_weights(),
        };
        self.with_curvature("ambient-occlusion", |made, curvature| {
            let color = made.or_else(|| frame.color.clone());
            let color = color.expect("radiance scaling needs a picture");
            light_layers::scale_by_occlusion(color, occlusion, &frame.mask, curvature, by)
        });
    }

    /// Makes the picture anew of the one made so far, by curvature.
    pub(crate) fn with_curvature(
        &mut self,
        name: &'static str,
        pass: impl FnOnce(Option<ColorPlanes>, Curvature) -> ColorPlanes,
    ) {
        let start = Instant::now();
        let shape = &self.outcome.shape;
        let curvature = Curvature {
            trace: shape.trace.as_ref().expect("scaling needs the trace"),
            hessian: shape.hessian.as_ref(),
            gain: self
                .outcome
                .gain
                .expect("the gain is chosen before scaling"),
        };
        let made = pass(self.outcome.color.take(), curvature);
        self.outcome.color = Some(made);
        self.outcome.timings.push((name, start.elapsed()));
    }
}
