//! Which neighbours lie on the same surface, and how values change between them.

use super::noise::{STEP_DEVIATION, ValueNoise};
use crate::frame::Plane;
use crate::frame::plane::each_row_beside;
use crate::kernel::simd::wide;
use rayon::prelude::*;
use std::f32::consts::SQRT_2;

/// A difference this many times larger than others on both sides is a step, unless noise explains it.
const STEP: f32 = 2.0;

/// Standard deviations that noise explains.
const DEVIATIONS: f32 = 6.0;

/// Errors of 32-bit floats, in spacings of floats, that are no steps.
const SPACINGS: f32 = 4.0;

/// The pairs of neighbours on the same surface.
pub(super) struct SurfaceLinks {
    /// Between each pixel and the next one to the right.
    pub(super) across: Plane<bool>,
    /// Between each pixel and the next one down.
    pub(super) down: Plane<bool>,
}

impl SurfaceLinks {
    pub(super) fn of(values: &Plane, noise: &ValueNoise) -> Self {
        let (width, height) = (values.width(), values.height());
        let [mut across, mut down] = [(); 2].map(|()| Plane::filled(width, height, false));
        // Three samples before a row and after it are none.
        let padded = || vec![f32::NAN; width + 6];
        let rows = across
            .samples_mut()
            .par_chunks_exact_mut(width.max(1))
            .enumerate();
        rows.for_each_init(padded, |padded, (y, links)| {
            padded[3..][..width].copy_from_slice(values.row(y));
            let around = std::array::from_fn(|i| &padded[i + 1..]);
            wide!(find(links, around, noise.steps(y), noise.white));
        });
        let none = vec![f32::NAN; width];
        down.each_row(|y, links| {
            let around = std::array::from_fn(|i| match (y + i).checked_sub(2) {
                Some(y) if y < height => values.row(y),
                _ => &none,
            });
            wide!(find(links, around, noise.steps(y), noise.white));
        });
        Self { across, down }
    }
}

/// Finds a row of links, from the samples before, here and ahead: each is between the third and the fourth of them.
#[inline(always)]
fn find(links: &mut [bool], around: [&[f32]; 6], steps: &[f32], white: f32) {
    let length = links.len();
    // Slices of one length, each in a variable of its own: a loop over an array of slices is not vectorised.
    let [a, b, c, d, e, f] = around.map(|samples| &samples[..length]);
    let steps = &steps[..length];
    for x in 0..length {
        let deviation = white.max(steps[x] * STEP_DEVIATION);
        let tolerance = DEVIATIONS * SQRT_2 * deviation + SPACINGS * f32::EPSILON * c[x].abs();
        links[x] = is_link([a[x], b[x], c[x], d[x], e[x], f[x]], tolerance);
    }
}

/// Whether the third and the fourth of six values in a line belong to the same surface; NaN is no value. Their
/// difference is a step if it is much larger than one of two next to it on either side, so that a step spread over two
/// differences is one, and if it stands out from the median of all five. At the crest or at the steepest place of a wave
/// it does not.
#[inline(always)]
fn is_link(values: [f32; 6], tolerance: f32) -> bool {
    let [a, b, c, d, e, f] = values;
    let d = [b - a, c - b, d - c, e - d, f - e];
    let around = least(d[0].abs(), d[1].abs()).max(least(d[3].abs(), d[4].abs()));
    let here = d[2].abs();
    let stands_out = (d[2] - median(d)).abs() > 0.5 * here;
    let is_step = (here > STEP * around + tolerance) & stands_out;
    !is_step & (here >= 0.0)
}

/// The smaller of two numbers; the other one if one is NaN.
#[inline(always)]
fn least(a: f32, b: f32) -> f32 {
    a.min(b)
}

/// The median of five differences. One that is missing is as the one on the other side.
#[inline(always)]
fn median([l2, l1, here, r1, r2]: [f32; 5]) -> f32 {
    let or = |a: f32, b: f32| if a.is_nan() { b } else { a };
    let (l1, r1) = (or(or(l1, r1), here), or(or(r1, l1), here));
    let (l2, r2) = (or(or(l2, r2), l1), or(or(r2, l2), r1));
    let min = |a: f32, b: f32| if a < b { a } else { b };
    let max = |a: f32, b: f32| if a > b { a } else { b };
    let low = max(min(l1, l2), min(r1, r2));
    let high = min(max(l1, l2), max(r1, r2));
    max(min(low, high), min(max(low, high), here))
}

/// Slopes across and down, the mean of the differences along links, and where both are found. A pixel without links along
/// an axis has the slope of those that it is linked with along the other one.
pub(super) fn differences(values: &Plane, links: &SurfaceLinks) -> ([Plane; 2], Plane<bool>) {
    let (width, height) = (values.width(), values.height());
    let mut found = Plane::filled(width, height, false);
    let [mut across, mut down] = [(); 2].map(|()| Plane::filled(width, height, 0.0));
    let unlinked = vec![false; width];
    each_row_beside(
        &mut found,
        [&mut across, &mut down],
        |y, found, [across, down]| {
            found.fill(true);
            let row = values.row(y);
            let right = links.across.row(y);
            if width > 2 {
                let [before, here, after] = [0, 1, 2].map(|i| &row[i..][..width - 2]);
                let links = [&right[..width - 2], &right[1..width - 1]];
                let inner = &mut across[1..width - 1];
                wide!(mean_row(inner, links, [before, here, after]));
            }
            for x in [0, width - 1] {
                across[x] = slope(values, &links.across, 1, y * width + x);
            }
            let (above, upward) = match y.checked_sub(1) {
                Some(above) => (values.row(above), links.down.row(above)),
                None => (row, &unlinked[..]),
            };
            let below = values.row((y + 1).min(height - 1));
            wide!(mean_row(
                down,
                [upward, links.down.row(y)],
                [above, row, below]
            ));
            for (x, found) in found.iter_mut().enumerate() {
                if across[x].is_nan() | down[x].is_nan() {
                    let i = y * width + x;
                    let other = |along, stride, other, turned| {
                        beside_slope(values, [along, other], [stride, turned], i)
                    };
                    if across[x].is_nan() {
                        across[x] = other(&links.across, 1, &links.down, width);
                    }
                    if down[x].is_nan() {
                        down[x] = other(&links.down, width, &links.across, 1);
                    }
                    *found = !(across[x].is_nan() | down[x].is_nan());
                    for slope in [&mut across[x], &mut down[x]] {
                        *slope = if slope.is_nan() { 0.0 } else { *slope };
                    }
                }
            }
        },
    );
    ([across, down], found)
}

/// [`mean`] of a row.
#[inline(always)]
fn mean_row(slopes: &mut [f32], links: [&[bool]; 2], values: [&[f32]; 3]) {
    let length = slopes.len();
    let [before, here, after] = values.map(|values| &values[..length]);
    let [first, second] = links.map(|links| &links[..length]);
    for x in 0..length {
        slopes[x] = mean([first[x], second[x]], [before[x], here[x], after[x]]);
    }
}

/// The mean difference along links between the second of three values and its neighbours; NaN without links.
#[inline(always)]
fn mean(links: [bool; 2], values: [f32; 3]) -> f32 {
    let difference = |i: usize| {
        if links[i] {
            values[i + 1] - values[i]
        } else {
            0.0
        }
    };
    let count = f32::from(u8::from(links[0]) + u8::from(links[1]));
    (difference(0) + difference(1)) / count
}

/// Indices of the samples that sample `i` is linked with, `stride` before and after it.
fn linked(links: &Plane<bool>, stride: usize, i: usize) -> impl Iterator<Item = usize> {
    let links = links.samples();
    let before = i.checked_sub(stride).filter(|&before| links[before]);
    before.into_iter().chain(links[i].then_some(i + stride))
}

/// The mean difference along links of sample `i` and those `stride` before and after it; NaN without links.
fn slope(values: &Plane, links: &Plane<bool>, stride: usize, i: usize) -> f32 {
    let values = values.samples();
    let differences =
        linked(links, stride, i).map(|j| (values[j] - values[i]) * if j > i { 1.0 } else { -1.0 });
    let (sum, count) = differences.fold((0.0, 0.0), |(sum, count), d| (sum + d, count + 1.0));
    sum / count
}

/// The mean slope along the first links of the samples that sample `i` is linked with by the second ones; NaN without.
fn beside_slope(values: &Plane, links: [&Plane<bool>; 2], strides: [usize; 2], i: usize) -> f32 {
    let slopes = linked(links[1], strides[1], i).map(|j| slope(values, links[0], strides[0], j));
    let slopes = slopes.filter(|slope| !slope.is_nan());
    let (sum, count) = slopes.fold((0.0, 0.0), |(sum, count), s| (sum + s, count + 1.0));
    sum / count
}
