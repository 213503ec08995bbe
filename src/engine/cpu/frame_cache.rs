//! What a run of a frame leaves to the next one of the same frame.

use crate::engine::outcome::Outcome;
use crate::frame::CurvaturePlanes;
use crate::frame::{ColorPlanes, Plane, SymmetricPlanes, Vector2Planes};
use crate::line::contours::Contour;
use crate::params::{
    Adaptive, ContourParams, FieldParams, LineParams, Magnitudes, ScalingParams, ShapeParams,
    SoftThreshold, StrokeDirections, TermWhiteLevels,
};
use crate::plan::{Goal, Plan, Points, Stage};
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::shape::edges::cpu::Weights;

/// What edges and the gradient depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EdgesKey {
    silhouettes: [bool; 2],
    thresholds: [SoftThreshold; 3],
    foreshortening: f32,
    min_nz: f32,
}

impl EdgesKey {
    fn of(plan: &Plan) -> Self {
        let ShapeParams {
            silhouette,
            occlusion_silhouette,
            crease,
            foreshortening,
            min_nz,
            ..
        } = plan.shape;
        Self {
            silhouettes: [Stage::DepthSilhouettes, Stage::OcclusionSilhouettes]
                .map(|stage| plan.has(stage)),
            thresholds: [silhouette, occlusion_silhouette, crease],
            foreshortening,
            min_nz,
        }
    }
}

/// What the diffused gradient depends on: edges, and sweeps where there are any.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GradientKey(EdgesKey, Option<DiffusionSchedule>);

/// What curvature depends on: the gradient, and the factor of resolution.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CurvatureKey(GradientKey, f64);

/// What the trace of the Hessian is made of; its bits may differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TraceOf {
    Gradient,
    Hessian,
    Curvatures,
}

impl TraceOf {
    fn in_plan(plan: &Plan) -> Self {
        if plan.has(Stage::Curvatures) {
            Self::Curvatures
        } else if plan.has(Stage::Hessian) && plan.goal != Goal::Relight {
            Self::Hessian
        } else {
            Self::Gradient
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TraceKey(CurvatureKey, TraceOf);

/// What the directions of the surface's own curvature depend on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RaysKey(EdgesKey, Points, [usize; 2]);

/// What the directions of strokes depend on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FieldKey(EdgesKey, f64, FieldParams, StrokeDirections);

/// What lines along edges depend on: they are scaled with strokes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ContoursKey(EdgesKey, ContourParams);

/// What the white levels of kinds of light depend on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TermsKey {
    /// Which kinds are scaled at all.
    scaled: [bool; 3],
    has_ambient: bool,
    white: Adaptive,
    told: TermWhiteLevels,
}

impl TermsKey {
    fn of(scaling: &ScalingParams) -> Self {
        let Magnitudes {
            ambient,
            diffuse,
            specular,
        } = scaling.magnitudes();
        Self {
            scaled: [ambient, diffuse, specular].map(|magnitude| magnitude > 0.0),
            has_ambient: scaling.scaling_ambient.is_some(),
            white: scaling.white_level,
            told: scaling.term_white_levels,
        }
    }
}

/// One result, and what it is made of.
#[derive(Debug)]
pub(crate) struct Slot<K, T> {
    key: Option<K>,
    value: Option<T>,
}

impl<K, T> Default for Slot<K, T> {
    fn default() -> Self {
        Self {
            key: None,
            value: None,
        }
    }
}

impl<K: PartialEq, T> Slot<K, T> {
    /// Drops the result unless it is made of `key`, as the next one will be.
    fn invalidate_unless(&mut self, key: K) {
        if self.key.as_ref() != Some(&key) {
            *self = Self {
                key: Some(key),
                value: None,
            };
        }
    }

    pub(crate) fn take(&mut self) -> Option<T> {
        self.value.take()
    }

    pub(crate) fn get(&self) -> Option<&T> {
        self.value.as_ref()
    }

    pub(crate) fn put(&mut self, value: T) {
        self.value = Some(value);
    }

    fn put_any(&mut self, value: Option<T>) {
        if value.is_some() {
            self.value = value;
        }
    }
}

/// What was made of a frame. A run takes what it can use and moves it into its outcome; when that is given back it is
/// kept again.
#[derive(Debug, Default)]
pub(crate) struct FrameCache {
    silhouette: Slot<EdgesKey, Plane>,
    crease: Slot<EdgesKey, Plane>,
    conductance: Slot<EdgesKey, Plane>,
    /// The gradient before diffusion.
    pub(crate) undiffused: Slot<EdgesKey, Vector2Planes>,
    pub(crate) gradient: Slot<GradientKey, Vector2Planes>,
    pub(crate) trace: Slot<TraceKey, Plane>,
    pub(crate) hessian: Slot<CurvatureKey, SymmetricPlanes>,
    pub(crate) curvatures: Slot<CurvatureKey, CurvaturePlanes>,
    pub(crate) direction_view: Slot<CurvatureKey, Vector2Planes>,
    pub(crate) gain: Slot<TraceKey, f32>,
    pub(crate) rays: Slot<RaysKey, Vector2Planes>,
    pub(crate) term_whites: Slot<TermsKey, Vec<(&'static str, f32)>>,
    pub(crate) field: Slot<FieldKey, Vec<Vector2Planes>>,
    pub(crate) contours: Slot<ContoursKey, (Plane, Vec<Contour>)>,
    /// White level of the picture.
    pub(crate) white: Option<f32>,
    /// Albedo, estimated from the picture.
    pub(crate) albedo: Option<ColorPlanes>,
}

impl FrameCache {
    /// Drops what is not of use to `plan`. What it does not ask for stays.
    pub(crate) fn invalidate_for(&mut self, plan: &Plan) {
        self.term_whites
            .invalidate_unless(TermsKey::of(&plan.scaling));
        if !plan.has(Stage::Conductance) {
            return;
        }
        let edges = EdgesKey::of(plan);
        self.silhouette.invalidate_unless(edges);
        self.crease.invalidate_unless(edges);
        self.conductance.invalidate_unless(edges);
        self.undiffused.invalidate_unless(edges);
        let sweeps = plan.has(Stage::Diffusion).then(|| plan.sweeps.clone());
        let gradient = GradientKey(edges, sweeps);
        let curvature = CurvatureKey(gradient.clone(), plan.resolution_factor);
        self.gradient.invalidate_unless(gradient);
        if !plan.more_px.is_empty() {
            // Only that of the first scale is kept.
            self.gradient.take();
        }
        self.hessian.invalidate_unless(curvature.clone());
        self.curvatures.invalidate_unless(curvature.clone());
        self.direction_view.invalidate_unless(curvature.clone());
        let trace = TraceKey(curvature, TraceOf::in_plan(plan));
        self.gain.invalidate_unless(trace.clone());
        self.trace.invalidate_unless(trace);
        self.rays
            .invalidate_unless(RaysKey(edges, plan.points, plan.direction_steps_px));
        if let Some(drawing) = &plan.drawing {
            self.invalidate_drawing(plan, edges, drawing);
        }
    }

    fn invalidate_drawing(&mut self, plan: &Plan, edges: EdgesKey, drawing: &LineParams) {
        let factor = plan.resolution_factor;
        let LineParams {
            field, directions, ..
        } = *drawing;
        self.field
            .invalidate_unless(FieldKey(edges, factor, field, directions));
        if let Some(contours) = &drawing.contours {
            let scale = drawing.strokes.factor(factor as f32);
            self.contours
                .invalidate_unless(ContoursKey(edges, contours.scaled(scale)));
        }
        if plan.specular.is_some() {
            // They go through mirrors and lenses, of which nothing is known here.
            self.field.take();
            self.contours.take();
        }
    }

    /// The edges, if they are kept; weights that are not `wanted` stay here.
    pub(crate) fn take_weights(&mut self, wanted: bool) -> Option<Weights> {
        let all = self.silhouette.get().is_some()
            && self.crease.get().is_some()
            && self.undiffused.get().is_some();
        let conductance = self.conductance.take().filter(|_| all)?;
        let silhouette = wanted.then(|| self.silhouette.take()).flatten();
        let crease = wanted.then(|| self.crease.take()).flatten();
        Some(Weights {
            silhouette,
            crease,
            conductance,
        })
    }

    /// Keeps of weights that were made what is not `wanted`.
    pub(crate) fn keep_unwanted(&mut self, weights: &mut Weights, wanted: bool) {
        if !wanted {
            self.silhouette.put_any(weights.silhouette.take());
            self.crease.put_any(weights.crease.take());
        }
    }

    /// Takes back what the last run made, or took, from its outcome.
    pub(crate) fn recycle(&mut self, outcome: &mut Outcome) {
        let shape = &mut outcome.shape;
        self.silhouette.put_any(shape.silhouette.take());
        self.crease.put_any(shape.crease.take());
        self.conductance.put_any(shape.conductance.take());
        self.gradient.put_any(shape.gradient.take());
        self.trace.put_any(shape.trace.take());
        self.hessian.put_any(shape.hessian.take());
        self.curvatures.put_any(shape.curvatures.take());
        self.direction_view.put_any(shape.direction_view.take());
        self.rays.put_any(shape.direction.take());
    }
}
