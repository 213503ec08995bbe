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
    // A place between both ends of cell `i` along a side of the picture, by 16 random bits.
    let place = move |within: &Range<usize>, i: usize, random: u32| {
        let [from, to] = [i, i + 1].map(|i| ((i as f64 * side) as usize).min(within.len()));
        let offset = ((to - from) * (random >> 16) as usize) >> 16;
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
