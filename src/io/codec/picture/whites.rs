//! Counting pixels that a display shows as plain white.

use super::display::WHITE;
use super::format::Picture;
use super::group::{Colors, GROUP, color_at, largest, straight};
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
        let Some(shown) = self.display.shown() else {
            return 0;
        };
        let count = |y: usize| {
            let is_compressed = |&x: &usize| {
                let alpha = self.alpha.map_or(1.0, |alpha| f64::from(alpha.at(x, y)));
                let of = |color: &ColorPlanes| color.at(x, y).map(|v| f64::from(v) / alpha);
                shown.compresses(of(self.color), of)
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
        let shown = picture.display.shown();
        let count_in = |y: usize, columns: Range<usize>| {
            let of = |ColorPlanes { r, g, b }: &ColorPlanes| {
                straight([r, g, b], picture.alpha, y, columns.clone(), max_code(8)).0
            };
            let white_in = |colors: &Colors| {
                let brightest = (0..columns.len()).map(|x| largest(color_at(colors, x)));
                brightest.filter(|&v| v >= WHITE).count()
            };
            let after = of(picture.color);
            let after = shown.map_or(after, |shown| shown.group(&after, of));
            Self {
                count: white_in(&after),
                before: before.map_or(0, |before| white_in(&of(before))),
                ..Self::default()
            }
        };
        let of_row = |y: usize| {
            let mut whites = Self::default();
            for run in mask.runs(y) {
                whites.of += run.len();
                for start in run.clone().step_by(GROUP) {
                    let group = start..run.end.min(start + GROUP);
                    whites = whites.with(count_in(y, group));
                }
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
