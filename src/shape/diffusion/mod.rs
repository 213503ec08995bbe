//! Anisotropic diffusion of the gradient: the scale of the descriptor.
//!
//! Theory: dg/ds = div(c grad g) ([LW] section 4.3), Neumann at the border of the picture and of coverage. Changes:
//! face conductances are harmonic means, so the operator is conservative and a closed silhouette leaks exactly nothing.
//! Practice: one row of the operator serves both solvers, the paper's explicit steps, stable up to a time step of 1/4,
//! and [`super::chebyshev`].

use crate::kernel::lanes::multiply_add;
use kernel::{Chunk, Sum};

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod importance;
pub(crate) mod kernel;
pub(crate) mod medium;
pub(crate) mod stage;
pub(crate) mod still;
pub(crate) mod sweeps;
pub(crate) mod tiles;
pub(crate) mod wavefront;

/// Pixels read to each side by one step.
pub(crate) const REACH: usize = 1;

/// The update in a sweep, from a sample g, the flux Lg into it and an earlier value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Update {
    /// An explicit step of the given length: g + dt Lg.
    Step(f32),
    /// The first step of the Chebyshev recurrence: T_1 = X g with X = -L/4 - 1.
    First,
    /// Later steps: T_k+1 = 2 X T_k - T_k-1.
    Next,
}

impl Update {
    /// The next value of a sample g with the flux `lg` into it.
    #[inline(always)]
    pub(crate) fn updated(self, g: f32, lg: f32, earlier: f32) -> f32 {
        match self {
            Self::Step(dt) => g + dt * lg,
            Self::First => -0.25 * lg - g,
            Self::Next => -0.5 * lg - (2.0 * g + earlier),
        }
    }
}

/// The flux through a face, out of a sample on one side into that on the other.
#[inline(always)]
pub(crate) fn through(joined: f32, out_of: f32, into: f32) -> f32 {
    joined * (out_of - into)
}

/// The flux into a sample, from those through its faces west, east, north and south. Opposite faces are summed first: a
/// mirrored or turned picture gives the same bits.
#[inline(always)]
pub(crate) fn flux(through: [f32; 4]) -> f32 {
    (through[0] + through[1]) + (through[2] + through[3])
}

/// A sum with two weighted terms of a recurrence added.
#[inline(always)]
pub(crate) fn added(fma: bool, sum: f32, weights: [f32; 2], terms: [f32; 2]) -> f32 {
    let sum = multiply_add(fma, weights[0], terms[0], sum);
    multiply_add(fma, weights[1], terms[1], sum)
}

/// Adds two weighted terms of a recurrence to a row of a sum, first the one that the last sweep has read.
#[inline(always)]
pub(crate) fn add_terms_row<const N: usize>(
    fma: bool,
    sums: &mut [Sum<N>],
    row: &[Chunk<N>],
    read: usize,
    weights: [f32; 2],
) {
    add_terms_by::<N>(fma, sums, row, read, |_, _| weights);
}

/// Levels that importance is quantised to.
pub(crate) const LEVELS: usize = 1024;

/// [`add_terms_row`] with weights by the level of the pixel.
#[inline(always)]
pub(crate) fn add_terms_by_level_row<const N: usize>(
    fma: bool,
    sums: &mut [Sum<N>],
    row: &[Chunk<N>],
    read: usize,
    levels: &[[u16; N]],
    weights: [&[f32; LEVELS]; 2],
) {
    add_terms_by::<N>(fma, sums, row, read, |i, j| {
        let level = usize::from(levels[i][j]) % LEVELS;
        [weights[0][level], weights[1][level]]
    });
}

/// Number of levels up to which selecting weights for a vector of pixels is faster than looking them up.
pub(crate) const FEW_LEVELS: usize = 8;

/// [`add_terms_by_level_row`] for few levels.
#[inline(always)]
pub(crate) fn add_terms_by_few_levels_row<const N: usize>(
    fma: bool,
    sums: &mut [Sum<N>],
    row: &[Chunk<N>],
    read: usize,
    levels: &[[u16; N]],
    weights: [&[f32; FEW_LEVELS]; 2],
) {
    // Copied, so that values are selected rather than addresses to load from.
    let [first, second] = [*weights[0], *weights[1]];
    add_terms_by::<N>(fma, sums, row, read, |i, j| {
        let level = i32::from(levels[i][j]);
        [chosen(first, level), chosen(second, level)]
    });
}

/// The value of a level, without a look-up: selects among pairs, then among pairs of pairs, by the bits of its number.
#[inline(always)]
fn chosen(values: [f32; FEW_LEVELS], level: i32) -> f32 {
    // All ones if the bit is set. The compiler keeps selections by mask; it would turn a selection of values into one
    // of addresses to load from.
    let mask = |bit: i32| -((level >> bit) & 1) as u32;
    let either = |mask: u32, no: u32, yes: u32| no ^ (mask & (no ^ yes));
    let (low, middle, high) = (mask(0), mask(1), mask(2));
    let pair = |i: usize| either(low, values[i].to_bits(), values[i + 1].to_bits());
    let four = |i: usize| either(middle, pair(i), pair(i + 2));
    f32::from_bits(either(high, four(0), four(4)))
}

/// Adds terms with weights by chunk and lane, for the term read and for the one made.
#[inline(always)]
fn add_terms_by<const N: usize>(
    fma: bool,
    sums: &mut [Sum<N>],
    row: &[Chunk<N>],
    read: usize,
    weights: impl Fn(usize, usize) -> [f32; 2],
) {
    let (from, to) = (read % 2, 1 - read % 2);
    for (i, Sum(sum)) in sums.iter_mut().enumerate() {
        // Opaque, or the compiler would gather one lane of many chunks instead of taking a chunk whole.
        let i = std::hint::black_box(i);
        let (of_read, of_made) = (row[i].terms[from], row[i].terms[to]);
        let (mut x, mut y) = (sum[0], sum[1]);
        for j in 0..N {
            let weights = weights(i, j);
            x[j] = added(fma, x[j], weights, [of_read[0][j], of_made[0][j]]);
            y[j] = added(fma, y[j], weights, [of_read[1][j], of_made[1][j]]);
        }
        *sum = [x, y];
    }
}
