//! Sessions: repeated runs of one frame with changing parameters; only affected stages are recomputed.

use crate::engine::backends::Engine;
use crate::engine::cpu::runner::RunFrame;
use crate::engine::inputs::PlanInputs;
use crate::engine::request::Request;
use crate::engine::run::Run;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::plan::execution::Runner;
use crate::plan::frame_cache::FrameCache;
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Plan};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Runs plans on one frame and caches results that later runs on the CPU can reuse: edges, the diffused gradient,
/// curvature and its gain, directions, white levels, an estimated albedo, lines along edges. Outcomes equal those of
/// [`Engine::execute`] bit for bit.
///
/// `F` holds the frame: a reference, or the frame itself, alone or with other data loaded beside it.
#[derive(Debug)]
pub struct Session<F> {
    engine: Arc<Engine>,
    held: F,
    runner: Runner,
    kept: FrameCache,
    /// The last outcome of the CPU.
    outcome: Outcome,
    /// A later outcome that nothing is kept for: from a device, or of a tile.
    elsewhere: Option<Outcome>,
    counts: BTreeMap<&'static str, u32>,
}

impl<F: AsRef<Frame>> Session<F> {
    /// A session for the frame of `held` that runs on `engine`.
    pub fn new(engine: impl Into<Arc<Engine>>, held: F) -> Self {
        Self {
            engine: engine.into(),
            held,
            runner: Runner::default(),
            kept: FrameCache::default(),
            outcome: Outcome::default(),
            elsewhere: None,
            counts: BTreeMap::new(),
        }
    }

    /// The holder of the frame.
    pub fn held(&self) -> &F {
        &self.held
    }

    /// The outcome of the last run.
    pub fn outcome(&self) -> &Outcome {
        self.elsewhere.as_ref().unwrap_or(&self.outcome)
    }

    /// How often each pass has run on the CPU, named as in [`Outcome::timings`]; a cached pass does not count.
    pub fn counts(&self) -> &BTreeMap<&'static str, u32> {
        &self.counts
    }

    /// As [`Engine::run`]; drawings are not enlarged.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn run(&mut self, request: &Request, run: &Run) -> Result<&Outcome> {
        let available = Available::in_frame(self.held.as_ref());
        let (plan, light) = (request.plan(available)?, request.light(available));
        let inputs = PlanInputs {
            illumination: Some(&light),
            ..request.inputs
        };
        self.execute(&plan, inputs, run)?;
        let outcome = self.elsewhere.as_mut().unwrap_or(&mut self.outcome);
        outcome.complete(&plan, self.held.as_ref(), 1.0, &request.params);
        Ok(self.outcome())
    }

    /// As [`Engine::execute`].
    ///
    /// # Errors
    /// As [`Engine::execute`].
    pub fn execute(&mut self, plan: &Plan, inputs: PlanInputs, run: &Run) -> Result<&Outcome> {
        if run.region.is_some() || run.max_memory.is_some() {
            return Err(Error::Unfit {
                found: "a session keeps what it makes of whole frames, and a region or strips are asked for"
                    .into(),
                remedy: "run the engine itself",
            });
        }
        let mask = &self.held.as_ref().mask;
        run.begin([mask.height(), mask.width()])?;
        self.elsewhere = None;
        let frame = self.held.as_ref();
        if frame.is_tile() {
            self.elsewhere = Some(self.engine.execute(plan, frame, inputs, run)?);
            return Ok(self.outcome());
        }
        self.elsewhere = self.engine.on_device(plan, frame, inputs, run)?;
        if self.elsewhere.is_none() {
            self.execute_on_cpu(plan, inputs, run)?;
        }
        run.finish(self.held.as_ref(), self.outcome())?;
        Ok(self.outcome())
    }

    fn execute_on_cpu(&mut self, plan: &Plan, inputs: PlanInputs, run: &Run) -> Result<()> {
        let mut last = std::mem::take(&mut self.outcome);
        self.kept.recycle(&mut last.shape);
        self.runner.recycle(last);
        let (frame, kept) = (self.held.as_ref(), Some(&mut self.kept));
        self.outcome = run.install(|| {
            self.runner
                .execute_watched(plan, RunFrame::Shared(frame), inputs, run.watch(), kept)
        })?;
        for (pass, _) in &self.outcome.timings {
            *self.counts.entry(pass).or_default() += 1;
        }
        Ok(())
    }
}

impl AsRef<Frame> for Frame {
    fn as_ref(&self) -> &Frame {
        self
    }
}
