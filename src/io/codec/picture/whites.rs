//! Counting pixels that a display shows as plain white.

use super::display::WHITE;
use super::format::Picture;
use super::straight::{largest, rows_of, straight};
use crate::frame::{ColorPlanes, MOST_ROWS_PER_TASK, Mask};
use crate::io::photo::max_code;
use rayon::prelude::*;
use std::ops::Range;

/// Numbers of surface pixels that are white in some channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Whites {
    /// White in the picture.
    pub(crate) count: usize,
    /// White in the picture before the change and its exposure, if there is one.
    pub(crate) before: usize,
    /// All surface pixels.
    pub(crate) of: usize,
    /// Compressed, so that they stay below white, where these are counted.
    pub(crate) compressed: Option<usize>,
}

impl Picture<'_> {
    /// The number of pixels in these rows that are compressed, so that they stay below white, where `mask` has a surface.
    pub(crate) fn compressed(&self, mask: &Mask, rows: Range<usize>) -> usize {
        let mapping = self.display.mapping();
        let count = |y: usize| {
            let is_compressed = |&x: &usize| {
                let alpha = self.alpha.map_or(1.0, |alpha| f64::from(alpha.at(x, y)));
                let of = |color: &ColorPlanes| color.at(x, y).map(|v| f64::from(v) / alpha);
                mapping.compresses(of(self.color), of)
            };
            mask.runs(y).flatten().filter(is_compressed).count()
        };
        rows.into_par_iter().map(count).sum()
    }
}

impl Whites {
    /// Counts these rows of a picture for a display, where `mask` has a surface, and of the picture `before` as it would
    /// be shown without any change.
    pub(crate) fn of(
        picture: &Picture,
        before: Option<&ColorPlanes>,
        mask: &Mask,
        rows: Range<usize>,
    ) -> Self {
        let mapping = picture.display.mapping();
        let is_white = |color: [f64; 3]| usize::from(largest(color) >= WHITE);
        let of_row = |y: usize| {
            let (mut whites, alphas) = (Self::default(), picture.alpha.map(|plane| plane.row(y)));
            for x in mask.runs(y).flatten() {
                let of =
                    |color: &ColorPlanes| straight(rows_of(color, y), alphas, x, max_code(8)).0;
                whites.of += 1;
                whites.count += is_white(mapping.shown(of(picture.color), of));
                whites.before += before.map_or(0, |before| is_white(of(before)));
            }
            whites
        };
        rows.into_par_iter()
            .with_max_len(MOST_ROWS_PER_TASK)
            .map(of_row)
            .reduce(Self::default, Self::with)
    }

    /// Both together.
    pub(crate) fn with(self, other: Self) -> Self {
        let sum = |own| own + other.compressed.unwrap_or(0);
        Self {
            count: self.count + other.count,
            before: self.before + other.before,
            of: self.of + other.of,
            compressed: self.compressed.map(sum).or(other.compressed),
        }
    }
}
