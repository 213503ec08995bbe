//! The CPU as a caller sees it: plans run one after another, in memory that is kept.

use crate::engine::cpu::Run;
use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::memory::Memory;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::run::Watch;
use crate::error::Result;
use crate::frame::{Frame, SpecularScene, Vector2Planes};
use crate::light::prepared_environment::EnvironmentCache;
use crate::line::direction_field::cpu as direction_field;
use crate::line::specular;
use crate::line::specular::map_directions::DirectionCache;
use crate::line::tonal_art_map::cached::ArtMapCache;
use crate::params::{FieldParams, LineParams, RunOptions, StrokeDirections};
use crate::plan::{Plan, Stage};
use crate::shape::edges::cpu as edges;

/// Runs plans one after another. A runner that is given outcomes back makes the next ones in their memory,
/// and it keeps what it made of the last environment and the last texture of strokes; all are faster. None of
/// its options changes a bit of the outcome.
#[derive(Debug, Default)]
pub struct Runner {
    pub(crate) options: RunOptions,
    pub(crate) memory: Memory,
    pub(crate) environment: EnvironmentCache,
    pub(crate) art_map: ArtMapCache,
    pub(crate) map_directions: DirectionCache,
}

impl Runner {
    /// A runner with these options.
    pub fn new(options: RunOptions) -> Self {
        Self {
            options,
            ..Self::default()
        }
    }

    /// Runs `plan` on `frame`, in the rayon pool of the caller.
    ///
    /// # Errors
    /// [`Error::Unfit`](crate::Error::Unfit) if the plan was made for other inputs.
    pub fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        self.execute_watched(plan, frame, inputs, Watch::default(), None)
    }

    /// [`Runner::execute`] that is looked on, with what was kept of the frame.
    ///
    /// # Errors
    /// As [`Runner::execute`]; [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn execute_watched(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        watch: Watch,
        kept: Option<&mut FrameCache>,
    ) -> Result<Outcome> {
        inputs.check(plan, frame)?;
        self.start(plan, frame, watch, kept, |run| {
            match inputs.illumination {
                Some(light) if plan.relighting.is_some() => run.relight(light, inputs.specular),
                _ => run.enhance(),
            }
            let Some(params) = &plan.drawing else {
                return Ok(());
            };
            watch.check()?;
            run.draw(params, inputs);
            Ok(())
        })
    }

    /// The directions that strokes follow, of the curvatures wanted in turn: unit, in the picture, x right,
    /// y up, each equal to its opposite; 0 outside the mask.
    ///
    /// # Panics
    /// If the plan leaves out conductance.
    pub fn stroke_fields(
        &self,
        plan: &Plan,
        frame: &Frame,
        params: &FieldParams,
        directions: StrokeDirections,
    ) -> Vec<Vector2Planes> {
        assert!(plan.has(Stage::Conductance), "strokes stop at edges");
        let (edges, _) = edges::edges_and_gradient(plan, frame, &self.memory);
        let memory = &self.memory;
        let conductance = &edges.conductance;
        direction_field::stroke_fields(plan, params, directions, frame, conductance, None, memory)
    }

    /// The directions that strokes by `params` follow on `frame` and on what its specular pixels show of `scene`, in
    /// the form of [`Runner::stroke_fields`].
    ///
    /// # Panics
    /// If the plan leaves out conductance, or does not trace specular pixels.
    pub fn stroke_fields_through(
        &self,
        plan: &Plan,
        frame: &Frame,
        scene: &SpecularScene,
        params: &LineParams,
    ) -> Vec<Vector2Planes> {
        let specular = plan.specular.expect("the plan traces specular pixels");
        let kept = &self.map_directions;
        let seen =
            specular::seen_through(plan, frame, scene, &specular, params, kept, &self.memory);
        let drawn = seen.as_ref().map_or(frame, |seen| &seen.frame);
        let given = seen.as_ref().map(|seen| &seen.directions[..]);
        let (edges, _) = edges::edges_and_gradient(plan, drawn, &self.memory);
        direction_field::stroke_fields(
            plan,
            &params.field,
            params.directions,
            drawn,
            &edges.conductance,
            given,
            &self.memory,
        )
    }

    /// The shape alone, whatever light `plan` is for.
    pub(crate) fn find_shape(&self, plan: &Plan, frame: &Frame) -> Outcome {
        let mut run = Run::new(self, plan, frame);
        run.find_planned_shape();
        run.outcome
    }

    fn start(
        &self,
        plan: &Plan,
        frame: &Frame,
        watch: Watch,
        kept: Option<&mut FrameCache>,
        light: impl FnOnce(&mut Run) -> Result<()>,
    ) -> Result<Outcome> {
        watch.check()?;
        let mut run = Run {
            watch,
            kept,
            ..Run::new(self, plan, frame)
        };
        run.find_planned_shape();
        watch.check()?;
        light(&mut run)?;
        Ok(run.outcome)
    }

    /// Forgets what was made of the last environment, so that making it is measured again.
    pub fn forget_environment(&self) {
        self.environment.forget();
    }

    /// Takes an outcome that is no longer needed.
    pub fn recycle(&self, outcome: Outcome) {
        self.memory.recycle(outcome.into_planes());
    }
}
