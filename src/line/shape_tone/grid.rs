//! The grid of cells on which tone is found, and the way to it and back.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::map_covered;
use crate::frame::{Mask, Plane};

/// Cells of `step` by `step` pixels; those that hold any surface are covered.
pub(crate) struct Grid {
    pub(crate) step: usize,
    pub(crate) mask: Mask,
}

impl Grid {
    pub(crate) fn new(pixels: &Mask, step: usize) -> Self {
        if step == 1 {
            let mask = pixels.clone();
            return Self { step, mask };
        }
        let [width, height] = [pixels.width(), pixels.height()].map(|length| length.div_ceil(step));
        let mut covered = Plane::filled(width, height, false);
        for y in 0..pixels.height() {
            let row = covered.row_mut(y / step);
            for run in pixels.runs(y) {
                row[run.start / step..=(run.end - 1) / step].fill(true);
            }
        }
        let mask = Mask::new(covered);
        Self { step, mask }
    }

    /// The means over cells of `sample(x, y)`, of what is covered.
    pub(crate) fn means<const N: usize>(
        &self,
        pixels: &Mask,
        memory: &Memory,
        sample: impl Fn(usize, usize) -> [f32; N] + Sync,
    ) -> [Plane; N] {
        let (step, sample) = (self.step, &sample);
        let [width, height] = [pixels.width(), pixels.height()];
        map_covered(&self.mask, memory, |row| {
            move |column| {
                let (mut sums, mut count) = ([0.0; N], 0.0);
                for y in row * step..((row + 1) * step).min(height) {
                    let columns = column * step..((column + 1) * step).min(width);
                    let covered = pixels.row(y);
                    for x in columns.filter(|&x| covered[x]) {
                        let sample = sample(x, y);
                        sums.iter_mut().zip(sample).for_each(|(sum, v)| *sum += v);
                        count += 1.0;
                    }
                }
                sums.map(|sum| sum / count)
            }
        })
    }

    /// The least sample of a plane of pixels in each cell; 0 where nothing is covered.
    pub(crate) fn least(&self, pixels: &Plane) -> Plane {
        let step = self.step;
        Plane::from_fn(self.mask.width(), self.mask.height(), |column, row| {
            let rows = row * step..((row + 1) * step).min(pixels.height());
            let columns = column * step..((column + 1) * step).min(pixels.width());
            let samples = rows.flat_map(|y| &pixels.row(y)[columns.clone()]);
            samples.copied().fold(f32::INFINITY, f32::min)
        })
    }

    /// What a plane of cells has at the pixels of row `y`, by their column: the mean of the four cells around, by distance;
    /// of those covered.
    #[inline(always)]
    pub(crate) fn row<'a>(&'a self, cells: &'a Plane, y: usize) -> impl Fn(usize) -> f32 + 'a {
        let (rows, down) = self.place(y, cells.height());
        let rows = rows.map(|row| (self.mask.row(row), cells.row(row)));
        let of_rows = [1.0 - down, down];
        move |x| {
            if self.step == 1 {
                return rows[0].1[x];
            }
            let (columns, across) = self.place(x, cells.width());
            let of_columns = [1.0 - across, across];
            let (mut sum, mut weight) = (0.0, 0.0);
            for ((covered, samples), of_row) in rows.into_iter().zip(of_rows) {
                for (column, of_column) in columns.into_iter().zip(of_columns) {
                    if covered[column] {
                        sum += of_row * of_column * samples[column];
                        weight += of_row * of_column;
                    }
                }
            }
            // A pixel's own cell is covered, and weighs a quarter at the least.
            sum / weight
        }
    }

    /// The two cells, of so many, around a pixel along an axis, and how far it lies toward the second.
    #[inline(always)]
    fn place(&self, pixel: usize, count: usize) -> ([usize; 2], f32) {
        let at = (pixel as f32 + 0.5) / self.step as f32 - 0.5;
        let first = at.floor();
        let inside = |i: f32| (i.max(0.0) as usize).min(count - 1);
        ([inside(first), inside(first + 1.0)], at - first)
    }
}
