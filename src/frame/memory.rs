//! Recycled planes of finished runs: fresh memory is mapped page by page, which costs more than many passes.

use crate::frame::{Mask, Plane, Vector2Planes};
use crate::kernel::cancel::CancelToken;
use std::sync::{Arc, Mutex, PoisonError};

/// Planes for reuse, and the cancellation state of the run that uses them.
///
/// Long loops check it once per row, tile or line, and when cancelled return at once, leaving undefined samples. Nobody
/// sees these: the run checks its token after each stage, and discards a stage that was cancelled.
#[derive(Debug, Clone, Default)]
pub(crate) struct Memory {
    spare: Arc<Mutex<Vec<Vec<f32>>>>,
    cancel: Option<CancelToken>,
}

impl Memory {
    /// The same planes for a run that `cancel` can end.
    pub(crate) fn for_run(&self, cancel: Option<&CancelToken>) -> Self {
        Self {
            spare: self.spare.clone(),
            cancel: cancel.cloned(),
        }
    }

    /// An empty pool, for a part of the run at another size.
    pub(crate) fn at_other_size(&self) -> Self {
        Self {
            spare: Arc::default(),
            cancel: self.cancel.clone(),
        }
    }

    /// The token that can end the run.
    pub(crate) fn cancel(&self) -> Option<&CancelToken> {
        self.cancel.as_ref()
    }

    /// Whether the run has been cancelled. It never returns to false.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(CancelToken::is_cancelled)
    }

    /// A plane of the size of `mask`, 0 outside it. Samples inside are undefined until written.
    pub(crate) fn plane(&self, mask: &Mask) -> Plane {
        let (mut plane, is_zero) = self.any_plane(mask);
        if !is_zero && mask.count() < plane.samples().len() {
            plane.each_row(|y, row| mask.gaps(y).for_each(|gap| row[gap].fill(0.0)));
        }
        plane
    }

    /// A plane of the size of `mask`. All samples are undefined until written.
    pub(crate) fn unwritten(&self, mask: &Mask) -> Plane {
        self.any_plane(mask).0
    }

    /// A plane of the size of `mask`, and whether it is 0 everywhere: else all samples are undefined until written.
    pub(crate) fn any_plane(&self, mask: &Mask) -> (Plane, bool) {
        let (width, height) = (mask.width(), mask.height());
        match self.spare_of(width * height) {
            Some(samples) => (Plane::from_samples(width, height, samples), false),
            None => (Plane::filled(width, height, 0.0), true),
        }
    }

    /// Two planes as from [`Memory::plane`].
    pub(crate) fn vectors(&self, mask: &Mask) -> Vector2Planes {
        Vector2Planes {
            x: self.plane(mask),
            y: self.plane(mask),
        }
    }

    fn spare_of(&self, samples: usize) -> Option<Vec<f32>> {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        // Planes of another size are unlikely to be needed soon.
        spare.retain(|plane| plane.len() == samples);
        spare.pop()
    }

    /// Frees the planes kept for reuse.
    pub(crate) fn release(&self) {
        self.spare
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clear();
    }

    /// Reclaims planes whose samples are no longer needed.
    pub(crate) fn recycle(&self, planes: impl IntoIterator<Item = Plane>) {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        spare.extend(planes.into_iter().map(Plane::into_samples));
    }
}
