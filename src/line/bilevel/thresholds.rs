//! Local thresholds between black and white.

use crate::frame::Plane;

/// Side of the squares that greys are counted in, in pixels.
const SIDE: usize = 8;

/// Parts of 0..1 that greys are counted by.
const PARTS: usize = 32;

/// Weights of neighbouring squares along one axis: effectively three squares, 24 pixels, the distance between strokes
/// of a large drawing. Fewer follow single strokes, more lose light parts beside dark ones.
const WEIGHTS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Between all grey that is black and all that is white, where nothing is grey.
const MIDDLE: f32 = 0.5;

/// Thresholds that keep the local mean: the share of grey above them equals the light in it.
pub(super) struct Thresholds {
    /// One for each square.
    of_squares: Plane,
}

/// The greys of a square.
#[derive(Clone, Copy)]
struct Greys {
    /// Counts of greys in each part of 0..1.
    counts: [f32; PARTS],
    /// Their sum.
    sum: f32,
}

impl Greys {
    const NONE: Self = Self {
        counts: [0.0; PARTS],
        sum: 0.0,
    };

    fn add(&mut self, grey: f32) {
        self.counts[((grey * PARTS as f32) as usize).min(PARTS - 1)] += 1.0;
        self.sum += grey;
    }

    fn add_all(&mut self, greys: &Self, weight: f32) {
        let counts = self.counts.iter_mut().zip(&greys.counts);
        counts.for_each(|(sum, count)| *sum += weight * count);
        self.sum += weight * greys.sum;
    }

    /// The threshold above which as many greys lie as their values add up to.
    fn threshold(&self) -> f32 {
        let mut above = 0.0;
        for (part, &count) in self.counts.iter().enumerate().rev() {
            if above + count > self.sum {
                let share = (self.sum - above).max(0.0) / count;
                return ((part + 1) as f32 - share) / PARTS as f32;
            }
            above += count;
        }
        MIDDLE
    }
}

impl Thresholds {
    /// Thresholds for `light`, 0..1, where values that satisfy `is_plain` do not count as grey.
    pub(super) fn of(light: &Plane, is_plain: impl Fn(f32) -> bool + Sync) -> Self {
        let [columns, rows] = [light.width(), light.height()].map(|side| side.div_ceil(SIDE));
        let mut greys = Plane::filled(columns, rows, Greys::NONE);
        greys.each_row(|row, squares| {
            for y in row * SIDE..light.height().min((row + 1) * SIDE) {
                for (x, &light) in light.row(y).iter().enumerate() {
                    if !is_plain(light) {
                        squares[x / SIDE].add(light);
                    }
                }
            }
        });
        let threshold = |column, row| around(&greys, column, row).threshold();
        Self {
            of_squares: Plane::of_pixels(columns, rows, threshold),
        }
    }

    /// The threshold at a pixel, interpolated between those of the surrounding squares.
    #[inline]
    pub(super) fn at(&self, x: usize, y: usize) -> f32 {
        let ([left, right], across) = between(x, self.of_squares.width());
        let ([above, below], down) = between(y, self.of_squares.height());
        let row = |y| {
            let [left, right] = [left, right].map(|x| self.of_squares.at(x, y));
            left + across * (right - left)
        };
        let (above, below) = (row(above), row(below));
        above + down * (below - above)
    }
}

/// The greys of a square and its neighbours.
fn around(greys: &Plane<Greys>, column: usize, row: usize) -> Greys {
    let mut sum = Greys::NONE;
    let reach = WEIGHTS.len() / 2;
    for (j, down) in WEIGHTS.iter().enumerate() {
        for (i, across) in WEIGHTS.iter().enumerate() {
            let [x, y] = [column + i, row + j].map(|at| at.wrapping_sub(reach));
            if let Some(greys) = greys.get(x, y) {
                sum.add_all(&greys, across * down);
            }
        }
    }
    sum
}

/// The squares whose centres surround that of a pixel along an axis, and the share of the second.
#[inline]
fn between(at: usize, count: usize) -> ([usize; 2], f32) {
    let at = ((at as f32 + 0.5) / SIDE as f32 - 0.5).clamp(0.0, (count - 1) as f32);
    let first = at as usize;
    ([first, (first + 1).min(count - 1)], at - first as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_much_lies_above_as_is_light() {
        // For greys spread evenly over 0 to 1/2, a quarter becomes white: those above 3/8.
        let mut greys = Greys::NONE;
        (0..1000).for_each(|i| greys.add((i as f32 + 0.5) / 2000.0));
        assert!(
            (greys.threshold() - 0.375).abs() < 0.005,
            "{}",
            greys.threshold()
        );
        assert_eq!(Greys::NONE.threshold(), MIDDLE);
        // All alike: .3 of them should become white, so the threshold lies among them, in part 9 of 32.
        let mut alike = Greys::NONE;
        (0..10).for_each(|_| alike.add(0.3));
        assert!((9.0 / 32.0..10.0 / 32.0).contains(&alike.threshold()));
    }
}
