//! Percentiles of many values, without sorting or copying all of them: exactly the values that sorting would give.
//!
//! Some rows show about where a percentile lies; a pass over all counts what is below, and collects what is near. Where
//! it lies elsewhere, or where values come a few rows at a time, histograms find it: floats have the order of their bits,
//! once negative ones are flipped, so one over the upper half of the bits finds the bin that holds the value, and one over
//! the lower half within that bin finds the value. Counts are integers, independent of the number of threads.

use rayon::prelude::*;
use std::ops::Range;

/// Bins of a histogram over half the bits.
const BINS: usize = 1 << 16;

/// Rows that show about where a percentile lies, and how far off it may be, in percent.
const SAMPLED_ROWS: usize = 64;
const MARGIN: u32 = 3;

/// One in this many values, at most, is collected.
const MOST_WITHIN: usize = 6;

/// The value below which `percent` of the finite values lie; `None` if there are none. `row(y)` gives the values of row
/// `y` and is called a few times.
pub(crate) fn percentile<Values: Iterator<Item = f32>>(
    height: usize,
    percent: u32,
    row: impl Fn(usize) -> Values + Sync,
) -> Option<f32> {
    if let Some(found) = bracketed(height, percent, &row) {
        return Some(found);
    }
    let mut search = PercentileSearch::new(percent);
    search.add(0..height, &row);
    search.narrow();
    search.add(0..height, &row);
    search.found()
}

/// The percentile, if it lies where some rows show that it should. The others are looked at once.
fn bracketed<Values: Iterator<Item = f32>>(
    height: usize,
    percent: u32,
    row: impl Fn(usize) -> Values + Sync,
) -> Option<f32> {
    let step = height / SAMPLED_ROWS;
    if step < 2 {
        return None;
    }
    let is_finite = |v: &f32| v.is_finite();
    let rows = (step / 2..height).step_by(step);
    let mut sample: Vec<f32> = rows.flat_map(&row).filter(is_finite).collect();
    let last = sample.len().checked_sub(1)?;
    let mut at = |percent: u32| {
        let index = last * percent as usize / 100;
        *sample.select_nth_unstable_by(index, f32::total_cmp).1
    };
    let from = percent.checked_sub(MARGIN).map_or(f32::MIN, &mut at);
    let to = match percent + MARGIN {
        above @ ..100 => at(above),
        _ => f32::MAX,
    };
    // Many equal values are better counted than collected.
    let is_within = |v: &&f32| **v >= from && **v <= to;
    if sample.iter().filter(is_within).count() > sample.len() / MOST_WITHIN {
        return None;
    }
    let add = |mut found: Bracketed, y: usize| {
        row(y).for_each(|v| found.add(v, from, to));
        found
    };
    let mut found = (0..height)
        .into_par_iter()
        .with_min_len(height.div_ceil(2 * rayon::current_num_threads()))
        .fold(Bracketed::default, add)
        .reduce(Bracketed::default, Bracketed::and);
    let last = (found.below + found.within.len() + found.above).checked_sub(1)?;
    let rank = rank_of(percent, last as u64) as usize;
    let within = rank.checked_sub(found.below)?;
    (within < found.within.len()).then(|| {
        let order = f32::total_cmp;
        *found.within.select_nth_unstable_by(within, order).1
    })
}

/// Finite values below and above a range, and those in it.
#[derive(Default)]
struct Bracketed {
    below: usize,
    within: Vec<f32>,
    above: usize,
}

impl Bracketed {
    fn add(&mut self, value: f32, from: f32, to: f32) {
        self.below += usize::from(value < from && value >= f32::MIN);
        self.above += usize::from(value > to && value <= f32::MAX);
        if value >= from && value <= to {
            self.within.push(value);
        }
    }

    fn and(mut self, mut other: Self) -> Self {
        self.below += other.below;
        self.above += other.above;
        self.within.append(&mut other.within);
        self
    }
}

/// The rank of a percentile, where the last one is `last`.
fn rank_of(percent: u32, last: u64) -> u64 {
    (f64::from(percent) / 100.0 * last as f64).round() as u64
}

/// A search among values that come some at a time, all of them twice: once before [`PercentileSearch::narrow`], and
/// once after.
#[derive(Debug, Clone)]
pub(crate) struct PercentileSearch {
    percent: u32,
    counts: Vec<u64>,
    /// The upper half of the value's bits, and its rank among those that have it.
    upper: Option<(u32, u64)>,
    is_narrow: bool,
}

impl PercentileSearch {
    pub(crate) fn new(percent: u32) -> Self {
        Self {
            percent,
            counts: vec![0; BINS],
            upper: None,
            is_narrow: false,
        }
    }

    /// Counts the values of these rows.
    pub(crate) fn add<Values: Iterator<Item = f32>>(
        &mut self,
        rows: Range<usize>,
        row: impl Fn(usize) -> Values + Sync,
    ) {
        let keys = |y| row(y).map(key_of);
        let counts = match (self.is_narrow, self.upper) {
            (false, _) => histogram(rows, &|y, counts| {
                keys(y).for_each(|key| counts[(key >> 16) as usize % BINS] += 1);
            }),
            (true, Some((upper, _))) => histogram(rows, &|y, counts| {
                let within = keys(y).filter(|key| key >> 16 == upper);
                within.for_each(|key| counts[(key & 0xffff) as usize % BINS] += 1);
            }),
            (true, None) => return,
        };
        let sums = self.counts.iter_mut().zip(counts);
        sums.for_each(|(sum, count)| *sum += u64::from(count));
    }

    /// Ends the first time, and begins the second.
    pub(crate) fn narrow(&mut self) {
        let upper = &mut self.counts;
        // Forgetting the bins of infinities and NaN is cheaper than looking for these among the values.
        upper[..=key_of(f32::NEG_INFINITY) as usize >> 16].fill(0);
        upper[key_of(f32::INFINITY) as usize >> 16..].fill(0);
        let count: u64 = upper.iter().sum();
        self.upper = count
            .checked_sub(1)
            .map(|last| bin_at(upper, rank_of(self.percent, last)));
        self.counts.fill(0);
        self.is_narrow = true;
    }

    /// The percentile, after all values have been given twice.
    pub(crate) fn found(&self) -> Option<f32> {
        let (upper, rank) = self.upper?;
        let (lower, _) = bin_at(&self.counts, rank);
        Some(value_of(upper << 16 | lower))
    }
}

/// How often each of the bins is counted over all rows, by `count(y, counts)`.
fn histogram(rows: Range<usize>, count: &(dyn Fn(usize, &mut [u32]) + Sync)) -> Vec<u32> {
    // A histogram for each task: few tasks, yet enough to even out threads that were kept waiting.
    let rows_per_task = rows.len().div_ceil(2 * rayon::current_num_threads());
    rows.into_par_iter()
        .with_min_len(rows_per_task)
        .fold(
            || vec![0; BINS],
            |mut counts, y| {
                count(y, &mut counts);
                counts
            },
        )
        .reduce_with(|mut sum, counts| {
            sum.iter_mut().zip(&counts).for_each(|(s, n)| *s += n);
            sum
        })
        .unwrap_or_else(|| vec![0; BINS])
}

/// The bin of the value that comes `rank`-th, from 0, and its rank within the bin.
fn bin_at(counts: &[u64], mut rank: u64) -> (u32, u64) {
    for (bin, &count) in counts.iter().enumerate() {
        match rank.checked_sub(count) {
            Some(rest) => rank = rest,
            None => return (bin as u32, rank),
        }
    }
    unreachable!("a rank is less than the sum of the counts")
}

/// Bits that are ordered as `f32::total_cmp` orders the values.
#[inline(always)]
pub(crate) fn key_of(value: f32) -> u32 {
    let bits = value.to_bits();
    let negative = ((bits as i32) >> 31) as u32;
    bits ^ (negative | SIGN)
}

/// The value with this key.
pub(crate) fn value_of(key: u32) -> f32 {
    f32::from_bits(if key & SIGN == 0 { !key } else { key ^ SIGN })
}

const SIGN: u32 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;

    fn of_rows(rows: &[Vec<f32>], percent: u32) -> Option<f32> {
        percentile(rows.len(), percent, |y| rows[y].iter().copied())
    }

    #[test]
    fn percentiles_of_hostile_values() {
        assert_eq!(of_rows(&[], 50), None);
        assert_eq!(of_rows(&[vec![], vec![]], 50), None);
        assert_eq!(of_rows(&[vec![f32::NAN, f32::INFINITY]], 50), None);
        let some = vec![vec![3.0, f32::NAN], vec![1.0, 2.0, f32::NEG_INFINITY]];
        assert_eq!(of_rows(&some, 50), Some(2.0));
        assert_eq!(of_rows(&[vec![7.5; 1000]], 98), Some(7.5));
    }

    #[test]
    fn it_is_what_sorting_finds() {
        // Many sizes and both signs, some of them often, in rows of unequal length.
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            seed >> 8
        };
        let rows: Vec<Vec<f32>> = (0..97)
            .map(|y| {
                let values = (0..y * 7 % 41).map(|_| match random() % 4 {
                    0 => f32::from_bits(random() << 7),
                    1 => -f32::from_bits(random() << 7),
                    2 => 0.25,
                    _ => random() as f32 * 1e-7,
                });
                values.collect()
            })
            .collect();
        let mut sorted: Vec<f32> = rows.iter().flatten().copied().collect();
        sorted.retain(|v| v.is_finite());
        sorted.sort_by(f32::total_cmp);
        for percent in [0, 10, 50, 80, 98, 100] {
            let share = f64::from(percent) / 100.0;
            let index = (share * (sorted.len() - 1) as f64).round() as usize;
            let found = of_rows(&rows, percent).unwrap();
            assert_eq!(found.to_bits(), sorted[index].to_bits(), "{percent} %");
        }
    }

    #[test]
    fn keys_give_their_values_back_in_order() {
        let values = [-f32::MAX, -1.0, -1e-45, -0.0, 0.0, 1e-45, 1.0, f32::MAX];
        assert!(
            values
                .windows(2)
                .all(|pair| key_of(pair[0]) < key_of(pair[1]))
        );
        for v in values {
            assert_eq!(value_of(key_of(v)).to_bits(), v.to_bits());
        }
    }
}
