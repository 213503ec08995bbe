//! Rows in flight, and the kernel that applies the diffusion operator to them.
//!
//! All that a sweep reads of a few neighbouring pixels lies together, aligned to the lines of the cache. The flux
//! through a face is computed once, for the pixels on both of its sides, which see the same number but for its sign;
//! and of four rows that are swept together, the fluxes between them stay in registers.

use crate::kernel::lanes::{shifted_left, shifted_right};
use crate::shape::diffusion::{Update, added, flux, through};

/// Rows that can be swept together.
pub(crate) const TOGETHER: usize = 4;

/// One value for each pixel of a chunk of `N` pixels.
pub(crate) type ChunkLanes<const N: usize> = [f32; N];

/// Neighbouring pixels of a row in flight.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Chunk<const N: usize> {
    /// The last even and the last odd term, x and y of each.
    pub(crate) terms: [[ChunkLanes<N>; 2]; 2],
    /// Conductances of the faces left of the pixels.
    pub(crate) left: ChunkLanes<N>,
    /// Conductances of the faces above the pixels.
    pub(crate) above: ChunkLanes<N>,
}

impl<const N: usize> Chunk<N> {
    /// Zeros behind closed faces.
    pub(crate) const EMPTY: Self = Self {
        terms: [[[0.0; N]; 2]; 2],
        left: [0.0; N],
        above: [0.0; N],
    };
}

/// x and y of a sum of terms, for the pixels of a chunk.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Sum<const N: usize>(pub(crate) [ChunkLanes<N>; 2]);

/// What a sweep computes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlowSweep {
    pub(crate) update: Update,
    /// Which of the terms is read, by its parity; the other one holds the earlier value and is replaced.
    pub(crate) from: usize,
    /// Weights in the sums of the term read and of the term made.
    pub(crate) weights: [f32; 2],
}

/// Calls a kernel compiled for an update, with sums or without.
macro_rules! with_update {
    ($fma:ident, $sweep:ident, $is_without_sums:expr, $by:ident($($arg:expr),*)) => {
        match ($sweep.update, $is_without_sums) {
            (Update::Step(dt), true) => $by::<N, false>($fma, $($arg),*, step(dt)),
            (Update::Step(dt), false) => $by::<N, true>($fma, $($arg),*, step(dt)),
            (Update::First, true) => $by::<N, false>($fma, $($arg),*, first),
            (Update::First, false) => $by::<N, true>($fma, $($arg),*, first),
            (Update::Next, true) => $by::<N, false>($fma, $($arg),*, next($fma)),
            (Update::Next, false) => $by::<N, true>($fma, $($arg),*, next($fma)),
        }
    };
}

#[inline(always)]
fn step(dt: f32) -> impl Fn(f32, f32, f32) -> f32 {
    move |g, lg, _| Update::Step(dt).updated(g, lg, 0.0)
}

#[inline(always)]
fn first(g: f32, lg: f32, _: f32) -> f32 {
    Update::First.updated(g, lg, 0.0)
}

/// [`Update::Next`]. Its factors are powers of two, so that only one sum is rounded in each of the two fused
/// multiply-adds, as it is without them: the bits are the same, but for half of a flux below 2^-126.
#[inline(always)]
fn next(fma: bool) -> impl Fn(f32, f32, f32) -> f32 {
    move |g, lg, earlier| match fma {
        true => (-0.5_f32).mul_add(lg, -2.0_f32.mul_add(g, earlier)),
        false => Update::Next.updated(g, lg, earlier),
    }
}

/// One row of the diffusion operator on both components of a field, `Lg = sum c_ij (g_j - g_i)` over the 4 neighbours,
/// and its update; adds the weighted terms to `sums` unless these are empty.
///
/// All slices have the same chunks. The first and the last one are only read, as neighbours.
#[inline(always)]
pub(crate) fn sweep_row<const N: usize>(
    fma: bool,
    above: &[Chunk<N>],
    row: &mut [Chunk<N>],
    below: &[Chunk<N>],
    sums: &mut [Sum<N>],
    sweep: FlowSweep,
) {
    #[inline(always)]
    fn by<const N: usize, const SUMMED: bool>(
        fma: bool,
        above: &[Chunk<N>],
        row: &mut [Chunk<N>],
        below: &[Chunk<N>],
        sums: &mut [Sum<N>],
        sweep: FlowSweep,
        updated: impl Fn(f32, f32, f32) -> f32,
    ) {
        let count = row.len();
        let (above, below) = (&above[..count], &below[..count]);
        let mut row = SweptRow::<N, SUMMED>::new(fma, row, sums, sweep, count);
        for i in 1..count.saturating_sub(1) {
            let mut from_above = row.fluxes_from(i, &above[i]);
            row.step(i, &mut from_above, &below[i], &updated);
        }
    }
    with_update!(
        fma,
        sweep,
        sums.is_empty(),
        by(above, row, below, sums, sweep)
    );
}

/// [`sweep_row`] on four rows, top to bottom, between the rows above and below them.
#[inline(always)]
pub(crate) fn sweep_rows<const N: usize>(
    fma: bool,
    above: &[Chunk<N>],
    rows: [&mut [Chunk<N>]; TOGETHER],
    below: &[Chunk<N>],
    sums: [&mut [Sum<N>]; TOGETHER],
    sweep: FlowSweep,
) {
    #[inline(always)]
    fn by<const N: usize, const SUMMED: bool>(
        fma: bool,
        above: &[Chunk<N>],
        [a, b, c, d]: [&mut [Chunk<N>]; TOGETHER],
        below: &[Chunk<N>],
        [sum_a, sum_b, sum_c, sum_d]: [&mut [Sum<N>]; TOGETHER],
        sweep: FlowSweep,
        updated: impl Fn(f32, f32, f32) -> f32,
    ) {
        let count = a.len();
        let (above, below) = (&above[..count], &below[..count]);
        let mut a = SweptRow::<N, SUMMED>::new(fma, a, sum_a, sweep, count);
        let mut b = SweptRow::<N, SUMMED>::new(fma, b, sum_b, sweep, count);
        let mut c = SweptRow::<N, SUMMED>::new(fma, c, sum_c, sweep, count);
        let mut d = SweptRow::<N, SUMMED>::new(fma, d, sum_d, sweep, count);
        for i in 1..count.saturating_sub(1) {
            let mut from_above = a.fluxes_from(i, &above[i]);
            a.step(i, &mut from_above, &b.chunks[i], &updated);
            b.step(i, &mut from_above, &c.chunks[i], &updated);
            c.step(i, &mut from_above, &d.chunks[i], &updated);
            d.step(i, &mut from_above, &below[i], &updated);
        }
    }
    with_update!(
        fma,
        sweep,
        sums[0].is_empty(),
        by(above, rows, below, sums, sweep)
    );
}

/// A row while it is swept, from left to right.
struct SweptRow<'a, const N: usize, const SUMMED: bool> {
    fma: bool,
    chunks: &'a mut [Chunk<N>],
    sums: &'a mut [Sum<N>],
    sweep: FlowSweep,
    /// The fluxes from the west into the chunk that is next, of x and y.
    from_west: (ChunkLanes<N>, ChunkLanes<N>),
}

// Both components are written out: kept in arrays, they would pass through memory.
impl<'a, const N: usize, const SUMMED: bool> SweptRow<'a, N, SUMMED> {
    #[inline(always)]
    fn new(
        fma: bool,
        chunks: &'a mut [Chunk<N>],
        sums: &'a mut [Sum<N>],
        sweep: FlowSweep,
        count: usize,
    ) -> Self {
        let from = sweep.from % 2;
        let from_west = match &chunks[..count] {
            [before, at, ..] => {
                let (before, here) = (&before.terms[from], &at.terms[from]);
                (
                    fluxes_from_west::<N>(fma, &before[0], &here[0], &at.left),
                    fluxes_from_west::<N>(fma, &before[1], &here[1], &at.left),
                )
            }
            _ => ([0.0; N], [0.0; N]),
        };
        Self {
            fma,
            chunks: &mut chunks[..count],
            sums: &mut sums[..if SUMMED { count } else { 0 }],
            sweep: FlowSweep { from, ..sweep },
            from_west,
        }
    }

    /// The fluxes from the row above into chunk `i`.
    #[inline(always)]
    fn fluxes_from(&self, i: usize, above: &Chunk<N>) -> (ChunkLanes<N>, ChunkLanes<N>) {
        let (at, from) = (&self.chunks[i], self.sweep.from);
        let (out_of, into) = (&above.terms[from], &at.terms[from]);
        (
            fluxes(&at.above, &out_of[0], &into[0]),
            fluxes(&at.above, &out_of[1], &into[1]),
        )
    }

    /// Sweeps chunk `i` with the fluxes from above, and replaces these by the fluxes into the chunk below.
    #[inline(always)]
    fn step(
        &mut self,
        i: usize,
        from_above: &mut (ChunkLanes<N>, ChunkLanes<N>),
        below: &Chunk<N>,
        updated: &impl Fn(f32, f32, f32) -> f32,
    ) {
        let next = &self.chunks[i + 1];
        let (terms, joined) = (next.terms[self.sweep.from], next.left);
        let (west, above) = (self.from_west, *from_above);
        let x = self.component(
            i,
            0,
            (west.0, above.0),
            (&terms[0], &joined),
            below,
            updated,
        );
        let y = self.component(
            i,
            1,
            (west.1, above.1),
            (&terms[1], &joined),
            below,
            updated,
        );
        (self.from_west, *from_above) = ((x.0, y.0), (x.1, y.1));
    }

    /// Sweeps component `c` of a chunk with the fluxes from west and north. Returns those into the chunks to the east,
    /// whose terms and faces are `next`, and below.
    #[inline(always)]
    fn component(
        &mut self,
        i: usize,
        c: usize,
        (west, north): (ChunkLanes<N>, ChunkLanes<N>),
        next: (&ChunkLanes<N>, &ChunkLanes<N>),
        below: &Chunk<N>,
        updated: &impl Fn(f32, f32, f32) -> f32,
    ) -> (ChunkLanes<N>, ChunkLanes<N>) {
        let (from, to) = (self.sweep.from, 1 - self.sweep.from);
        let at = &mut self.chunks[i];
        let g = at.terms[from][c];
        let past_east = fluxes_from_west::<N>(self.fma, &g, next.0, next.1);
        let east = shifted_left::<N>(self.fma, &west, &past_east);
        let south = fluxes(&below.above, &g, &below.terms[from][c]);
        let mut made = at.terms[to][c];
        for j in 0..N {
            let lg = flux([west[j], -east[j], north[j], -south[j]]);
            made[j] = updated(g[j], lg, made[j]);
        }
        at.terms[to][c] = made;
        if SUMMED {
            let sum = &mut self.sums[i].0[c];
            for j in 0..N {
                sum[j] = added(self.fma, sum[j], self.sweep.weights, [g[j], made[j]]);
            }
        }
        (past_east, south)
    }
}

/// The fluxes through faces, out of samples on one side into those on the other.
#[inline(always)]
fn fluxes<const N: usize>(
    joined: &ChunkLanes<N>,
    out_of: &ChunkLanes<N>,
    into: &ChunkLanes<N>,
) -> ChunkLanes<N> {
    let mut fluxes = [0.0; N];
    for j in 0..N {
        fluxes[j] = through(joined[j], out_of[j], into[j]);
    }
    fluxes
}

/// The fluxes from the west into the samples `at`, right of the samples `before`.
#[inline(always)]
fn fluxes_from_west<const N: usize>(
    fma: bool,
    before: &ChunkLanes<N>,
    at: &ChunkLanes<N>,
    left: &ChunkLanes<N>,
) -> ChunkLanes<N> {
    fluxes(left, &shifted_right::<N>(fma, before, at), at)
}
