//! Observers of a run: progress, and the token that ends it.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Progress of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The pass that begins, named as in [`Outcome::timings`](crate::engine::Outcome::timings); `device` where a device takes over, and then each of its
    /// stages; `done` at the end.
    pub stage: &'static str,
    /// Approximate share of the work that is done, 0..1.
    pub done: f32,
}

/// Cancels runs from another thread. Clones share one state.
#[derive(Debug, Clone, Default)]
pub struct CancelToken(Arc<AtomicBool>);

impl CancelToken {
    /// A token that is not cancelled.
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

/// Watches a run: reports progress and may end it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Watch<'a> {
    /// The caller's function, and the largest share reported so far, as bits: shares from 0 on have their order.
    pub(super) progress: Option<(&'a Tell<'a>, &'a AtomicU32)>,
    pub(super) cancel: Option<&'a CancelToken>,
}

/// A caller's function for progress.
pub(super) type Tell<'a> = dyn Fn(Progress) + Sync + 'a;

impl Watch<'_> {
    /// Reports that a pass begins when about this share of the work is done. A run in strips that then goes on reports
    /// shares of a part: none is less than the one before.
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

    /// Whether anybody watches progress, or may end the run.
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
