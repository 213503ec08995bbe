//! A bounded sample of pixels, for judging a picture without looking at all of it.
//!
//! Stratified: one pixel in every cell of a lattice, in a random row for each row of cells and in a random column for each
//! cell, so that no pattern of the picture can agree with it. Pixels that share a row share pages of memory, too: in rows
//! of their own they would take several times as long. The places depend on the lattice alone: the same picture always
//! gives the same sample.

use std::ops::Range;

/// About one pixel in `area`, row after row: each of them once where that is 1 or less.
pub(crate) fn one_in(
    area: f64,
    columns: Range<usize>,
    rows: Range<usize>,
) -> impl Iterator<Item = (usize, usize)> {
    let side = area.max(1.0).sqrt();
    let cells = move |within: &Range<usize>| 0..(within.len() as f64 / side).ceil() as usize;
    // A place between both ends of cell `i` along a side of the picture.
    let place = move |within: &Range<usize>, i: usize, random: u32| {
        let [from, to] = [i, i + 1].map(|i| ((i as f64 * side) as usize).min(within.len()));
        let offset = place_in((to - from) as u32, random) as usize;
        (from < to).then_some(within.start + from + offset)
    };
    let across = cells(&columns);
    let down = cells(&rows);
    let row = move |j: usize| Some((j, place(&rows, j, scattered(0, j as u32))?));
    down.filter_map(row).flat_map(move |(j, y)| {
        let columns = columns.clone();
        across.clone().filter_map(move |i| {
            let random = scattered(1 + i as u32, j as u32);
            Some((place(&columns, i, random)?, y))
        })
    })
}

/// Square cells of whole pixels, with a place in each. Integers alone decide where these lie, so that every backend, and
/// every strip of a picture, finds the same.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct SampleLattice {
    /// Pixels along a side of a cell.
    pub(crate) side: u32,
    pub(crate) columns: Range<usize>,
    pub(crate) rows: Range<usize>,
}

/// Least number of pixels that a lattice takes of a large picture, and of values that are enough for a percentile. On
/// renders and photos, percentiles of curvature and light from these are up to 0.7 % off, from half as many over 1 %.
const WANTED: usize = 120_000;
const ENOUGH: u32 = 100_000;

impl SampleLattice {
    /// Cells over these pixels, `count` of which are covered: from [`WANTED`] on up to four times as many as that are
    /// taken, and all if there are no more.
    pub(crate) fn of(columns: Range<usize>, rows: Range<usize>, count: usize) -> Self {
        Self {
            side: (count / WANTED).max(1).isqrt() as u32,
            columns,
            rows,
        }
    }

    /// The rows of cells whose places lie in the rows `within`, and the rows of these places.
    pub(crate) fn rows(&self, within: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let [first, end] = [within.start, within.end.min(self.rows.end)]
            .map(|y| y.saturating_sub(self.rows.start));
        let cells = first / self.side as usize..end.div_ceil(self.side as usize);
        let length = self.rows.len() as u32;
        let row = move |j: usize| {
            let random = scattered(0, j as u32);
            let place = lattice_place(j as u32, self.side, length, random);
            (j, self.rows.start + place as usize)
        };
        cells.map(row).filter(move |(_, y)| within.contains(y))
    }

    /// The columns of the places in row `j` of cells, as far as these cells reach into `within`.
    pub(crate) fn columns(&self, j: usize, within: Range<usize>) -> impl Iterator<Item = usize> {
        let side = self.side;
        let [first, end] = [within.start, within.end.min(self.columns.end)]
            .map(|x| x.saturating_sub(self.columns.start) as u32);
        (first / side..end.div_ceil(side)).map(move |i| {
            let random = scattered(1 + i, j as u32);
            self.columns.start + lattice_place(i, side, self.columns.len() as u32, random) as usize
        })
    }
}

/// The place in cell `i` of cells with this side along `length` pixels, the last of which may be shorter.
fn lattice_place(i: u32, side: u32, length: u32, random: u32) -> u32 {
    let from = i * side;
    from + place_in(side.min(length - from), random)
}

/// The largest side, up to that of a lattice of which `counted` values count, with which [`ENOUGH`] should: filters may
/// leave too few.
pub(crate) fn finer_side(side: u32, counted: u32) -> u32 {
    if counted >= ENOUGH {
        return side;
    }
    let mut finer = side;
    while finer > 1 && finer * finer * ENOUGH > side * side * counted {
        finer -= 1;
    }
    finer
}

/// One of `length` places, by 16 random bits.
fn place_in(length: u32, random: u32) -> u32 {
    (length * (random >> 16)) >> 16
}

/// Bits that depend on both numbers like random ones.
fn scattered(i: u32, j: u32) -> u32 {
    let mixed = |bits: u32, by: u32| (bits ^ bits >> 16).wrapping_mul(by);
    let both = i
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add(mixed(j, 0x85eb_ca6b));
    let bits = mixed(mixed(both, 0x85eb_ca6b), 0xc2b2_ae35);
    bits ^ bits >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_gives_one_pixel_and_small_pictures_all_of_theirs() {
        let all: Vec<_> = one_in(0.5, 2..7, 1..4).collect();
        let expected: Vec<_> = (1..4).flat_map(|y| (2..7).map(move |x| (x, y))).collect();
        assert_eq!(all, expected);
        assert_eq!(one_in(9.0, 3..3, 0..9).count(), 0);
        // Cells of 2.5 x 2.5 pixels: 4 x 2 in 10 x 5, one pixel in each of them.
        let some: Vec<_> = one_in(6.25, 0..10, 0..5).collect();
        let cell = |&(x, y): &(usize, usize)| ((2 * x + 1) / 5, (2 * y + 1) / 5);
        let cells: Vec<_> = some.iter().map(cell).collect();
        let expected: Vec<_> = (0..2).flat_map(|j| (0..4).map(move |i| (i, j))).collect();
        assert_eq!(cells, expected);
    }

    #[test]
    fn a_lattice_gives_one_pixel_of_every_cell_and_strips_the_same() {
        // Cells of 3 x 3 over 10 x 7 pixels: 4 x 3, those at the end with 1 column or row.
        let lattice = SampleLattice {
            side: 3,
            columns: 5..15,
            rows: 2..9,
        };
        let pixels = |within: Range<usize>| -> Vec<(usize, usize)> {
            let rows = lattice.rows(within);
            let row = |(j, y)| lattice.columns(j, 0..20).map(move |x| (x, y));
            rows.flat_map(row).collect()
        };
        let all = pixels(0..20);
        let cells: Vec<_> = all
            .iter()
            .map(|(x, y)| ((x - 5) / 3, (y - 2) / 3))
            .collect();
        let expected: Vec<_> = (0..3).flat_map(|j| (0..4).map(move |i| (i, j))).collect();
        assert_eq!(cells, expected);
        assert!(
            all.iter()
                .all(|(x, y)| (5..15).contains(x) && (2..9).contains(y))
        );
        let strips: Vec<_> = [0..3, 3..4, 4..8, 8..20]
            .into_iter()
            .flat_map(pixels)
            .collect();
        assert_eq!(strips, all);
        // Every pixel of a small picture.
        let small = SampleLattice::of(5..15, 2..9, 70);
        let rows: Vec<_> = small.rows(0..9).collect();
        assert_eq!(rows, (0..7).map(|j| (j, j + 2)).collect::<Vec<_>>());
        assert!(small.columns(3, 7..9).eq(7..9));
    }

    #[test]
    fn a_lattice_takes_no_fewer_pixels_than_wanted() {
        for (count, side) in [(0, 1), (479_999, 1), (480_000, 2), (33_177_600, 16)] {
            assert_eq!(SampleLattice::of(0..1, 0..1, count).side, side);
        }
        // Half of the values asked for at a side of 16: 16 / sqrt(2) is 11.3.
        assert_eq!(finer_side(16, 50_000), 11);
        assert_eq!([0, 100_000].map(|counted| finer_side(16, counted)), [1, 16]);
    }

    #[test]
    fn every_place_of_a_cell_is_as_likely() {
        // Of 250 x 250 cells of 4 x 4: each of the four columns is taken 15,625 times, and each of the four rows in 62.5
        // rows of cells, give or take 4.5 standard deviations of 108 and of 6.8.
        let (mut columns, mut rows) = ([0_u32; 4], [0_u32; 4]);
        for (x, y) in one_in(16.0, 0..1000, 0..1000) {
            columns[x % 4] += 1;
            rows[y % 4] += 1;
        }
        assert!(
            columns.iter().all(|n| n.abs_diff(15_625) < 487),
            "{columns:?}"
        );
        let is_likely = |n: &u32| (n / 250).abs_diff(62) < 31;
        assert!(rows.iter().all(is_likely), "{rows:?}");
    }
}
