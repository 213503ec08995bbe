//! Diffusion of the gradient, by steps or by expansion, tile by tile.

use super::simd::Simd;
use super::tiles::Tiling;
use super::wave::{Pass, Results, VectorRows, Wave};
use crate::frame::{Mask, Plane, Vector2Planes};
use crate::params::RunOptions;
use crate::plan::Sweeps;
use crate::shape::diffusion::Update;
use rayon::prelude::*;

/// The gradient after all sweeps.
///
/// The sweeps are done in passes of several at once; what a pass leaves to the next are the last two
/// terms of the recurrence and, of an expansion, the sum so far.
pub(super) fn diffusion(
    gradient: Vector2Planes,
    conductance: &Plane,
    mask: &Mask,
    sweeps: &Sweeps,
    options: &RunOptions,
) -> Vector2Planes {
    let tiling = Tiling::new(mask, options.tile);
    let (updates, weights) = recurrence(sweeps);
    if updates.is_empty() {
        return gradient;
    }
    let passes = updates.len().div_ceil(options.sweeps_per_pass.get()).max(1);
    let per_pass = updates.len().div_ceil(passes).max(1);

    let blank = || {
        let plane = || Plane::filled(mask.width(), mask.height(), 0.0);
        Vector2Planes {
            x: plane(),
            y: plane(),
        }
    };
    let expands = !weights.is_empty();
    let mut sum = expands.then(blank);
    let (mut last, mut earlier) = (gradient, None);
    let mut spare = (None, None);
    for (i, updates) in updates.chunks(per_pass).enumerate() {
        let first = i * per_pass;
        let pass = Pass {
            updates,
            weights: weights.get(first..).unwrap_or(&[]),
            last: &last,
            earlier: earlier.as_ref(),
            conductance,
            simd: Simd::widest(),
        };
        // An expansion needs no term past its end, a step no term but the last.
        let goes_on = i + 1 < passes;
        let mut next_last = (goes_on || !expands).then(|| spare.0.take().unwrap_or_else(blank));
        let mut next_earlier = (goes_on && expands).then(|| spare.1.take().unwrap_or_else(blank));
        let results = results_by_tile(&tiling, [&mut sum, &mut next_last, &mut next_earlier]);
        tiling
            .tiles()
            .par_iter()
            .zip(results)
            .for_each_init(Wave::default, |wave, (tile, mut results)| {
                wave.run(&pass, tile, &mut results)
            });
        if let Some(next) = next_last {
            spare = (Some(std::mem::replace(&mut last, next)), earlier.take());
            earlier = next_earlier;
        }
    }
    sum.unwrap_or(last)
}

/// The update of every sweep, and what their terms are added up with, if they are.
fn recurrence(sweeps: &Sweeps) -> (Vec<Update>, &[f32]) {
    match sweeps {
        Sweeps::Explicit { count, time_step } => {
            (vec![Update::Step(*time_step); *count as usize], &[])
        }
        Sweeps::Chebyshev(coefficients) => {
            let mut updates = vec![Update::Next; coefficients.len() - 1];
            if let Some(first) = updates.first_mut() {
                *first = Update::First;
            }
            (updates, coefficients)
        }
    }
}

/// Where each tile writes, given the planes for the sum, the last term and the one before.
fn results_by_tile<'a>(
    tiling: &Tiling,
    planes: [&'a mut Option<Vector2Planes>; 3],
) -> Vec<Results<'a>> {
    let [sum, last, earlier] = planes.map(|planes| match planes {
        None => None,
        Some(Vector2Planes { x, y }) => {
            let rows = tiling.cut(x).into_iter().zip(tiling.cut(y));
            Some(rows.map(|(x, y)| [x, y]))
        }
    });
    let (mut sum, mut last, mut earlier) = (sum, last, earlier);
    let next =
        |rows: &mut Option<_>| -> Option<VectorRows<'a>> { rows.as_mut().and_then(Iterator::next) };
    tiling
        .tiles()
        .iter()
        .map(|_| Results {
            sum: next(&mut sum),
            last: next(&mut last),
            earlier: next(&mut earlier),
        })
        .collect()
}
