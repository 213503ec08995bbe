//! The plan and its decisions.

use crate::frame::Window;
use crate::kernel::shelf::Shelf;
use crate::params::{
    Background, ContourParams, LineParams, ScalingParams, ShapeParams, SpecularParams,
};
use crate::plan::available::Available;
use crate::plan::stage::{Makes, Stage};
use crate::product::Product;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Source of surface positions at neighbouring pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Points {
    /// Depth along the camera's sight lines.
    Depth,
    /// The normals, integrated from pixel to pixel.
    Normals,
}

/// A tile within a frame that repeats it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Its pixels. Gains and white levels are chosen from them.
    pub(crate) window: Window,
    /// Whether it is repeated to the left and right, and above and below.
    pub(crate) wraps: [bool; 2],
}

impl Tile {
    /// The tile with so many pixels of its repetition on every side.
    pub(crate) fn grown(&self, by: usize) -> Window {
        let grown = self.window.grown(by);
        let [x, y] = self
            .wraps
            .map(|wraps| if wraps { grown } else { self.window });
        Window {
            x0: x.x0,
            y0: y.y0,
            x1: x.x1,
            y1: y.y1,
        }
    }
}

/// The stages of a run in order, the reason for each step kept or dropped, and the parameters of the run.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Shape analysis.
    pub(crate) shape: ShapeParams,
    /// Radiance scaling.
    pub(crate) scaling: ScalingParams,
    /// Whether the picture is the curvature display.
    pub(crate) display: bool,
    /// Drawing of the picture, if any.
    pub(crate) drawing: Option<LineParams>,
    /// Whether the coverage of its strokes is computed, which lines alone do not take.
    pub(crate) inks_strokes: bool,
    /// Whether the tone that its strokes were to have is a result.
    pub(crate) keeps_tone: bool,
    /// Width factor of the drawing's lines along edges; 1 at scale 1.
    pub(crate) line_scale: f32,
    /// Whether the drawing's tone is stretched to show the shape.
    pub(crate) shows_shape: bool,
    /// Tracing of specular pixels, if any.
    pub(crate) specular: Option<SpecularParams>,
    /// What stages found for themselves when the plan was made.
    pub(crate) settings: Shelf,
    /// Sigmas of further scales, in pixels of the reference.
    pub(crate) more_px: Vec<f32>,
    /// Pixels of the frame per pixel of the reference, the unit of curvature; 1 without a [reference
    /// height](ShapeParams::reference_height).
    pub resolution_factor: f64,
    /// Source of positions for directions of the surface's own curvature.
    pub points: Points,
    /// Smallest and largest distance in pixels between those positions.
    pub(crate) direction_steps_px: [usize; 2],
    /// The inputs the plan was made for.
    pub(crate) available: Available,
    /// The tile of which the frame is a repetition, if it is.
    pub(crate) tile: Option<Tile>,
    /// Why no shape is needed, if so.
    pub(crate) no_shape: Option<&'static str>,
    pub(crate) wanted: BTreeSet<Product>,
    pub(crate) decisions: Vec<Decision>,
    /// The stages that run, in order.
    pub(crate) stages: Vec<&'static Stage>,
    /// By stage: a key of all that its result depends on, earlier stages included.
    pub(crate) keys: BTreeMap<&'static str, String>,
    pub(crate) reach: usize,
}

/// Whether a step runs, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Decision {
    /// The step's name.
    #[serde(rename = "stage")]
    pub step: &'static str,
    /// Whether it runs.
    pub kept: bool,
    /// The reason in a few words.
    pub reason: String,
}

impl std::fmt::Display for Decision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verdict = if self.kept { "run " } else { "skip" };
        write!(f, "{verdict}  {:<21} {}", self.step, self.reason)
    }
}

impl Plan {
    /// The same plan for a frame that repeats a tile.
    pub(crate) fn of_tile(self, window: Window, wraps: [bool; 2]) -> Self {
        Self {
            tile: Some(Tile { window, wraps }),
            ..self
        }
        .follow()
    }

    /// Follows dependencies from the first stage to the last: the reach of samples, and the keys of results.
    pub(crate) fn follow(mut self) -> Self {
        let mut made: BTreeMap<Product, (usize, String)> = BTreeMap::new();
        self.reach = 0;
        for stage in self.stages.clone() {
            let takes = (stage.takes)(&self);
            let taken: Vec<_> = takes
                .iter()
                .filter_map(|product| made.get(product))
                .collect();
            let reach =
                taken.iter().map(|(reach, _)| *reach).max().unwrap_or(0) + (stage.reach_px)(&self);
            let before: BTreeSet<&str> = taken.iter().map(|(_, key)| key.as_str()).collect();
            let before: Vec<_> = before.into_iter().collect();
            let key = format!(
                "{} {} ({})",
                stage.name,
                (stage.depends_on)(&self),
                before.join(", ")
            );
            self.reach = self.reach.max(reach);
            made.extend(stage.gives().map(|product| (product, (reach, key.clone()))));
            self.keys.insert(stage.name, key);
        }
        self
    }

    /// All steps in the order of execution, kept or dropped, with reasons.
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Whether the step named as in [`Plan::decisions`] runs.
    ///
    /// # Panics
    /// If there is no step of this name.
    pub fn runs(&self, step: &str) -> bool {
        let decision = self.decisions.iter().find(|known| known.step == step);
        decision
            .unwrap_or_else(|| panic!("no step is called {step}"))
            .kept
    }

    /// Whether it makes neither a picture nor a drawing.
    pub(crate) fn makes_shape_alone(&self) -> bool {
        self.stages.iter().all(|stage| stage.makes == Makes::Shape)
    }

    /// Whether a product is wanted, by the caller or by a stage.
    pub fn wants(&self, product: Product) -> bool {
        self.wanted.contains(&product)
    }

    /// How the background of the drawing is drawn, if there is one.
    pub(crate) fn background(&self) -> Option<Background> {
        self.drawing.as_ref().map(|params| params.tone.background)
    }

    /// Contours of the drawing, if any, with the size of lines in the picture.
    pub(crate) fn contours(&self) -> Option<ContourParams> {
        let contours = self.drawing.as_ref()?.contours?;
        Some(contours.scaled(self.line_scale))
    }

    /// Whether curvature is computed.
    pub(crate) fn wants_curvature(&self) -> bool {
        self.wants(Product::Trace) || self.wants(Product::Hessian)
    }

    /// The stages that run, in order, named as in [`crate::plan::outcome::Outcome::timings`].
    pub fn stages(&self) -> Vec<&'static str> {
        self.stages.iter().map(|stage| stage.name).collect()
    }

    /// Key of all that a stage's result depends on, earlier stages included: results with equal keys are
    /// interchangeable between plans.
    pub(crate) fn key(&self, stage: &str) -> &str {
        self.keys.get(stage).map_or("", String::as_str)
    }

    /// The key of a stage's result; `None` where it depends on what mirrors and lenses show, of which a key tells nothing.
    pub(crate) fn key_without_scene(&self, stage: &str) -> Option<&str> {
        self.specular.is_none().then(|| self.key(stage))
    }

    /// How far, in pixels, an input sample reaches: beyond this distance from its border a crop gives the results of
    /// the whole picture, unless a gain or white level is chosen from the frame. A drawing depends on the whole
    /// picture.
    pub fn reach(&self) -> usize {
        self.reach
    }
}
