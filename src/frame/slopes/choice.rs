//! The width of smoothing that each pixel takes.

use super::links::SurfaceLinks;
use super::noise::ValueNoise;
use super::smoothing::smoothed;
use crate::frame::{MOST_ROWS_PER_TASK, Plane, parallel_rows};
use crate::kernel::fast_math::exp_to_normal;
use crate::kernel::simd::wide;
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_SQRT_2, PI};

/// Standard deviations of the kernels that slopes are smoothed by, in pixels, narrowest first.
const WIDTHS: [f32; 6] = [0.0, 0.6, 1.2, 2.4, 4.8, 9.6];

/// Standard deviations of slopes smoothed to these widths, where values have white noise with a deviation of 1.
const GAINS: [f32; 6] = [FRAC_1_SQRT_2, 0.4148, 0.1677, 0.04759, 0.01219, 0.003064];

/// Half widths of confidence intervals, in standard deviations. From wider ones waves are smoothed away, from narrower
/// ones noise is left on planes: the first ones are compared with all others, and decide how many pixels keep theirs.
const CONFIDENCES: [f32; 6] = [2.6, 2.3, 2.0, 2.0, 2.0, 2.0];

/// The slopes at the largest width whose confidence interval intersects those of all smaller ones.
pub(super) fn choose(slopes: [Plane; 2], links: &SurfaceLinks, noise: &ValueNoise) -> [Plane; 2] {
    let mut levels = vec![slopes];
    for widths in WIDTHS.windows(2) {
        let variance = widths[1].powi(2) - widths[0].powi(2);
        let narrower = levels.last().expect("at least one");
        levels.push(smoothed(narrower, links, variance));
    }
    let mut reached = Plane::filled(links.across.width(), links.across.height(), 0_u8);
    reached.each_row(|y, reached| wide!(reach(reached, &levels, noise, y)));
    between(levels, &reached)
}

/// Pixels of a row that are looked at together, at all levels.
const TOGETHER: usize = 256;

/// The last level that agrees with all before it, in row `y`.
#[inline(always)]
fn reach(reached: &mut [u8], levels: &[[Plane; 2]], noise: &ValueNoise, y: usize) {
    let steps = noise.steps(y);
    for (i, reached) in reached.chunks_mut(TOGETHER).enumerate() {
        let span = i * TOGETHER..i * TOGETHER + reached.len();
        let mut half = [0.0; TOGETHER];
        let mut agrees = [1.0; TOGETHER];
        let mut count = [0.0; TOGETHER];
        let mut intervals = [[[f32::NEG_INFINITY; TOGETHER], [f32::INFINITY; TOGETHER]]; 2];
        for (level, here) in levels.iter().enumerate() {
            let wider = &levels[(level + 1).min(levels.len() - 1)];
            let wider = [0, 1].map(|axis| &wider[axis].row(y)[span.clone()]);
            half_widths(&mut half, level, wider, noise, &steps[span.clone()]);
            for ([low, high], slopes) in intervals.iter_mut().zip(here) {
                let slopes = &slopes.row(y)[span.clone()];
                intersect(low, high, slopes, &half, &mut agrees);
            }
            if level > 0 {
                let counts = count.iter_mut().zip(&agrees);
                counts.for_each(|(count, agrees)| *count += agrees);
            }
        }
        let counts = reached.iter_mut().zip(count);
        counts.for_each(|(reached, count)| *reached = count as u8);
    }
}

/// Half the widths of confidence intervals of slopes, given those at the next width.
#[inline(always)]
fn half_widths(
    half: &mut [f32],
    level: usize,
    wider: [&[f32]; 2],
    noise: &ValueNoise,
    steps: &[f32],
) {
    let scale = CONFIDENCES[level] * GAINS[level];
    let slopes = wider[0].iter().zip(wider[1]).zip(steps);
    for (half, ((p, q), &step)) in half.iter_mut().zip(slopes) {
        *half = scale * noise.deviation(step);
        if noise.has_steps() {
            *half += ripple(p * p + q * q, step, WIDTHS[level]);
        }
    }
}

/// Intersects intervals with those around `slopes`; a pixel where nothing is left agrees no more.
#[inline(always)]
fn intersect(low: &mut [f32], high: &mut [f32], slopes: &[f32], half: &[f32], agrees: &mut [f32]) {
    let intervals = low.iter_mut().zip(high).zip(agrees);
    for (((low, high), agrees), (slope, half)) in intervals.zip(slopes.iter().zip(half)) {
        *low = larger(*low, slope - half);
        *high = smaller(*high, slope + half);
        *agrees = if *low <= *high { *agrees } else { 0.0 };
    }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// What smoothing to a width leaves of a staircase of `step`, whose mean slope has this square: the first harmonic of its
/// ripple, or the ramp of a single riser where treads are wider than the kernel.
#[inline(always)]
fn ripple(square: f32, step: f32, width: f32) -> f32 {
    let width = width.max(0.5);
    let slope = square.sqrt();
    let risers = width * slope / larger(step, f32::MIN_POSITIVE);
    let harmonic = 2.0 * slope * exp_to_normal(larger(-2.0 * PI * PI * risers * risers, -80.0));
    let riser = if risers < 0.16 {
        0.193 / width * step
    } else {
        0.0
    };
    if step > 0.0 { harmonic + riser } else { 0.0 }
}

/// The slopes between the levels that are reached, which are smoothed so that they do not flicker, but never raised.
fn between(mut levels: Vec<[Plane; 2]>, reached: &Plane<u8>) -> [Plane; 2] {
    let (width, height) = (reached.width(), reached.height());
    let wider = levels.split_off(1);
    let mut chosen = levels.remove(0);
    let rows = parallel_rows(chosen.each_mut()).with_max_len(MOST_ROWS_PER_TASK);
    let scratch = || (vec![0.0; width + 4], [(); 2].map(|()| vec![0.0; width]));
    rows.for_each_init(scratch, |(column, [smooth, first]), (y, chosen)| {
        let near: [&[u8]; 5] = std::array::from_fn(|i| {
            &reached.row((y + i).saturating_sub(2).min(height - 1))[..width]
        });
        wide!(smooth_levels(smooth, column, near));
        for (axis, chosen) in chosen.into_iter().enumerate() {
            first.copy_from_slice(chosen);
            let mut from = &first[..];
            for (level, to) in wider.iter().enumerate() {
                let to = to[axis].row(y);
                wide!(go_on(chosen, from, to, smooth, level as f32));
                from = to;
            }
        }
    });
    chosen
}

/// The levels that a row reaches, from those of five rows; `column` has room for two pixels more on either side.
#[inline(always)]
fn smooth_levels(smooth: &mut [f32], column: &mut [f32], near: [&[u8]; 5]) {
    let width = smooth.len();
    let [a, b, c, d, e] = near;
    for x in 0..width {
        column[x + 2] = binomial([a[x], b[x], c[x], d[x], e[x]].map(f32::from));
    }
    let [first, last] = [column[2], column[width + 1]];
    column[..2].fill(first);
    column[width + 2..].fill(last);
    let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|i| &column[i..i + width]);
    for x in 0..width {
        let mean = binomial([a[x], b[x], c[x], d[x], e[x]]);
        smooth[x] = smaller(mean, f32::from(near[2][x]));
    }
}

/// Goes on from one level to the next, as far as a row reaches.
#[inline(always)]
fn go_on(chosen: &mut [f32], from: &[f32], to: &[f32], reached: &[f32], level: f32) {
    let slopes = from.iter().zip(to).zip(reached);
    for (chosen, ((from, to), reached)) in chosen.iter_mut().zip(slopes) {
        *chosen += smaller(larger(reached - level, 0.0), 1.0) * (to - from);
    }
}

/// The binomial mean of five values, whose standard deviation is 1.
#[inline(always)]
fn binomial([a, b, c, d, e]: [f32; 5]) -> f32 {
    (a + e + 4.0 * (b + d) + 6.0 * c) / 16.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::slopes::links::differences;

    #[test]
    fn gains_are_those_of_the_kernels() {
        // The variance of filtered white noise is the sum of the squared responses to one sample.
        const SIZE: usize = 161;
        let impulse = Plane::from_fn(
            SIZE,
            SIZE,
            |x, y| if [x, y] == [SIZE / 2; 2] { 1.0 } else { 0.0 },
        );
        let links = SurfaceLinks {
            across: Plane::from_fn(SIZE, SIZE, |x, _| x + 1 < SIZE),
            down: Plane::from_fn(SIZE, SIZE, |_, y| y + 1 < SIZE),
        };
        let mut slopes = differences(&impulse, &links).0;
        for (level, gain) in GAINS.into_iter().enumerate() {
            if level > 0 {
                slopes = smoothed(
                    &slopes,
                    &links,
                    WIDTHS[level].powi(2) - WIDTHS[level - 1].powi(2),
                );
            }
            for slopes in &slopes {
                let squares: f64 = slopes.samples().iter().map(|&s| f64::from(s).powi(2)).sum();
                let found = squares.sqrt() as f32;
                assert!((found / gain - 1.0).abs() < 0.002, "{level} {found} {gain}");
            }
        }
    }
}
