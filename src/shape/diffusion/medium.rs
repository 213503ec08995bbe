//! The medium of diffusion.

use crate::frame::{Mask, Plane};
use crate::shape::diffusion::importance::ImportanceLevels;

/// What slopes spread through.
#[derive(Clone, Copy)]
pub(crate) struct Medium<'a> {
    pub(crate) conductance: &'a Plane,
    pub(crate) mask: &'a Mask,
    pub(crate) importance: Option<&'a ImportanceLevels>,
    /// Whether left and right borders are joined, and upper and lower ones; nothing passes through the others.
    pub(crate) wraps: [bool; 2],
}

impl<'a> Medium<'a> {
    /// A medium equally important everywhere, which nothing leaves.
    pub(crate) fn of_whole(conductance: &'a Plane, mask: &'a Mask) -> Self {
        Self {
            conductance,
            mask,
            importance: None,
            wraps: [false; 2],
        }
    }
}
