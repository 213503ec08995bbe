//! The runner of the CPU: plans run one at a time, in recycled memory.

use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::run::{Run, Runner};
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::run::Watch;
use crate::error::Result;
use crate::frame::{Frame, Vector2Planes};
use crate::line::direction_field::cpu as direction_field;
use crate::line::specular;
use crate::params::LineParams;
use crate::plan::Plan;
use crate::plan::stage::Stage;
use crate::plan::stages::{SHAPE, stages};
use crate::product::Product;
use crate::shape::edges::cpu as edges;

impl Runner {
    /// Runs `plan` on `frame`, in the rayon pool of the caller.
    ///
    /// # Errors
    /// [`Error::Unfit`](crate::Error::Unfit) if the plan was made for other inputs.
    pub(crate) fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
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
        let mut run = Run {
            watch,
            kept,
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through(stages())?;
        Ok(run.outcome)
    }

    /// The directions that strokes by `params` follow: see [`Engine::stroke_fields`](crate::engine::Engine::stroke_fields).
    ///
    /// # Panics
    /// If the plan leaves out conductance.
    pub(crate) fn stroke_fields(
        &self,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
        params: &LineParams,
    ) -> Vec<Vector2Planes> {
        assert!(plan.wants(Product::Conductance), "strokes stop at edges");
        let (kept, memory) = (&self.map_directions, &self.memory);
        let through = inputs.specular.zip(plan.specular);
        let seen = through.and_then(|(scene, specular)| {
            specular::seen_through(plan, frame, scene, &specular, params, kept, memory)
        });
        let drawn = seen.as_ref().map_or(frame, |seen| &seen.frame);
        let given = seen.as_ref().map(|seen| &seen.directions[..]);
        let (edges, _) = edges::edges_and_gradient(plan, drawn, memory);
        direction_field::stroke_fields(
            plan,
            &params.field,
            params.directions,
            drawn,
            &edges.conductance,
            given,
            memory,
        )
    }

    /// The shape alone, whatever light `plan` is for.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn find_shape(&self, plan: &Plan, frame: &Frame, watch: Watch) -> Result<Outcome> {
        let mut run = Run {
            watch,
            ..Run::new(self, plan, frame, Inputs::default())
        };
        run.go_through(SHAPE)?;
        Ok(run.outcome)
    }

    /// Forgets what was made of the last environment, so that making it is measured again.
    pub(crate) fn forget_environment(&self) {
        self.environment.forget();
    }

    /// Takes an outcome that is no longer needed.
    pub(crate) fn recycle(&self, outcome: Outcome) {
        self.memory.recycle(outcome.into_planes());
    }
}

impl Run<'_> {
    /// Those of the stages that the plan runs.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), looked for before each of them.
    pub(crate) fn go_through(
        &mut self,
        stages: impl IntoIterator<Item = &'static Stage>,
    ) -> Result<()> {
        let plan = self.plan;
        let planned = stages.into_iter();
        for stage in planned.filter(|stage| plan.stages().contains(&stage.name)) {
            self.watch.check()?;
            (stage.cpu)(self);
        }
        Ok(())
    }
}
