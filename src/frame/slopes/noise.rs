//! How noisy values are.

use super::Rounding;
use crate::frame::{Mask, Plane};
use crate::kernel::quantile::quantile;
use rayon::prelude::*;

/// Number of pixels that noise is estimated from: to 2 %.
const PIXELS: usize = 4096;

/// Orders of the differences that it is estimated from, and the sums of their squared coefficients. Low orders take
/// curvature for noise, high ones need a long run of samples.
const ORDERS: [(usize, f32); 4] = [(2, 6.0), (4, 70.0), (6, 924.0), (8, 12870.0)];

/// Samples that the highest order reads, and those before the middle one.
const LINE: usize = 9;
const BEFORE: usize = LINE / 2;

/// The median of a normal distribution's absolute values, over its standard deviation.
const NORMAL_MEDIAN: f32 = 0.6745;

/// The standard deviation of rounding errors where codes are 1 apart: the root of 1/12.
pub(super) const STEP_DEVIATION: f32 = 0.288_675_13;

/// The noise of values.
pub(super) struct ValueNoise {
    /// Standard deviation of white noise.
    pub(super) white: f32,
    /// The median size of values.
    pub(super) size: f32,
    /// The distance of codes around every value; one row if it is the same in all rows.
    steps: Plane,
    has_steps: bool,
}

impl ValueNoise {
    pub(super) fn of(values: &Plane, rounding: &Rounding) -> Self {
        let (white, size) = white_noise(values);
        let step = |step: f32| {
            if step > 0.0 {
                step.min(super::TOO_LARGE)
            } else {
                0.0
            }
        };
        let steps = match rounding {
            Rounding::Step(constant) => Plane::filled(values.width(), 1, step(*constant)),
            Rounding::Of(of) => {
                let mut steps = values.clone();
                steps.each_row(|_, row| row.iter_mut().for_each(|v| *v = step(of(*v))));
                steps
            }
        };
        let has_steps = steps.samples().iter().any(|&step| step > 0.0);
        Self {
            white,
            size,
            steps,
            has_steps,
        }
    }

    /// The distance of codes around the values of row `y`.
    pub(super) fn steps(&self, y: usize) -> &[f32] {
        self.steps.row(y.min(self.steps.height() - 1))
    }

    /// Standard deviation of noise and rounding where codes have this distance.
    #[inline(always)]
    pub(super) fn deviation(&self, step: f32) -> f32 {
        self.white.max(step * STEP_DEVIATION)
    }

    /// Whether values are rounded to codes.
    pub(super) fn has_steps(&self) -> bool {
        self.has_steps
    }

    /// Whether noise and rounding are below this share of the values' median size everywhere.
    pub(super) fn is_below(&self, share: f32) -> bool {
        let most = self
            .steps
            .samples()
            .iter()
            .fold(0.0_f32, |most, &step| most.max(step));
        self.deviation(most) <= share * self.size
    }
}

/// Standard deviation of white noise, the least that differences along rows and columns show, and the median size of
/// values; 0 where nothing is known.
fn white_noise(values: &Plane) -> (f32, f32) {
    let mut finite = Plane::filled(values.width(), values.height(), false);
    finite.each_row(|y, row| {
        let pairs = row.iter_mut().zip(values.row(y));
        pairs.for_each(|(finite, value)| *finite = value.is_finite());
    });
    let places: Vec<_> = Mask::new(finite).sample(PIXELS).collect();
    let value = |x: Option<usize>, y: Option<usize>| match (x, y) {
        (Some(x), Some(y)) if x < values.width() && y < values.height() => values.at(x, y),
        _ => f32::NAN,
    };
    // The differences of each order along a row and a column: places are far from each other in memory.
    let seen: Vec<_> = places
        .par_iter()
        .map(|&(x, y)| {
            let row = std::array::from_fn(|i| value((x + i).checked_sub(BEFORE), Some(y)));
            let column = std::array::from_fn(|i| value(Some(x), (y + i).checked_sub(BEFORE)));
            [row, column].map(differences)
        })
        .collect();
    let median = |values: &mut dyn Iterator<Item = f32>| {
        let mut finite: Vec<_> = values.filter(|v| v.is_finite()).collect();
        quantile(&mut finite, 0.5, f32::total_cmp)
    };
    let noise = (0..2).flat_map(|axis| (0..ORDERS.len()).map(move |order| (axis, order)));
    let noise = noise.filter_map(|(axis, order)| {
        let deviation = NORMAL_MEDIAN * ORDERS[order].1.sqrt();
        Some(median(&mut seen.iter().map(|seen| seen[axis][order]))? / deviation)
    });
    let sizes = &mut places.iter().map(|&(x, y)| values.at(x, y).abs());
    (
        noise.reduce(f32::min).unwrap_or(0.0),
        median(sizes).unwrap_or(0.0),
    )
}

/// The sizes of the differences of each order in the middle of a line of samples; NaN where one is missing.
fn differences(mut line: [f32; LINE]) -> [f32; ORDERS.len()] {
    let mut order = 0;
    ORDERS.map(|(wanted, _)| {
        while order < wanted {
            order += 1;
            (0..LINE - order).for_each(|i| line[i] = line[i + 1] - line[i]);
        }
        line[BEFORE - order / 2].abs()
    })
}
