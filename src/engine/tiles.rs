//! Pictures in strips, where memory limits the number of rows at a time.

use crate::frame::Window;
use std::ops::Range;

/// Division of a picture into strips.
#[derive(Clone, Copy)]
pub(crate) struct Strips {
    height: usize,
    /// Output rows of a strip, and its margin above and below.
    rows: usize,
    reach: usize,
}

impl Strips {
    /// Strips of `rows` output rows with a margin of `reach` rows above and below.
    pub(crate) fn of_rows(rows: usize, height: usize, reach: usize) -> Self {
        Self {
            height,
            rows: rows.max(1),
            reach,
        }
    }

    /// Strips of at most `most_rows` rows, margins of `reach` included; `None` if that leaves no output row. One strip
    /// if the whole picture fits.
    pub(crate) fn new(reach: usize, height: usize, most_rows: usize) -> Option<Self> {
        if most_rows >= height {
            return Some(Self::of_rows(height, height, 0));
        }
        let rows = most_rows.checked_sub(2 * reach).filter(|&rows| rows > 0)?;
        Some(Self::of_rows(rows, height, reach))
    }

    /// Number of strips.
    #[cfg(feature = "cli")]
    pub(crate) fn count(&self) -> usize {
        self.height.div_ceil(self.rows)
    }

    /// For each strip its rows in the picture, and the output rows among them.
    pub(crate) fn each(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        (0..self.height).step_by(self.rows).map(|start| {
            let end = (start + self.rows).min(self.height);
            let takes = start.saturating_sub(self.reach)..(end + self.reach).min(self.height);
            let gives = start - takes.start..end - takes.start;
            (takes, gives)
        })
    }
}

/// The given rows of a window.
pub(crate) fn rows_of(whole: Window, rows: &Range<usize>) -> Window {
    Window {
        y0: whole.y0 + rows.start as i32,
        y1: whole.y0 + rows.end as i32,
        ..whole
    }
}
