//! The strength of the effect in each pixel.

use super::Plane;
use super::coverage::shares;

/// Strength of the effect, 0..1: the share that the chosen objects cover times the mask; `None` without either. NaN
/// changes nothing.
pub(crate) fn strength_of(mask: Option<Plane>, objects: Option<Plane>) -> Option<Plane> {
    match (mask.map(shares), objects.map(shares)) {
        (Some(mut mask), Some(objects)) => {
            let samples = mask.samples_mut().iter_mut().zip(objects.samples());
            samples.for_each(|(share, object)| *share *= object);
            Some(mask)
        }
        (mask, objects) => mask.or(objects),
    }
}
