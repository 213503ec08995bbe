//! Anisotropic diffusion of the gradient: the scale of the descriptor.
//!
//! Theory: dg/ds = div(c grad g) ([LW] section 4.3), Neumann at the border of the picture and of coverage. Changes:
//! face conductances are harmonic means, so the operator is conservative and a closed silhouette leaks exactly nothing.
//! Practice: one row of the operator serves both solvers, the paper's explicit steps, stable up to a time step of 1/4,
//! and [`super::chebyshev`].

use crate::engine::cpu::simd::widened;

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod importance;
pub(crate) mod stage;
pub(crate) mod sweeps;
pub(crate) mod tiles;
pub(crate) mod wavefront;

/// Face conductances around one row of pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Faces<'a> {
    /// `left[x]` joins column `x - 1` and `x`; one longer than the row.
    pub left: &'a [f32],
    /// `above[x]` joins this row and the row above.
    pub above: &'a [f32],
    /// `below[x]` joins this row and the row below.
    pub below: &'a [f32],
}

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

/// The rows of a field that a sweep reads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stencil<'a> {
    /// The row above.
    pub above: &'a [f32],
    /// The row itself, and one column more at both of its ends.
    pub at: &'a [f32],
    /// The row below.
    pub below: &'a [f32],
}

/// One row of the diffusion operator on both components of a field, `Lg = sum c_ij (g_j - g_i)` over the 4 neighbours.
/// `out` holds the earlier value, and is replaced by the result of `update`.
///
/// All slices have the length of `out`, except for the extra columns stated by their types.
#[inline(always)]
pub(crate) fn sweep_row(out: [&mut [f32]; 2], g: [Stencil; 2], faces: Faces, update: Update) {
    match update {
        Update::Step(dt) => sweep(out, g, faces, |g, lg, _| {
            Update::Step(dt).updated(g, lg, 0.0)
        }),
        Update::First => sweep(out, g, faces, |g, lg, _| Update::First.updated(g, lg, 0.0)),
        Update::Next => sweep(out, g, faces, |g, lg, earlier| {
            Update::Next.updated(g, lg, earlier)
        }),
    }
}

widened! {
    fn sweep_row(out: [&mut [f32]; 2], g: [Stencil; 2], faces: Faces, update: Update);
}

#[inline(always)]
fn sweep(
    out: [&mut [f32]; 2],
    g: [Stencil; 2],
    faces: Faces,
    updated: impl Fn(f32, f32, f32) -> f32,
) {
    let [out_x, out_y] = out;
    let n = out_x.len();
    let out_y = &mut out_y[..n];
    let (gx, gy) = (Neighbours::new(g[0], n), Neighbours::new(g[1], n));
    let faces = faces.of(n);
    for x in 0..n {
        let joined = faces.around(x);
        out_x[x] = updated(gx.at[x], gx.flux(x, joined), out_x[x]);
        out_y[x] = updated(gy.at[x], gy.flux(x, joined), out_y[x]);
    }
}

impl<'a> Faces<'a> {
    /// The faces of `n` pixels, in slices of known length.
    #[inline(always)]
    fn of(self, n: usize) -> Self {
        Self {
            left: &self.left[..n + 1],
            above: &self.above[..n],
            below: &self.below[..n],
        }
    }

    /// West, east, north and south of a pixel.
    #[inline(always)]
    fn around(&self, x: usize) -> [f32; 4] {
        [self.left[x], self.left[x + 1], self.above[x], self.below[x]]
    }
}

/// The neighbours of a row's samples, in slices of equal length.
struct Neighbours<'a> {
    at: &'a [f32],
    west: &'a [f32],
    east: &'a [f32],
    north: &'a [f32],
    south: &'a [f32],
}

impl<'a> Neighbours<'a> {
    #[inline(always)]
    fn new(g: Stencil<'a>, n: usize) -> Self {
        Self {
            at: &g.at[1..][..n],
            west: &g.at[..n],
            east: &g.at[2..][..n],
            north: &g.above[..n],
            south: &g.below[..n],
        }
    }

    /// The flux into a sample.
    #[inline(always)]
    fn flux(&self, x: usize, joined: [f32; 4]) -> f32 {
        let sides = [self.west[x], self.east[x], self.north[x], self.south[x]];
        flux(self.at[x], sides, joined)
    }
}

/// The flux into a sample from its neighbours west, east, north and south through faces with the given conductances.
/// Opposite neighbours are summed first: a mirrored or turned picture gives the same bits.
#[inline(always)]
pub(crate) fn flux(g: f32, sides: [f32; 4], joined: [f32; 4]) -> f32 {
    let through = |i: usize| joined[i] * (sides[i] - g);
    (through(0) + through(1)) + (through(2) + through(3))
}

/// Adds two weighted terms of a recurrence to a row of a sum.
#[inline(always)]
pub(crate) fn add_terms_row(sum: &mut [f32], terms: [&[f32]; 2], weights: [f32; 2]) {
    let n = sum.len();
    let (first, second) = (&terms[0][..n], &terms[1][..n]);
    for x in 0..n {
        sum[x] += weights[0] * first[x] + weights[1] * second[x];
    }
}

widened! {
    fn add_terms_row(sum: &mut [f32], terms: [&[f32]; 2], weights: [f32; 2]);
}

/// Levels that importance is quantised to.
pub(crate) const LEVELS: usize = 1024;

/// [`add_terms_row`] for both components, with weights by the level of the pixel.
#[inline(always)]
pub(crate) fn add_terms_by_level_row(
    sum: [&mut [f32]; 2],
    terms: [[&[f32]; 2]; 2],
    levels: &[u16],
    weights: [&[f32; LEVELS]; 2],
) {
    add_terms_by(sum, terms, levels, |level| {
        let level = usize::from(level) % LEVELS;
        [weights[0][level], weights[1][level]]
    });
}

widened! {
    fn add_terms_by_level_row(
        sum: [&mut [f32]; 2],
        terms: [[&[f32]; 2]; 2],
        levels: &[u16],
        weights: [&[f32; LEVELS]; 2],
    );
}

/// Number of levels up to which selecting weights for a vector of pixels is faster than looking them up.
pub(crate) const FEW_LEVELS: usize = 8;

/// [`add_terms_by_level_row`] for few levels.
#[inline(always)]
pub(crate) fn add_terms_by_few_levels_row(
    sum: [&mut [f32]; 2],
    terms: [[&[f32]; 2]; 2],
    levels: &[u16],
    weights: [&[f32; FEW_LEVELS]; 2],
) {
    // Copied, so that values are selected rather than addresses to load from.
    let [first, second] = [*weights[0], *weights[1]];
    add_terms_by(sum, terms, levels, |level| {
        let level = i32::from(level);
        [chosen(first, level), chosen(second, level)]
    });
}

widened! {
    fn add_terms_by_few_levels_row(
        sum: [&mut [f32]; 2],
        terms: [[&[f32]; 2]; 2],
        levels: &[u16],
        weights: [&[f32; FEW_LEVELS]; 2],
    );
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

#[inline(always)]
fn add_terms_by(
    sum: [&mut [f32]; 2],
    terms: [[&[f32]; 2]; 2],
    levels: &[u16],
    weights: impl Fn(u16) -> [f32; 2],
) {
    let [sum_x, sum_y] = sum;
    let n = sum_x.len();
    let (sum_y, levels) = (&mut sum_y[..n], &levels[..n]);
    let [[first_x, second_x], [first_y, second_y]] = terms;
    let (first_x, second_x) = (&first_x[..n], &second_x[..n]);
    let (first_y, second_y) = (&first_y[..n], &second_y[..n]);
    for x in 0..n {
        let [first, second] = weights(levels[x]);
        sum_x[x] += first * first_x[x] + second * second_x[x];
        sum_y[x] += first * first_y[x] + second * second_y[x];
    }
}
