//! Errors of a result, over every pixel.

use super::numbers::{rounded, scientific};
use crate::frame::{Mask, Plane, Window};
use serde::Serialize;
use std::fmt::{self, Display};

/// Errors of a field over the covered pixels, relative to a scale chosen by the caller: for the gradient and its
/// derivatives the largest |g| before diffusion.
///
/// A non-finite result has an infinite error: it spoils the mean, as it should, and is counted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Errors {
    /// Mean.
    pub mean: f64,
    /// The bound for 99 of 100 pixels.
    pub p99: f64,
    /// Largest.
    pub max: f64,
    /// Number of samples that are NaN or infinite.
    pub non_finite: usize,
    /// Number of pixels compared.
    pub pixels: usize,
    /// Column and row of the largest error; `None` if nothing was compared.
    pub worst: Option<[i64; 2]>,
}

impl Errors {
    /// The same errors with the worst pixel in the coordinates of `window` rather than relative to its first column and
    /// row.
    pub(crate) fn in_window(self, window: Window) -> Self {
        let origin = [window.x0, window.y0].map(i64::from);
        Self {
            worst: self.worst.map(|[x, y]| [x + origin[0], y + origin[1]]),
            ..self
        }
    }
}

/// Mean, 99th percentile and largest.
impl Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mean, p99, max] = [self.mean, self.p99, self.max].map(scientific);
        write!(f, "{mean} / {p99} / {max}")
    }
}

/// Compares the components of a field with their reference; the worst component of a pixel counts.
///
/// # Panics
/// If a plane differs in size from the mask.
pub(crate) fn compare<const N: usize>(
    found: [&Plane; N],
    exact: [&Plane<f64>; N],
    mask: &Mask,
    scale: f64,
) -> Errors {
    compare_where(found, exact, scale, |x, y| mask.at(x, y))
}

/// [`compare`] over the pixels for which `counts` holds.
pub(crate) fn compare_where<const N: usize>(
    found: [&Plane; N],
    exact: [&Plane<f64>; N],
    scale: f64,
    counts: impl Fn(usize, usize) -> bool,
) -> Errors {
    let mut tally = Tally::default();
    for y in 0..found[0].height() {
        for x in (0..found[0].width()).filter(|&x| counts(x, y)) {
            let error = |i: usize| (f64::from(found[i].at(x, y)) - exact[i].at(x, y)).abs();
            tally.add([x, y], (0..N).map(error).fold(0.0, larger) / scale);
        }
    }
    tally.errors()
}

/// How far the covered samples of `plane` exceed `range`, [least, largest], relative to `scale`.
///
/// Exact diffusion makes no new extremum; an expansion does, by its error.
pub(crate) fn overshoot(plane: &Plane, range: [f64; 2], mask: &Mask, scale: f64) -> f64 {
    let samples = plane.samples().iter().zip(mask.plane().samples());
    let beyond = |v: f64| (range[0] - v).max(v - range[1]);
    samples
        .filter(|&(_, &covered)| covered)
        .map(|(&v, _)| beyond(f64::from(v)))
        .fold(0.0, |worst: f64, b| {
            if b.is_nan() {
                f64::INFINITY
            } else {
                worst.max(b)
            }
        })
        / scale
}

/// Every pixel of a plane.
pub(super) fn pixels(plane: &Plane) -> impl Iterator<Item = [usize; 2]> + use<> {
    let (width, height) = (plane.width(), plane.height());
    (0..width * height).map(move |i| [i % width, i / width])
}

/// Every covered pixel.
pub(super) fn covered(mask: &Mask) -> impl Iterator<Item = [usize; 2]> + '_ {
    let rows = (0..mask.height()).flat_map(|y| mask.runs(y).map(move |run| (y, run)));
    rows.flat_map(|(y, run)| run.map(move |x| [x, y]))
}

/// The larger of two errors. Not `f64::max`, which would drop a NaN.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b || a.is_nan() { a } else { b }
}

/// Errors collected pixel by pixel.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    errors: Vec<f64>,
    non_finite: usize,
    largest: f64,
    worst: Option<[i64; 2]>,
}

impl Tally {
    /// Adds the error of one pixel.
    pub(crate) fn add(&mut self, at: [usize; 2], error: f64) {
        let error = if error.is_finite() {
            error.abs()
        } else {
            self.non_finite += 1;
            f64::INFINITY
        };
        if self.worst.is_none() || error > self.largest {
            (self.largest, self.worst) = (error, Some(at.map(|i| i as i64)));
        }
        self.errors.push(error);
    }

    /// The smallest error that at least a share, 0..1, of the pixels do not exceed; 0 if there are none.
    pub(crate) fn quantile(&mut self, share: f64) -> f64 {
        let Some(last) = self.errors.len().checked_sub(1) else {
            return 0.0;
        };
        let count = (share * self.errors.len() as f64).ceil() as usize;
        let rank = count.saturating_sub(1).min(last);
        *self.errors.select_nth_unstable_by(rank, f64::total_cmp).1
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> usize {
        self.errors.len()
    }

    /// The summary.
    pub(crate) fn errors(mut self) -> Errors {
        let pixels = self.errors.len();
        let mean = self.errors.iter().sum::<f64>() / pixels.max(1) as f64;
        let p99 = self.quantile(0.99);
        Errors {
            mean,
            p99,
            max: self.largest,
            non_finite: self.non_finite,
            pixels,
            worst: self.worst,
        }
    }
}

/// Angles between directions, in degrees, over all pixels compared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Angles {
    /// Mean.
    pub mean: f64,
    /// The bound for 95 of 100 directions.
    pub p95: f64,
    /// Largest.
    pub max: f64,
}

impl Display for Angles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mean, p95, max] = [self.mean, self.p95, self.max].map(rounded);
        write!(f, "{mean} / {p95} / {max}")
    }
}

impl Angles {
    pub(crate) fn of(mut tally: Tally) -> Self {
        let p95 = tally.quantile(0.95);
        let errors = tally.errors();
        Self {
            mean: errors.mean,
            p95,
            max: errors.max,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_known_values() {
        // Errors 0, 1, .. 99 tenths at a scale of 10; the pixel (7, 0) is outside.
        let found = Plane::from_fn(101, 1, |x, _| {
            if x == 7 {
                1e9
            } else {
                x as f32 - f32::from(x > 7)
            }
        });
        let mask = Mask::new(Plane::from_fn(101, 1, |x, _| x != 7));
        let exact = Plane::filled(101, 1, 0.0_f64);
        let errors = compare([&found], [&exact], &mask, 10.0);
        assert_eq!(errors.pixels, 100);
        assert!((errors.mean - 4.95).abs() < 1e-12, "{errors:?}");
        assert!((errors.p99 - 9.8).abs() < 1e-12, "{errors:?}");
        assert!((errors.max - 9.9).abs() < 1e-12, "{errors:?}");
        assert_eq!((errors.worst, errors.non_finite), (Some([100, 0]), 0));
    }

    #[test]
    fn a_field_is_off_by_its_worse_component() {
        let (x, y) = (Plane::filled(1, 1, 3.0), Plane::filled(1, 1, -4.0));
        let (nan, zero) = (Plane::filled(1, 1, f32::NAN), Plane::filled(1, 1, 0.0));
        let mask = Mask::full(1, 1);
        assert_eq!(compare([&x, &y], [&zero, &zero], &mask, 1.0).max, 4.0);
        for found in [[&nan, &x], [&x, &nan]] {
            assert_eq!(compare(found, [&zero, &zero], &mask, 1.0).non_finite, 1);
        }
    }

    #[test]
    fn nan_and_infinity_are_counted_and_spoil_the_mean() {
        let found = Plane::from_samples(3, 1, vec![0.0, f32::NAN, f32::INFINITY]);
        let errors = compare(
            [&found],
            [&Plane::filled(3, 1, 0.0)],
            &Mask::full(3, 1),
            1.0,
        );
        assert_eq!((errors.non_finite, errors.worst), (2, Some([1, 0])));
        assert!(errors.mean == f64::INFINITY && errors.max == f64::INFINITY);
        let over = overshoot(&found, [-1.0, 1.0], &Mask::full(3, 1), 1.0);
        assert_eq!(over, f64::INFINITY);
    }

    #[test]
    fn an_empty_mask_compares_nothing() {
        let empty = Mask::new(Plane::filled(2, 2, false));
        let errors = compare(
            [&Plane::filled(2, 2, 1.0)],
            [&Plane::filled(2, 2, 0.0)],
            &empty,
            1.0,
        );
        assert_eq!(
            (errors.pixels, errors.mean, errors.max, errors.worst),
            (0, 0.0, 0.0, None)
        );
    }

    #[test]
    fn overshoot_is_measured_on_both_sides() {
        let plane = Plane::from_samples(4, 1, vec![-1.5, 0.0, 1.25, 9.0]);
        let mask = Mask::new(Plane::from_fn(4, 1, |x, _| x < 3));
        assert_eq!(overshoot(&plane, [-1.0, 1.0], &mask, 2.0), 0.25);
        assert_eq!(overshoot(&plane, [-2.0, 2.0], &mask, 2.0), 0.0);
    }
}
