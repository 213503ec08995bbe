//! One run of a plan: a frame on its way through the stages.

use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane, SpecularScene, Vector2Planes, Vector3Planes};
use crate::kernel::shelf::{Caches, Lent, Shelf};
use crate::params::{Adaptive, RunOptions};
use crate::plan::Plan;
use crate::plan::drawing::SequenceInputs;
use crate::plan::frame_cache::FrameCache;
use crate::plan::outcome::Outcome;
use crate::plan::watch::Watch;
use crate::product::Product;
use std::ops::Range;
use std::time::Instant;

/// Runs plans one after another. Recycled outcomes provide memory for the next ones, and stages keep what takes long to
/// prepare. No option changes a bit of the outcome.
#[derive(Debug, Default)]
pub(crate) struct Runner {
    pub(crate) options: RunOptions,
    pub(crate) memory: Memory,
    /// What stages prepared for earlier runs.
    pub(crate) caches: Caches,
}

/// What a run takes beside its plan and its frame.
#[derive(Clone, Copy, Default)]
pub(crate) struct RunInputs<'a> {
    /// What mirrors and lenses show.
    pub(crate) specular: Option<&'a SpecularScene>,
    /// What the previous frame of a sequence left.
    pub(crate) sequence: Option<SequenceInputs<'a>>,
    /// New light, and a texture of strokes.
    pub(crate) others: Lent<'a>,
}

/// Rows of a frame that is a strip of a picture.
#[derive(Clone)]
pub(crate) struct StripRows {
    /// Those that count, among the rows of the strip.
    pub(crate) rows: Range<usize>,
    /// The row of the picture that its first one is.
    pub(crate) top: usize,
    /// Width and height of the picture.
    pub(crate) whole: [usize; 2],
}

/// The context of a stage: inputs, results of earlier stages, and storage for its own.
pub(crate) struct Execution<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) frame: &'a Frame,
    /// The frame that this one is a part of, if it is.
    pub(crate) whole: Option<&'a Frame>,
    /// Its rows that count, where it is a strip of a picture of which something is chosen.
    pub(crate) strip: Option<StripRows>,
    pub(crate) inputs: RunInputs<'a>,
    pub(crate) runner: &'a Runner,
    /// The runner's planes, and whether this run has been cancelled.
    pub(crate) memory: &'a Memory,
    pub(crate) watch: Watch<'a>,
    /// The cache of earlier runs of this frame, if there is one.
    pub(crate) kept: Option<&'a mut FrameCache>,
    /// What the stages so far have made.
    pub(crate) made: Interim,
    /// Products of the shape that nothing reads after this stage.
    pub(crate) read_last: Vec<Product>,
    /// The normals, where the frame no longer has them: their memory is for what the only stage that reads them makes.
    pub(crate) normals: Option<Vector3Planes>,
    /// Their lengths, likewise.
    pub(crate) lengths: Option<Plane>,
}

/// What the stages so far have made.
#[derive(Default)]
pub(crate) struct Interim {
    pub(crate) outcome: Outcome,
    /// The gradient before diffusion.
    pub(crate) undiffused: Option<Vector2Planes>,
    /// The gradient at further scales.
    pub(crate) more_gradients: Vec<Vector2Planes>,
    /// The trace, where it is computed as the sum of curvatures that are themselves products.
    pub(crate) trace: Option<Plane>,
    /// What stages of one subject hand on.
    pub(crate) handed_on: Shelf,
}

impl<'a> Execution<'a> {
    pub(crate) fn new(
        runner: &'a Runner,
        plan: &'a Plan,
        frame: &'a Frame,
        inputs: RunInputs<'a>,
    ) -> Self {
        Self {
            plan,
            frame,
            whole: None,
            strip: None,
            inputs,
            runner,
            memory: &runner.memory,
            watch: Watch::default(),
            kept: None,
            made: Interim::default(),
            read_last: Vec::new(),
            normals: None,
            lengths: None,
        }
    }

    pub(crate) fn timed<T>(&mut self, name: &'static str, pass: impl FnOnce() -> T) -> T {
        self.timed_on(name, |_| pass())
    }

    /// Runs a pass over what has been made so far, and keeps its time under `name`.
    pub(crate) fn timed_on<T>(
        &mut self,
        name: &'static str,
        pass: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let (passed, planned) = (self.made.outcome.timings.len(), self.plan.stages().len());
        self.watch
            .begins(name, passed as f32 / planned.max(1) as f32);
        let start = Instant::now();
        let result = pass(self);
        self.made.outcome.timings.push((name, start.elapsed()));
        result
    }

    /// Takes products of the shape that an earlier run of the frame made under this key, if they are all there.
    pub(crate) fn has_kept(&mut self, products: &[Product], key: &str) -> bool {
        let Some(kept) = self.kept.as_deref_mut() else {
            return false;
        };
        let has = kept.has(products, key);
        if has {
            kept.take(products, &mut self.made.outcome.shape);
        }
        has
    }

    /// A copy of the result kept by this name under this key, or else the result of `pass`, of which a copy is then kept;
    /// without a key, that alone.
    pub(crate) fn copied_or<T: Clone + Send + 'static>(
        &mut self,
        name: &'static str,
        key: Option<&str>,
        pass: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let kept = self.kept.as_deref().zip(key);
        if let Some(copy) = kept.and_then(|(kept, key)| kept.copy(name, key)) {
            return copy;
        }
        let made = pass(self);
        if let Some((kept, key)) = self.kept_if_whole().zip(key) {
            kept.keep(name, key, made.clone());
        }
        made
    }

    /// The cache for the next run, unless this run was cancelled and its results are incomplete.
    pub(crate) fn kept_if_whole(&mut self) -> Option<&mut FrameCache> {
        let is_whole = !self.memory.is_cancelled();
        self.kept.as_deref_mut().filter(|_| is_whole)
    }

    /// The gain of the curvature mapping.
    pub(crate) fn gain(&self) -> f32 {
        match self.plan.scaling.curvature_gain {
            Adaptive::Fixed(gain) => gain,
            Adaptive::Auto => self
                .made
                .outcome
                .gain
                .expect("the gain is chosen before it is used"),
        }
    }
}
