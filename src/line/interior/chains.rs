//! Chains: lines through crests that hang together and are plain somewhere.

use crate::line::contours::lattice::STEPS;
use crate::line::contours::network::{Line, Sets};
use crate::line::contours::ridge;
use crate::line::contours::smoothing::Smoothing;
use crate::line::interior::crests::Crest;
use crate::line::interior::fade::supports;
use crate::line::interior::sizes::Sizes;
use glam::IVec2;

/// Crests deviate from a line by so much, and are smoothed over so many on either side.
const SMOOTHING: Smoothing = Smoothing {
    step_px: 1.0,
    tolerance: 0.7,
    reach: 5,
    is_stepped: false,
};

/// The lines through crests of one kind, each with its share of the full width; the crests are on a grid of `width` by
/// `height` pixels in row order. Crests above the first threshold form networks; each network kept exceeds the second
/// threshold somewhere, and is about as long as `shortest` pixels.
pub(super) fn chains(
    crests: &[Crest],
    [width, height]: [usize; 2],
    shortest: f32,
    sizes: &Sizes,
) -> Vec<(Line, f32)> {
    let thresholds = sizes.thresholds;
    // A line aslant has a crest for the root of two of its length.
    let fewest = (shortest * std::f32::consts::FRAC_1_SQRT_2) as usize;
    let crests = plain(crests, [width, height], thresholds[1], fewest);
    let lines = ridge::lines(&crests, &[], [width, height], |_| 0.0, SMOOTHING);
    let fades = match sizes.fades {
        true => fades(&lines, &crests, [width, height], thresholds),
        false => vec![1.0; lines.len()],
    };
    lines.into_iter().zip(fades).collect()
}

/// The share of its width that each line is drawn with, by the support that its crests have.
fn fades(lines: &[Line], crests: &[Crest], size: [usize; 2], thresholds: [f32; 2]) -> Vec<f32> {
    let numbers = CrestNumbers::of(crests, size);
    let supports = supports(crests, thresholds, |crest| numbers.beside(crest).collect());
    let of_line = |line: &Line| {
        let own = line
            .spots
            .iter()
            .filter_map(|spot| numbers.at(spot.at.as_ivec2()));
        own.map(|i| supports[i]).fold(0.0, f32::max)
    };
    lines.iter().map(of_line).collect()
}

/// The number of every crest, by pixel.
struct CrestNumbers {
    size: [usize; 2],
    /// Counted from 1; 0 for none.
    numbers: Vec<u32>,
}

impl CrestNumbers {
    fn of(crests: &[Crest], size: [usize; 2]) -> Self {
        let mut numbers = vec![0; size[0] * size[1]];
        for (number, crest) in (1..).zip(crests) {
            numbers[crest.pixel as usize] = number;
        }
        Self { size, numbers }
    }

    /// The number of the crest of a pixel, if it has one.
    fn at(&self, pixel: IVec2) -> Option<usize> {
        let [x, y] = pixel.to_array().map(|i| i as usize);
        let is_inside = x < self.size[0] && y < self.size[1];
        let number = is_inside.then(|| self.numbers[y * self.size[0] + x] as usize)?;
        number.checked_sub(1)
    }

    /// The numbers of the crests around one.
    fn beside(&self, crest: &Crest) -> impl Iterator<Item = usize> {
        let (pixel, width) = (crest.pixel as i32, self.size[0] as i32);
        let own = IVec2::new(pixel % width, pixel / width);
        STEPS
            .iter()
            .filter_map(move |&step| self.at(own + IVec2::from(step)))
    }
}

/// Connected sets of crests, of at least `fewest`, with one at least as strong as `strength`.
fn plain(crests: &[Crest], size: [usize; 2], strength: f32, fewest: usize) -> Vec<Crest> {
    let numbers = CrestNumbers::of(crests, size);
    let mut sets = Sets::new(crests.len());
    for (i, crest) in crests.iter().enumerate() {
        numbers
            .beside(crest)
            .filter(|&other| other < i)
            .for_each(|other| sets.unite(i, other));
    }
    let mut found = vec![(0, false); crests.len()];
    for (i, crest) in crests.iter().enumerate() {
        let (count, is_strong) = &mut found[sets.of(i)];
        (*count, *is_strong) = (*count + 1, *is_strong || crest.strength >= strength);
    }
    let kept = crests.iter().enumerate().filter(|&(i, _)| {
        let (count, is_strong) = found[sets.of(i)];
        is_strong && count >= fewest
    });
    kept.map(|(_, &crest)| crest).collect()
}
