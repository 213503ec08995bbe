//! Many sweeps of the diffusion operator over one tile, in a single pass down its rows.
//!
//! A sweep of row y needs rows y - 1 to y + 1 of the previous sweep. So while rows enter at the top, every sweep
//! follows the previous one by one row, and a row leaves after all sweeps: the frame is read and written once, and for
//! the rows in flight, a few more than there are sweeps, the last two terms stay in the cache. A tile loses one pixel
//! per sweep at its rim, and starts with that margin.

use crate::frame::memory::Memory;
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::kernel::simd::wide;
use crate::shape::conductance;
use crate::shape::diffusion::kernel::{self, Chunk, ChunkLanes, FlowSweep, Sum, TOGETHER};
use crate::shape::diffusion::still::Moving;
use crate::shape::diffusion::tiles::TrimmedTile;
use crate::shape::diffusion::{self, FEW_LEVELS, LEVELS, Update};
use std::ops::Range;

/// Rows of this many pixels lie whole pages of memory apart.
const PIXELS_OF_PAGES: usize = 512;

/// A run of sweeps, and its starting state.
#[derive(Debug)]
pub(crate) struct Pass<'a> {
    /// One update per sweep.
    pub(crate) updates: &'a [Update],
    /// The weights of the sum of terms.
    pub(crate) weights: TermWeights<'a>,
    /// Number of the starting term; 0 at the beginning of the recurrence.
    pub(crate) first_term: usize,
    /// Whether this is the last pass.
    pub(crate) is_final: bool,
    /// The starting term.
    pub(crate) last: &'a Vector2Planes,
    /// The term before it, if there is one and it is needed.
    pub(crate) earlier: Option<&'a Vector2Planes>,
    /// Conductance of the pixels.
    pub(crate) conductance: &'a Plane,
    /// Coverage: the terms are 0 outside.
    pub(crate) mask: &'a Mask,
    /// The parts that sweeps may change: no others are read or written.
    pub(crate) moving: &'a Moving,
    /// Whether left and right borders are joined, and upper and lower ones.
    pub(crate) wraps: [bool; 2],
    /// Vectors to compute with.
    /// Whether the run has been cancelled.
    pub(crate) memory: &'a Memory,
}

/// The weights of all terms of a recurrence, that of term 0 first.
#[derive(Debug, Clone, Copy)]
pub(crate) enum TermWeights<'a> {
    /// No sum.
    None,
    /// One list of weights per sum; terms beyond its end have weight 0.
    Sums(&'a [Vec<f32>]),
    /// One sum with weights by the level of the pixel.
    ByLevel {
        levels: &'a Plane<u16>,
        /// Whether there are at most [`FEW_LEVELS`].
        are_few: bool,
        weights: &'a [[f32; LEVELS]],
    },
}

impl TermWeights<'_> {
    /// Number of sums.
    pub(crate) fn sums(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Sums(sums) => sums.len(),
            Self::ByLevel { .. } => 1,
        }
    }
}

impl Pass<'_> {
    /// The terms that sweep `k` adds to the sums: odd terms are added together with the one before. So the order of
    /// summation does not depend on the passes.
    fn added_at(&self, k: usize) -> Option<Added> {
        let own = self.first_term + k;
        if !own.is_multiple_of(2) {
            Some(Added::Both(own))
        } else if self.is_final && k == self.updates.len() {
            Some(Added::Own(own))
        } else {
            None
        }
    }
}

/// Terms to add, by number.
#[derive(Debug, Clone, Copy)]
enum Added {
    /// The sweep's own term.
    Own(usize),
    /// The previous term and the sweep's own.
    Both(usize),
}

impl Added {
    /// The weights of the previous and the own term in a sum with these weights.
    fn of_sum(self, weights: &[f32]) -> [f32; 2] {
        let of_term = |term: usize| weights.get(term).copied().unwrap_or(0.0);
        match self {
            Self::Own(term) => [0.0, of_term(term)],
            Self::Both(term) => [of_term(term - 1), of_term(term)],
        }
    }

    /// The same by level.
    fn of_levels(self, of_term: &[[f32; LEVELS]]) -> [&[f32; LEVELS]; 2] {
        match self {
            Self::Own(term) => [&[0.0; LEVELS], &of_term[term]],
            Self::Both(term) => [&of_term[term - 1], &of_term[term]],
        }
    }
}

/// Rows of a tile in both planes of a vector field.
pub(crate) type VectorRows<'a> = [Vec<&'a mut [f32]>; 2];

/// Destination of a tile's results.
#[derive(Debug, Default)]
pub(crate) struct TileTarget<'a> {
    /// The sums, accumulated in place.
    pub(crate) sums: Vec<VectorRows<'a>>,
    /// The last term.
    pub(crate) last: Option<VectorRows<'a>>,
    /// The term before it.
    pub(crate) earlier: Option<VectorRows<'a>>,
}

/// The rows in flight, in ring buffers, in chunks of `N` pixels.
#[derive(Debug, Default)]
pub(crate) struct WavefrontTile<const N: usize> {
    /// Columns left of the tile, in whole chunks.
    pad: usize,
    /// The columns of the picture within reach, and their position in the row.
    columns: Vec<(Range<usize>, usize)>,
    /// Chunks of a row.
    stride: usize,
    /// Rows of a ring.
    in_flight: usize,
    /// The last two terms of every row and the conductances of its faces. A term overwrites the one two before it.
    chunks: Vec<Chunk<N>>,
    /// The sums, a ring for each.
    sums: Vec<Vec<Sum<N>>>,
    /// The levels of the pixels, if weights depend on them.
    levels: Vec<[u16; N]>,
    /// Conductances of two rows, by parity.
    open: [Vec<f32>; 2],
    /// Conductances of the faces left of and above the pixels of a row that enters.
    left: Vec<f32>,
    above: Vec<f32>,
}

impl<const N: usize> WavefrontTile<N> {
    /// Runs `pass` over `tile`; stops early if the run is cancelled.
    pub(crate) fn run(&mut self, pass: &Pass, tile: &TrimmedTile, results: &mut TileTarget) {
        let sweeps = pass.updates.len();
        let height = pass.conductance.height();
        self.make_room(pass, tile.columns.len(), results.sums.len());
        self.find_columns(pass, tile);
        // Joined borders: rows continue above and below, numbered from as many whole pictures above as are reached.
        let (above, bottom) = match pass.wraps[1] {
            true => (height * sweeps.div_ceil(height), usize::MAX),
            false => (0, height),
        };
        let tile = &TrimmedTile {
            columns: tile.columns.clone(),
            rows: tile.rows.start + above..tile.rows.end + above,
        };
        // Rows that sweep `k` must produce so that later ones can produce the tile.
        let rows = |k: usize| {
            let rim = sweeps - k;
            tile.rows.start.saturating_sub(rim)..(tile.rows.end + rim).min(bottom)
        };
        // The rows processed by sweep `k` while those from `front` on enter.
        let at_work = |front: usize, k: usize| {
            let all = rows(k);
            front.saturating_sub(k).max(all.start)
                ..(front + TOGETHER).saturating_sub(k).min(all.end)
        };
        for front in (rows(0).start..tile.rows.end + sweeps).step_by(TOGETHER) {
            if pass.memory.is_cancelled() {
                return;
            }
            for y in at_work(front, 0) {
                self.enter(pass, tile, y, y == rows(0).start, results);
            }
            if (front..front + TOGETHER).contains(&bottom) {
                // No flow through the lower border of the picture.
                let below = self.row(bottom);
                self.chunks[below].fill(Chunk::EMPTY);
            }
            for k in 1..=sweeps {
                self.sweep(pass, k, at_work(front, k), tile);
            }
            for y in at_work(front, sweeps) {
                self.leave(pass, y, tile, results);
            }
        }
    }

    fn make_room(&mut self, pass: &Pass, columns: usize, sums: usize) {
        let sweeps = pass.updates.len();
        self.pad = sweeps.next_multiple_of(N) + N;
        self.stride = (self.pad + columns + sweeps).div_ceil(N) + 1;
        if (self.stride * N).is_multiple_of(PIXELS_OF_PAGES) {
            // Loads from one row would wait for stores to the next, and compete with it for places in the cache.
            self.stride += 1;
        }
        self.in_flight = sweeps + TOGETHER + 1;
        let ring = self.in_flight * self.stride;
        refill(&mut self.chunks, ring, Chunk::EMPTY);
        self.sums.resize_with(sums, Default::default);
        for sum in &mut self.sums {
            refill(sum, ring, Sum([[0.0; N]; 2]));
        }
        if let TermWeights::ByLevel { .. } = pass.weights {
            refill(&mut self.levels, ring, [0; N]);
        }
        let [even, odd] = &mut self.open;
        for row in [even, odd, &mut self.left, &mut self.above] {
            refill(row, self.stride * N, 0.0);
        }
    }

    /// Finds the columns of the picture in reach of the sweeps, across joined borders as often as they reach.
    fn find_columns(&mut self, pass: &Pass, tile: &TrimmedTile) {
        let (reach, width) = (pass.updates.len(), pass.conductance.width());
        self.columns.clear();
        if !pass.wraps[0] {
            let columns =
                tile.columns.start.saturating_sub(reach)..(tile.columns.end + reach).min(width);
            let at = columns.start + self.pad - tile.columns.start;
            self.columns.push((columns, at));
            return;
        }
        let end = self.pad + tile.columns.len() + reach;
        let mut at = self.pad - reach;
        let mut x = (tile.columns.start + width * reach.div_ceil(width) - reach) % width;
        while at < end {
            let count = (width - x).min(end - at);
            self.columns.push((x..x + count, at));
            (x, at) = (0, at + count);
        }
    }

    /// Position of row `y` in a ring.
    fn row(&self, y: usize) -> Range<usize> {
        let start = y % self.in_flight * self.stride;
        start..start + self.stride
    }

    /// Loads row `y`: terms, conductances of its faces, and the sum so far.
    fn enter(
        &mut self,
        pass: &Pass,
        tile: &TrimmedTile,
        y: usize,
        is_first: bool,
        results: &mut TileTarget,
    ) {
        let in_picture = y % pass.conductance.height();
        let row = self.row(y);
        let [even, odd] = &mut self.open;
        let (open, open_above) = if y.is_multiple_of(2) {
            (even, odd)
        } else {
            (odd, even)
        };
        open.fill(0.0);
        let columns = read(&self.columns, pass.moving, in_picture);
        if columns.clone().next().is_none() {
            self.chunks[row].fill(Chunk::EMPTY);
            return;
        }
        let conductance = pass.conductance.row(in_picture);
        for (columns, at) in columns.clone() {
            open[at..][..columns.len()].copy_from_slice(&conductance[columns]);
        }
        wide!(conductance::face_conductance_row(
            &mut self.left[1..],
            open,
            &open[1..]
        ));
        if is_first {
            // The upper border of the picture, or a face that no sweep reads.
            self.above.fill(0.0);
        } else {
            wide!(conductance::face_conductance_row(
                &mut self.above,
                open,
                open_above
            ));
        }

        let chunks = &mut self.chunks[row.clone()];
        let left = self.left.as_chunks().0.iter();
        let above = self.above.as_chunks().0.iter();
        for (chunk, (&left, &above)) in chunks.iter_mut().zip(left.zip(above)) {
            chunk.terms = Chunk::EMPTY.terms;
            (chunk.left, chunk.above) = (left, above);
        }
        for (k, term) in [(0, pass.earlier), (1, Some(pass.last))] {
            let Some(term) = term else { continue };
            for (c, plane) in [&term.x, &term.y].into_iter().enumerate() {
                for (columns, at) in columns.clone() {
                    let samples = &plane.row(in_picture)[columns];
                    place(chunks, at, samples, |chunk| &mut chunk.terms[k][c]);
                }
            }
        }

        if !tile.rows.contains(&y) {
            return;
        }
        for (ring, rows) in self.sums.iter_mut().zip(&results.sums) {
            let sums = &mut ring[row.clone()];
            sums.fill(Sum([[0.0; N]; 2]));
            if pass.first_term > 0 {
                for (c, rows) in rows.iter().enumerate() {
                    let samples = &rows[y - tile.rows.start];
                    place(sums, self.pad, samples, |sum| &mut sum.0[c]);
                }
            }
        }
        if let TermWeights::ByLevel { levels, .. } = pass.weights {
            let row = self.levels[row].as_flattened_mut();
            row[self.pad..][..tile.columns.len()]
                .copy_from_slice(&levels.row(in_picture)[tile.columns.clone()]);
        }
    }

    /// Rows `at_work` of sweep `k`, which computes term `k` of the pass from the previous ones, and adds it to the sums.
    fn sweep(&mut self, pass: &Pass, k: usize, at_work: Range<usize>, tile: &TrimmedTile) {
        let (rim, height) = (pass.updates.len() - k, pass.mask.height());
        // Only where a row is covered: elsewhere all terms are 0.
        let span = at_work
            .clone()
            .map(|y| pass.mask.span(y % height))
            .filter(|span| !span.is_empty())
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
        let Some(covered) = span else { return };
        // Positions in the row.
        let reached = self.pad - rim..self.pad + tile.columns.len() + rim;
        let first = at_work.start % height;
        let rows = first..(first + at_work.len()).min(height);
        for span in parts(pass.moving.spans(rows), &covered) {
            let at = |x: usize| (x + self.pad).saturating_sub(tile.columns.start);
            let swept = match pass.wraps[0] {
                true => reached.clone(),
                false => reached.start.max(at(span.start))..reached.end.min(at(span.end)),
            };
            self.sweep_columns(pass, k, at_work.clone(), swept);
        }
        if let Some(added) = pass.added_at(k) {
            let tile_rows = at_work.start.max(tile.rows.start)..at_work.end.min(tile.rows.end);
            for y in tile_rows {
                self.add(pass, added, k, y, tile);
            }
        }
    }

    /// [`WavefrontTile::sweep`] at these positions in the rows; of several sums, the first is added to.
    fn sweep_columns(&mut self, pass: &Pass, k: usize, at_work: Range<usize>, swept: Range<usize>) {
        if swept.is_empty() {
            return;
        }
        // With a neighbour at both ends.
        let chunks = swept.start / N - 1..swept.end.div_ceil(N) + 1;
        let weights = match (pass.added_at(k), pass.weights) {
            (Some(added), TermWeights::Sums(all)) => added.of_sum(&all[0]),
            _ => [0.0; 2],
        };
        let sweep = FlowSweep {
            update: pass.updates[k - 1],
            from: k % 2,
            weights,
        };
        let (in_flight, stride) = (self.in_flight, self.stride);
        let part = |y: usize| {
            let start = y % in_flight * stride;
            start + chunks.start..start + chunks.end
        };
        // At the borders of the picture any row will do as neighbour: the face is closed.
        let above = |y: usize| part(y + in_flight - 1);
        let is_summed = weights != [0.0; 2];
        if at_work.len() == TOGETHER {
            let [a, b, c, d] = std::array::from_fn(|i| part(at_work.start + i));
            let own = [a.clone(), b.clone(), c.clone(), d.clone()];
            let all = [above(at_work.start), a, b, c, d, part(at_work.end)];
            let [above, a, b, c, d, below] = apart(&mut self.chunks, all);
            let sums = match self.sums.first_mut() {
                Some(sum) if is_summed => apart(sum, own),
                _ => Default::default(),
            };
            wide!(|fma| kernel::sweep_rows(fma, above, [a, b, c, d], below, sums, sweep));
        } else {
            for y in at_work.clone() {
                let own = part(y);
                let all = [above(y), own.clone(), part(y + 1)];
                let [above, row, below] = apart(&mut self.chunks, all);
                let sums = match self.sums.first_mut() {
                    Some(sum) if is_summed => &mut sum[own],
                    _ => Default::default(),
                };
                wide!(|fma| kernel::sweep_row(fma, above, row, below, sums, sweep));
            }
        }
    }

    /// Adds terms to the sums that sweep `k` has not added to itself, in row `y`.
    fn add(&mut self, pass: &Pass, added: Added, k: usize, y: usize, tile: &TrimmedTile) {
        let columns = self.tile_chunks(y, tile);
        let row = &self.chunks[columns.clone()];
        let read = k % 2;
        match pass.weights {
            TermWeights::None => {}
            TermWeights::Sums(all) => {
                for (sum, of_sum) in self.sums.iter_mut().zip(all).skip(1) {
                    let weights = added.of_sum(of_sum);
                    if weights != [0.0; 2] {
                        let sum = &mut sum[columns.clone()];
                        wide!(|fma| diffusion::add_terms_row(fma, sum, row, read, weights));
                    }
                }
            }
            TermWeights::ByLevel {
                are_few, weights, ..
            } => {
                let sum = &mut self.sums[0][columns.clone()];
                let levels = &self.levels[columns];
                let [before, own] = added.of_levels(weights);
                if are_few {
                    let few = [few_levels(before), few_levels(own)];
                    wide!(|fma| diffusion::add_terms_by_few_levels_row(
                        fma, sum, row, read, levels, few
                    ));
                } else {
                    let all = [before, own];
                    wide!(|fma| diffusion::add_terms_by_level_row(
                        fma, sum, row, read, levels, all
                    ));
                }
            }
        }
    }

    /// Position of the tile's chunks of row `y` in a ring.
    fn tile_chunks(&self, y: usize, tile: &TrimmedTile) -> Range<usize> {
        let start = self.row(y).start + self.pad / N;
        start..start + tile.columns.len().div_ceil(N)
    }

    /// Outputs row `y`, which has passed all sweeps.
    fn leave(&self, pass: &Pass, y: usize, tile: &TrimmedTile, results: &mut TileTarget) {
        let (tile_row, in_picture) = (y - tile.rows.start, y % pass.mask.height());
        let sweeps = pass.updates.len();
        let chunks = self.tile_chunks(y, tile);
        for columns in parts(pass.moving.spans(in_picture..in_picture + 1), &tile.columns) {
            let at = columns.start - tile.columns.start;
            let columns = at..at + columns.len();
            for (rows, ring) in results.sums.iter_mut().zip(&self.sums) {
                for (c, rows) in rows.iter_mut().enumerate() {
                    let row = &mut rows[tile_row][columns.clone()];
                    take(row, &ring[chunks.clone()], at, |sum| &sum.0[c]);
                }
            }
            // Sweep k has made a term with the parity of k + 1.
            let terms = [
                (&mut results.last, sweeps + 1),
                (&mut results.earlier, sweeps),
            ];
            for (rows, term) in terms {
                for (c, rows) in rows.iter_mut().flatten().enumerate() {
                    let row = &mut rows[tile_row][columns.clone()];
                    let chunks = &self.chunks[chunks.clone()];
                    take(row, chunks, at, |chunk| &chunk.terms[term % 2][c]);
                }
            }
        }
    }
}

/// The columns of row `y` of the picture that are read, of those within reach, with their positions in the row.
fn read<'a>(
    within: &'a [(Range<usize>, usize)],
    moving: &'a Moving,
    y: usize,
) -> impl Iterator<Item = (Range<usize>, usize)> + Clone + use<'a> {
    within.iter().flat_map(move |(columns, at)| {
        let parts = parts(moving.spans(y..y + 1), columns);
        parts.map(move |part| (part.clone(), at + part.start - columns.start))
    })
}

/// The parts of ascending spans within `columns`.
fn parts<'a>(
    spans: &'a [Range<usize>],
    columns: &Range<usize>,
) -> impl Iterator<Item = Range<usize>> + Clone + use<'a> {
    let columns = columns.clone();
    let parts = spans.iter();
    let parts = parts.map(move |span| span.start.max(columns.start)..span.end.min(columns.end));
    parts.filter(|part| !part.is_empty())
}

/// Sizes a buffer and sets all of it to `value`.
fn refill<T: Clone>(buffer: &mut Vec<T>, len: usize, value: T) {
    buffer.clear();
    buffer.resize(len, value);
}

/// Parts of a ring that have nothing in common.
///
/// # Panics
/// If they overlap.
fn apart<T, const N: usize>(ring: &mut [T], parts: [Range<usize>; N]) -> [&mut [T]; N] {
    ring.get_disjoint_mut(parts)
        .expect("a ring holds all rows that are swept together, and their neighbours")
}

/// Copies samples into chunks, the first one to lane `at`.
fn place<T, const N: usize>(
    chunks: &mut [T],
    at: usize,
    samples: &[f32],
    lanes: impl Fn(&mut T) -> &mut ChunkLanes<N>,
) {
    let to_whole = at.next_multiple_of(N) - at;
    let (head, rest) = samples.split_at(to_whole.min(samples.len()));
    if !head.is_empty() {
        lanes(&mut chunks[at / N])[at % N..][..head.len()].copy_from_slice(head);
    }
    let (whole, tail) = rest.as_chunks();
    let mut chunks = chunks[at.div_ceil(N)..].iter_mut();
    for (whole, chunk) in whole.iter().zip(&mut chunks) {
        *lanes(chunk) = *whole;
    }
    if let Some(chunk) = chunks.next() {
        lanes(chunk)[..tail.len()].copy_from_slice(tail);
    }
}

/// Copies a row out of chunks, from lane `at` on. Negative zeros become positive: their sign may come from beyond a closed
/// face and so depend on the tile.
fn take<T, const N: usize>(
    row: &mut [f32],
    chunks: &[T],
    at: usize,
    lanes: impl Fn(&T) -> &ChunkLanes<N>,
) {
    let to_whole = at.next_multiple_of(N) - at;
    let (head, rest) = row.split_at_mut(to_whole.min(row.len()));
    let out = |row: &mut [f32], lanes: &[f32]| {
        for (out, value) in row.iter_mut().zip(lanes) {
            *out = value + 0.0;
        }
    };
    if !head.is_empty() {
        out(head, &lanes(&chunks[at / N])[at % N..]);
    }
    let (whole, tail) = rest.as_chunks_mut::<N>();
    let chunks = &chunks[at.div_ceil(N)..];
    for (whole, chunk) in whole.iter_mut().zip(chunks) {
        *whole = lanes(chunk).map(|value| value + 0.0);
    }
    if let Some(chunk) = chunks.get(whole.len()) {
        out(tail, lanes(chunk));
    }
}

/// The weights of the first levels.
fn few_levels(weights: &[f32; LEVELS]) -> &[f32; FEW_LEVELS] {
    weights.first_chunk().expect("there are more levels in all")
}
