//! Polylines through places known to within a pixel: their smooth course, length and direction.

use super::smoothing::{Parabola, Smoothing};
use super::straight::straighten;
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Points to either side that may be looked at together: each a third more than the one before.
const REACHES: [usize; 15] = [1, 2, 3, 4, 5, 7, 9, 12, 16, 21, 28, 38, 51, 68, 100];

/// The smooth version of a polyline whose points deviate by up to the tolerance: steps between pixels vanish, corners
/// stay.
///
/// Points of a straight run move onto its line. Every other point moves onto the least-squares parabola through its
/// neighbours, as many to either side as stay within the tolerance of their parabola: many along a straight line, few around
/// a corner. Adjacent points use nearly equal ranges, so that the line shows no seam.
pub(crate) fn smoothed(points: &[Vec2], closed: bool, smoothing: Smoothing) -> Vec<Vec2> {
    let allowed = REACHES.partition_point(|&reach| reach <= smoothing.reach);
    if points.len() < 3 || allowed == 0 {
        return points.to_vec();
    }
    let line = Wrapped::new(points, closed, REACHES[allowed - 1]);
    let n = points.len();
    let fits = |i: usize, level: usize| {
        line.fits(line.window(i, REACHES[level]), smoothing.tolerance_px())
    };
    let mut levels: Vec<usize> = (0..n)
        .map(|i| largest(allowed, |level| fits(i, level)))
        .collect();
    // Twice around, so that a closed line has no first point.
    for i in 1..n * (1 + usize::from(closed)) {
        levels[i % n] = levels[i % n].min(levels[(i - 1) % n] + 1);
    }
    for i in (1..n * (1 + usize::from(closed))).rev() {
        levels[(i - 1) % n] = levels[(i - 1) % n].min(levels[i % n] + 1);
    }
    let moved = |(i, &level): (usize, &usize)| match level {
        0 => points[i],
        _ => line.moved(i, REACHES[level - 1]),
    };
    let mut smooth: Vec<Vec2> = levels.iter().enumerate().map(moved).collect();
    if smoothing.is_stepped {
        let reach = REACHES[allowed - 1];
        straighten(&mut smooth, points, (closed, reach), smoothing);
    }
    smooth
}

/// The largest level up to `all` that holds, if every level below one that holds does.
fn largest(all: usize, mut holds: impl FnMut(usize) -> bool) -> usize {
    let (mut least, mut most) = (0, all);
    while least < most {
        let level = usize::midpoint(least, most);
        if holds(level) {
            least = level + 1;
        } else {
            most = level;
        }
    }
    least
}

/// The points of a line, a closed one continued beyond its ends.
struct Wrapped {
    x: Vec<f32>,
    y: Vec<f32>,
    /// Start of the line's own points.
    start: usize,
}

impl Wrapped {
    fn new(points: &[Vec2], closed: bool, reach: usize) -> Self {
        let n = points.len();
        let start = if closed { reach.min(n) } else { 0 };
        let wrapped = (0..n + 2 * start).map(|i| points[(i + n - start) % n]);
        let (x, y) = wrapped.map(|point| (point.x, point.y)).unzip();
        Self { x, y, start }
    }

    /// The points within `reach` of the line's point `i`.
    fn window(&self, i: usize, reach: usize) -> Range<usize> {
        let at = self.start + i;
        at.saturating_sub(reach)..(at + reach + 1).min(self.x.len())
    }

    /// The line's point `i` on the parabola through those within `reach`.
    fn moved(&self, i: usize, reach: usize) -> Vec2 {
        let window = self.window(i, reach);
        let at = [&self.x, &self.y].map(|samples| {
            let parabola = Parabola::through(&samples[window.clone()]);
            parabola.at((self.start + i - window.start) as f32 - parabola.half)
        });
        at.into()
    }

    /// Whether all points of a window lie within the tolerance of their parabola.
    fn fits(&self, window: Range<usize>, tolerance: f32) -> bool {
        let [x, y] = [&self.x, &self.y].map(|samples| &samples[window.clone()]);
        let (along_x, along_y) = (Parabola::through(x), Parabola::through(y));
        x.iter().zip(y).enumerate().all(|(k, (x, y))| {
            let t = k as f32 - along_x.half;
            let (slope_x, slope_y) = (along_x.slope(t), along_y.slope(t));
            let across = slope_x * (y - along_y.at(t)) - slope_y * (x - along_x.at(t));
            let squared = slope_x * slope_x + slope_y * slope_y;
            across * across <= tolerance * tolerance * squared
        })
    }
}

/// The mean of the values up to `reach` away along a line.
pub(crate) fn evened(values: &[f32], closed: bool, reach: usize) -> Vec<f32> {
    let n = values.len();
    let reach = reach.min(n.saturating_sub(1) / 2);
    if closed {
        let at = |i: usize| values[i % n];
        let window = 2 * reach + 1;
        let mean =
            |i: usize| (0..window).map(|j| at(i + n + j - reach)).sum::<f32>() / window as f32;
        return (0..n).map(mean).collect();
    }
    (0..n)
        .map(|i| {
            let part = &values[i.saturating_sub(reach)..(i + reach + 1).min(n)];
            part.iter().sum::<f32>() / part.len() as f32
        })
        .collect()
}

/// The lengths from the first point to every point, along the line.
pub(crate) fn lengths(points: &[Vec2]) -> Vec<f32> {
    let mut length = 0.0;
    let mut before = None;
    points
        .iter()
        .map(|&point| {
            length += before.map_or(0.0, |before: Vec2| before.distance(point));
            before = Some(point);
            length
        })
        .collect()
}

/// The length of a line.
pub(crate) fn length(points: &[Vec2], closed: bool) -> f32 {
    let open = lengths(points).pop().unwrap_or(0.0);
    match (closed, points) {
        (true, [first, .., last]) => open + first.distance(*last),
        _ => open,
    }
}

/// The points of a line with half its width at each as the third coordinate: thinned, it keeps its swelling.
pub(crate) fn with_radii(points: &[Vec2], widths: &[f32]) -> Vec<Vec3> {
    let swelling = points.iter().zip(widths);
    swelling.map(|(at, width)| at.extend(0.5 * width)).collect()
}

/// Indices of the points needed for a line to pass within `tolerance_px` of all of them, omitting at most `most` in a
/// row.
pub(crate) fn thinned(points: &[Vec3], tolerance_px: f32, most: usize) -> Vec<usize> {
    let mut kept = vec![0];
    let mut from = 0;
    while from + 1 < points.len() {
        let within = |to: usize| {
            let chord = (points[to] - points[from]).normalize_or_zero();
            (from + 1..to).all(|i| {
                let offset = points[i] - points[from];
                let along = offset.dot(chord);
                (offset - along * chord).length_squared() <= tolerance_px * tolerance_px
                    && along >= 0.0
            })
        };
        let last = (from + 1 + most).min(points.len() - 1);
        let mut to = from + 1;
        while to < last && within(to + 1) {
            to += 1;
        }
        kept.push(to);
        from = to;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMOOTHING: Smoothing = Smoothing {
        step_px: 1.0,
        tolerance: 0.6,
        reach: 28,
        is_stepped: true,
    };

    /// Middles of the cracks along a line y = slope x, as pixels show it.
    fn steps(slope: f64, length: usize) -> Vec<Vec2> {
        let level = |x: usize| (slope * (x as f64 + 0.5)).round();
        let mut points = Vec::new();
        for x in 0..length {
            points.push(Vec2::new(x as f32 + 0.5, level(x) as f32));
            if level(x + 1) > level(x) {
                points.push(Vec2::new(x as f32 + 1.0, level(x) as f32 + 0.5));
            }
        }
        points
    }

    #[test]
    fn steps_between_pixels_become_a_straight_line() {
        for slope in [0.0, 0.07, 0.2, 0.37, 0.5, 0.81, 0.97] {
            let across = |p: Vec2| (f64::from(p.y) - slope * f64::from(p.x)) / slope.hypot(1.0);
            let smooth = smoothed(&steps(slope, 200), false, SMOOTHING);
            let worst = |part: &[Vec2]| part.iter().map(|&p| across(p).abs()).fold(0.0, f64::max);
            // Centres of cracks are up to half a pixel off the line. A line of slope 0.07 has a step in 14 pixels, one
            // of slope 0.97 a longer one in 33: beyond the reach of 28 points, so some of it remains.
            assert!(worst(&smooth) < 0.5, "slope {slope}: {}", worst(&smooth));
            let inner = worst(&smooth[30..smooth.len() - 30]);
            assert!(inner < 0.25, "slope {slope}: {inner}");
        }
    }

    #[test]
    fn a_parabola_stays_and_a_corner_stays_within_a_pixel() {
        let parabola: Vec<Vec2> = (0..40)
            .map(|i| Vec2::new(i as f32, 0.01 * (i * i) as f32))
            .collect();
        for (p, q) in smoothed(&parabola, false, SMOOTHING).iter().zip(&parabola) {
            assert!(p.distance(*q) < 1e-3);
        }
        let corner: Vec<Vec2> = (0..41)
            .map(|i| Vec2::new(i.min(20) as f32, (i.max(20) - 20) as f32))
            .collect();
        let nearest = smoothed(&corner, false, SMOOTHING)
            .iter()
            .map(|p| p.distance(Vec2::new(20.0, 0.0)))
            .fold(f32::INFINITY, f32::min);
        assert!(nearest < 1.0, "{nearest}");
    }

    #[test]
    fn a_closed_line_has_no_first_point() {
        let square: Vec<Vec2> = (0..80)
            .map(|i| {
                let along = (i % 20) as f32;
                match i / 20 {
                    0 => Vec2::new(along, 0.0),
                    1 => Vec2::new(20.0, along),
                    2 => Vec2::new(20.0 - along, 20.0),
                    _ => Vec2::new(0.0, 20.0 - along),
                }
            })
            .collect();
        let smooth = smoothed(&square, true, SMOOTHING);
        let turned: Vec<Vec2> = square.iter().cycle().skip(33).take(80).copied().collect();
        let turned = smoothed(&turned, true, SMOOTHING);
        for (i, p) in turned.iter().enumerate() {
            assert!(p.distance(smooth[(i + 33) % 80]) < 1e-4);
        }
    }

    #[test]
    fn thinned_lines_pass_all_their_points() {
        let arc: Vec<Vec2> = (0..100)
            .map(|i| 30.0 * Vec2::from_angle(i as f32 / 30.0))
            .collect();
        let arc = with_radii(&arc, &[1.0; 100]);
        let kept = thinned(&arc, 0.05, 64);
        assert!(
            kept.len() < 40 && kept[0] == 0 && kept.last() == Some(&99),
            "{kept:?}"
        );
        // The sagitta of an arc over s pixels is s^2/(8 R) = 0.05 for s = 3.5.
        assert!(kept.windows(2).all(|pair| pair[1] - pair[0] <= 4));
        assert_eq!(thinned(&arc[..1], 0.05, 64), [0]);
        // Straight, with half widths of 0, 1, 2, 1, 0: the middle stays.
        let points: Vec<Vec2> = (0..5).map(|i| Vec2::new(i as f32, 0.0)).collect();
        let swelling = with_radii(&points, &[0.0, 2.0, 4.0, 2.0, 0.0]);
        assert_eq!(thinned(&swelling, 0.05, 64), [0, 2, 4]);
    }

    #[test]
    fn lengths_and_means_along_a_line() {
        let line = [Vec2::ZERO, Vec2::new(3.0, 4.0), Vec2::new(3.0, 0.0)];
        assert_eq!(lengths(&line), [0.0, 5.0, 9.0]);
        assert_eq!((length(&line, false), length(&line, true)), (9.0, 12.0));
        assert_eq!(evened(&[0.0, 3.0, 0.0], true, 1), [1.0; 3]);
        assert_eq!(evened(&[0.0, 3.0, 0.0], false, 1), [1.5, 1.0, 1.5]);
    }
}
