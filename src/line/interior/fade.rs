//! Fading of lines in a sequence: a continuous form of the thresholds for drawing them.

use crate::line::interior::crests::Crest;
use crate::line::smooth_step::smooth_step;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Multiple of its threshold from which strength, or its persistent part, gives a line in full.
const FULL_STRENGTH: f32 = 1.5;

/// Multiple of the required length and worth from which a line is drawn in full.
const FULL_SIZE: f32 = 2.0;

/// Share of the length that all lines may have at whose end lines begin to fade.
const SPENT: f32 = 0.85;

/// The share of the full width, 0..1, for a strength of so many times its threshold.
pub(super) fn by_strength(times: f32) -> f32 {
    smooth_step([1.0, FULL_STRENGTH], times)
}

/// Share of the full width, 0..1, for a length or a worth of so many times the required one.
pub(super) fn by_size(times: f32) -> f32 {
    smooth_step([1.0, FULL_SIZE], times)
}

/// The share of its width, 0..1, of the line that brings all lines so far to this share of the length they may have.
pub(super) fn by_budget(spent: f32) -> f32 {
    smooth_step([1.0, SPENT], spent)
}

/// Support of each of these crests, 0..1: hysteresis between two thresholds without its step. A crest well over the
/// upper one supports itself; others are supported along the chain of crests `beside` each other whose weakest link is
/// strongest, and a link that hardly exceeds the lower threshold passes nothing on.
pub(super) fn supports(
    crests: &[Crest],
    thresholds: [f32; 2],
    beside: impl Fn(&Crest) -> Vec<usize>,
) -> Vec<f32> {
    let over = |crest: &Crest, i: usize| by_strength(crest.strength / thresholds[i]);
    let mut shares = vec![0.0; crests.len()];
    // The best supported first; above 0 the bits of numbers are in their order.
    let mut waiting = BinaryHeap::new();
    for (number, crest) in crests.iter().enumerate() {
        let share = over(crest, 0).min(over(crest, 1));
        if share > 0.0 {
            shares[number] = share;
            waiting.push((share.to_bits(), Reverse(number)));
        }
    }
    while let Some((share, Reverse(number))) = waiting.pop() {
        let share = f32::from_bits(share);
        if share < shares[number] {
            continue;
        }
        for next in beside(&crests[number]) {
            let passed = share.min(over(&crests[next], 0));
            if passed > shares[next] {
                shares[next] = passed;
                waiting.push((passed.to_bits(), Reverse(next)));
            }
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn support_is_that_of_the_weakest_link_and_has_no_step() {
        // A row of crests between thresholds of 10 and 20: 30 is 1.5 times the upper one, so full. 12.5 is 1.25 times
        // the lower one, half-way, and passes on 0.5; 10 passes nothing on. 20 supports nothing by itself, and is
        // behind it.
        let crests: Vec<Crest> = [15.0, 30.0, 12.5, 18.0, 10.0, 20.0]
            .into_iter()
            .enumerate()
            .map(|(pixel, strength)| Crest {
                pixel: pixel as u32,
                at: Vec2::ZERO,
                strength,
            })
            .collect();
        let beside = |crest: &Crest| {
            let at = crest.pixel as usize;
            let sides = [at.checked_sub(1), Some(at + 1).filter(|&next| next < 6)];
            sides.into_iter().flatten().collect()
        };
        let found = supports(&crests, [10.0, 20.0], beside);
        assert_eq!(found, [1.0, 1.0, 0.5, 0.5, 0.0, 0.0]);
    }

    #[test]
    fn lines_fade_to_nothing_where_they_would_be_dropped() {
        assert_eq!([by_strength(1.0), by_size(1.0), by_budget(1.0)], [0.0; 3]);
        assert_eq!([by_strength(1.5), by_size(2.0), by_budget(0.85)], [1.0; 3]);
    }
}
