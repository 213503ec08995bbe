//! The gain of the curvature mapping, found a strip at a time.

use super::cpu::{curved, gain_of};
use super::{CURVATURE_PERCENT, flat_curvature};
use crate::engine::cpu::percentile::PercentileSearch;
use crate::frame::{Mask, Plane};
use std::ops::Range;

/// A search for the gain in a picture that comes some rows at a time.
#[derive(Debug, Clone)]
pub(crate) struct GainSearch {
    pub(crate) search: PercentileSearch,
    flat: f32,
    most: f32,
}

impl GainSearch {
    /// For a picture of this size, a trace of `factor` times its value per pixel, and a gain of at most `most`.
    pub(crate) fn new(size: [usize; 2], factor: f32, most: f32) -> Self {
        Self {
            search: PercentileSearch::new(CURVATURE_PERCENT),
            flat: flat_curvature(size, factor),
            most,
        }
    }

    /// As [`PercentileSearch::add`].
    pub(crate) fn add(
        &mut self,
        mask: &Mask,
        rows: Range<usize>,
        top: usize,
        [trace, conductance]: [&Plane; 2],
    ) {
        let flat = self.flat;
        let curved = |x, y| curved(trace, conductance, flat, [x, y]);
        self.search.add(mask, rows, top, curved);
    }

    pub(crate) fn gain(self) -> f32 {
        gain_of(self.search.found(), self.most)
    }
}
