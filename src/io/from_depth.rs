//! What depth holds, where no normals tell.

use super::names::Hint;
use crate::frame::{Plane, StoredDepth};

/// Depth mapped to 0..1 may exceed 1 by this much.
const ABOVE_ONE: f32 = 1e-3;

/// The quantity that a layer of depth holds, and why: what its name or the renderer implies, else distances where they
/// exceed 1. From 0 to 1 white is taken for near, as estimators of depth write it, which is a guess and said to be.
pub(super) fn judged(
    depth: &Plane,
    (hint, by): (Hint, String),
    warnings: &mut Vec<String>,
) -> (StoredDepth, String) {
    let is_finite = |d: &&f32| d.is_finite() && d.abs() < 1e9;
    let range = depth.samples().iter().filter(is_finite);
    let is_unit = range.clone().all(|&d| (0.0..=1.0 + ABOVE_ONE).contains(&d));
    if let Some(stored) = hint.depth.filter(|_| !by.is_empty()) {
        return (stored, by);
    }
    if !is_unit {
        return (StoredDepth::Planar, "its values exceed 1".into());
    }
    warnings.push(
        "depth runs from 0 to 1, and nothing says which is near: white is taken for near, and bumps would be hollows if it \
         is not; compare with --depth-kind white-far, or z for distances"
            .into(),
    );
    let kind = StoredDepth::NormalizedNearIsOne;
    (kind, "from 0 to 1, as estimators write it".into())
}
