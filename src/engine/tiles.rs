//! Pictures in strips, where memory or a device limits the number of rows at a time.

use crate::engine::outcome::{Outcome, add_timings};
use crate::engine::watch::Watch;
use crate::error::Result;
use crate::frame::{Frame, Plane, Window};
use std::ops::Range;

/// Division of a picture into strips.
#[derive(Clone, Copy)]
pub(crate) struct Strips<'a> {
    watch: Watch<'a>,
    height: usize,
    /// Output rows of a strip, and its margin above and below.
    rows: usize,
    reach: usize,
}

impl<'a> Strips<'a> {
    /// Strips of `rows` output rows with a margin of `reach` rows above and below.
    pub(crate) fn of_rows(rows: usize, height: usize, reach: usize) -> Self {
        Self {
            watch: Watch::default(),
            height,
            rows: rows.max(1),
            reach,
        }
    }

    /// Strips of at most `most_rows` rows, margins of `reach` included; `None` if that leaves no output row. One strip
    /// if the whole picture fits.
    #[cfg(any(feature = "cli", feature = "gpu"))]
    pub(crate) fn new(reach: usize, height: usize, most_rows: usize) -> Option<Self> {
        if most_rows >= height {
            return Some(Self::of_rows(height, height, 0));
        }
        let rows = most_rows.checked_sub(2 * reach).filter(|&rows| rows > 0)?;
        Some(Self::of_rows(rows, height, reach))
    }

    /// The same strips, with `watch` checked before each.
    #[cfg(feature = "gpu")]
    pub(crate) fn watched(&self, watch: Watch<'a>) -> Self {
        Self { watch, ..*self }
    }

    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled) if the run is cancelled.
    #[cfg(feature = "gpu")]
    pub(crate) fn check(&self) -> Result<()> {
        self.watch.check()
    }

    /// Calls `run` for every strip of a frame, with its rows, and assembles the results. Planes of strips are passed to
    /// `recycle`.
    ///
    /// # Errors
    /// Those of `run`; [`Error::Cancelled`](crate::Error::Cancelled).
    pub(crate) fn run(
        &self,
        frame: &Frame,
        mut run: impl FnMut(&Frame, &Range<usize>) -> Result<Outcome>,
        mut recycle: impl FnMut(Vec<Plane>),
    ) -> Result<Outcome> {
        let mut whole: Option<Outcome> = None;
        for (takes, gives) in self.each() {
            self.watch.check()?;
            let mut part = run(&strip_of(frame, &takes), &takes)?;
            let start = takes.start + gives.start;
            match &mut whole {
                None => {
                    let mut strips = Vec::new();
                    part.for_each_plane(|plane| {
                        let size = (frame.mask.width(), frame.mask.height());
                        let all = Plane::filled(size.0, size.1, 0.0);
                        let strip = std::mem::replace(plane, all);
                        paste(&strip, &gives, plane, start);
                        strips.push(strip);
                    });
                    recycle(strips);
                    whole = Some(part);
                }
                Some(whole) => {
                    whole.for_each_pair(&part, |whole, strip| paste(strip, &gives, whole, start));
                    add_timings(&mut whole.timings, &part.timings);
                    recycle(part.into_planes());
                }
            }
        }
        Ok(whole.unwrap_or_default())
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

/// The given rows of a frame, as a frame.
pub(crate) fn strip_of(frame: &Frame, rows: &Range<usize>) -> Frame {
    frame.crop(rows_of(frame.data_window, rows))
}

/// The given rows of a window.
pub(crate) fn rows_of(whole: Window, rows: &Range<usize>) -> Window {
    Window {
        y0: whole.y0 + rows.start as i32,
        y1: whole.y0 + rows.end as i32,
        ..whole
    }
}

/// Copies the rows `from` of a strip to `whole`, starting at row `start`.
fn paste(strip: &Plane, from: &Range<usize>, whole: &mut Plane, start: usize) {
    for (i, y) in from.clone().enumerate() {
        whole.row_mut(start + i).copy_from_slice(strip.row(y));
    }
}
