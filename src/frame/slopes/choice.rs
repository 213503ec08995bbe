//! The width of smoothing that each pixel takes.

use super::links::Links;
use super::noise::Noise;
use super::smoothing::smoothed;
use crate::frame::{MOST_ROWS_PER_TASK, Plane, parallel_rows};
use crate::kernel::fast_math::exp_to_normal;
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
pub(super) fn choose(slopes: [Plane; 2], links: &Links, noise: &Noise) -> [Plane; 2] {
    let (width, height) = (links.across.width(), links.across.height());
    let whole = [f32::NEG_INFINITY, f32::INFINITY].repeat(2);
    let mut intervals = [0, 1, 2, 3].map(|i| Plane::filled(width, height, whole[i]));
    // The last level that agrees with all before it.
    let mut reached = Plane::filled(width, height, -1.0);
    let mut levels = vec![slopes];
    for level in 0..WIDTHS.len() {
        if level + 1 < WIDTHS.len() {
            let variance = WIDTHS[level + 1].powi(2) - WIDTHS[level].powi(2);
            levels.push(smoothed(&levels[level], links, variance));
        }
        let (here, wider) = (&levels[level], levels.last().expect("at least one"));
        let [low_p, high_p, low_q, high_q] = intervals.each_mut();
        let rows = parallel_rows([&mut reached, low_p, high_p, low_q, high_q])
            .with_max_len(MOST_ROWS_PER_TASK);
        let scratch = || [(); 2].map(|()| vec![0.0; width]);
        let go_on = rows.map_init(
            scratch,
            |[half, agrees], (y, [reached, low_p, high_p, low_q, high_q])| {
                half_widths(
                    half,
                    level,
                    wider.each_ref().map(|plane| plane.row(y)),
                    noise,
                    y,
                );
                agrees.fill(1.0);
                intersect(low_p, high_p, here[0].row(y), half, agrees);
                intersect(low_q, high_q, here[1].row(y), half, agrees);
                let before = level as f32 - 1.0;
                for (reached, agrees) in reached.iter_mut().zip(agrees) {
                    *reached += if *reached == before { *agrees } else { 0.0 };
                }
                reached.contains(&(level as f32))
            },
        );
        if !go_on.reduce(|| false, |a, b| a | b) {
            break;
        }
    }
    between(levels, &reached)
}

/// Half the widths of confidence intervals of slopes in row `y`, given those at the next width.
fn half_widths(half: &mut [f32], level: usize, wider: [&[f32]; 2], noise: &Noise, y: usize) {
    let scale = CONFIDENCES[level] * GAINS[level];
    let slopes = wider[0].iter().zip(wider[1]).zip(noise.steps(y));
    for (half, ((p, q), &step)) in half.iter_mut().zip(slopes) {
        *half = scale * noise.deviation(step);
        if noise.has_steps() {
            *half += ripple(p * p + q * q, step, WIDTHS[level]);
        }
    }
}

/// Intersects intervals with those around `slopes`; a pixel where nothing is left agrees no more.
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
fn between(mut levels: Vec<[Plane; 2]>, reached: &Plane) -> [Plane; 2] {
    let (width, height) = (reached.width(), reached.height());
    let mut chosen = levels[0].clone();
    let wider = levels.split_off(1);
    let rows = parallel_rows(chosen.each_mut()).with_max_len(MOST_ROWS_PER_TASK);
    let scratch = || (vec![0.0; width + 4], vec![0.0; width]);
    rows.for_each_init(scratch, |(column, smooth), (y, chosen)| {
        let near: [&[f32]; 5] = std::array::from_fn(|i| {
            &reached.row((y + i).saturating_sub(2).min(height - 1))[..width]
        });
        for (x, mean_of) in column[2..][..width].iter_mut().enumerate() {
            *mean_of = binomial(near.map(|row| row[x]));
        }
        let [first, last] = [column[2], column[width + 1]];
        column[..2].fill(first);
        column[width + 2..].fill(last);
        for ((smooth, five), own) in smooth.iter_mut().zip(column.windows(5)).zip(near[2]) {
            *smooth = smaller(binomial(five.try_into().expect("five")), *own);
        }
        for (axis, chosen) in chosen.into_iter().enumerate() {
            let mut from = &levels[0];
            for (level, to) in wider.iter().enumerate() {
                let slopes = from[axis].row(y).iter().zip(to[axis].row(y)).zip(&*smooth);
                for (chosen, ((from, to), smooth)) in chosen.iter_mut().zip(slopes) {
                    let share = smaller(larger(smooth - level as f32, 0.0), 1.0);
                    *chosen += share * (to - from);
                }
                from = to;
            }
        }
    });
    chosen
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
        let links = Links {
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
