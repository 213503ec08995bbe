//! The plan and its decisions.

use crate::light::enhancement::{Enhancement, Subject};
use crate::light::relight::setting::Relighting;
use crate::params::{ContourParams, LineParams, ScalingParams, ShapeParams, SpecularParams};
use crate::plan::available::Available;
use crate::product::Product;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// How the positions of the surface at neighbouring pixels are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Points {
    /// Depth along sight lines that the camera gives.
    Depth,
    /// The normals: the surface is followed from pixel to pixel.
    Normals,
}

/// The stages of a run in order, the reason for each step kept or left out, and the parameters they run with.
#[derive(Debug, Clone)]
pub struct Plan {
    /// How shape is found.
    pub(crate) shape: ShapeParams,
    /// How light is scaled.
    pub(crate) scaling: ScalingParams,
    /// The part of the picture that radiance scaling changes.
    pub(crate) enhancement: Option<Enhancement>,
    /// How the frame is lit anew, if it is.
    pub(crate) relighting: Option<Relighting>,
    /// Whether the curvature display is the picture.
    pub(crate) display: bool,
    /// How the picture that was made is drawn, if it is.
    pub(crate) drawing: Option<LineParams>,
    /// How many times as wide as at scale 1 its lines along edges are.
    pub(crate) line_scale: f32,
    /// Whether its tone is spread so that it shows the shape.
    pub(crate) shows_shape: bool,
    /// How specular pixels are traced, if they are.
    pub(crate) specular: Option<SpecularParams>,
    /// How the gradient is diffused.
    pub(crate) sweeps: DiffusionSchedule,
    /// Sigmas of further scales, in pixels of the reference.
    pub(crate) more_px: Vec<f32>,
    /// Pixels of the frame per pixel of the reference, in which curvature is measured; 1 without a
    /// [reference height](ShapeParams::reference_height).
    pub resolution_factor: f64,
    /// How positions are found for directions of the surface's own curvature.
    pub points: Points,
    /// How many pixels away they are, at the least and at the most.
    pub(crate) direction_steps_px: [usize; 2],
    /// The inputs that the plan was made for.
    pub(crate) available: Available,
    /// Why nothing is asked of shape, where that is so.
    pub(crate) no_shape: Option<&'static str>,
    pub(super) wanted: BTreeSet<Product>,
    pub(super) decisions: Vec<Decision>,
    /// The stages that run, in their order.
    pub(super) stages: Vec<&'static str>,
    /// What the result of each of these depends on, all before it included.
    pub(super) keys: BTreeMap<&'static str, String>,
    pub(super) reach: usize,
}

/// Whether a step runs, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Decision {
    /// The step's name.
    #[serde(rename = "stage")]
    pub step: &'static str,
    /// Whether it runs.
    pub kept: bool,
    /// Why, in a few words.
    pub reason: String,
}

impl std::fmt::Display for Decision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = if self.kept { "run " } else { "skip" };
        write!(f, "{verdict}  {:<21} {}", self.step, self.reason)
    }
}

impl Plan {
    /// Every step, kept or left out, and why, in the order of execution.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Whether a step, by the name it has in [`Plan::decisions`], is part of the plan.
    ///
    /// # Panics
    /// If there is no step of this name.
    pub fn runs(&self, step: &str) -> bool {
        let decision = self.decisions.iter().find(|known| known.step == step);
        decision
            .unwrap_or_else(|| panic!("no step is called {step}"))
            .kept
    }

    /// Whether a product is wanted, by the caller or by a stage.
    pub fn wants(&self, product: Product) -> bool {
        self.wanted.contains(&product)
    }

    /// Contours of the drawing, where it has any, at the size that lines have in the picture.
    pub(crate) fn contours(&self) -> Option<ContourParams> {
        let contours = self.drawing.as_ref()?.contours?;
        Some(contours.scaled(self.line_scale))
    }

    /// Whether curvature is made at all.
    pub(crate) fn wants_curvature(&self) -> bool {
        self.wants(Product::Trace) || self.wants(Product::Hessian)
    }

    /// The part of the picture that radiance scaling changes, if any.
    pub(crate) fn scaled(&self) -> Option<Subject> {
        let scaled = self
            .enhancement
            .filter(|enhancement| enhancement.magnitude > 0.0);
        scaled.map(|enhancement| enhancement.subject)
    }

    /// Whether a picture is made, not only taken as it is.
    #[cfg(feature = "gpu")]
    pub(crate) fn makes_picture(&self) -> bool {
        self.enhancement
            .is_some_and(|enhancement| !enhancement.is_idle())
            || self.relighting.is_some()
            || self.display
    }

    /// The stages that run, in their order, under the names that [`crate::engine::outcome::Outcome::timings`] has.
    pub fn stages(&self) -> &[&'static str] {
        &self.stages
    }

    /// What the result of a stage that runs depends on, all before it included: a result of one key is that of another
    /// plan with the same.
    pub(crate) fn key(&self, stage: &str) -> &str {
        self.keys.get(stage).map_or("", String::as_str)
    }

    /// How far, in pixels, an input sample reaches: a crop gives the results of the whole picture from
    /// this distance to its border on, unless a gain or white level is chosen from the frame. A drawing
    /// depends on all of it.
    pub fn reach(&self) -> usize {
        self.reach
    }
}
