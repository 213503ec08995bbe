//! Polylines through places known to within a pixel: their smooth course, length and direction.

use glam::Vec2;

/// Parameters of smoothing a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Smoothing {
    /// Largest deviation of its points from the true line, in pixels.
    pub tolerance_px: f32,
    /// Most points to either side that are looked at together.
    pub reach: usize,
}

/// Points to either side that may be looked at together: each a third more than the one before.
const REACHES: [usize; 15] = [1, 2, 3, 4, 5, 7, 9, 12, 16, 21, 28, 38, 51, 68, 100];

/// The smooth version of a polyline whose points deviate by up to the tolerance: steps between pixels vanish, corners
/// stay.
///
/// Every point moves onto the least-squares parabola through its neighbours, as many to either side as stay within the
/// tolerance of their parabola: many along a straight line, few around a corner. Adjacent points use nearly equal
/// ranges, so that the line shows no seam.
pub(crate) fn smoothed(points: &[Vec2], closed: bool, smoothing: Smoothing) -> Vec<Vec2> {
    let allowed = REACHES.partition_point(|&reach| reach <= smoothing.reach);
    if points.len() < 3 || allowed == 0 {
        return points.to_vec();
    }
    let line = Wrapped::new(points, closed, REACHES[allowed - 1]);
    let mut levels = Vec::with_capacity(points.len());
    for first in (0..points.len()).step_by(LANES) {
        // Neighbours mostly need the same levels.
        let mut fits: [Option<[bool; LANES]>; REACHES.len()] = [None; REACHES.len()];
        for lane in 0..LANES.min(points.len() - first) {
            levels.push(largest(allowed, |level| {
                let reach = REACHES[level];
                match line.has_whole_windows(first, reach) {
                    true => fits[level].get_or_insert_with(|| {
                        line.fit_together(first, reach, smoothing.tolerance_px)
                    })[lane],
                    false => line.fits(first + lane, reach, smoothing.tolerance_px),
                }
            }));
        }
    }
    let n = levels.len();
    // Twice around, so that a closed line has no first point.
    for i in 1..n * (1 + usize::from(closed)) {
        levels[i % n] = levels[i % n].min(levels[(i - 1) % n] + 1);
    }
    for i in (1..n * (1 + usize::from(closed))).rev() {
        levels[(i - 1) % n] = levels[(i - 1) % n].min(levels[i % n] + 1);
    }
    let moved = |(i, &level): (usize, &usize)| match level {
        0 => points[i],
        _ => line.fit(i, REACHES[level - 1]).at(line.start + i),
    };
    levels.iter().enumerate().map(moved).collect()
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

/// Points that are looked at together.
const LANES: usize = 8;

/// The points of a line, a closed one continued beyond its ends.
struct Wrapped {
    points: Vec<Vec2>,
    /// Their coordinates apart.
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
        let points: Vec<Vec2> = wrapped.collect();
        Self {
            x: points.iter().map(|point| point.x).collect(),
            y: points.iter().map(|point| point.y).collect(),
            points,
            start,
        }
    }

    /// The points within `reach` of the line's point `i`: the first and one past the last.
    fn window(&self, i: usize, reach: usize) -> [usize; 2] {
        let at = self.start + i;
        [
            at.saturating_sub(reach),
            (at + reach + 1).min(self.points.len()),
        ]
    }

    fn fit(&self, i: usize, reach: usize) -> Parabola {
        let [from, to] = self.window(i, reach);
        Parabola::through(&self.points[from..to], from)
    }

    /// Whether each of the points processed together from `first` on has `reach` neighbours on either side.
    fn has_whole_windows(&self, first: usize, reach: usize) -> bool {
        let at = self.start + first;
        at >= reach && at + LANES + reach <= self.points.len()
    }

    /// [`Wrapped::fits`] for the points processed together from `first` on, which have whole windows.
    fn fit_together(&self, first: usize, reach: usize, tolerance: f32) -> [bool; LANES] {
        let at = self.start + first;
        let (x, y) = (&self.x[at - reach..], &self.y[at - reach..]);
        let axes = [x, y].map(|samples| Parabolas::through(samples, reach));
        let mean_square = Sums::of(2 * reach + 1).mean_square;
        let mut fit = [true; LANES];
        for k in 0..2 * reach + 1 {
            let t = k as f32 - reach as f32;
            let (x, y): (&[f32; LANES], &[f32; LANES]) = (
                x[k..][..LANES].try_into().expect("of this length"),
                y[k..][..LANES].try_into().expect("of this length"),
            );
            for lane in 0..LANES {
                let middle = |axis: usize| axes[axis].at(lane, t, mean_square);
                let slope = |axis: usize| axes[axis].slope(lane, t);
                let (slope_x, slope_y) = (slope(0), slope(1));
                let across = slope_x * (y[lane] - middle(1)) - slope_y * (x[lane] - middle(0));
                let squared = slope_x * slope_x + slope_y * slope_y;
                fit[lane] &= across * across <= tolerance * tolerance * squared;
            }
        }
        fit
    }

    /// Whether all points within `reach` of point `i` lie within the tolerance of their parabola.
    fn fits(&self, i: usize, reach: usize, tolerance: f32) -> bool {
        let [from, to] = self.window(i, reach);
        let parabola = Parabola::through(&self.points[from..to], from);
        let near = |j: usize| {
            let across = parabola.slope(j).perp_dot(self.points[j] - parabola.at(j));
            across * across <= tolerance * tolerance * parabola.slope(j).length_squared()
        };
        (from..to).all(near)
    }
}

/// Sums over t = -half, -half + 1, ... half, n points: of t^2 it is n (n^2 - 1)/12, and of (t^2 - mean)^2 n (n^2 -
/// 1)(n^2 - 4)/180.
struct Sums {
    squares: f32,
    fourths: f32,
    mean_square: f32,
}

impl Sums {
    fn of(points: usize) -> Self {
        let n = points as f32;
        let squares = n * (n * n - 1.0) / 12.0;
        Self {
            squares,
            fourths: n * (n * n - 1.0) * (n * n - 4.0) / 180.0,
            mean_square: squares / n,
        }
    }
}

/// One coordinate of parabolas through several windows, each a point further, by the same operations as [`Parabola`]
/// uses for both.
struct Parabolas([[f32; LANES]; 3]);

impl Parabolas {
    fn through(samples: &[f32], reach: usize) -> Self {
        let window = |k: usize| -> &[f32; LANES] {
            samples[k..][..LANES].try_into().expect("of this length")
        };
        let count = 2 * reach + 1;
        let sums = Sums::of(count);
        let origin = window(0);
        let (mut constant, mut linear, mut bent) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..count {
            let t = k as f32 - reach as f32;
            let samples = window(k);
            for lane in 0..LANES {
                let p = samples[lane] - origin[lane];
                constant[lane] += p;
                linear[lane] += t * p;
                bent[lane] += (t * t - sums.mean_square) * p;
            }
        }
        let n = count as f32;
        Self([
            std::array::from_fn(|lane| origin[lane] + constant[lane] / n),
            linear.map(|sum| sum / sums.squares),
            bent.map(|sum| sum / sums.fourths),
        ])
    }

    #[inline]
    fn at(&self, lane: usize, t: f32, mean_square: f32) -> f32 {
        let [a, b, c] = &self.0;
        a[lane] + t * b[lane] + (t * t - mean_square) * c[lane]
    }

    #[inline]
    fn slope(&self, lane: usize, t: f32) -> f32 {
        self.0[1][lane] + 2.0 * t * self.0[2][lane]
    }
}

/// The parabola of least squares through points that follow each other evenly.
struct Parabola {
    middle: f32,
    mean_square: f32,
    /// Coefficients of 1, t and t^2 - mean(t^2), which are orthogonal; t counts points from the middle.
    coefficients: [Vec2; 3],
}

impl Parabola {
    fn through(points: &[Vec2], from: usize) -> Self {
        let n = points.len() as f32;
        let half = 0.5 * (n - 1.0);
        let Sums {
            squares,
            fourths,
            mean_square,
        } = Sums::of(points.len());
        // Relative to the first point: differences keep their digits far from the origin.
        let origin = points[0];
        let (mut constant, mut linear, mut bent) = (Vec2::ZERO, Vec2::ZERO, Vec2::ZERO);
        let mut t = -half;
        for &point in points {
            let p = point - origin;
            constant += p;
            linear += t * p;
            bent += (t * t - mean_square) * p;
            t += 1.0;
        }
        let over = |sum: Vec2, squares: f32| {
            if squares > 0.0 {
                sum / squares
            } else {
                Vec2::ZERO
            }
        };
        Self {
            middle: from as f32 + half,
            mean_square,
            coefficients: [
                origin + constant / n,
                over(linear, squares),
                over(bent, fourths),
            ],
        }
    }

    fn at(&self, i: usize) -> Vec2 {
        let t = i as f32 - self.middle;
        let [a, b, c] = self.coefficients;
        a + t * b + (t * t - self.mean_square) * c
    }

    fn slope(&self, i: usize) -> Vec2 {
        let t = i as f32 - self.middle;
        self.coefficients[1] + 2.0 * t * self.coefficients[2]
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
    let open: f32 = points
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .sum();
    match (closed, points) {
        (true, [first, .., last]) => open + first.distance(*last),
        _ => open,
    }
}

/// Indices of the points needed for a line to pass within `tolerance_px` of all of them, omitting at most `most` in a
/// row.
pub(crate) fn thinned(points: &[Vec2], tolerance_px: f32, most: usize) -> Vec<usize> {
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
        tolerance_px: 0.6,
        reach: 28,
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
    fn neighbours_told_together_fit_as_each_alone() {
        let points: Vec<Vec2> = (0..400)
            .map(|i| {
                let t = i as f32 / 40.0;
                300.0 * Vec2::new(t.cos(), t.sin())
                    + 0.7 * Vec2::new((9.1 * t).sin(), (7.3 * t).cos())
            })
            .collect();
        let line = Wrapped::new(&points, false, 100);
        let mut found = [0; 2];
        for reach in REACHES {
            for first in reach..points.len() - reach - LANES {
                assert!(line.has_whole_windows(first, reach));
                let together = line.fit_together(first, reach, SMOOTHING.tolerance_px);
                let alone = |lane| line.fits(first + lane, reach, SMOOTHING.tolerance_px);
                assert_eq!(
                    together,
                    std::array::from_fn(alone),
                    "{reach} around {first}"
                );
                found[usize::from(together[0])] += 1;
            }
        }
        assert!(found.iter().all(|&count| count > 100), "{found:?}");
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
        let kept = thinned(&arc, 0.05, 64);
        assert!(
            kept.len() < 40 && kept[0] == 0 && kept.last() == Some(&99),
            "{kept:?}"
        );
        // The sagitta of an arc over s pixels is s^2/(8 R) = 0.05 for s = 3.5.
        assert!(kept.windows(2).all(|pair| pair[1] - pair[0] <= 4));
        assert_eq!(thinned(&arc[..1], 0.05, 64), [0]);
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
