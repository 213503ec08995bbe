//! Extremes, sums and means over the square around each pixel.

use super::Plane;
use std::ops::Range;

/// The minimum or maximum over the square around each pixel, cut off at the plane's border.
///
/// The samples of the border, repeated beyond it, are in every square that reaches there. Windows of samples become twice
/// as wide at each step, first along rows, then of rows.
pub(super) fn over_squares(plane: &Plane, reach: usize, of: impl Fn(f32, f32) -> f32) -> Plane {
    let (width, height) = (plane.width(), plane.height());
    let (Some(last), false) = (width.checked_sub(1), height == 0) else {
        return plane.clone();
    };
    let steps = doubling_steps(2 * reach + 1);
    let mut windows = Plane::filled(width, height + 2 * reach, 0.0);
    let [mut line, mut wider] = [(); 2].map(|()| vec![0.0; width + 2 * reach]);
    for y in 0..height {
        let row = plane.row(y);
        line[..reach].fill(row[0]);
        line[reach..][..width].copy_from_slice(row);
        line[reach + width..].fill(row[last]);
        // What lies beyond the last whole window is of no use, and of no harm.
        for &step in &steps {
            let pairs = line.iter().zip(&line[step..]);
            for (wider, (&a, &b)) in wider.iter_mut().zip(pairs) {
                *wider = of(a, b);
            }
            std::mem::swap(&mut line, &mut wider);
        }
        windows.row_mut(y + reach).copy_from_slice(&line[..width]);
    }
    for y in 0..reach {
        for (to, from) in [(y, reach), (reach + height + y, reach + height - 1)] {
            let samples = windows.samples_mut();
            samples.copy_within(from * width..(from + 1) * width, to * width);
        }
    }
    let mut rows = windows.into_samples();
    for step in steps {
        for y in 0..height + 2 * reach - step {
            let (above, below) = rows.split_at_mut((y + step) * width);
            combine(&mut above[y * width..][..width], &below[..width], &of);
        }
    }
    rows.truncate(width * height);
    Plane::from_samples(width, height, rows)
}

/// How far apart windows that are joined lie, from single samples to `side` of them.
fn doubling_steps(side: usize) -> Vec<usize> {
    let mut covered = 1;
    let next = || {
        let step = covered.min(side - covered);
        covered += step;
        (step > 0).then_some(step)
    };
    std::iter::from_fn(next).collect()
}

/// The mean over the square around each pixel, with 0 beyond the plane.
pub(super) fn mean_over_squares(plane: &Plane, reach: usize) -> Plane {
    let side = (2 * reach + 1) as f32;
    sum_over_squares(plane, reach).map(|sum| sum / (side * side))
}

/// The sum over the square around each pixel, cut off at the plane's border.
pub(super) fn sum_over_squares(plane: &Plane, reach: usize) -> Plane {
    of_rows(plane, |y, row| {
        let mut column = vec![0.0; row.len()];
        for other in around(y, reach, plane.height()) {
            combine(&mut column, plane.row(other), |sum, sample| sum + sample);
        }
        add_along_row(row, &column, reach);
    })
}

/// Adds to every sample of a row those of `column` around it, from left to right: all that are equally far away at a time,
/// so that the compiler takes several pixels at once.
fn add_along_row(row: &mut [f32], column: &[f32], reach: usize) {
    let after = |samples: usize| column.get(samples..).unwrap_or_default();
    let add = |sum: f32, sample: f32| sum + sample;
    for left in (1..=reach.min(row.len())).rev() {
        combine(&mut row[left..], column, add);
    }
    for right in 0..=reach {
        combine(row, after(right), add);
    }
}

/// Combines samples with others, as far as there are both.
fn combine(samples: &mut [f32], others: &[f32], of: impl Fn(f32, f32) -> f32) {
    for (sample, &other) in samples.iter_mut().zip(others) {
        *sample = of(*sample, other);
    }
}

/// The range within `reach` of a position on a line of this length.
pub(super) fn around(place: usize, reach: usize, length: usize) -> Range<usize> {
    place.saturating_sub(reach)..(place + reach + 1).min(length)
}

/// A plane of this size whose rows, initially zero, are filled by `make`.
pub(super) fn of_rows(like: &Plane, make: impl Fn(usize, &mut [f32])) -> Plane {
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
                over_squares(&plane, reach, f32::max),
                over_squares(&plane, reach, f32::min),
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
