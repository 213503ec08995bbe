//! The gain of the curvature mapping, found a strip at a time.

use super::cpu::Counted;
use super::{flat_curvature, gain_of};
use crate::frame::percentile::Sample;
use crate::frame::{Frame, Plane};
use std::ops::Range;

/// A search for the gain in a picture that comes some rows at a time.
#[derive(Debug, Clone)]
pub(crate) struct GainSearch {
    pub(crate) sample: Sample<[f32; 2]>,
    flat: f32,
    most: f32,
}

impl GainSearch {
    /// For a picture of this size, a trace of `factor` times its value per pixel, and a gain of at most `most`.
    pub(crate) fn new(size: [usize; 2], factor: f32, most: f32) -> Self {
        Self {
            sample: Sample::default(),
            flat: flat_curvature(size, factor),
            most,
        }
    }

    /// As [`Sample::add`].
    pub(crate) fn add(
        &mut self,
        strip: &Frame,
        rows: Range<usize>,
        top: usize,
        curvature: [&Plane; 2],
    ) {
        let (counted, flat) = (Counted::of(strip, curvature), self.flat);
        let curved = |x, y| counted.at(flat, [x, y]);
        self.sample.add(&strip.mask, rows, top, curved);
    }

    pub(crate) fn gain(self) -> f32 {
        gain_of(&self.sample.values(), self.most)
    }
}
