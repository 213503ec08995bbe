//! Percentiles and other statistics of what is seen in a picture, from a bounded sample of its pixels: exact for small
//! pictures, and within 1 % for large ones.
//!
//! If too few of the sampled values count, such as curvature in a picture of walls, a second look at more pixels
//! replaces the first. A picture that comes some rows at a time gives the same as the whole.

use crate::frame::sampling::{SampleLattice, finer_side};
use crate::frame::{Extent, Mask};
use crate::kernel::quantile::quantile;
use rayon::prelude::*;
use std::ops::Range;

/// Rows of the sample that are worth a task.
const ROWS_PER_TASK: usize = 32;

/// About the value below which `percent` of the finite values of covered pixels lie; `None` if there are none.
/// `value(x, y)` is `None` where a pixel does not count.
pub(crate) fn percentile(
    mask: &Mask,
    percent: u32,
    value: impl Fn(usize, usize) -> Option<f32> + Sync,
) -> Option<f32> {
    let mut sample = PictureSample::default();
    sample.begin(&Extent::of(mask));
    while sample.is_open() {
        sample.add(mask, 0..mask.height(), 0, &value);
        sample.end_look();
    }
    sample.percentile(percent)
}

/// What is known of a pixel: a number, or a number and its weight.
pub(crate) trait Known: Copy + Send + Default {
    fn is_finite(self) -> bool;
}

impl Known for f32 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Known for [f32; 2] {
    fn is_finite(self) -> bool {
        self.iter().all(|number| number.is_finite())
    }
}

/// A sample of the values of a picture that comes some rows at a time, once or twice: its finite values, row by row.
#[derive(Debug, Clone, Default)]
pub(crate) struct PictureSample<T> {
    lattice: SampleLattice,
    values: Vec<T>,
    looks: SampleLook,
}

/// The look that a sample takes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
enum SampleLook {
    First,
    Second,
    #[default]
    Done,
}

/// A sample that is taken in one or two looks at a picture.
pub(crate) trait InLooks {
    /// Begins the first, of a picture with these covered pixels.
    fn begin(&mut self, extent: &Extent);
    /// Whether it takes another.
    fn is_open(&self) -> bool;
    /// Ends one, at all rows.
    fn end_look(&mut self);
}

impl<T: Known> InLooks for PictureSample<T> {
    fn begin(&mut self, extent: &Extent) {
        self.lattice = extent.lattice();
        self.looks = SampleLook::First;
    }

    fn is_open(&self) -> bool {
        self.looks != SampleLook::Done
    }

    fn end_look(&mut self) {
        let finer = finer_side(self.lattice.side, self.values.len() as u32);
        self.looks = match self.looks {
            SampleLook::First if finer < self.lattice.side => SampleLook::Second,
            _ => SampleLook::Done,
        };
        if self.looks == SampleLook::Second {
            self.lattice.side = finer;
            self.values.clear();
        }
    }
}

impl<T: Known> PictureSample<T> {
    /// Looks at the rows `rows` of a strip whose first row is row `top` of the picture.
    pub(crate) fn add(
        &mut self,
        mask: &Mask,
        rows: Range<usize>,
        top: usize,
        value: impl Fn(usize, usize) -> Option<T> + Sync,
    ) {
        if !self.is_open() {
            return;
        }
        let lattice = &self.lattice;
        let within = top + rows.start..top + rows.end;
        let rows: Vec<_> = lattice.rows(within).map(|(j, y)| (j, y - top)).collect();
        let values = rows
            .into_par_iter()
            .with_min_len(ROWS_PER_TASK)
            .flat_map_iter(|(j, y)| {
                let (covered, value) = (mask.row(y), &value);
                let columns = lattice.columns(j, mask.span(y));
                let columns = columns.filter(move |&x| covered[x]);
                let values = columns.filter_map(move |x| value(x, y));
                values.filter(|v| v.is_finite())
            });
        self.values.par_extend(values);
    }

    /// The values, once no other look is taken.
    pub(crate) fn values(self) -> Vec<T> {
        self.values
    }
}

impl PictureSample<f32> {
    /// A percentile of the values, once no other look is taken.
    pub(crate) fn percentile(mut self, percent: u32) -> Option<f32> {
        let share = f64::from(percent) / 100.0;
        quantile(&mut self.values, share, f32::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Plane, Window};

    /// Numbers that depend on the pixel like random ones, 0..1 (SplitMix64).
    fn random(x: usize, y: usize) -> f32 {
        let mixed = |z: u64, shift: u32, by: u64| (z ^ (z >> shift)).wrapping_mul(by);
        let z = (x as u64 + ((y as u64) << 32)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = mixed(z, 30, 0xbf58_476d_1ce4_e5b9);
        let z = mixed(z, 27, 0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1 << 24) as f32
    }

    #[test]
    fn percentiles_of_hostile_values() {
        let of = |values: &[f32], percent| {
            let value = |x: usize, _| Some(values[x]);
            percentile(&Mask::full(values.len(), 1), percent, value)
        };
        assert_eq!(of(&[], 50), None);
        assert_eq!(of(&[f32::NAN, f32::INFINITY], 50), None);
        let some = [3.0, f32::NAN, 1.0, 2.0, f32::NEG_INFINITY];
        assert_eq!(of(&some, 50), Some(2.0));
        assert_eq!(of(&[7.5; 1000], 98), Some(7.5));
        assert_eq!(percentile(&Mask::full(5, 5), 50, |_, _| None), None);
        let nowhere = Mask::new(Plane::filled(5, 5, false));
        assert_eq!(percentile(&nowhere, 50, |_, _| Some(1.0)), None);
    }

    #[test]
    fn small_pictures_give_what_sorting_finds() {
        // 400,000 pixels, a third of them covered, in a picture three times as large.
        let mask = Mask::new(Plane::from_fn(1200, 1000, |x, y| {
            (300..1100).contains(&x) && y >= 500 && random(y, x) < 0.33
        }));
        let value = |x, y| random(x, y) - 0.5;
        let pixels = (0..1000).flat_map(|y| mask.runs(y).flatten().map(move |x| (x, y)));
        let mut sorted: Vec<f32> = pixels.map(|(x, y)| value(x, y)).collect();
        sorted.sort_by(f32::total_cmp);
        for percent in [0, 10, 50, 80, 98, 100] {
            let share = f64::from(percent) / 100.0;
            let index = (share * (sorted.len() - 1) as f64).round() as usize;
            let found = percentile(&mask, percent, |x, y| Some(value(x, y)));
            assert_eq!(found, Some(sorted[index]), "{percent} %");
        }
    }

    #[test]
    fn a_sample_of_a_large_picture_is_within_one_per_cent() {
        // -ln(1 - u) of even u stays below -ln(1 - p) with probability p. The error of a share p among 153,600 values is
        // sqrt(p (1 - p) / 153,600), and of the percentile that over the density 1 - p: 0.3 % and 0.5 %.
        let mask = Mask::full(2400, 1600);
        let value = |x, y| Some(-(1.0 - random(x, y)).ln());
        for (percent, exact) in [(80, 5_f32.ln()), (98, 50_f32.ln())] {
            let found = percentile(&mask, percent, value).unwrap();
            assert!((found / exact - 1.0).abs() < 0.01, "{percent} %: {found}");
        }
        // A ramp of 3.8 million pixels, of which the lightest sixtieth counts: from 59/60 to 1. Half of that is 119/120,
        // to 1e-5: a cell has 5 of 2400 columns at the first look, and 1 at the second.
        let ramp = |x: usize, _| (x >= 2360).then_some((x as f32 + 0.5) / 2400.0);
        let found = percentile(&mask, 50, ramp).unwrap();
        assert!(
            (found - 119.0 / 120.0).abs() <= 0.5 / 2400.0 + 1e-6,
            "{found}"
        );
    }

    #[test]
    fn strips_give_what_the_whole_gives() {
        let mask = Mask::new(Plane::from_fn(1500, 1400, |x, y| {
            x.abs_diff(700) + y.abs_diff(600) > 250
        }));
        let window = Window::from_size(1500, 1400);
        // All values, and so few that they take a second look.
        for share in [1.0, 0.2] {
            let value = |x, y| (random(y, x) < share).then(|| random(x, y));
            let whole = percentile(&mask, 98, value);
            for height in [173, 700] {
                let strips = || (0..1400).step_by(height).map(|y| y..(y + height).min(1400));
                let strip = |rows: &Range<usize>| {
                    let top = rows.start.saturating_sub(9);
                    let part = Window {
                        y0: top as i32,
                        y1: rows.end as i32,
                        ..window
                    };
                    (
                        mask.crop(window, part),
                        rows.start - top..rows.end - top,
                        top,
                    )
                };
                let mut extent = Extent::default();
                for rows in strips() {
                    let (mask, rows, top) = strip(&rows);
                    extent.add(&mask, rows, top);
                }
                let (mut search, mut looks) = (PictureSample::default(), 0);
                search.begin(&extent);
                while search.is_open() {
                    for rows in strips() {
                        let (mask, rows, top) = strip(&rows);
                        search.add(&mask, rows, top, |x, y| value(x, y + top));
                    }
                    search.end_look();
                    looks += 1;
                }
                assert_eq!(looks, if share < 1.0 { 2 } else { 1 });
                assert_eq!(search.percentile(98), whole, "{share} {height}");
            }
        }
    }
}
