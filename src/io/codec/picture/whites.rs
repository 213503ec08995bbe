//! Counting pixels that a display shows as plain white.

use super::display::WHITE;
use super::format::Picture;
use super::group::{Colors, GROUP, color_at, largest, straight};
use crate::frame::{ColorPlanes, MOST_ROWS_PER_TASK, Mask};
use crate::io::photo::max_code;
use rayon::prelude::*;
use std::ops::Range;

/// A little less than [`WHITE`]: rounding to single precision misses nothing white.
const LEAST: f32 = (0.9999 * WHITE) as f32;

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
        let Picture {
            color,
            alpha,
            display,
            ..
        } = picture;
        let shown = display.shown();
        let gain = display.exposure.exp2().max(1.0);
        let count_in = |y: usize, columns: Range<usize>| {
            let of = |ColorPlanes { r, g, b }: &ColorPlanes| {
                straight([r, g, b], *alpha, y, columns.clone(), max_code(8)).0
            };
            let white_in = |colors: &Colors| {
                let brightest = (0..columns.len()).map(|x| largest(color_at(colors, x)));
                brightest.filter(|&v| v >= WHITE).count()
            };
            let after = of(color);
            let after = shown.map_or(after, |shown| shown.group(&after, of));
            Self {
                count: white_in(&after),
                before: before.map_or(0, |before| white_in(&of(before))),
                ..Self::default()
            }
        };
        // A colour whose largest channel is no brighter than white is not made white.
        let planes = [Some(*color), before].into_iter().flatten();
        let planes: Vec<_> = planes
            .flat_map(|ColorPlanes { r, g, b }| [r, g, b])
            .collect();
        let may_be_white = |y: usize, columns: Range<usize>| {
            let alpha = alpha.map(|alpha| &alpha.row(y)[columns.clone()]);
            let rows = planes.iter().map(|plane| &plane.row(y)[columns.clone()]);
            // Without a branch, so that the compiler takes many at a time.
            let is_bright = |row: &[f32]| match alpha {
                None => row.iter().fold(false, |any, &v| any | (gain * v >= LEAST)),
                Some(alpha) => row.iter().zip(alpha).fold(false, |any, (&v, &alpha)| {
                    any | (gain * v >= LEAST * alpha) | (alpha <= 0.0)
                }),
            };
            rows.into_iter().any(is_bright)
        };
        let of_row = |y: usize| {
            let mut whites = Self::default();
            for run in mask.runs(y) {
                whites.of += run.len();
                for start in run.clone().step_by(GROUP) {
                    let group = start..run.end.min(start + GROUP);
                    if may_be_white(y, group.clone()) {
                        whites = whites.with(count_in(y, group));
                    }
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
        Self {
            count: self.count + other.count,
            before: self.before + other.before,
            of: self.of + other.of,
            compressed: self.compressed.or(other.compressed).map(|_| {
                [self, other]
                    .iter()
                    .filter_map(|whites| whites.compressed)
                    .sum()
            }),
        }
    }
}
