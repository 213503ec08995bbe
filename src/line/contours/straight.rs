//! Straight runs of polylines: a line that is nearly level or upright has its steps between pixels so far apart that curves
//! through a few of them follow the steps.

use super::smoothing::{Parabola, Smoothing};
use crate::line::smooth_step::smooth_step;
use glam::Vec2;
use std::ops::Range;

/// Shortest straight run, as a multiple of the points that are otherwise looked at together.
const SHORTEST: f32 = 1.5;

/// Most that the middle of a straight run is off its ends, in steps between pixels. Runs of an arc that stay within the
/// tolerance are off by more than 0.35, and those of a line of any slope by less than 0.15.
const BENT: f32 = 0.2;

/// Distance from the end of a run over which points move onto it, in steps.
const ONTO: f32 = 8.0;

/// Rounding of places, as a share of a step.
const ROUNDING: f32 = 1e-3;

/// How often the slopes that the narrowest band may have are cut to two thirds: to a millionth.
const THIRDS: usize = 34;

/// A line through points, and how far these are off it.
struct Straight {
    middle: Vec2,
    along: Vec2,
    off: Vec<f32>,
}

impl Straight {
    /// The line of least squares.
    fn through(points: &[Vec2]) -> Self {
        let from = points[0];
        let sum: Vec2 = points.iter().map(|&point| point - from).sum();
        let middle = from + sum / points.len() as f32;
        let twice = |off: Vec2| Vec2::new(off.x * off.x - off.y * off.y, 2.0 * off.x * off.y);
        let sum: Vec2 = points.iter().map(|&point| twice(point - middle)).sum();
        Self::at(middle, Vec2::from_angle(0.5 * sum.to_angle()), points)
    }

    fn at(middle: Vec2, along: Vec2, points: &[Vec2]) -> Self {
        let off = points.iter().map(|&point| along.perp_dot(point - middle));
        Self {
            middle,
            along,
            off: off.collect(),
        }
    }

    /// The middle of the narrowest band around the points: the width is convex in the slope.
    fn amid(&self, points: &[Vec2]) -> Self {
        let along = |point: &Vec2| self.along.dot(*point - self.middle);
        let places: Vec<f32> = points.iter().map(along).collect();
        let ends = |slope: f32| range(self.off.iter().zip(&places).map(|(off, a)| off - slope * a));
        let width = |slope: f32| ends(slope)[1] - ends(slope)[0];
        let [first, last] = range(places.iter().copied());
        let most = 2.0 * width(0.0) / (last - first);
        let mut slopes = [-most, most];
        for _ in 0..THIRDS {
            let third = (slopes[1] - slopes[0]) / 3.0;
            let [low, high] = [slopes[0] + third, slopes[1] - third];
            slopes = match width(low) < width(high) {
                true => [slopes[0], high],
                false => [low, slopes[1]],
            };
        }
        let slope = 0.5 * (slopes[0] + slopes[1]);
        let [low, high] = ends(slope);
        let middle = self.middle + 0.5 * (low + high) * self.along.perp();
        let along = (self.along + slope * self.along.perp()).normalize();
        Self::at(middle, along, points)
    }

    /// The line that points are on the way along, if there is one: stairs between pixels that a line could have made are
    /// within one step of it, and have two steps at the least.
    fn of_run(points: &[Vec2], smoothing: Smoothing) -> Option<Self> {
        let step = smoothing.step_px;
        let line = Self::through(points);
        let is_bent = Parabola::through(&line.off).rise() >= BENT * step;
        let [wide, high] = [
            range(points.iter().map(|at| at.x)),
            range(points.iter().map(|at| at.y)),
        ];
        let climbs = f32::min(wide[1] - wide[0], high[1] - high[0]);
        if !smoothing.is_stepped || climbs < 1.5 * step {
            return (!is_bent).then_some(line);
        }
        let amid = line.amid(points);
        let steepness = amid.along.abs().max_element();
        match amid.is_within((1.0 + ROUNDING) * steepness * step) {
            true => Some(amid),
            false => (!is_bent).then_some(line),
        }
    }

    fn is_within(&self, band: f32) -> bool {
        let [least, most] = range(self.off.iter().copied());
        most - least <= band
    }
}

/// The least and the largest of values.
fn range(values: impl Iterator<Item = f32>) -> [f32; 2] {
    values.fold(
        [f32::INFINITY, f32::NEG_INFINITY],
        |[least, most], value| [least.min(value), most.max(value)],
    )
}

/// Moves those of `smooth`, the smooth places of `points`, that lie in straight runs onto a straight line.
pub(super) fn straighten(
    smooth: &mut [Vec2],
    points: &[Vec2],
    (closed, reach): (bool, usize),
    smoothing: Smoothing,
) {
    let shortest = (SHORTEST * (2 * reach + 1) as f32) as usize;
    for (run, line) in runs(points, shortest, smoothing) {
        // From the ends of a line all of it is straight.
        let is_bent = [run.start > 0, run.end < points.len()].map(|is_inside| closed || is_inside);
        for i in run.clone() {
            let ends = [i - run.start, run.end - 1 - i].into_iter().zip(is_bent);
            let near = ends
                .filter_map(|(steps, is_bent)| is_bent.then_some(steps))
                .min();
            let share = near.map_or(1.0, |steps| steps as f32 / (ONTO * smoothing.step_px));
            let foot = line.middle + line.along * line.along.dot(points[i] - line.middle);
            smooth[i] = smooth[i].lerp(foot, smooth_step([0.0, 1.0], share));
        }
    }
}

/// The straight runs of so many points at the least.
fn runs(points: &[Vec2], shortest: usize, smoothing: Smoothing) -> Vec<(Range<usize>, Straight)> {
    let is_straight = |run: &Range<usize>| {
        let band = 2.0 * smoothing.tolerance_px();
        run.end <= points.len() && Straight::through(&points[run.clone()]).is_within(band)
    };
    let mut runs: Vec<(Range<usize>, Straight)> = Vec::new();
    let mut from = 0;
    while from + shortest <= points.len() {
        let mut run = from..from + shortest;
        from += (shortest / 8).max(1);
        if !is_straight(&run) {
            continue;
        }
        // As far as it goes on and back, by leaps that get shorter: parts of an arc may be straight.
        let first = runs.last().map_or(0, |(before, _)| before.end);
        let mut leap = shortest;
        while leap > 0 {
            let back = run.start.saturating_sub(leap).max(first)..run.end;
            let longer = [run.start..run.end + leap, back].into_iter();
            match longer
                .filter(|longer| longer.len() > run.len())
                .find(is_straight)
            {
                Some(longer) => run = longer,
                None => leap /= 2,
            }
        }
        if let Some(line) = Straight::of_run(&points[run.clone()], smoothing) {
            from = run.end;
            runs.push((run, line));
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::polyline::smoothed;

    /// Middles of the cracks between pixels along the edge below a height over columns.
    fn cracks(columns: usize, height: impl Fn(f32) -> f32) -> Vec<Vec2> {
        let mut points: Vec<Vec2> = Vec::new();
        let mut before = height(0.5).round();
        for x in 0..columns {
            let here = height(x as f32 + 0.5).round();
            while before != here {
                let next = before + (here - before).signum();
                points.push(Vec2::new(x as f32, 0.5 * (before + next)));
                before = next;
            }
            points.push(Vec2::new(x as f32 + 0.5, here));
        }
        points
    }

    fn rms(points: &[Vec2], height: impl Fn(f32) -> f32) -> f32 {
        let squares = points.iter().map(|at| (at.y - height(at.x)).powi(2));
        (squares.sum::<f32>() / points.len() as f32).sqrt()
    }

    #[test]
    fn a_horizon_is_straight_and_an_arc_stays_one() {
        let smoothing = Smoothing {
            step_px: 1.0,
            tolerance: 0.6,
            reach: 24,
            is_stepped: true,
        };
        for degrees in [0.5_f32, 1.0, 1.5, 3.0, 7.0, 20.0] {
            let height = |x: f32| 100.3 + x * degrees.to_radians().tan();
            let smooth = smoothed(&cracks(640, height), false, smoothing);
            let off = rms(&smooth, height);
            // Steps between pixels are off by 1/sqrt(12) = 0.29.
            assert!(off < 0.08, "{degrees} {off}");
        }
        // Two steps: all lines through such stairs are within a fiftieth of the middle one.
        let height = |x: f32| 100.6 + x / 55.0;
        let off = rms(&smoothed(&cracks(145, height), false, smoothing), height);
        assert!(off < 0.02, "{off}");
        for radius in [160.0_f32, 1000.0, 3000.0] {
            let height = |x: f32| (radius * radius - (x - 320.0).powi(2)).max(0.0).sqrt();
            let arc = |x: f32| 100.0 + radius - height(x);
            let inside = |points: Vec<Vec2>| -> Vec<Vec2> {
                points
                    .into_iter()
                    .filter(|at| (at.x - 320.0).abs() < 100.0)
                    .collect()
            };
            let points = inside(cracks(640, arc));
            assert_eq!(runs(&points, 64, smoothing).len(), 0, "{radius}");
        }
    }

    #[test]
    fn a_corner_between_straight_runs_stays() {
        // Two sides of a box, 1 degree down and 1 degree off upright: their corner is at most as round as without.
        let slope = 1.0_f32.to_radians().tan();
        let level = cracks(300, |x| 50.0 + slope * x);
        let corner = level[level.len() - 1];
        let upright = cracks(300, |y| slope * y);
        let upright = upright
            .iter()
            .map(|at| corner + Vec2::new(0.5 - at.y, at.x));
        let points: Vec<Vec2> = level.iter().copied().chain(upright).collect();
        let smoothing = Smoothing {
            step_px: 1.0,
            tolerance: 0.6,
            reach: 24,
            is_stepped: true,
        };
        let found = runs(&points, 64, smoothing);
        assert_eq!(found.len(), 2);
        let smooth = smoothed(&points, false, smoothing);
        let tip = Vec2::new(300.0, 50.0 + 300.0 * slope);
        let nearest = smooth
            .iter()
            .map(|at| at.distance(tip))
            .fold(f32::INFINITY, f32::min);
        assert!(nearest < 1.0, "{nearest}");
    }
}
