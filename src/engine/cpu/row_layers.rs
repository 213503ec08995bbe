//! Layers whose last stages run while they are written: what some rows tell is never there as a whole.

use crate::engine::cpu::runner::{Passage, RunFrame};
use crate::engine::inputs::PlanInputs;
use crate::engine::tiles::rows_of;
use crate::error::Result;
use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane, Vector2Planes};
use crate::plan::Plan;
use crate::plan::execution::{Interim, RunInputs, Runner};
use crate::plan::outcome::Outcome;
use crate::plan::stage::Stage;
use crate::plan::watch::Watch;
use std::ops::Range;

/// Layers of a frame, with the stages that remain to be run on rows of them.
pub(crate) struct RowLayers<'a> {
    runner: &'a Runner,
    /// Planes of so many rows.
    memory: Memory,
    plan: &'a Plan,
    pub(crate) outcome: Outcome,
    /// The gradient at further scales.
    more_gradients: Vec<Vector2Planes>,
    rest: Vec<&'static Stage>,
}

/// Some rows of a frame and of its layers, with others around them.
pub(crate) struct LaidRows {
    pub(crate) frame: Frame,
    pub(crate) outcome: Outcome,
    /// The rows that were asked for, among those.
    pub(crate) rows: Range<usize>,
}

impl Runner {
    /// Runs `plan`, but for stages that run on rows.
    ///
    /// # Errors
    /// As [`Runner::execute`].
    pub(crate) fn execute_for_rows<'a>(
        &'a self,
        plan: &'a Plan,
        frame: &Frame,
        inputs: PlanInputs,
        watch: Watch,
    ) -> Result<RowLayers<'a>> {
        inputs.check(plan, frame)?;
        let of_shape = plan.makes_shape_alone();
        let (rest, whole): (Vec<_>, Vec<_>) = plan
            .stages
            .iter()
            .copied()
            .partition(|stage: &&'static Stage| stage.by_rows && of_shape);
        let passage = Passage::new(self, plan, inputs.given(), watch);
        let made = passage.go(RunFrame::Shared(frame), &whole)?;
        let (mut outcome, more_gradients) = (made.outcome, made.more_gradients);
        if !rest.is_empty() {
            // The gain takes it; rows have their own.
            self.memory.recycle(outcome.shape.trace.take());
        }
        Ok(RowLayers {
            more_gradients,
            rest,
            ..RowLayers::whole(self, plan, outcome)
        })
    }
}

impl<'a> RowLayers<'a> {
    /// Layers of which nothing remains to be made.
    pub(crate) fn whole(runner: &'a Runner, plan: &'a Plan, outcome: Outcome) -> Self {
        Self {
            runner,
            memory: runner.memory.at_other_size(),
            plan,
            outcome,
            more_gradients: Vec::new(),
            rest: Vec::new(),
        }
    }

    /// These rows of `frame`, which the layers are of: bit for bit those that [`Runner::execute`] makes.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn rows(&self, frame: &Frame, rows: &Range<usize>) -> Result<LaidRows> {
        let (plan, whole) = (self.plan, frame.data_window);
        let reaches = self.rest.iter().map(|stage| (stage.reach_px)(plan));
        let reach: usize = reaches.sum();
        let takes = rows.start.saturating_sub(reach)..(rows.end + reach).min(whole.height());
        let strip = frame.crop(rows_of(whole, &takes));
        let samples = takes.start * whole.width()..takes.end * whole.width();
        let cut = |plane: &Plane| {
            let mut rows = self.memory.unwritten(&strip.mask);
            rows.samples_mut()
                .copy_from_slice(&plane.samples()[samples.clone()]);
            rows
        };
        let more = self.more_gradients.iter();
        let more = more.map(|Vector2Planes { x, y }| Vector2Planes {
            x: cut(x),
            y: cut(y),
        });
        let more = more.collect();
        let passage = Passage {
            memory: self.memory.clone(),
            made: Interim {
                outcome: self.outcome.shape_mapped(cut),
                more_gradients: more,
                ..Interim::default()
            },
            ..Passage::new(self.runner, plan, RunInputs::default(), Watch::default())
        };
        let made = passage.go(RunFrame::Shared(&strip), &self.rest)?;
        Ok(LaidRows {
            rows: rows.start - takes.start..rows.end - takes.start,
            outcome: made.outcome,
            frame: strip,
        })
    }

    /// Reclaims the memory of rows.
    pub(crate) fn recycle(&self, rows: LaidRows) {
        self.memory.recycle(rows.outcome.into_planes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::{Available, Goal};
    use crate::scenes::Scene;

    /// All layers, at two scales, in pixels of the picture and of another size, where the trace is rounded otherwise.
    #[test]
    fn rows_are_those_of_the_whole_bit_for_bit() {
        let scene = Scene::barriers(70, 50).frame;
        for reference_height in [None, Some(33)] {
            let shape = ShapeParams {
                reference_height,
                ..ShapeParams::default()
            };
            let available = Available::in_frame(&scene);
            let scaling = ScalingParams::default();
            let plan = Plan::new(
                Goal::Layers {
                    and: &[],
                    more_px: &[3.0],
                },
                available,
                shape,
                scaling,
            );
            let (plan, runner, frame) = (plan.unwrap(), Runner::default(), scene.clone());
            let (inputs, watch) = (PlanInputs::default(), Watch::default());
            let whole = runner.execute(&plan, &frame, inputs).unwrap();
            let layers = runner
                .execute_for_rows(&plan, &frame, inputs, watch)
                .unwrap();
            assert!(layers.outcome.shape.hessian.is_none() && !layers.rest.is_empty());
            assert_eq!(whole.shape.more_scales.len(), 1);
            assert_eq!(layers.outcome.gain, whole.gain);
            for rows in [0..1, 1..20, 20..49, 49..50] {
                let laid = layers.rows(&frame, &rows).unwrap();
                let made = laid.outcome.products();
                let expected = whole.products();
                for ((product, made), (_, whole)) in made.zip(expected) {
                    for (made, whole) in made.into_iter().zip(whole) {
                        let own = laid.rows.clone().map(|y| made.row(y));
                        assert!(own.eq(rows.clone().map(|y| whole.row(y))), "{product:?}");
                    }
                }
                assert_eq!(laid.outcome.products().count(), whole.products().count());
                layers.recycle(laid);
            }
        }
    }
}
