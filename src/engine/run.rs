//! How a request is run: nothing here changes a sample of what is asked for.

use crate::engine::outcome::Outcome;
use crate::engine::target::Target;
use crate::error::{Error, Result};
use crate::frame::{Frame, Window};
use crate::product::Product;
use rayon::ThreadPool;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The pass that begins, under its name in [`Outcome::timings`]; `device` where a device takes over, and then each of
    /// its stages; `done` at the end.
    pub stage: &'static str,
    /// About how much of the work is done, 0..1.
    pub done: f32,
}

/// Ends runs from another thread. Clones are the same token.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that cancels nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Ends every run that has this token: long passes stop within a few rows, short ones end first.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it was cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What looks on as a plan is run, and may end it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Watch<'a> {
    /// Who is told, and how far the run had come at the most, as bits: a share from 0 on is in the order of these.
    progress: Option<(&'a Tell<'a>, &'a AtomicU32)>,
    cancel: Option<&'a CancelToken>,
}

/// Is told how far a run has come.
type Tell<'a> = dyn Fn(Progress) + Sync + 'a;

impl Watch<'_> {
    /// Says that a pass begins, when about this share of the work is done. Where a run comes in strips and then goes on, its
    /// shares are those of a part: nobody is told of less than before.
    pub(crate) fn begins(&self, stage: &'static str, done: f32) {
        if let Some((tell, furthest)) = self.progress {
            let done = done.clamp(0.0, 1.0).to_bits();
            let done = furthest.fetch_max(done, Ordering::Relaxed).max(done);
            tell(Progress {
                stage,
                done: f32::from_bits(done),
            });
        }
    }

    /// Whether anybody is told of progress, or may end the run.
    #[cfg(feature = "gpu")]
    pub(crate) fn looks_on(&self) -> bool {
        self.progress.is_some() || self.cancel.is_some()
    }

    /// What may end the run.
    pub(crate) fn token(&self) -> Option<&CancelToken> {
        self.cancel
    }

    /// # Errors
    /// [`Error::Cancelled`] where the run is to end here.
    pub(crate) fn check(&self) -> Result<()> {
        match self.cancel.is_some_and(CancelToken::is_cancelled) {
            true => Err(Error::Cancelled),
            false => Ok(()),
        }
    }
}

/// How a request is run.
#[derive(Default)]
pub struct Run<'a> {
    progress: Option<&'a Tell<'a>>,
    furthest: AtomicU32,
    cancel: Option<&'a CancelToken>,
    pub(crate) region: Option<Window>,
    warn: Option<&'a (dyn Fn(&str) + Sync)>,
    pool: Option<&'a ThreadPool>,
    targets: Mutex<Vec<(Product, Target<'a>)>>,
}

impl<'a> Run<'a> {
    /// A run that says nothing, and goes to its end.
    pub fn new() -> Self {
        Self::default()
    }

    /// Tells how far the run has come, as each pass begins.
    #[must_use]
    pub fn progress(mut self, tell: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = Some(tell);
        self
    }

    /// Lets a token end the run with [`Error::Cancelled`].
    #[must_use]
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.cancel = Some(token);
        self
    }

    /// Tells in one line why a device does not do what the CPU then does. It may say so at every run.
    #[must_use]
    pub fn warn(mut self, tell: &'a (dyn Fn(&str) + Sync)) -> Self {
        self.warn = Some(tell);
        self
    }

    /// Runs on these pixels of the frame and as many around them as the plan reaches: a preview, or a tile. The outcome has
    /// the region's size. Gains and white levels that are chosen from the frame are chosen from this part of it; give them
    /// to have the samples of the whole. Mirrors and lenses in new light show there what they show in the whole. A drawing
    /// is that of this part, alone or in a sequence: its strokes depend on all of a frame, and no part has those of the
    /// whole.
    #[must_use]
    pub fn region(mut self, region: Window) -> Self {
        self.region = Some(region);
        self
    }

    /// Runs in this pool of threads; else in that of the caller.
    #[must_use]
    pub fn threads(mut self, pool: &'a ThreadPool) -> Self {
        self.pool = Some(pool);
        self
    }

    /// Writes a product to memory of the caller as well, whose size is looked at before anything is done. A picture in which
    /// there is nothing to change is that of the frame.
    #[must_use]
    pub fn output(mut self, product: Product, target: impl Into<Target<'a>>) -> Self {
        let targets = self.targets.get_mut();
        let targets = targets.unwrap_or_else(PoisonError::into_inner);
        targets.push((product, target.into()));
        self
    }

    /// What looks on as it is run.
    pub(crate) fn watch(&self) -> Watch<'_> {
        Watch {
            progress: self.progress.map(|tell| (tell, &self.furthest)),
            cancel: self.cancel,
        }
    }

    /// Begins a run of a picture of this size: looks whether the caller's memory takes it.
    ///
    /// # Errors
    /// As [`Target::check`].
    pub(crate) fn begin(&self, size: [usize; 2]) -> Result<()> {
        self.furthest.store(0, Ordering::Relaxed);
        let targets = self.targets.lock().unwrap_or_else(PoisonError::into_inner);
        let mut targets = targets.iter();
        targets.try_for_each(|(product, target)| target.check(*product, size))
    }

    /// Does `work` where the run is to be done.
    pub(crate) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Ends a run: writes what goes to memory of the caller.
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
