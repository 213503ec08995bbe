//! Removes quantisation steps from 8-bit normals.
//!
//! A gentle slope stored in codes is a staircase: its treads are flat, and each riser is a ridge of curvature. The
//! original lies within half a step of each code, and the smoothest such slope is chosen: smoothed over wide
//! neighbourhoods first and narrow ones last, never farther than half a step from the codes. A neighbourhood is left
//! unchanged where its codes rise and fall by more than [`MOST_STEPS`]: there rounding is noise, which diffusion
//! averages out, and texture is no staircase.

use crate::frame::{Plane, Vector3Planes, Window};

/// Number of halvings for the widest neighbourhoods, whose standard deviation is 13 pixels.
const LEVELS: usize = 4;

/// Number of passes per width. The second pass halves curvature errors of gentle domes.
const PASSES: usize = 2;

/// Code steps, summed along one standard deviation of a neighbourhood, up to which it is smoothed in full; at twice as
/// many it is not smoothed.
const MOST_STEPS: f32 = 1.0;

/// Number of rows within which a code can affect another: each pass at level l reads 5 2^l - 4 rows for halving,
/// smoothing and doubling.
pub(crate) const UNROUNDING_REACH: usize = PASSES * (5 * ((2 << LEVELS) - 2) - 4 * LEVELS) + 1;

/// Halvings start at multiples of this: rows read separately give the same result if the first one is a multiple.
pub(crate) const UNROUNDING_PHASE: usize = 1 << LEVELS;

/// Moves the components of quantised vectors to the smoothest field within `half_step` of them. Vectors with all
/// components 0 were never written, and stay.
pub(crate) fn unround(stored: &mut Vector3Planes, half_step: f32) {
    unround_wrapped(stored, half_step, [false; 2]);
}

/// [`unround`] of vectors of which left and right borders continue each other, or top and bottom.
pub(crate) fn unround_wrapped(stored: &mut Vector3Planes, half_step: f32, wraps: [bool; 2]) {
    let unwritten = unwritten(stored);
    let whole = Window::from_size(stored.x.width(), stored.x.height());
    let margin = UNROUNDING_REACH.next_multiple_of(UNROUNDING_PHASE);
    let around = with_margins(whole, margin, wraps);
    for plane in [&mut stored.x, &mut stored.y, &mut stored.z] {
        let mut field = plane.repeated(whole, around);
        unround_values(&mut field, half_step, 0);
        *plane = field.crop(around, whole);
        unwritten.iter().for_each(|&i| plane.samples_mut()[i] = 0.0);
    }
}

/// A window with margins where its borders continue each other.
pub(super) fn with_margins(whole: Window, margin: usize, wraps: [bool; 2]) -> Window {
    let [mx, my] = wraps.map(|wraps| i32::from(wraps) * margin as i32);
    Window {
        x0: whole.x0 - mx,
        y0: whole.y0 - my,
        x1: whole.x1 + mx,
        y1: whole.y1 + my,
    }
}

/// Where the vectors are that were never written.
pub(super) fn unwritten(stored: &Vector3Planes) -> Vec<usize> {
    let vectors = stored.vectors().enumerate();
    let unwritten = vectors.filter(|(_, v)| *v == glam::Vec3::ZERO);
    unwritten.map(|(i, _)| i).collect()
}

/// [`unround`] of one plane of values, all of them written. Those in the `margin` are no codes, and move freely.
pub(crate) fn unround_values(field: &mut Plane, half_step: f32, margin: usize) {
    if field.samples().is_empty() {
        return;
    }
    let codes = &field.clone();
    let mut steps = halved(&steps_of(codes, 0.5 / half_step));
    let steps: [Plane; LEVELS] = std::array::from_fn(|_| {
        let next = halved(&steps);
        std::mem::replace(&mut steps, next)
    });
    for level in (1..=LEVELS).rev() {
        // The variance is 4^k for each k below the level, in halving and again in doubling.
        let deviation = (2.0 * (4.0_f32.powi(level as i32) - 1.0) / 3.0).sqrt();
        let share = smoothed(&steps[level - 1])
            .map(|steps| (2.0 - deviation * steps / MOST_STEPS).clamp(0.0, 1.0));
        if share.samples().iter().all(|&share| share == 0.0) {
            continue;
        }
        let share = doubled(share, level, field);
        for _ in 0..PASSES {
            let mut wide = halved(field);
            for _ in 1..level {
                wide = halved(&wide);
            }
            let wide = doubled(without_bias(&wide), level, field);
            toward(field, codes, [&wide, &share], (half_step, margin));
        }
    }
}

/// Moves a field by a share of the way toward the wide neighbourhoods' values, both given at every second sample of
/// every second row, and limits it to half a step from the codes inside a margin.
fn toward(
    field: &mut Plane,
    codes: &Plane,
    halves: [&Plane; 2],
    (half_step, margin): (f32, usize),
) {
    let [width, height] = [field.width(), field.height()];
    let inside = |at: usize, length: usize| (margin..length - margin).contains(&at);
    field.each_row(|y, row| {
        let [mut wide, mut share] = [vec![0.0; row.len()], vec![0.0; row.len()]];
        double_row(halves[0], y, &mut wide);
        double_row(halves[1], y, &mut share);
        let wide = wide.iter().zip(&share).zip(codes.row(y));
        for (x, (sample, ((wide, share), code))) in row.iter_mut().zip(wide).enumerate() {
            let is_code = inside(x, width) & inside(y, height);
            let half_step = if is_code { half_step } else { f32::INFINITY };
            // Not `clamp`, which has to check the order of its bounds.
            let within = wide.min(code + half_step).max(code - half_step);
            *sample += share * (within - *sample);
        }
    });
}

/// Sum of a field's changes from each pixel to the next ones, times `scale`.
fn steps_of(field: &Plane, scale: f32) -> Plane {
    let (width, height) = (field.width(), field.height());
    Plane::of_pixels(width, height, |x, y| {
        let here = field.at(x, y);
        let dx = field.at((x + 1).min(width - 1), y) - here;
        let dy = field.at(x, (y + 1).min(height - 1)) - here;
        scale * (dx * dx + dy * dy).sqrt()
    })
}

/// Twice a mean minus its own mean: restores the amount that the mean takes off a bend.
fn without_bias(mean: &Plane) -> Plane {
    let mut twice = smoothed(mean);
    twice.each_with(mean, |twice, once| *twice = 2.0 * once - *twice);
    twice
}

/// The mean over 3x3 pixels.
pub(super) fn smoothed(plane: &Plane) -> Plane {
    Plane::of_rows(plane.width(), plane.height(), |y, row| {
        let column = weighted(plane, y, &[1.0 / 3.0; 3]);
        for (smooth, three) in row.iter_mut().zip(column.windows(3)) {
            *smooth = (three[0] + three[1] + three[2]) / 3.0;
        }
    })
}

/// Every second sample of every second row, after binomial smoothing over five.
pub(super) fn halved(plane: &Plane) -> Plane {
    let size = [plane.width(), plane.height()].map(|length| length.div_ceil(2));
    Plane::of_rows(size[0], size[1], |y, row| {
        let column = weighted(plane, 2 * y, &[1.0, 4.0, 6.0, 4.0, 1.0].map(|w| w / 16.0));
        let pairs = |from: usize| column[from..].chunks_exact(2);
        let taps = pairs(0).zip(pairs(2)).zip(pairs(4));
        for (half, ((left, here), right)) in row.iter_mut().zip(taps) {
            *half = (left[0] + right[0] + 4.0 * (left[1] + here[1]) + 6.0 * here[0]) / 16.0;
        }
    })
}

/// A plane after this many halvings, upsampled by the same binomials to the first halving of the `whole`.
fn doubled(plane: Plane, halvings: usize, whole: &Plane) -> Plane {
    (1..halvings).rev().fold(plane, |half, finer| {
        let size = [whole.width(), whole.height()].map(|length| length.div_ceil(1 << finer));
        Plane::of_rows(size[0], size[1], |y, row| double_row(&half, y, row))
    })
}

/// Row `y` of the plane at twice the size.
pub(super) fn double_row(half: &Plane, y: usize, row: &mut [f32]) {
    let column = match y % 2 {
        0 => weighted(half, y / 2, &[1.0, 6.0, 1.0].map(|w| w / 8.0)),
        _ => weighted(half, y / 2, &[0.0, 0.5, 0.5]),
    };
    let three = column.iter().zip(&column[1..]).zip(&column[2..]);
    for (pair, ((left, here), right)) in row.chunks_exact_mut(2).zip(three) {
        pair[0] = (left + 6.0 * here + right) / 8.0;
        pair[1] = 0.5 * (here + right);
    }
    if row.len() % 2 == 1
        && let ([.., last], [.., left, here, right, _]) = (row, &column[..])
    {
        *last = (left + 6.0 * here + right) / 8.0;
    }
}

/// The weighted sum of the rows around row `y`, padded by `N / 2` samples on the left and one more on the right; beyond
/// the plane its edge is repeated.
fn weighted<const N: usize>(plane: &Plane, y: usize, weights: &[f32; N]) -> Vec<f32> {
    let (width, reach) = (plane.width(), N / 2);
    let mut sum = vec![0.0; width + 2 * reach + 1];
    for (i, weight) in weights.iter().enumerate() {
        let row = plane.row((y + i).saturating_sub(reach).min(plane.height() - 1));
        for (sum, sample) in sum[reach..].iter_mut().zip(row) {
            *sum += weight * sample;
        }
    }
    let [first, last] = [sum[reach], sum[reach + width - 1]];
    sum[..reach].fill(first);
    sum[reach + width..].fill(last);
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const HALF_STEP: f32 = 1.0 / 255.0;

    fn in_codes(normal: &Vector3Planes) -> Vector3Planes {
        let code = |n: f32| ((0.5 * n + 0.5) * 255.0).round() / 127.5 - 1.0;
        let [x, y, z] = [&normal.x, &normal.y, &normal.z].map(|plane| plane.map(code));
        Vector3Planes { x, y, z }
    }

    /// A flat section of a ball: its curvature is -2 / radius everywhere.
    fn dome(size: usize, radius: f64) -> Vector3Planes {
        Vector3Planes::from_fn(size, size, |x, y| {
            let [x, y] = [x, y].map(|i| (i as f64 + 0.5 - size as f64 / 2.0) / radius);
            DVec3::new(x, -y, (1.0 - x * x - y * y).sqrt())
        })
    }

    /// Root mean square error of the divergence of slopes over 9 pixels, away from the border.
    fn curvature_error(found: &Vector3Planes, exact: &Vector3Planes) -> f64 {
        let slope = |n: DVec3| [-n.x / n.z, n.y / n.z];
        let divergence = |n: &Vector3Planes, x: usize, y: usize| {
            let mut sum = 0.0;
            for i in 0..9 {
                let along = slope(n.at(x + 8, y + i))[0] - slope(n.at(x, y + i))[0];
                sum += along + slope(n.at(x + i, y + 8))[1] - slope(n.at(x + i, y))[1];
            }
            sum / (8.0 * 9.0)
        };
        let (width, border) = (found.x.width(), 24);
        let (mut sum, mut count) = (0.0, 0.0);
        for y in border..width - border - 8 {
            for x in border..width - border - 8 {
                sum += (divergence(found, x, y) - divergence(exact, x, y)).powi(2);
                count += 1.0;
            }
        }
        f64::sqrt(sum / count)
    }

    #[test]
    fn a_dome_in_codes_keeps_a_fifth_of_the_error_of_its_curvature() {
        // Treads of 8, 16, 24 and 31 pixels: a step of 2/255 covers radius * 2/255 on the ball.
        for radius in [1000.0, 2000.0, 3000.0, 4000.0] {
            let exact = dome(320, radius);
            let codes = in_codes(&exact);
            let mut smooth = codes.clone();
            unround(&mut smooth, HALF_STEP);
            let before = curvature_error(&codes, &exact);
            let after = curvature_error(&smooth, &exact);
            assert!(
                after < before / 5.0,
                "{radius}: {before:.1e} to {after:.1e}"
            );
            for (smooth, code) in [(&smooth.x, &codes.x), (&smooth.z, &codes.z)] {
                let moved = smooth.samples().iter().zip(code.samples());
                assert!(
                    moved
                        .map(|(s, c)| (s - c).abs())
                        .all(|d| d < 1.001 * HALF_STEP)
                );
            }
        }
    }

    #[test]
    fn texture_stays_and_so_do_flat_pixels_and_those_never_written() {
        // Bumps of 6 pixels that span 20 codes.
        let bumpy = Vector3Planes::from_fn(96, 80, |x, y| {
            let [x, y] = [x, y].map(|i| 0.08 * (i as f64 * std::f64::consts::TAU / 6.0).sin());
            DVec3::new(x, y, (1.0 - x * x - y * y).sqrt())
        });
        let codes = in_codes(&bumpy);
        let mut smooth = codes.clone();
        unround(&mut smooth, HALF_STEP);
        assert_eq!(smooth.x, codes.x);
        for (width, height) in [(1, 1), (1, 50), (50, 1), (33, 17)] {
            let flat = Vector3Planes::from_fn(width, height, |x, _| match x % 7 {
                3 => DVec3::ZERO,
                _ => DVec3::Z,
            });
            let mut smooth = flat.clone();
            unround(&mut smooth, HALF_STEP);
            assert_eq!(smooth.x.samples(), flat.x.samples());
            let unwritten = |n: &Vector3Planes| n.z.samples().iter().filter(|z| **z == 0.0).count();
            assert_eq!(unwritten(&smooth), unwritten(&flat));
        }
    }

    #[test]
    fn rows_apart_are_those_of_the_whole() {
        let height = 3 * UNROUNDING_REACH;
        let exact = dome(height, 1500.0);
        let part = |from: usize, to: usize, of: &Vector3Planes| {
            let part = |plane: &Plane| {
                let rows = plane.rows_within(0..64, from..to);
                Plane::from_samples(64, to - from, rows.flatten().copied().collect())
            };
            let [x, y, z] = [&of.x, &of.y, &of.z].map(part);
            Vector3Planes { x, y, z }
        };
        let codes = part(0, height, &in_codes(&exact));
        let mut whole = codes.clone();
        unround(&mut whole, HALF_STEP);
        let from = UNROUNDING_REACH.next_multiple_of(UNROUNDING_PHASE);
        let [first, last] = [from, from + UNROUNDING_PHASE + 5];
        let (before, after) = (first - from, last + UNROUNDING_REACH);
        assert!(before > 0 || first >= UNROUNDING_REACH);
        let mut apart = part(before, after, &codes);
        unround(&mut apart, HALF_STEP);
        let rows = part(first - before, last - before, &apart);
        assert_eq!(rows, part(first, last, &whole));
    }
}
