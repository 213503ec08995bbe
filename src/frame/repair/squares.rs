//! Extremes, sums and means over the square around each pixel.

use crate::frame::Plane;
use std::ops::Range;

/// The samples of the square around each pixel combined, cut off at the plane's border: of `start`, each column from top to
/// bottom, and then columns: those on the left from left to right, and the others.
///
/// All samples that are equally far away at a time, so that the compiler takes several pixels at once.
pub(super) fn over_squares(
    plane: &Plane,
    reach: usize,
    start: f32,
    of: impl Fn(f32, f32) -> f32,
) -> Plane {
    let combine = |samples: &mut [f32], others: &[f32]| {
        for (sample, &other) in samples.iter_mut().zip(others) {
            *sample = of(*sample, other);
        }
    };
    let mut column = vec![start; plane.width()];
    of_rows(plane, |y, row| {
        column.fill(start);
        for other in around(y, reach, plane.height()) {
            combine(&mut column, plane.row(other));
        }
        row.fill(start);
        for left in (1..=reach.min(row.len())).rev() {
            combine(&mut row[left..], &column);
        }
        for right in 0..=reach.min(row.len()) {
            combine(row, &column[right..]);
        }
    })
}

/// The mean over the square around each pixel, with 0 beyond the plane.
pub(in crate::frame) fn mean_over_squares(plane: &Plane, reach: usize) -> Plane {
    let side = (2 * reach + 1) as f32;
    sum_over_squares(plane, reach).map(|sum| sum / (side * side))
}

/// The sum over the square around each pixel, cut off at the plane's border.
pub(super) fn sum_over_squares(plane: &Plane, reach: usize) -> Plane {
    over_squares(plane, reach, 0.0, |sum, sample| sum + sample)
}

/// The range within `reach` of a position on a line of this length.
pub(super) fn around(place: usize, reach: usize, length: usize) -> Range<usize> {
    place.saturating_sub(reach)..(place + reach + 1).min(length)
}

/// A plane of this size whose rows, initially zero, are filled by `make`.
pub(super) fn of_rows(like: &Plane, mut make: impl FnMut(usize, &mut [f32])) -> Plane {
    let mut made = Plane::filled(like.width(), like.height(), 0.0);
    for y in 0..made.height() {
        make(y, made.row_mut(y));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extremes_of_squares_are_those_of_their_samples() {
        for (width, height, reach) in [(1, 1, 2), (3, 2, 8), (23, 19, 2), (40, 31, 8), (5, 6, 0)] {
            let plane = Plane::from_fn(width, height, |x, y| {
                (7.0 * x as f32 + 3.0 * (y * y) as f32).sin()
            });
            let squares = [
                over_squares(&plane, reach, f32::MIN, f32::max),
                over_squares(&plane, reach, f32::MAX, f32::min),
            ];
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                let rows = around(y, reach, height).map(|y| &plane.row(y)[around(x, reach, width)]);
                let samples: Vec<f32> = rows.flatten().copied().collect();
                let expected = [f32::max, f32::min].map(|of| samples.iter().copied().reduce(of));
                assert_eq!(squares.each_ref().map(|made| Some(made.at(x, y))), expected);
            }
        }
    }
}
