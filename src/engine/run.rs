//! How a request is run: nothing here changes a sample of what is asked for.

use crate::error::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How far a run has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// The pass that begins, under its name in [`Outcome::timings`](crate::engine::outcome::Outcome::timings).
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

    /// Ends every run that has this token, as soon as the pass in hand is done.
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
    progress: Option<&'a (dyn Fn(Progress) + Sync)>,
    cancel: Option<&'a CancelToken>,
}

impl Watch<'_> {
    /// Says that a pass begins, when this share of the work is done.
    pub(crate) fn begins(&self, stage: &'static str, done: f32) {
        if let Some(tell) = self.progress {
            tell(Progress {
                stage,
                done: done.min(1.0),
            });
        }
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
    pub(crate) watch: Watch<'a>,
    warn: Option<&'a (dyn Fn(&str) + Sync)>,
}

impl<'a> Run<'a> {
    /// A run that says nothing, and goes to its end.
    pub fn new() -> Self {
        Self::default()
    }

    /// Tells how far the run has come, as each pass begins.
    #[must_use]
    pub fn progress(mut self, tell: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.watch.progress = Some(tell);
        self
    }

    /// Lets a token end the run with [`Error::Cancelled`].
    #[must_use]
    pub fn cancel(mut self, token: &'a CancelToken) -> Self {
        self.watch.cancel = Some(token);
        self
    }

    /// Tells in one line why a device does not do what the CPU then does. It may say so at every run.
    #[must_use]
    pub fn warn(mut self, tell: &'a (dyn Fn(&str) + Sync)) -> Self {
        self.warn = Some(tell);
        self
    }

    pub(crate) fn warning(&self, text: &str) {
        if let Some(tell) = self.warn {
            tell(text);
        }
    }
}
