//! Coverage of pixels by a line of varying width with round ends.

use glam::Vec2;

/// A piece of a line, round at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RoundStroke {
    from: Vec2,
    along: Vec2,
    /// 1 over the squared length; 0 for a dot.
    per_square: f32,
    /// Half the width at the start, and its growth.
    radius: f32,
    growth: f32,
    /// Half the extent of a pixel perpendicular to the line.
    half_pixel: f32,
}

impl RoundStroke {
    /// From one point to another, with the half widths at both.
    pub(crate) fn new([from, to]: [Vec2; 2], radii: [f32; 2]) -> Self {
        let along = to - from;
        let square = along.length_squared();
        Self {
            from,
            along,
            per_square: if square > 0.0 { 1.0 / square } else { 0.0 },
            radius: radii[0],
            growth: radii[1] - radii[0],
            half_pixel: match along.try_normalize() {
                Some(u) => 0.5 * (u.x.abs() + u.y.abs()),
                None => 0.5,
            },
        }
    }

    /// Distance from the line up to which it covers anything.
    fn reach(&self) -> f32 {
        self.radius.max(self.radius + self.growth) + self.half_pixel
    }

    /// The first and the last covered coordinate along y.
    pub(crate) fn rows(&self) -> [f32; 2] {
        self.extent([self.from.y, self.from.y + self.along.y])
    }

    /// The first and the last covered coordinate along x.
    pub(crate) fn across(&self) -> [f32; 2] {
        self.extent([self.from.x, self.from.x + self.along.x])
    }

    /// The first and the last covered coordinate along an axis, from those of its ends.
    fn extent(&self, [from, to]: [f32; 2]) -> [f32; 2] {
        let reach = self.reach();
        [from.min(to) - reach, from.max(to) + reach]
    }

    /// The first and the last covered coordinate along x in the pixel row whose middle is `y`; the last is before the
    /// first if there is none.
    fn columns(&self, y: f32) -> [f32; 2] {
        let reach = self.reach();
        let ends = [self.from, self.from + self.along];
        // The part of the line that is within reach of the row.
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        let mut add = |x: f32| range = [range[0].min(x), range[1].max(x)];
        let slope = self.along.x / self.along.y;
        for end in ends {
            if (end.y - y).abs() <= reach {
                add(end.x);
            }
        }
        for rim in [y - reach, y + reach] {
            if (ends[0].y - rim) * (ends[1].y - rim) < 0.0 {
                add(ends[0].x + (rim - ends[0].y) * slope);
            }
        }
        [range[0] - reach, range[1] + reach]
    }

    /// The covered share of a pixel with its centre at `p`, as if the pixel were rotated to the line's direction, with
    /// its actual width across it.
    #[inline]
    pub(crate) fn coverage(&self, p: Vec2) -> f32 {
        let offset = p - self.from;
        let t = (offset.dot(self.along) * self.per_square).clamp(0.0, 1.0);
        let radius = self.radius + t * self.growth;
        let distance = (offset - t * self.along).length();
        // Overlap of the interval from -radius to radius and the pixel's around the distance.
        let half = self.half_pixel;
        let shared = radius.min(distance + half) - (distance - half).max(-radius);
        (shared / (2.0 * half)).clamp(0.0, 1.0)
    }

    /// Covers a row of pixels whose centres have the coordinate `y`: the maximum with the coverage so far, so that
    /// overlaps do not darken.
    pub(crate) fn cover(&self, row: &mut [f32], y: f32) {
        let [first, last] = self.columns(y);
        // Casts saturate outside the picture.
        let (first, last) = (
            first.floor() as usize,
            (last.ceil().max(0.0) as usize).min(row.len()),
        );
        for (x, covered) in row.iter_mut().enumerate().take(last).skip(first) {
            *covered = covered.max(self.coverage(Vec2::new(x as f32 + 0.5, y)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(strokes: &[RoundStroke], side: usize) -> Vec<Vec<f32>> {
        let mut rows = vec![vec![0.0; side]; side];
        for (y, row) in rows.iter_mut().enumerate() {
            for stroke in strokes {
                stroke.cover(row, y as f32 + 0.5);
            }
        }
        rows
    }

    #[test]
    fn a_stroke_covers_its_length_times_its_width() {
        for width in [0.1_f32, 0.7, 2.0, 5.0] {
            for angle in [0.0_f32, 0.3, 0.785, 1.3] {
                let (middle, half) = (Vec2::splat(32.3), 20.0 * Vec2::from_angle(angle));
                let stroke = RoundStroke::new([middle - half, middle + half], [0.5 * width; 2]);
                let sum: f32 = drawn(&[stroke], 64).iter().flatten().sum();
                // Two half discs at the ends. A pixel's filter is a pixel wide at the ends too: thin lines end half a
                // pixel later on either side.
                let disc = std::f32::consts::PI * 0.25 * width * width;
                let expected = 40.0 * width + disc;
                assert!(
                    (sum - expected).abs() < 0.03 * expected + 0.8 * width,
                    "{width} {angle}: {sum}"
                );
            }
        }
    }

    #[test]
    fn overlaps_do_not_darken_and_pixels_are_never_more_than_covered() {
        let a = RoundStroke::new([Vec2::new(3.0, 8.5), Vec2::new(9.0, 8.5)], [0.4; 2]);
        let b = RoundStroke::new([Vec2::new(6.0, 8.5), Vec2::new(13.0, 8.5)], [0.4; 2]);
        let both = drawn(&[a, b], 16);
        assert!((both[8][7] - 0.8).abs() < 1e-6);
        let wide = RoundStroke::new([Vec2::splat(8.0); 2], [3.0; 2]);
        let rows = drawn(&[wide], 16);
        assert!(rows.iter().flatten().all(|&c| (0.0..=1.0).contains(&c)));
        assert_eq!((rows[8][8], rows[8][12]), (1.0, 0.0));
    }
}
