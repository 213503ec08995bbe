//! Observers of a run.

use crate::error::{Error, Result};
use crate::kernel::cancel::CancelToken;
use std::sync::atomic::{AtomicU32, Ordering};

/// Progress of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The pass that begins, named as in [`Outcome::timings`](crate::engine::Outcome::timings); `device` when a device
    /// takes over, followed by each of its stages; `done` at the end.
    pub stage: &'static str,
    /// Approximate share of the work completed, 0..1.
    pub done: f32,
}

/// Observes a run: reports progress and may cancel it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Watch<'a> {
    /// The caller's function, and the largest share reported so far, as bits: non-negative floats order like their
    /// bits.
    pub(crate) progress: Option<(&'a Tell<'a>, &'a AtomicU32)>,
    /// The share of the work that came before these passes.
    pub(crate) before: f32,
    pub(crate) cancel: Option<&'a CancelToken>,
}

/// A caller's function for progress.
pub(crate) type Tell<'a> = dyn Fn(Progress) + Sync + 'a;

impl Watch<'_> {
    /// Reports that a pass begins, with the approximate share of work completed. In strips the stages report shares of
    /// a part, so the share never decreases.
    pub(crate) fn begins(&self, stage: &'static str, done: f32) {
        if let Some((tell, furthest)) = self.progress {
            let done = self.before + (1.0 - self.before) * done.clamp(0.0, 1.0);
            let done = done.to_bits();
            let done = furthest.fetch_max(done, Ordering::Relaxed).max(done);
            tell(Progress {
                stage,
                done: f32::from_bits(done),
            });
        }
    }

    /// Whether the run is observed: progress or cancellation.
    #[cfg(feature = "gpu")]
    pub(crate) fn looks_on(&self) -> bool {
        self.progress.is_some() || self.cancel.is_some()
    }

    /// The token that can cancel the run.
    pub(crate) fn token(&self) -> Option<&CancelToken> {
        self.cancel
    }

    /// # Errors
    /// [`Error::Cancelled`] if the run is cancelled.
    pub(crate) fn check(&self) -> Result<()> {
        match self.cancel.is_some_and(CancelToken::is_cancelled) {
            true => Err(Error::Cancelled),
            false => Ok(()),
        }
    }
}
