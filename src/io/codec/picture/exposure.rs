//! Exposure of new light: as bright as the picture was, and without burning out.

use crate::frame::{ColorPlanes, Mask};
use rayon::prelude::*;
use std::ops::Range;

/// Share of a surface that stays at or below 1, so that the shoulder preserves order and colour.
const KEPT: f64 = 0.98;

/// Steps of brightness to a stop.
const STEPS: f32 = 16.0;

/// The least brightness that counts, in stops: no picture brightens by more.
const DARKEST: f32 = -8.0;

/// The largest that counts: the largest f32.
const BRIGHTEST: f32 = 128.0;

/// The brightness of a surface.
#[derive(Debug, Clone)]
pub(crate) struct Brightness {
    /// Pixels by their largest channel, in steps of a sixteenth of a stop.
    counts: Vec<u64>,
    /// Sums of [`levels`]: of the surface, and of the picture it is to be like, if there is one.
    levels: [f64; 2],
}

impl Default for Brightness {
    fn default() -> Self {
        Self {
            counts: vec![0; 1 + ((BRIGHTEST - DARKEST) * STEPS) as usize],
            levels: [0.0; 2],
        }
    }
}

impl Brightness {
    /// Counts the pixels of these rows where `mask` has a surface, and takes in how bright the picture `like` is there.
    /// Pixels with non-finite colour do not count.
    pub(crate) fn add(
        &mut self,
        color: &ColorPlanes,
        like: Option<&ColorPlanes>,
        mask: &Mask,
        rows: Range<usize>,
    ) {
        let last = self.counts.len() - 1;
        // Without a picture to be like none brightens: most is no brighter than 1, and needs no logarithm.
        let least = if like.is_some() { DARKEST } else { 0.0 };
        let step = |x: usize, y: usize| {
            let color = color.at(x, y);
            let brightest = color.into_iter().fold(0.0, f32::max);
            let stops = match brightest > least.exp2() {
                true => brightest.log2(),
                false => least,
            };
            let has_meaning = color.iter().all(|v| v.is_finite());
            has_meaning.then_some(((STEPS * (stops - DARKEST)).ceil() as u16).min(last as u16))
        };
        let steps_of = |y: usize| -> Vec<u16> {
            let pixels = mask.runs(y).flatten();
            pixels.filter_map(|x| step(x, y)).collect()
        };
        let steps: Vec<_> = rows.clone().into_par_iter().map(steps_of).collect();
        for step in steps.into_iter().flatten() {
            self.counts[usize::from(step)] += 1;
        }
        if let Some(like) = like {
            let of_row = |y: usize| levels([color, like], mask, y);
            let rows: Vec<[f64; 2]> = rows.into_par_iter().map(of_row).collect();
            // In row order: the same bits for any number of threads and strips.
            for [made, like] in rows {
                self.levels = [self.levels[0] + made, self.levels[1] + like];
            }
        }
    }

    /// Stops, in steps of a sixteenth, that make the surface as bright as the picture it is to be like; 0 without one. At
    /// most those after which no more than a small share is brighter than 1.
    pub(crate) fn exposure(&self) -> f32 {
        let all: u64 = self.counts.iter().sum();
        let mut kept = 0;
        let within = |&count: &u64| {
            kept += count;
            kept as f64 >= KEPT * all as f64
        };
        let steps = self.counts.iter().position(within).unwrap_or(0);
        let most = -DARKEST - steps as f32 / STEPS;
        let [made, like] = self.levels;
        // A level is a square root.
        let alike = 2.0 * (like / made).log2();
        let wanted = match alike.is_finite() {
            true => (alike as f32 * STEPS).round() / STEPS,
            false => 0.0,
        };
        0.0 + wanted.min(most)
    }
}

/// Sums of the levels of a row of two pictures, where both are finite: square roots, near those of a display.
fn levels(pictures: [&ColorPlanes; 2], mask: &Mask, y: usize) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for x in mask.runs(y).flatten() {
        let colors = pictures.map(|picture| picture.at(x, y));
        if colors.iter().flatten().all(|v| v.is_finite()) {
            let of_channel = |v: f32| f64::from(v.max(0.0).sqrt());
            let level = |color: [f32; 3]| color.map(of_channel).iter().sum::<f64>();
            sums = [sums[0] + level(colors[0]), sums[1] + level(colors[1])];
        }
    }
    sums
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
            brightness.add(&color, None, &mask, 0..4);
            brightness.add(&color, None, &mask, 4..10);
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
    #[test]
    fn a_surface_becomes_as_bright_as_its_picture_where_there_is_room() {
        let exposure = |made: [f32; 2], like: f32| {
            let [color, like] = [[made[0], made[1]], [like; 2]]
                .map(|samples| ColorPlanes::grey(Plane::from_samples(2, 1, samples.to_vec())));
            let mut brightness = Brightness::default();
            brightness.add(&color, Some(&like), &Mask::full(2, 1), 0..1);
            brightness.exposure()
        };
        // Roots of .09 and .01 are .3 and .1, .2 in the mean, that of .01 is half as much: a quarter of the light.
        assert_eq!(exposure([0.09, 0.01], 0.01), -2.0);
        // That of .16 is twice as much: .09 becomes .36.
        assert_eq!(exposure([0.09, 0.01], 0.16), 2.0);
        // Half of 1 has room for one stop, where two would be as bright.
        assert_eq!(exposure([0.5, 0.0], 0.5), 1.0);
        // Nothing to compare with.
        assert_eq!(exposure([0.0, 0.0], 0.5), 0.0);
        assert_eq!(exposure([f32::NAN, f32::NAN], 0.5), 0.0);
    }
}
