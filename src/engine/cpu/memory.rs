//! Recycled planes of finished runs: fresh memory comes page by page from the system, which costs more than many a pass
//! over it.

use crate::engine::watch::CancelToken;
use crate::frame::{Mask, Plane, Vector2Planes};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Planes to be used again, and whether the run that works in them has been cancelled.
///
/// Long loops ask that once a row, a tile or a line: where it is so they leave the rest undone, and the pass returns at
/// once with samples of no meaning. Nobody sees these: the run looks at its token after each stage, and keeps nothing of
/// a stage that was cancelled.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    spare: Arc<Mutex<Vec<Vec<f32>>>>,
    cancel: Option<CancelToken>,
}

impl Memory {
    /// The same planes for a run that this token ends.
    pub(crate) fn for_run(&self, cancel: Option<&CancelToken>) -> Self {
        Self {
            spare: self.spare.clone(),
            cancel: cancel.cloned(),
        }
    }

    /// No planes yet, for a part of the run that works at another size.
    pub(crate) fn at_other_size(&self) -> Self {
        Self {
            spare: Arc::default(),
            cancel: self.cancel.clone(),
        }
    }

    /// What may end the run.
    pub(crate) fn cancel(&self) -> Option<&CancelToken> {
        self.cancel.as_ref()
    }

    /// Whether the run has been cancelled. Once it has, it stays so.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(CancelToken::is_cancelled)
    }

    /// A plane of the size of `mask`, 0 where uncovered. Where covered its samples are of no meaning, and
    /// have to be written.
    pub(crate) fn plane(&self, mask: &Mask) -> Plane {
        let (width, height) = (mask.width(), mask.height());
        let Some(mut samples) = self.spare_of(width * height) else {
            return Plane::filled(width, height, 0.0);
        };
        if mask.count() < samples.len() {
            samples
                .par_chunks_mut(1 << 16)
                .for_each(|part| part.fill(0.0));
        }
        Plane::from_samples(width, height, samples)
    }

    /// A plane of the size of `mask` whose samples are of no meaning, and all have to be written.
    pub(crate) fn unwritten(&self, mask: &Mask) -> Plane {
        let (width, height) = (mask.width(), mask.height());
        match self.spare_of(width * height) {
            Some(samples) => Plane::from_samples(width, height, samples),
            None => Plane::filled(width, height, 0.0),
        }
    }

    /// Two planes as [`Memory::plane`] gives them.
    pub(crate) fn vectors(&self, mask: &Mask) -> Vector2Planes {
        Vector2Planes {
            x: self.plane(mask),
            y: self.plane(mask),
        }
    }

    fn spare_of(&self, samples: usize) -> Option<Vec<f32>> {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        // Planes of another size will not be asked for again soon.
        spare.retain(|plane| plane.len() == samples);
        spare.pop()
    }

    /// Takes planes whose samples are no longer needed.
    pub(crate) fn recycle(&self, planes: impl IntoIterator<Item = Plane>) {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        spare.extend(planes.into_iter().map(Plane::into_samples));
    }
}
