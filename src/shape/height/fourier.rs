//! Height of a tile without edges, by Fourier transforms: derivatives of the waves that the pixels hold are exact.

use super::Slopes;
use crate::frame::Plane;
use rayon::prelude::*;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Columns that are turned into rows at a time: two cache lines.
const AT_ONCE: usize = 16;

/// The least-squares height of slopes that repeat across all borders, with mean 0.
///
/// For each wave `(kx, ky)` the height that is nearest to the slopes `p`, `q` is `-i (kx p + ky q) / (kx^2 + ky^2)`
/// (Frankot and Chellappa, *A Method for Enforcing Integrability in Shape from Shading Algorithms*, 1988, equation 21).
pub(super) fn height_of_tile(slopes: &Slopes) -> Plane {
    let (width, height) = (slopes.x.width(), slopes.x.height());
    let mut planner = FftPlanner::new();
    // Both slopes are real: one transform does for the two.
    let slopes = slopes.x.samples().iter().zip(slopes.y.samples());
    let mut field: Vec<_> = slopes.map(|(&p, &q)| Complex32::new(p, q)).collect();
    let mut turned = vec![Complex32::default(); field.len()];
    rows(&mut field, &planner.plan_fft_forward(width));
    transpose(&field, width, &mut turned);
    rows(&mut turned, &planner.plan_fft_forward(height));
    heights_of_waves(&turned, [width, height], &mut field);
    rows(&mut field, &planner.plan_fft_inverse(height));
    transpose(&field, height, &mut turned);
    drop(field);
    rows(&mut turned, &planner.plan_fft_inverse(width));
    Plane::from_samples(width, height, turned.iter().map(|z| z.re).collect())
}

/// The waves of the height, from those of the slopes; both have a row for each column of pixels.
fn heights_of_waves(slopes: &[Complex32], [width, height]: [usize; 2], heights: &mut [Complex32]) {
    let [kx, ky] = [width, height].map(frequencies);
    let scale = 1.0 / (width * height) as f32;
    let rows = heights.par_chunks_mut(height).enumerate();
    rows.for_each(|(x, row)| {
        let (own, opposite) = (
            &slopes[x * height..],
            &slopes[(width - x) % width * height..],
        );
        for (y, wave) in row.iter_mut().enumerate() {
            let (f, g) = (own[y], opposite[(height - y) % height].conj());
            let (p, twice_iq) = (0.5 * (f + g), f - g);
            let q = Complex32::new(0.5 * twice_iq.im, -0.5 * twice_iq.re);
            let (kx, ky) = (kx[x], ky[y]);
            let square = kx * kx + ky * ky;
            let along = p * kx + q * ky;
            *wave = match square > 0.0 {
                true => Complex32::new(along.im, -along.re) * (scale / square),
                false => Complex32::default(),
            };
        }
    });
}

/// Angular frequencies per pixel, in the order of a transform. The highest of an even length has no derivative.
fn frequencies(length: usize) -> Vec<f32> {
    let of = |i: usize| match 2 * i {
        twice if twice < length => i as f64,
        twice if twice == length => 0.0,
        _ => i as f64 - length as f64,
    };
    let frequencies = (0..length).map(|i| (TAU * of(i) / length as f64) as f32);
    frequencies.collect()
}

/// Transforms each row.
fn rows(field: &mut [Complex32], fft: &Arc<dyn Fft<f32>>) {
    let scratch = || vec![Complex32::default(); fft.get_inplace_scratch_len()];
    let rows = field.par_chunks_mut(fft.len());
    rows.for_each_init(scratch, |scratch, row| {
        fft.process_with_scratch(row, scratch)
    });
}

/// Turns the columns of a field with rows of `width` into rows.
fn transpose(field: &[Complex32], width: usize, turned: &mut [Complex32]) {
    let height = field.len() / width;
    let blocks = turned.par_chunks_mut(AT_ONCE * height).enumerate();
    blocks.for_each(|(block, columns)| {
        let first = AT_ONCE * block;
        for (y, row) in field.chunks_exact(width).enumerate() {
            let samples = row[first..].iter().take(columns.len() / height);
            for (column, sample) in samples.enumerate() {
                columns[column * height + y] = *sample;
            }
        }
    });
}
