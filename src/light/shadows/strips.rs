//! Heights in the order in which sweeps read them.

use super::hull::{Abreast, LINES};
use crate::frame::Plane;
use crate::shape::occlusion::NOTHING;
use rayon::prelude::*;

/// Rows of [`NOTHING`] above and below the picture at least: as many as the first and the last lines reach beyond it.
const BEYOND: usize = LINES + 2;

/// Heights of the rows above the upper pixels of lines, of these, of the lower ones, and of those below.
pub(super) type Around = [Abreast; 4];

/// Heights in strips of [`LINES`] rows, each strip column by column: lines pass through memory in order.
pub(super) struct Heights {
    is_transposed: bool,
    pub(super) columns: usize,
    pub(super) rows: usize,
    samples: Vec<Abreast>,
}

impl Heights {
    /// Of the picture, or of the transposed one: light changes rows no faster than columns.
    pub(super) fn of(height: &Plane, is_transposed: bool) -> Self {
        let (w, h) = (height.width(), height.height());
        let [columns, rows] = if is_transposed { [h, w] } else { [w, h] };
        // Three are read from the one on that a line begins in.
        let count = (rows + 2 * BEYOND) / LINES + 3;
        let mut samples = vec![[NOTHING; LINES]; count * columns];
        let strips = samples.par_chunks_mut(columns.max(1)).enumerate();
        strips.for_each(|(strip, samples)| {
            let row = |l: usize| (strip * LINES + l).wrapping_sub(BEYOND);
            for (l, row) in (0..LINES)
                .map(|l| (l, row(l)))
                .filter(|(_, row)| *row < rows)
            {
                for (x, sample) in samples.iter_mut().enumerate() {
                    let [x, y] = if is_transposed { [row, x] } else { [x, row] };
                    sample[l] = height.at(x, y);
                }
            }
        });
        Self {
            is_transposed,
            columns,
            rows,
            samples,
        }
    }

    /// The heights around the lines from `line` on in column `x`.
    #[inline(always)]
    pub(super) fn around(&self, line: isize, x: usize) -> Around {
        let row = (line + BEYOND as isize - 1) as usize;
        let mut rows = [0.0; 3 * LINES];
        for (i, rows) in rows.as_chunks_mut().0.iter_mut().enumerate() {
            *rows = self.samples[(row / LINES + i) * self.columns + x];
        }
        let mut heights = [[0.0; LINES]; 4];
        for (i, heights) in heights.iter_mut().enumerate() {
            heights.copy_from_slice(&rows[row % LINES + i..][..LINES]);
        }
        heights
    }

    /// A plane for what is found, column by column.
    pub(super) fn found<T: Copy + Default>(&self) -> Plane<T> {
        Plane::filled(self.rows, self.columns, T::default())
    }

    /// What was found, as the picture is.
    pub(super) fn turned_back<T: Copy + Default + Send + Sync>(&self, found: Plane<T>) -> Plane<T> {
        match self.is_transposed {
            true => found,
            false => Plane::of_pixels(self.columns, self.rows, |x, y| found.at(y, x)),
        }
    }
}
