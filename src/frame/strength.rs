//! The strength of the effect in each pixel.

use super::Plane;
use super::coverage::shares;

/// Strength of the effect, 0..1: the share that the chosen objects cover times the mask; `None` without either. NaN
/// changes nothing.
pub(crate) fn strength_of(mask: Option<Plane>, objects: Option<Plane>) -> Option<Plane> {
    match (mask.map(shares), objects.map(shares)) {
        (Some(mut mask), Some(objects)) => {
            mask.each_with(&objects, |share, object| *share *= object);
            Some(mask)
        }
        (mask, objects) => mask.or(objects),
    }
}
