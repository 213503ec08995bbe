//! Exposure that keeps new light from burning out.

use crate::frame::{ColorPlanes, Mask};
use rayon::prelude::*;
use std::ops::Range;

/// Share of a surface that stays at or below 1, so that the shoulder preserves order and colour.
const KEPT: f64 = 0.98;

/// Steps of brightness to a stop.
const STEPS: f32 = 16.0;

/// Stops above 1 to count: up to the largest f32.
const MOST_STOPS: usize = 128;

/// Histogram of a surface's brightness, by the largest channel: counts of pixels up to 1, and in each sixteenth of a
/// stop above it.
#[derive(Debug, Clone)]
pub(crate) struct Brightness(Vec<u64>);

impl Default for Brightness {
    fn default() -> Self {
        Self(vec![0; 1 + MOST_STOPS * STEPS as usize])
    }
}

impl Brightness {
    /// Counts the pixels of these rows where `mask` has a surface. Pixels with non-finite colour do not count.
    pub(crate) fn add(&mut self, color: &ColorPlanes, mask: &Mask, rows: Range<usize>) {
        let last = self.0.len() - 1;
        let step = |x: usize, y: usize| {
            let color = color.at(x, y);
            let brightest = color.into_iter().fold(0.0, f32::max);
            // Most is no brighter than 1, and needs no logarithm.
            let above = match brightest > 1.0 {
                true => (STEPS * brightest.log2()).ceil(),
                false => 0.0,
            };
            let has_meaning = color.iter().all(|v| v.is_finite());
            has_meaning.then_some((above as usize).min(last))
        };
        let count = |mut counts: Vec<u64>, y: usize| {
            let pixels = mask.runs(y).flatten();
            let steps = pixels.filter_map(|x| step(x, y));
            steps.for_each(|step| counts[step] += 1);
            counts
        };
        let sum = |mut sum: Vec<u64>, counts: Vec<u64>| {
            sum.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
            sum
        };
        let none = || vec![0; last + 1];
        let task = rows.len().div_ceil(2 * rayon::current_num_threads()).max(1);
        let rows = rows.into_par_iter().with_min_len(task);
        let counts = rows.fold(none, count).reduce(none, sum);
        self.0.iter_mut().zip(counts).for_each(|(all, n)| *all += n);
    }

    /// Stops, 0 or less in steps of a sixteenth, after which no more than a small share is brighter than 1.
    pub(crate) fn exposure(&self) -> f32 {
        let all: u64 = self.0.iter().sum();
        let mut kept = 0;
        let within = |&count: &u64| {
            kept += count;
            kept as f64 >= KEPT * all as f64
        };
        let steps = self.0.iter().position(within).unwrap_or(0);
        0.0 - steps as f32 / STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;

    #[test]
    fn all_but_two_in_a_hundred_are_dimmed_to_one() {
        // 100 pixels: 97 of 0.5, one of 2^(1/2), which is 8 steps of a sixteenth above 1, and two of 40. 98 are no
        // brighter than 2^(1/2).
        let exposure = |bright: &[f32]| {
            let mut samples = vec![0.5; 100 - bright.len()];
            samples.extend(bright);
            let color = ColorPlanes::grey(Plane::from_samples(10, 10, samples));
            let mut brightness = Brightness::default();
            let mask = Mask::full(10, 10);
            brightness.add(&color, &mask, 0..4);
            brightness.add(&color, &mask, 4..10);
            brightness.exposure()
        };
        let root = 2.0_f32.sqrt();
        assert_eq!(exposure(&[0.999 * root, 40.0, 40.0]), -0.5);
        assert_eq!(exposure(&[40.0, 40.0]), 0.0);
        assert_eq!(exposure(&[4.0; 100]), -2.0);
        // Non-finite colours do not count: of 97 pixels two may be brighter, which leaves one of 4.
        let odd = [f32::NAN, f32::INFINITY, f32::NAN];
        assert_eq!(exposure(&[odd.as_slice(), &[4.0, 8.0, 8.0]].concat()), -3.0);
        assert_eq!(Brightness::default().exposure(), 0.0);
    }
}
