//! The directions of x and y of a normal map, from the rims in it: ahead of a rim, the way its normals point, the map breaks
//! off to what lies behind, and on the near side the surface turns smoothly. Neither coverage nor depth is needed.
//!
//! Limits: hollow forms turn the other way, and maps enlarged from much smaller ones break off nowhere.

use super::integrability::Curl;
use crate::frame::{Mask, Vector3Planes};
use glam::DVec3;

/// Pixels that are looked at, about.
const PIXELS: usize = 2_000_000;
/// A unit normal leans along an axis from this component on.
const STEEP: f64 = 0.6;
/// Normals at this many steps are compared.
const REACH: isize = 3;
/// On one side they differ by more than the first of these, on the other by less than the second.
const BREAKS: f64 = 0.6;
const TURNS: f64 = 0.35;
/// Steps in pixels: the first is taken at which there are rims.
const STEPS: [isize; 2] = [1, 2];
/// Fewest rims along an axis, and the least of their mean vote, from -1 to 1.
const FEWEST: usize = 60;
const LEAST_VOTE: f64 = 0.3;
/// The same for an axis without the other one's support.
const FEWEST_ALONE: usize = 200;
const LEAST_VOTE_ALONE: f64 = 0.5;
/// Fewest rims along an axis that are worth a doubt.
const FEWEST_DOUBTS: usize = 20;
/// So many rims that face one way do not contradict those that face the other.
const FEWEST_OF_A_SIDE: usize = 30;

/// Rims, by axis, by whether their normals point along it or against, and by whether the map breaks off behind or ahead.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rims([[[usize; 2]; 2]; 2]);

impl Rims {
    /// Looks at unit normals of view space. What is not covered lies behind everything.
    pub(crate) fn of(normal: &Vector3Planes, mask: &Mask) -> Self {
        let mut rims = Self::default();
        for step in STEPS {
            rims = Self::at(normal, mask, step);
            if [0, 1].iter().any(|&axis| rims.count(axis) >= FEWEST) {
                break;
            }
        }
        rims
    }

    fn at(normal: &Vector3Planes, mask: &Mask, step: isize) -> Self {
        let map = SteppedMap { normal, mask, step };
        let (width, height) = (mask.width() as isize, mask.height() as isize);
        let margin = (REACH + 2) * step;
        let every = (mask.width() * mask.height())
            .div_ceil(PIXELS)
            .next_multiple_of(step as usize);
        let mut rims = Self::default();
        for y in (margin..height - margin).step_by(every) {
            for x in (margin..width - margin).step_by(step as usize) {
                rims.look(&map, x, y);
            }
        }
        rims
    }

    fn look(&mut self, map: &SteppedMap, x: isize, y: isize) {
        // Smoothing lowers a component; what leans far less is not worth it.
        let stored = map.stored(x, y);
        let Some(stored) = stored.filter(|n| n.truncate().abs().max_element() > 0.8 * STEEP) else {
            return;
        };
        let here = map.smoothed(x, y);
        for axis in [0, 1] {
            if here[axis].abs() <= STEEP || stored[axis] * here[axis] < 0.0 {
                continue;
            }
            let is_along = here[axis] > 0.0;
            let reach = REACH * map.step * if is_along { 1 } else { -1 };
            // Rows go down, and y up.
            let [ahead, behind] = [reach, -reach].map(|reach| match axis {
                0 => map.smoothed(x + reach, y),
                _ => map.smoothed(x, y - reach),
            });
            let (ahead, behind) = (ahead.distance(here), behind.distance(here));
            if ahead.max(behind) > BREAKS && ahead.min(behind) < TURNS {
                self.0[axis][usize::from(is_along)][usize::from(ahead > behind)] += 1;
            }
        }
    }

    fn count(&self, axis: usize) -> usize {
        self.0[axis].as_flattened().iter().sum()
    }

    /// The mean vote on an axis: 1 where the map breaks off ahead of all rims, -1 where it does behind all.
    fn vote(&self, axis: usize) -> f64 {
        let against: usize = self.0[axis].iter().map(|side| side[0]).sum();
        let count = self.count(axis).max(1) as f64;
        1.0 - 2.0 * against as f64 / count
    }

    /// Whether an axis is reversed, from so many rims with such a mean vote on; `None` where they tell too little.
    fn reversed(&self, axis: usize, fewest: usize, least_vote: f64) -> Option<bool> {
        let vote = self.vote(axis);
        let contradicts = |&[behind, ahead]: &[usize; 2]| {
            let most_against = if vote > 0.0 {
                behind > ahead
            } else {
                ahead > behind
            };
            behind + ahead >= FEWEST_OF_A_SIDE && most_against
        };
        let shows = self.count(axis) >= fewest && vote.abs() >= least_vote;
        (shows && !self.0[axis].iter().any(contradicts)).then_some(vote < 0.0)
    }

    /// Whether x and y are reversed; `None` where too little shows it, or the curl contradicts it. Of one axis alone the other
    /// follows by the curl.
    pub(crate) fn show(&self, curl: &Curl) -> Option<[bool; 2]> {
        let both = [0, 1].map(|axis| self.reversed(axis, FEWEST, LEAST_VOTE));
        if let [Some(x), Some(y)] = both {
            return Some([x, y]).filter(|axes| curl.allows(*axes));
        }
        let one = curl.y_points_down()?;
        // Many rims along the other axis that tell nothing are those of letters and steps, which have two sides.
        let is_alone = |axis: usize| self.count(1 - axis) < FEWEST;
        let alone = [0, 1].map(|axis| {
            let reversed = self.reversed(axis, FEWEST_ALONE, LEAST_VOTE_ALONE);
            reversed.filter(|_| is_alone(axis))
        });
        match alone {
            [Some(x), None] => Some([x, x != one]),
            [None, Some(y)] => Some([y != one, y]),
            _ => None,
        }
    }

    /// Whether rims, too few to tell, speak against an axis as stored.
    pub(crate) fn speak_against(&self) -> bool {
        let against = |axis| self.count(axis) >= FEWEST_DOUBTS && self.vote(axis) <= -LEAST_VOTE;
        [0, 1].into_iter().any(against)
    }

    /// The votes, as the tail of a sentence.
    pub(crate) fn numbers(&self) -> String {
        let [x, y] = [0, 1].map(|axis| format!("{:+.2} of {}", self.vote(axis), self.count(axis)));
        format!("rims vote {x} along x, {y} along y")
    }
}

/// A normal map looked at in steps of pixels.
struct SteppedMap<'a> {
    normal: &'a Vector3Planes,
    mask: &'a Mask,
    step: isize,
}

impl SteppedMap<'_> {
    fn stored(&self, x: isize, y: isize) -> Option<DVec3> {
        let (x, y) = (x as usize, y as usize);
        self.mask.at(x, y).then(|| self.normal.at(x, y))
    }

    /// The mean around a pixel, by the binomial weights of five steps; zero counts where nothing is covered.
    fn smoothed(&self, x: isize, y: isize) -> DVec3 {
        const WEIGHTS: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
        let mut sum = DVec3::ZERO;
        for (j, down) in WEIGHTS.iter().enumerate() {
            for (i, across) in WEIGHTS.iter().enumerate() {
                let [right, below] = [i, j].map(|at| (at as isize - 2) * self.step);
                let n = self.stored(x + right, y + below);
                sum += n.unwrap_or(DVec3::ZERO) * (down * across / 256.0);
            }
        }
        sum
    }
}
