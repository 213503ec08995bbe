//! The CPU as a caller sees it: plans run one after another, in memory that is kept.

use crate::engine::cpu::Run;
use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::memory::Memory;
use crate::engine::outcome::Outcome;
use crate::frame::{Frame, SpecularScene, Vector2Planes};
use crate::light::lights::Illumination;
use crate::light::prepared_environment::EnvironmentCache;
use crate::line::direction_field::cpu as direction_field;
use crate::line::specular;
use crate::line::specular::map_directions::DirectionCache;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::tonal_art_map::TonalArtMap;
use crate::line::tonal_art_map::cached::ArtMapCache;
use crate::params::{FieldParams, LineParams, RunOptions, StrokeDirections};
use crate::plan::{Goal, Plan, Stage};
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

/// What a drawing takes beside the frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct DrawingInputs<'a> {
    /// The light, for a tone in new light.
    pub illumination: Option<&'a Illumination>,
    /// The texture of strokes, for [`crate::params::Style::Pictures`].
    pub art_map: Option<&'a TonalArtMap>,
    /// What mirrors and lenses show, where the plan traces it.
    pub specular: Option<&'a SpecularScene>,
    /// For a frame of a sequence, whose strokes move with the surface. A still picture has none, and asks
    /// nothing of it.
    pub sequence: Option<SequenceInputs<'a>>,
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
            plan.goal != Goal::Relight,
            "new light is run by Runner::relight"
        );
        assert!(plan.drawing.is_none(), "a drawing is run by Runner::draw");
        self.start(plan, frame, kept, |run| run.enhance())
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
        self.start(plan, frame, kept, |run| run.relight(illumination, scene))
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
        let params = plan.drawing.as_ref().expect("a drawing is planned");
        self.start(plan, frame, kept, |run| {
            match plan.goal {
                Goal::Relight => {
                    let illumination = inputs.illumination.expect("new light has lights");
                    run.relight(illumination, inputs.specular);
                }
                _ => run.enhance(),
            }
            run.draw(params, inputs);
        })
    }

    /// The shape alone, whatever light `plan` is for.
    pub(crate) fn find_shape(&self, plan: &Plan, frame: &Frame) -> Outcome {
        self.start(plan, frame, None, |_| ())
    }

    fn start(
        &self,
        plan: &Plan,
        frame: &Frame,
        kept: Option<&mut FrameCache>,
        light: impl FnOnce(&mut Run),
    ) -> Outcome {
        let mut run = Run {
            plan,
            frame,
            runner: self,
            kept,
            outcome: Outcome::default(),
        };
        if plan.has(Stage::Conductance) {
            run.find_shape();
        }
        light(&mut run);
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
