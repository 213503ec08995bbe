//! One frame, run again and again with other parameters: only what they touch is made anew.

use crate::engine::cpu::frame_cache::FrameCache;
use crate::engine::cpu::run::{DrawingInputs, Runner};
use crate::engine::outcome::Outcome;
use crate::frame::{Frame, SpecularScene};
use crate::light::lights::Illumination;
use crate::plan::Plan;
use std::collections::BTreeMap;

/// Runs plans on one frame, and keeps what the next ones can use: edges, the diffused gradient, curvature and its gain,
/// directions, white levels, an estimated albedo, lines along edges. The outcomes are those of a [`Runner`], bit for bit.
///
/// `F` is what holds the frame: a reference, or the frame itself with what was read along with it.
#[derive(Debug)]
pub struct LiveRunner<F> {
    held: F,
    runner: Runner,
    kept: FrameCache,
    outcome: Outcome,
    counts: BTreeMap<&'static str, u32>,
}

impl<F: AsRef<Frame>> LiveRunner<F> {
    /// A runner for the frame of `held`.
    pub fn new(held: F) -> Self {
        Self {
            held,
            runner: Runner::default(),
            kept: FrameCache::default(),
            outcome: Outcome::default(),
            counts: BTreeMap::new(),
        }
    }

    /// What holds the frame.
    pub fn held(&self) -> &F {
        &self.held
    }

    /// What the last run gave.
    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// How often each pass has run, under the names of [`Outcome::timings`]. A pass whose result was kept has not.
    pub fn counts(&self) -> &BTreeMap<&'static str, u32> {
        &self.counts
    }

    /// As [`Runner::run`].
    ///
    /// # Panics
    /// As [`Runner::run`] does.
    pub fn run(&mut self, plan: &Plan) -> &Outcome {
        self.go(|runner, frame, kept| runner.run_kept(plan, frame, Some(kept)))
    }

    /// As [`Runner::relight`]; where mirrors and lenses show a `scene`, as [`Runner::relight_specular`].
    ///
    /// # Panics
    /// As [`Runner::relight`] does.
    pub fn relight(
        &mut self,
        plan: &Plan,
        illumination: &Illumination,
        scene: Option<&SpecularScene>,
    ) -> &Outcome {
        self.go(|runner, frame, kept| {
            runner.relight_kept(plan, frame, illumination, scene, Some(kept))
        })
    }

    /// As [`Runner::draw`].
    ///
    /// # Panics
    /// As [`Runner::draw`] does.
    pub fn draw(&mut self, plan: &Plan, inputs: DrawingInputs) -> &Outcome {
        self.go(|runner, frame, kept| runner.draw_kept(plan, frame, inputs, Some(kept)))
    }

    fn go(&mut self, run: impl FnOnce(&Runner, &Frame, &mut FrameCache) -> Outcome) -> &Outcome {
        let mut last = std::mem::take(&mut self.outcome);
        self.kept.recycle(&mut last);
        self.runner.recycle(last);
        self.outcome = run(&self.runner, self.held.as_ref(), &mut self.kept);
        for (pass, _) in &self.outcome.timings {
            *self.counts.entry(pass).or_default() += 1;
        }
        &self.outcome
    }
}

impl AsRef<Frame> for Frame {
    fn as_ref(&self) -> &Frame {
        self
    }
}
