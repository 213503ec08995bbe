//! Options of a run: none of them changes a sample of the result.

use crate::engine::target::Target;
use crate::error::{Error, Result};
use crate::frame::{Frame, Window};
use crate::kernel::cancel::CancelToken;
use crate::plan::outcome::Outcome;
use crate::plan::watch::{Progress, Tell, Watch};
use crate::product::Product;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

/// The name of the pass that enlarges a frame.
pub(crate) const ENLARGE: &str = "enlarge";

/// The share of a drawing's run that enlarging its frame takes, about.
const ENLARGING: f32 = 0.25;

/// Options of a run.
#[derive(Default)]
pub struct Run<'a> {
    progress: Option<&'a Tell<'a>>,
    furthest: AtomicU32,
    /// The share of the work that is done before the passes begin, as bits.
    before: AtomicU32,
    cancel: Option<&'a CancelToken>,
    pub(crate) region: Option<Window>,
    pub(crate) max_memory: Option<u64>,
    warn: Option<&'a (dyn Fn(&str) + Sync)>,
    pool: Option<&'a ThreadPool>,
    targets: Mutex<Vec<(Product, Target<'a>)>>,
}

impl<'a> Run<'a> {
    /// A run without progress reports, cancellation or region.
    pub fn new() -> Self {
        Self::default()
    }

    /// Calls back as each pass begins.
    #[must_use]
    pub fn progress(mut self, tell: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = Some(tell);
        self
    }

    /// Lets a token cancel the run with [`Error::Cancelled`].
    #[must_use]
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Calls back with one line on what the CPU runs in place of a device. It may be called at every run.
    #[must_use]
    pub fn warn(mut self, tell: &'a (dyn Fn(&str) + Sync)) -> Self {
        self.warn = Some(tell);
        self
    }

    /// Restricts the run to these pixels of the frame, for a preview or a tile; a margin of the plan's reach is read
    /// around them. The outcome has the region's size. Automatic gains and white levels are chosen from the region; set
    /// them to get the samples of the whole frame. In new light, mirrors and lenses show the same as in the whole
    /// frame. A drawing is drawn anew for the region, alone or in a sequence: its strokes depend on the whole frame.
    #[must_use]
    pub fn region(mut self, region: Window) -> Self {
        self.region = Some(region);
        self
    }

    /// Lets the run take about so many bytes beside the frame and the result: a picture or layers that would take more are
    /// made in strips, with the samples of the whole; the outcome of a picture then lacks the shape. It takes several times
    /// as long where gain, white or albedo are chosen. Drawings, heights and skies that would take more are refused; regions
    /// and tiles are made whole.
    #[must_use]
    pub fn max_memory(mut self, bytes: u64) -> Self {
        self.max_memory = Some(bytes);
        self
    }

    /// Runs in this thread pool instead of the caller's.
    #[must_use]
    pub fn threads(mut self, pool: &'a ThreadPool) -> Self {
        self.pool = Some(pool);
        self
    }

    /// Also writes a product to the caller's memory, whose size is checked before the run. If the picture is unchanged,
    /// the frame's own is written.
    #[must_use]
    pub fn output(mut self, product: Product, target: impl Into<Target<'a>>) -> Self {
        let targets = self.targets.get_mut();
        let targets = targets.unwrap_or_else(PoisonError::into_inner);
        targets.push((product, target.into()));
        self
    }

    /// The observers of this run.
    pub(crate) fn watch(&self) -> Watch<'_> {
        Watch {
            progress: self.progress.map(|tell| (tell, &self.furthest)),
            before: f32::from_bits(self.before.load(Ordering::Relaxed)),
            cancel: self.cancel,
        }
    }

    /// [`Frame::enlarged`] as the first pass of this run, before those of a plan.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub fn enlarged(&self, frame: &Frame, factor: f64) -> Result<Frame> {
        self.before.store(0, Ordering::Relaxed);
        self.furthest.store(0, Ordering::Relaxed);
        let watch = self.watch();
        let tell = |done: f32| watch.begins(ENLARGE, ENLARGING * done);
        let goes_on = || watch.check().is_ok();
        let enlarged = self.install(|| frame.enlarged_while(factor, &goes_on, &tell));
        self.before.store(ENLARGING.to_bits(), Ordering::Relaxed);
        enlarged.ok_or(Error::Cancelled)
    }

    /// Begins a run of a picture of this size: checks that the caller's memory fits it.
    ///
    /// # Errors
    /// As [`Target::check`].
    pub(crate) fn begin(&self, size: [usize; 2]) -> Result<()> {
        let before = self.before.load(Ordering::Relaxed);
        self.furthest.store(before, Ordering::Relaxed);
        let targets = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        let mut targets = targets.iter();
        targets.try_for_each(|(product, target)| target.check(*product, size))
    }

    /// Calls `work` in the thread pool of the run.
    pub(crate) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Ends a run: writes products to the caller's memory.
    ///
    /// # Errors
    /// As [`Target::write`].
    pub(crate) fn finish(&self, frame: &Frame, outcome: &Outcome) -> Result<()> {
        let mut targets = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        for (product, target) in targets.iter_mut() {
            let mut planes = outcome.planes(*product);
            if let (Product::Picture, true, Some(color)) =
                (*product, planes.is_empty(), &frame.color)
            {
                planes = vec![&color.r, &color.g, &color.b];
            }
            target.write(*product, &planes)?;
        }
        self.watch().begins("done", 1.0);
        Ok(())
    }

    #[cfg_attr(
        not(feature = "gpu"),
        expect(dead_code, reason = "without devices there is nothing to warn of")
    )]
    pub(crate) fn warning(&self, text: &str) {
        if let Some(tell) = self.warn {
            tell(text);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Engine, PlanInputs};
    use crate::params::{ScalingParams, ShapeParams};
    use crate::plan::watch::Progress;
    use crate::plan::{Available, Goal, Plan};
    use crate::scenes::Scene;

    #[test]
    fn enlarging_is_the_first_quarter_of_a_run() {
        let (frame, said) = (Scene::waves(30, 20).frame, Mutex::new(Vec::new()));
        let tell = |at: Progress| said.lock().unwrap().push((at.stage, at.done));
        let run = Run::new().progress(&tell);
        let large = run.enlarged(&frame, 2.0).unwrap();
        assert_eq!(large.normal, frame.enlarged(2.0).normal);
        let (shape, scaling) = (ShapeParams::default(), ScalingParams::default());
        let plan = Plan::new(Goal::LAYERS, Available::in_frame(&large), shape, scaling).unwrap();
        let engine = Engine::cpu();
        engine
            .execute(&plan, &large, PlanInputs::default(), &run)
            .unwrap();
        let said = said.into_inner().unwrap();
        assert!(said.is_sorted_by(|a, b| a.1 <= b.1), "{said:?}");
        let passes = said.iter().filter(|at| at.0 == ENLARGE).count();
        let (enlarging, rest) = said.split_at(passes);
        // The mask, depth, and three planes of normals, twice: as they are, and beside jumps.
        assert_eq!(passes, 1 + 1 + 2 * 3);
        assert!(
            enlarging
                .iter()
                .all(|at| at.0 == ENLARGE && at.1 < ENLARGING)
        );
        assert!(rest.iter().all(|at| at.1 >= ENLARGING));
        assert_eq!(rest.last(), Some(&("done", 1.0)));
    }

    #[test]
    fn enlarging_ends_where_its_run_is_cancelled() {
        let (frame, token) = (Scene::waves(30, 20).frame, CancelToken::new());
        let begun = AtomicU32::new(0);
        let tell = |_: Progress| {
            if begun.fetch_add(1, Ordering::Relaxed) == 1 {
                token.cancel();
            }
        };
        let run = Run::new().progress(&tell).cancel(&token);
        assert!(matches!(run.enlarged(&frame, 3.0), Err(Error::Cancelled)));
    }
}
