//! Recycled planes of finished runs: fresh memory comes page by page from the system, which costs more than many a pass
//! over it.

use crate::frame::{Mask, Plane, Vector2Planes};
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Planes to be used again.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    spare: Mutex<Vec<Vec<f32>>>,
}

impl Memory {
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
