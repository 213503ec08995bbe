//! Counting pixels that a display shows as plain white.

use super::codes::straight;
use super::display::{Bright, WHITE, largest};
use super::format::Picture;
use crate::frame::{ColorPlanes, Mask};
use crate::io::photo::max_code;
use rayon::prelude::*;
use std::ops::Range;

/// Numbers of surface pixels that are white in some channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Whites {
    /// White in the picture.
    pub(crate) count: usize,
    /// White in the picture before the change, if there is one.
    pub(crate) before: usize,
    /// All surface pixels.
    pub(crate) of: usize,
}

impl Whites {
    /// Counts these rows of a picture for a display, where `mask` has a surface.
    pub(crate) fn of(picture: &Picture, mask: &Mask, rows: Range<usize>) -> Self {
        let Picture {
            color,
            alpha,
            display,
            ..
        } = picture;
        let before = match display.bright {
            Bright::ChangedFrom(before) => Some(before),
            _ => None,
        };
        let shown = display.shown();
        let gain = display.exposure.exp2();
        let of_row = |y: usize| {
            let mut whites = Self::default();
            for x in mask.runs(y).flatten() {
                let alpha = alpha.map(|alpha| f64::from(alpha.at(x, y)));
                // A colour whose largest channel is no brighter than white is not made white.
                let least = WHITE as f32 * alpha.map_or(1.0, |alpha| alpha as f32);
                let may_be_white =
                    |color: [f32; 3]| gain * color.into_iter().fold(0.0, f32::max) >= least;
                let straight = |color| straight(color, alpha, max_code(8)).0;
                let is_white = |color: [f64; 3]| usize::from(largest(color) >= WHITE);
                let of = |color: &ColorPlanes| color.at(x, y);
                whites.of += 1;
                if may_be_white(of(color)) {
                    let color = straight(of(color).map(f64::from));
                    whites.count +=
                        is_white(shown.map_or(color, |shown| shown.pixel(color, [x, y], straight)));
                }
                if let Some(before) = before.map(of).filter(|&before| may_be_white(before)) {
                    let before = straight(before.map(f64::from));
                    whites.before += is_white(before.map(|v| f64::from(gain) * v));
                }
            }
            whites
        };
        rows.into_par_iter()
            .map(of_row)
            .reduce(Self::default, Self::with)
    }

    /// Both together.
    pub(crate) fn with(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            before: self.before + other.before,
            of: self.of + other.of,
        }
    }
}
