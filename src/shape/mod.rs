//! The shape descriptor of [LW] section 4: pure kernels over rows, no files, threads or clock.
//!
//! Rows run down while y points up: `d/dy` is (row above - row below) / 2. Every kernel states how many pixels it reads
//! to each side.

pub(crate) mod auto_levels;
pub(crate) mod bends;
pub(crate) mod coarse_normals;
pub(crate) mod curvature_display;
pub(crate) mod edges;
pub(crate) mod height;
#[cfg(test)]
mod levels;
pub(crate) mod occlusion;

use std::ops::Range;

pub(crate) mod chebyshev;
pub mod conductance;
pub mod crease;
pub mod curvature;
pub(crate) mod diffusion;
pub mod gradient;
pub(crate) mod hessian;
pub(crate) mod silhouette;
pub mod view_hessian;

/// Three neighbouring rows of one plane: above, at and below the row being computed. At the border of a picture the
/// border row is repeated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows<'a, T = f32> {
    /// The row above.
    pub above: &'a [T],
    /// The row being computed.
    pub at: &'a [T],
    /// The row below.
    pub below: &'a [T],
}

impl<'a, T: Copy> Rows<'a, T> {
    /// The rows around row `y` of `plane`.
    pub(crate) fn around(plane: &'a crate::frame::Plane<T>, y: usize) -> Self {
        Self {
            above: plane.row(y.saturating_sub(1)),
            at: plane.row(y),
            below: plane.row((y + 1).min(plane.height() - 1)),
        }
    }

    /// The 3x3 samples around column `x`, rows top to bottom; columns beyond the border repeat it.
    #[inline(always)]
    pub(crate) fn neighbourhood(&self, x: usize) -> [[T; 3]; 3] {
        let around = |row: &[T]| match row.get(x.wrapping_sub(1)..x + 2) {
            Some(&[left, centre, right]) => [left, centre, right],
            _ => [
                row[x.saturating_sub(1)],
                row[x],
                row[(x + 1).min(row.len() - 1)],
            ],
        };
        // Written out: `map` over an array is not always inlined, and this is the innermost loop.
        [around(self.above), around(self.at), around(self.below)]
    }
}

/// The samples of a row in a range of columns, with those to their left and right, in slices of equal length, so that
/// loops vectorise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shifted<'a, T = f32> {
    /// The samples of `left` and `right` together.
    reach: &'a [T],
    left: &'a [T],
    at: &'a [T],
    right: &'a [T],
}

impl<'a, T: Copy> Shifted<'a, T> {
    /// The columns `columns` of `row`, which has at least one more on each side.
    ///
    /// # Panics
    /// If it does not.
    #[inline(always)]
    fn new(row: &'a [T], columns: &Range<usize>) -> Self {
        let n = columns.len();
        let reach = &row[columns.start - 1..columns.start + n + 1];
        Self {
            reach,
            left: &reach[..n],
            at: &reach[1..][..n],
            right: &reach[2..][..n],
        }
    }

    /// The samples left of, at and right of the `i`-th column.
    #[inline(always)]
    fn around(&self, i: usize) -> [T; 3] {
        [self.left[i], self.at[i], self.right[i]]
    }
}

/// The `columns` that have neighbours on both sides in a row of `width` samples.
#[inline(always)]
fn inner_columns(columns: &Range<usize>, width: usize) -> Range<usize> {
    let start = columns.start.max(1);
    start..columns.end.min(width.saturating_sub(1)).max(start)
}

/// The `columns` outside `inner`: the first and the last of a row.
#[inline(always)]
fn outer_columns(columns: &Range<usize>, inner: &Range<usize>) -> impl Iterator<Item = usize> {
    let before = columns.start..columns.end.min(inner.start);
    before.chain(columns.start.max(inner.end)..columns.end)
}

/// Derivatives (d/dx, d/dy) per pixel of a 3x3 neighbourhood, y up: Sobel's kernel, divided by its sum of 8.
#[inline(always)]
pub(crate) fn sobel(n: [[f32; 3]; 3]) -> [f32; 2] {
    let column = |x: usize| (n[0][x] + n[2][x]) + 2.0 * n[1][x];
    let row = |y: usize| (n[y][0] + n[y][2]) + 2.0 * n[y][1];
    [(column(2) - column(0)) / 8.0, (row(0) - row(2)) / 8.0]
}
