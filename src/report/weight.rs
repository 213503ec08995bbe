//! Edge weights in double precision, with the range that rounding leaves them.

use crate::frame::{Mask, Plane};
use crate::params::SoftThreshold;
use crate::shape::gap::pair::CLOSED;
use rayon::prelude::*;

/// Spacing of single-precision numbers at 1.
pub(super) const EPSILON: f64 = f32::EPSILON as f64;

/// A weight, 0..1, and the range it can take when single-precision rounding moves the value before its threshold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Weight {
    pub exact: f64,
    pub least: f64,
    pub most: f64,
}

impl Weight {
    pub(super) const FULL: Self = Self {
        exact: 1.0,
        least: 1.0,
        most: 1.0,
    };

    /// A linear ramp from 0 at `lo` to 1 at `hi`, or a step if they are equal, of a value known to within `rounding`.
    pub(super) fn ramp(value: f64, rounding: f64, SoftThreshold { lo, hi }: SoftThreshold) -> Self {
        let (lo, hi) = (f64::from(lo), f64::from(hi));
        let at = |value: f64| match lo < hi {
            true => ((value - lo) / (hi - lo)).clamp(0.0, 1.0),
            false => f64::from(u8::from(value >= hi)),
        };
        let [exact, least, most] = [value, value - rounding, value + rounding].map(at);
        Self { exact, least, most }
    }

    /// The larger of two, and their product.
    pub(super) fn max(self, other: Self) -> Self {
        self.with(other, f64::max)
    }

    pub(super) fn times(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }

    /// 1 from [`CLOSED`] on.
    pub(super) fn closed(self) -> Self {
        let of = |weight: f64| if weight > CLOSED.into() { 1.0 } else { weight };
        Self {
            exact: of(self.exact),
            least: of(self.least),
            most: of(self.most),
        }
    }

    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            exact: of(self.exact, other.exact),
            least: of(self.least, other.least),
            most: of(self.most, other.most),
        }
    }

    /// The conductance: 1 minus the larger of two edge weights.
    pub(super) fn conductance(a: Self, b: Self) -> Self {
        Self {
            exact: 1.0 - a.exact.max(b.exact),
            least: 1.0 - a.most.max(b.most),
            most: 1.0 - a.least.max(b.least),
        }
    }
}

/// `value` at every covered pixel, the default elsewhere.
pub(super) fn covered<T: Copy + Default + Send>(
    mask: &Mask,
    value: impl Fn(usize, usize) -> T + Sync,
) -> Plane<T> {
    let (w, h) = (mask.width(), mask.height());
    let pixels = (0..w * h).into_par_iter().with_min_len(w.max(1));
    let samples = pixels.map(|i| match (i % w, i / w) {
        (x, y) if mask.at(x, y) => value(x, y),
        _ => T::default(),
    });
    Plane::from_samples(w, h, samples.collect())
}
