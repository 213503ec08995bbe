//! The runner of the CPU: plans run one at a time, in recycled memory.

use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::run::{Run, Runner};
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::engine::watch::Watch;
use crate::error::Result;
use crate::frame::{Frame, Vector2Planes};
use crate::line::direction_field::cpu as direction_field;
use crate::line::direction_field::patches::Patches;
use crate::line::specular;
use crate::params::LineParams;
use crate::plan::Plan;
use crate::plan::stage::Stage;
use crate::plan::stages::{SHAPE, stages};
use crate::product::Product;
use crate::shape::edges::cpu as edges;

impl Runner {
    /// Runs `plan` on `frame`, in the caller's rayon pool.
    ///
    /// # Errors
    /// [`Error::Unfit`](crate::Error::Unfit) if the plan was made for other inputs.
    #[cfg(any(test, feature = "cli"))]
    pub(crate) fn execute(&self, plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
        self.execute_watched(plan, frame, inputs, Watch::default(), None)
    }

    /// [`Runner::execute`] with observers and the cache of the frame.
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
        let memory = &self.memory.for_run(watch.token());
        let mut run = Run {
            memory,
            watch,
            kept,
            ..Run::new(self, plan, frame, inputs)
        };
        run.go_through(stages())?;
        Ok(run.outcome)
    }

    /// Directions that strokes with `params` follow: see
    /// [`Engine::stroke_fields`](crate::engine::Engine::stroke_fields).
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
        let cell_px = params.field.cell_px as usize;
        let patches = Patches::new(drawn, &edges.conductance, cell_px);
        direction_field::stroke_fields(
            plan,
            &params.field,
            params.directions,
            drawn,
            &patches,
            given,
            memory,
        )
    }

    /// The shape only, whatever light `plan` is for.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn find_shape(&self, plan: &Plan, frame: &Frame, watch: Watch) -> Result<Outcome> {
        let memory = &self.memory.for_run(watch.token());
        let mut run = Run {
            memory,
            watch,
            ..Run::new(self, plan, frame, Inputs::default())
        };
        run.go_through(SHAPE)?;
        Ok(run.outcome)
    }

    /// Drops the prepared environment, so that benchmarks measure its preparation again.
    pub(crate) fn forget_environment(&self) {
        self.environment.forget();
    }

    /// Reclaims the memory of an outcome.
    pub(crate) fn recycle(&self, outcome: Outcome) {
        self.memory.recycle(outcome.into_planes());
    }
}

/// The products of other stages that any of these takes.
pub(crate) fn taken_by(
    stages: impl IntoIterator<Item = &'static Stage>,
    plan: &Plan,
) -> Vec<Product> {
    let stages = stages.into_iter();
    stages.flat_map(|stage| (stage.takes)(plan)).collect()
}

impl Run<'_> {
    /// [`Run::go_through`]; products of the shape are recycled where none of the stages to come takes them.
    ///
    /// # Errors
    /// As [`Run::go_through`].
    pub(crate) fn go_through_once(
        &mut self,
        stages: impl IntoIterator<Item = &'static Stage>,
    ) -> Result<()> {
        let plan = self.plan;
        let planned = stages.into_iter().filter(|stage| plan.has(stage));
        let planned: Vec<_> = planned.collect();
        for (i, stage) in planned.iter().enumerate() {
            let [now, later] =
                [i, i + 1].map(|first| taken_by(planned[first..].iter().copied(), plan));
            self.memory.recycle(self.outcome.shape.take_others(&now));
            self.read_last = (stage.takes)(plan);
            self.read_last.retain(|product| !later.contains(product));
            self.go_through([*stage])?;
        }
        self.memory.recycle(self.outcome.shape.take_others(&[]));
        Ok(())
    }

    /// Runs those of the stages that are in the plan.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), checked before and after each of them: the output of a cancelled
    /// stage is undefined.
    pub(crate) fn go_through(
        &mut self,
        stages: impl IntoIterator<Item = &'static Stage>,
    ) -> Result<()> {
        let plan = self.plan;
        for stage in stages.into_iter().filter(|stage| plan.has(stage)) {
            self.watch.check()?;
            (stage.cpu)(self);
        }
        self.watch.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cpu::memory::Memory;
    use crate::engine::cpu::rows::map_covered;
    use crate::engine::watch::CancelToken;
    use crate::frame::{Mask, Plane};
    use crate::params::RunOptions;
    use crate::shape::diffusion::cpu::{Medium, diffusion};
    use crate::shape::diffusion::sweeps::DiffusionSchedule;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// One thread writes 40 of 90 rows before row 39 cancels the run: the remaining rows are not written.
    #[test]
    fn rows_end_where_a_run_is_cancelled() {
        let token = CancelToken::new();
        let memory = Memory::default().for_run(Some(&token));
        let mask = Mask::new(Plane::filled(30, 90, true));
        let made = AtomicUsize::new(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let [plane] = pool.unwrap().install(|| {
            map_covered(&mask, &memory, |_| {
                if made.fetch_add(1, Ordering::Relaxed) == 39 {
                    token.cancel();
                }
                |_| [1.0]
            })
        });
        assert_eq!(made.into_inner(), 40);
        assert_eq!(plane.samples().iter().sum::<f32>(), 40.0 * 30.0);
    }

    /// Diffusion leaves a field of ones without edges unchanged; a cancelled one returns nothing.
    #[test]
    fn a_diffusion_ends_where_its_run_is_cancelled() {
        let (ones, mask) = (
            Plane::filled(50, 40, 1.0),
            Mask::new(Plane::filled(50, 40, true)),
        );
        let sweeps = DiffusionSchedule::to_sigmas(&[4.0], 1e-3);
        let sum = |token: &CancelToken| {
            let field = Vector2Planes {
                x: ones.clone(),
                y: ones.clone(),
            };
            let memory = Memory::default().for_run(Some(token));
            let options = RunOptions::default();
            let medium = Medium::of_whole(&ones, &mask);
            let spread = diffusion(field, medium, &sweeps, &options, &memory);
            spread[0].x.samples().iter().sum::<f32>()
        };
        let token = CancelToken::new();
        assert!((sum(&token) - 2000.0).abs() < 2.0);
        token.cancel();
        assert_eq!(sum(&token), 0.0);
    }
}
