//! Diffusion of the gradient, by explicit steps or by expansion, tile by tile.

use crate::frame::Vector2Planes;
use crate::frame::memory::Memory;
use crate::kernel::simd::Simd;
use crate::params::RunOptions;
use crate::shape::diffusion::medium::Medium;
use crate::shape::diffusion::still::Moving;
use crate::shape::diffusion::sweeps::{DiffusionSchedule, Readout, Recurrence};
use crate::shape::diffusion::tiles::{Tiling, even_tiles};
use crate::shape::diffusion::wavefront::{
    Pass, TermWeights, TileTarget, VectorRows, WavefrontTile,
};
use crate::shape::diffusion::{FEW_LEVELS, Update};
use rayon::prelude::*;

/// Rows of a tile for each sweep of a pass: with more sweeps the rim of tiles, which their neighbours compute as well,
/// would take longer than another pass.
const ROWS_PER_SWEEP: usize = 8;
/// Sweeps of a pass over the lowest tiles: with fewer, planes would be read and written too often.
const SHALLOW: usize = 32;
/// The same for pictures with joined borders, which may be far smaller than a rim.
const SHALLOW_IF_JOINED: usize = 4;

/// The result of diffusion.
#[derive(Debug)]
pub(crate) struct Diffused {
    /// The gradient at every scale.
    pub(crate) scales: Vec<Vector2Planes>,
    /// The number of blocks in which nothing flows, and of all.
    pub(crate) left_out: [usize; 2],
}

/// The gradient after all sweeps, at every scale read out.
///
/// Sweeps are grouped into passes; a pass hands the last two terms of the recurrence and the sums so far to the next.
pub(crate) fn diffusion(
    gradient: Vector2Planes,
    medium: Medium,
    sweeps: &DiffusionSchedule,
    options: &RunOptions,
    memory: &Memory,
) -> Diffused {
    let Medium { mask, wraps, .. } = medium;
    let threads = rayon::current_num_threads();
    let updates = updates(sweeps);
    let pixels = [mask.width(), mask.height()];
    let size = even_tiles(options.tile, pixels, threads, updates.len());
    let tiling = Tiling::new(mask, size);
    let weights = match (&sweeps.readout, medium.importance) {
        (Readout::Sums(sums), _) => TermWeights::Sums(sums),
        (_, Some(levels)) => TermWeights::ByLevel {
            levels: &levels.plane,
            are_few: levels.count <= FEW_LEVELS,
            weights: &levels.weights,
        },
        _ => TermWeights::None,
    };
    let shortest = pixels.into_iter().zip(wraps).filter(|&(_, wraps)| wraps);
    let shortest = shortest
        .map(|(length, _)| length / (2 * ROWS_PER_SWEEP))
        .min();
    let deepest = (size.height.get() / ROWS_PER_SWEEP).max(SHALLOW);
    let deepest = shortest.map_or(deepest, |most| deepest.min(most.max(SHALLOW_IF_JOINED)));
    let passes = updates
        .len()
        .div_ceil(options.sweeps_per_pass.get().min(deepest));
    let per_pass = updates.len().div_ceil(passes.max(1)).max(1);
    let is_expansion = sweeps.recurrence == Recurrence::Chebyshev;

    let blank = || memory.vectors(mask);
    let mut sums: Vec<_> = (0..weights.sums()).map(|_| blank()).collect();
    let mut terms = LastTerms {
        last: gradient,
        earlier: None,
    };
    let mut spare = None;
    let moving = Moving::of(&terms.last, medium);
    let read_out_still = |to: &mut Vector2Planes, weights: &[f32]| {
        if memory.is_cancelled() {
            return;
        }
        for (from, to) in [(&terms.last.x, &mut to.x), (&terms.last.y, &mut to.y)] {
            moving.read_out_still(from, to, weights);
        }
    };
    if let TermWeights::Sums(all) = weights {
        for (sum, weights) in sums.iter_mut().zip(all) {
            let signed = weights.iter().enumerate();
            let signed = signed.map(|(k, &a)| if k % 2 == 0 { a } else { -a });
            read_out_still(sum, &signed.collect::<Vec<_>>());
        }
    } else if sums.is_empty() {
        // Both of the planes that steps go to and fro between have what stays.
        let mut last = blank();
        read_out_still(&mut last, &[1.0]);
        spare = Some(LastTerms {
            last,
            earlier: None,
        });
    }
    for (i, updates) in updates.chunks(per_pass).enumerate() {
        let pass = Pass {
            updates,
            weights,
            first_term: i * per_pass,
            is_final: i + 1 == passes,
            last: &terms.last,
            earlier: terms.earlier.as_ref(),
            conductance: medium.conductance,
            mask,
            moving: &moving,
            wraps,
            memory,
        };
        let goes_on = i + 1 < passes;
        if goes_on || sums.is_empty() {
            let (last, earlier) = spare.take().map_or((None, None), LastTerms::into_parts);
            let mut next = LastTerms {
                last: last.unwrap_or_else(blank),
                // Explicit steps need only the last term.
                earlier: is_expansion.then(|| earlier.unwrap_or_else(blank)),
            };
            run_pass(&pass, &tiling, &mut sums, Some(&mut next));
            spare = Some(std::mem::replace(&mut terms, next));
        } else {
            run_pass(&pass, &tiling, &mut sums, None);
        }
    }
    if sums.is_empty() {
        sums.push(terms.last);
    } else {
        memory.recycle([terms.last.x, terms.last.y]);
    }
    let (last, earlier) = spare.map_or((None, None), LastTerms::into_parts);
    let left = [last, earlier, terms.earlier].into_iter().flatten();
    memory.recycle(left.flat_map(|Vector2Planes { x, y }| [x, y]));
    Diffused {
        scales: sums,
        left_out: moving.left_out,
    }
}

/// The last term of a recurrence and, if the next one needs it, the term before.
struct LastTerms {
    last: Vector2Planes,
    earlier: Option<Vector2Planes>,
}

impl LastTerms {
    fn into_parts(self) -> (Option<Vector2Planes>, Option<Vector2Planes>) {
        (Some(self.last), self.earlier)
    }
}

/// The update of every sweep.
fn updates(sweeps: &DiffusionSchedule) -> Vec<Update> {
    match sweeps.recurrence {
        Recurrence::Explicit(time_step) => vec![Update::Step(time_step); sweeps.count()],
        Recurrence::Chebyshev => {
            let mut updates = vec![Update::Next; sweeps.count()];
            if let Some(first) = updates.first_mut() {
                *first = Update::First;
            }
            updates
        }
    }
}

/// Runs a pass over all tiles.
fn run_pass(
    pass: &Pass,
    tiling: &Tiling,
    sums: &mut [Vector2Planes],
    next: Option<&mut LastTerms>,
) {
    let mut results: Vec<TileTarget> = tiling
        .tiles()
        .iter()
        .map(|_| TileTarget::default())
        .collect();
    for sum in sums {
        for (results, rows) in results.iter_mut().zip(rows_by_tile(tiling, sum)) {
            results.sums.push(rows);
        }
    }
    if let Some(next) = next {
        for (results, rows) in results.iter_mut().zip(rows_by_tile(tiling, &mut next.last)) {
            results.last = Some(rows);
        }
        if let Some(earlier) = &mut next.earlier {
            for (results, rows) in results.iter_mut().zip(rows_by_tile(tiling, earlier)) {
                results.earlier = Some(rows);
            }
        }
    }
    // Chunks as wide as the widest vectors; half as wide for the others, which would run out of registers.
    match Simd::widest().bits() {
        512 => run_tiles::<16>(pass, tiling, results),
        _ => run_tiles::<8>(pass, tiling, results),
    }
}

/// Runs a pass over all tiles, in chunks of `N` pixels.
fn run_tiles<const N: usize>(pass: &Pass, tiling: &Tiling, results: Vec<TileTarget>) {
    tiling
        .tiles()
        .par_iter()
        .zip(results)
        .for_each_init(WavefrontTile::<N>::default, |wave, (tile, mut results)| {
            wave.run(pass, tile, &mut results)
        });
}

/// The rows of every tile in both components.
fn rows_by_tile<'a>(
    tiling: &Tiling,
    planes: &'a mut Vector2Planes,
) -> impl Iterator<Item = VectorRows<'a>> {
    let x = tiling.cut(&mut planes.x);
    let y = tiling.cut(&mut planes.y);
    x.into_iter().zip(y).map(|(x, y)| [x, y])
}
