//! The CPU as a caller sees it: plans run one after another, in memory that is kept.

use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::run::{DrawingInputs, Run, Runner};
use crate::engine::outcome::Outcome;
use crate::frame::{Frame, SpecularScene, Vector2Planes};
use crate::light::lights::Illumination;
use crate::line::direction_field::cpu as direction_field;
use crate::line::specular;
use crate::params::{FieldParams, LineParams, RunOptions, StrokeDirections};
use crate::plan::Plan;
use crate::plan::stage::Stage;
use crate::plan::stages::{DRAWING, PICTURE, SHAPE};
use crate::product::Product;
use crate::shape::edges::cpu as edges;

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
    /// # Panics
    /// As [`run`](super::run) does.
    pub fn run(&self, plan: &Plan, frame: &Frame) -> Outcome {
        self.run_kept(plan, frame, None)
    }

    /// [`Runner::run`] with what was kept of the frame.
    pub(crate) fn run_kept(
        &self,
        plan: &Plan,
        frame: &Frame,
        kept: Option<&mut FrameCache>,
    ) -> Outcome {
        assert!(
            plan.relighting.is_none(),
            "new light is run by Runner::relight"
        );
        assert!(plan.drawing.is_none(), "a drawing is run by Runner::draw");
        self.go(plan, frame, DrawingInputs::default(), kept)
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
        assert!(plan.wants(Product::Conductance), "strokes stop at edges");
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

    /// Runs `plan`, made by [`Plan::relight`] for the kinds of light in `illumination`, on `frame`.
    ///
    /// # Panics
    /// If the plan was made for another goal, other inputs or other kinds of light.
    pub fn relight(&self, plan: &Plan, frame: &Frame, illumination: &Illumination) -> Outcome {
        self.relight_kept(plan, frame, illumination, None, None)
    }

    /// [`Runner::relight`] of mirrors and lenses that show what is around them: the specular pixels of `scene`, or all.
    ///
    /// # Panics
    /// As [`Runner::relight`] does.
    pub fn relight_specular(
        &self,
        plan: &Plan,
        frame: &Frame,
        illumination: &Illumination,
        scene: &SpecularScene,
    ) -> Outcome {
        self.relight_kept(plan, frame, illumination, Some(scene), None)
    }

    /// Both, with what was kept of the frame.
    pub(crate) fn relight_kept(
        &self,
        plan: &Plan,
        frame: &Frame,
        illumination: &Illumination,
        scene: Option<&SpecularScene>,
        kept: Option<&mut FrameCache>,
    ) -> Outcome {
        assert!(plan.drawing.is_none(), "a drawing is run by Runner::draw");
        let inputs = DrawingInputs {
            illumination: Some(illumination),
            specular: scene,
            ..DrawingInputs::default()
        };
        self.go(plan, frame, inputs, kept)
    }

    /// Runs `plan`, made by [`Plan::hatch`], on `frame`.
    ///
    /// # Panics
    /// If the plan was made for another goal or other inputs.
    pub fn draw(&self, plan: &Plan, frame: &Frame, inputs: DrawingInputs) -> Outcome {
        self.draw_kept(plan, frame, inputs, None)
    }

    /// [`Runner::draw`] with what was kept of the frame.
    pub(crate) fn draw_kept(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: DrawingInputs,
        kept: Option<&mut FrameCache>,
    ) -> Outcome {
        assert!(plan.drawing.is_some(), "a drawing is planned");
        self.go(plan, frame, inputs, kept)
    }

    /// The shape alone, whatever light `plan` is for.
    pub(crate) fn find_shape(&self, plan: &Plan, frame: &Frame) -> Outcome {
        let mut run = Run::new(self, plan, frame, DrawingInputs::default());
        run.go_through(&SHAPE);
        run.outcome
    }

    /// All stages of a plan.
    fn go(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: DrawingInputs,
        kept: Option<&mut FrameCache>,
    ) -> Outcome {
        let mut run = Run {
            kept,
            ..Run::new(self, plan, frame, inputs)
        };
        for stages in [&SHAPE[..], &PICTURE, &DRAWING] {
            run.go_through(stages);
        }
        run.outcome
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

impl Run<'_> {
    /// Those of the stages that the plan runs.
    pub(crate) fn go_through(&mut self, stages: &[&Stage]) {
        let planned = stages
            .iter()
            .filter(|stage| self.plan.stages().contains(&stage.name));
        for stage in planned.collect::<Vec<_>>() {
            (stage.cpu)(self);
        }
    }
}
