//! Many sweeps of the diffusion operator over one tile, in a single pass down its rows.
//!
//! A sweep of row y needs rows y - 1 to y + 1 of the previous sweep. So while rows enter at the top, every sweep
//! follows the previous one by one row, and a row leaves after all sweeps: the frame is read and written once, and for
//! the rows in flight, a few more than there are sweeps, the last two terms stay in the cache. A tile loses one pixel
//! per sweep at its rim, and starts with that margin.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::simd::Simd;
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::shape::diffusion::tiles::Tile;
use crate::shape::diffusion::{FEW_LEVELS, Faces, LEVELS, Stencil, Update};
use std::ops::Range;

/// Rows are padded to a multiple of this, so that sweeps start and end on whole vectors.
const LANES: usize = 8;

/// Samples of a page of memory.
const PAGE: usize = 1024;

/// Rows processed together by a sweep, while their neighbours are in the first-level cache.
const TOGETHER: usize = 4;

/// A run of sweeps, and its starting state.
#[derive(Debug)]
pub(crate) struct Pass<'a> {
    /// One update per sweep.
    pub(crate) updates: &'a [Update],
    /// The weights of the sum of terms.
    pub(crate) weights: Weights<'a>,
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
    /// Vectors to compute with.
    pub(crate) simd: Simd,
    /// Whether the run has been cancelled.
    pub(crate) memory: &'a Memory,
}

/// The weights of all terms of a recurrence, that of term 0 first.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Weights<'a> {
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

impl Weights<'_> {
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
    /// The weights of the previous and the own term, from those of all terms.
    fn weights(self, of_term: impl Fn(usize) -> f32) -> [f32; 2] {
        match self {
            Self::Own(term) => [0.0, of_term(term)],
            Self::Both(term) => [of_term(term - 1), of_term(term)],
        }
    }

    /// The same for weights by level.
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
pub(crate) struct Results<'a> {
    /// The sums, accumulated in place.
    pub(crate) sums: Vec<VectorRows<'a>>,
    /// The last term.
    pub(crate) last: Option<VectorRows<'a>>,
    /// The term before it.
    pub(crate) earlier: Option<VectorRows<'a>>,
}

/// The rows in flight, in ring buffers.
#[derive(Debug, Default)]
pub(crate) struct WavefrontTile {
    /// Columns left of the tile, and of a whole row.
    pad: usize,
    stride: usize,
    /// Rows of a ring.
    in_flight: usize,
    /// The last even and the last odd term of every row, a ring per component. A term overwrites the one two before it.
    terms: [[Vec<f32>; 2]; 2],
    /// Conductances of the faces left of and above every pixel.
    left: Vec<f32>,
    above: Vec<f32>,
    /// Conductances of two rows.
    open: Vec<f32>,
    /// The sums, one ring per component of each.
    sums: Vec<[Vec<f32>; 2]>,
}

impl WavefrontTile {
    /// Runs `pass` over `tile`; stops early if the run is cancelled.
    pub(crate) fn run(&mut self, pass: &Pass, tile: &Tile, results: &mut Results) {
        let sweeps = pass.updates.len();
        let height = pass.conductance.height();
        self.make_room(sweeps, tile.columns.len(), results.sums.len());
        // Rows that sweep `k` must produce so that later ones can produce the tile.
        let rows = |k: usize| {
            let rim = sweeps - k;
            tile.rows.start.saturating_sub(rim)..(tile.rows.end + rim).min(height)
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
            if (front..front + TOGETHER).contains(&height) {
                // No flow through the lower border of the picture.
                let above = self.row(height);
                self.above[above].fill(0.0);
            }
            for k in 1..=sweeps {
                for y in at_work(front, k) {
                    self.sweep(pass, k, y, tile);
                }
            }
            for y in at_work(front, sweeps) {
                self.leave(sweeps, y, tile, results);
            }
        }
    }

    fn make_room(&mut self, sweeps: usize, columns: usize, sums: usize) {
        self.pad = (sweeps + LANES).next_multiple_of(LANES);
        self.stride = (self.pad + columns + sweeps + LANES).next_multiple_of(LANES) + LANES;
        if self.stride.is_multiple_of(PAGE) {
            // Neighbouring rows would lie whole pages apart: a load from one then waits for stores to the other.
            self.stride += LANES;
        }
        self.in_flight = sweeps + TOGETHER + 1;
        let ring = self.in_flight * self.stride;
        let refill = |buffer: &mut Vec<f32>, samples: usize| {
            buffer.clear();
            buffer.resize(samples, 0.0);
        };
        self.terms
            .iter_mut()
            .flatten()
            .for_each(|terms| refill(terms, ring));
        self.sums.resize_with(sums, Default::default);
        self.sums
            .iter_mut()
            .flatten()
            .for_each(|sum| refill(sum, ring));
        refill(&mut self.left, ring);
        refill(&mut self.above, ring);
        refill(&mut self.open, 2 * self.stride);
    }

    /// Position of row `y` in a ring.
    fn row(&self, y: usize) -> Range<usize> {
        let start = y % self.in_flight * self.stride;
        start..start + self.stride
    }

    /// Loads row `y`: terms, conductances of its faces, and the sum so far.
    fn enter(&mut self, pass: &Pass, tile: &Tile, y: usize, is_first: bool, results: &mut Results) {
        let stride = self.stride;
        // Columns of the picture read by the sweeps, and their position in the row.
        let reach = pass.updates.len();
        let picture = tile.columns.start.saturating_sub(reach)
            ..(tile.columns.end + reach).min(pass.conductance.width());
        let at = picture.start + self.pad - tile.columns.start;
        let count = picture.len();

        let row = self.row(y);
        for (k, term) in [(0, pass.earlier), (1, Some(pass.last))] {
            let planes = term.map(|term| [&term.x, &term.y]);
            for (c, ring) in self.terms[k].iter_mut().enumerate() {
                let terms = &mut ring[row.clone()][at..at + count];
                match planes {
                    Some(planes) => terms.copy_from_slice(&planes[c].row(y)[picture.clone()]),
                    None => terms.fill(0.0),
                }
            }
        }

        let (even, odd) = self.open.split_at_mut(stride);
        let (open, open_above) = if y.is_multiple_of(2) {
            (even, odd)
        } else {
            (odd, even)
        };
        open[at..at + count].copy_from_slice(&pass.conductance.row(y)[picture]);
        let left = &mut self.left[row.clone()];
        let above = &mut self.above[row.clone()];
        pass.simd
            .face_conductance_row(&mut left[1..], open, &open[1..]);
        if is_first {
            // The upper border of the picture, or a face that no sweep reads.
            above.fill(0.0);
        } else {
            pass.simd.face_conductance_row(above, open, open_above);
        }

        if tile.rows.contains(&y) {
            let columns = self.tile_columns(y, tile);
            for (ring, rows) in self.sums.iter_mut().zip(&results.sums) {
                for (ring, rows) in ring.iter_mut().zip(rows) {
                    match pass.first_term {
                        0 => ring[columns.clone()].fill(0.0),
                        _ => ring[columns.clone()].copy_from_slice(rows[y - tile.rows.start]),
                    }
                }
            }
        }
    }

    /// Row `y` of sweep `k`, which computes term `k + 1` from the previous ones.
    fn sweep(&mut self, pass: &Pass, k: usize, y: usize, tile: &Tile) {
        let rim = pass.updates.len() - k;
        // Only where the row is covered: elsewhere all terms are 0.
        let span = pass.mask.span(y);
        let first = span.start.max(tile.columns.start.saturating_sub(rim));
        let last = span.end.min(tile.columns.end + rim);
        if first >= last {
            return;
        }
        let start = (first + self.pad - tile.columns.start) / LANES * LANES;
        let end = (last + self.pad - tile.columns.start).next_multiple_of(LANES);
        let columns = start..end;

        let (row, below) = (self.row(y), self.row(y + 1));
        // At the borders of the picture any row will do as neighbour: the face is closed.
        let above = self.row(y + self.in_flight - 1);
        let faces = Faces {
            left: &self.left[row.clone()][start..end + 1],
            above: &self.above[row.clone()][columns.clone()],
            below: &self.above[below.clone()][columns.clone()],
        };
        let [even, odd] = &mut self.terms;
        let (made, [out_x, out_y]) = if k.is_multiple_of(2) {
            (even, odd)
        } else {
            (odd, even)
        };
        let stencil = |c: usize| Stencil {
            above: &made[c][above.clone()][columns.clone()],
            at: &made[c][row.clone()][start - 1..end + 1],
            below: &made[c][below.clone()][columns.clone()],
        };
        let g = [stencil(0), stencil(1)];
        let out = [
            &mut out_x[row.clone()][columns.clone()],
            &mut out_y[row.clone()][columns.clone()],
        ];
        pass.simd.sweep_row(out, g, faces, pass.updates[k - 1]);
        if let Some(added) = pass.added_at(k)
            && tile.rows.contains(&y)
        {
            self.add(pass, added, k, y, tile);
        }
    }

    /// Adds terms to the sums in row `y`, right after sweep `k` has computed one.
    fn add(&mut self, pass: &Pass, added: Added, k: usize, y: usize, tile: &Tile) {
        let columns = self.tile_columns(y, tile);
        let [even, odd] = &self.terms;
        let (before, own) = if k.is_multiple_of(2) {
            (even, odd)
        } else {
            (odd, even)
        };
        let terms = |c: usize| [&before[c][columns.clone()], &own[c][columns.clone()]];
        match pass.weights {
            Weights::None => {}
            Weights::Sums(all) => {
                for (sum, of_sum) in self.sums.iter_mut().zip(all) {
                    let weights = added.weights(|term| of_sum.get(term).copied().unwrap_or(0.0));
                    if weights == [0.0; 2] {
                        continue;
                    }
                    for (c, sum) in sum.iter_mut().enumerate() {
                        pass.simd
                            .add_terms_row(&mut sum[columns.clone()], terms(c), weights);
                    }
                }
            }
            Weights::ByLevel {
                levels,
                are_few,
                weights,
            } => {
                let [sum_x, sum_y] = &mut self.sums[0];
                let sum = [&mut sum_x[columns.clone()], &mut sum_y[columns.clone()]];
                let terms = [terms(0), terms(1)];
                let levels = &levels.row(y)[tile.columns.clone()];
                let [before, own] = added.of_levels(weights);
                if are_few {
                    let few = [few_levels(before), few_levels(own)];
                    pass.simd
                        .add_terms_by_few_levels_row(sum, terms, levels, few);
                } else {
                    let all = [before, own];
                    pass.simd.add_terms_by_level_row(sum, terms, levels, all);
                }
            }
        }
    }

    /// Position of row `y` of the tile in a ring.
    fn tile_columns(&self, y: usize, tile: &Tile) -> Range<usize> {
        let start = self.row(y).start + self.pad;
        start..start + tile.columns.len()
    }

    /// Outputs row `y`, which has passed all sweeps.
    fn leave(&self, sweeps: usize, y: usize, tile: &Tile, results: &mut Results) {
        let tile_row = y - tile.rows.start;
        let columns = self.tile_columns(y, tile);
        // Sweep k has computed a term with the parity of k + 1.
        let [earlier, last] = [&self.terms[sweeps % 2], &self.terms[(sweeps + 1) % 2]];
        let terms = [(&mut results.last, last), (&mut results.earlier, earlier)];
        let terms = terms
            .into_iter()
            .filter_map(|(rows, ring)| Some((rows.as_mut()?, ring)));
        for (rows, ring) in results.sums.iter_mut().zip(&self.sums).chain(terms) {
            for (rows, ring) in rows.iter_mut().zip(ring) {
                write_row(rows[tile_row], &ring[columns.clone()]);
            }
        }
    }
}

/// The weights of the first levels.
fn few_levels(weights: &[f32; LEVELS]) -> &[f32; FEW_LEVELS] {
    weights.first_chunk().expect("there are more levels in all")
}

/// Copies a row. Negative zeros become positive: their sign may come from beyond a closed face and so depend on the
/// tile.
fn write_row(out: &mut [f32], row: &[f32]) {
    for (out, value) in out.iter_mut().zip(row) {
        *out = value + 0.0;
    }
}
