//! The CPU backend: rows in parallel by rayon, the same bits for any number of threads.

pub(crate) mod frame_cache;
pub(crate) mod lanes;
pub(crate) mod memory;
pub(crate) mod percentile;
pub(crate) mod row_layers;
pub(crate) mod rows;
pub(crate) mod run;
pub(crate) mod runner;
pub(crate) mod simd;
pub(crate) mod strips;

pub(crate) use crate::engine::cpu::run::Runner;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::error::Result;

use crate::fast_math::Function;
use crate::frame::Frame;
use crate::plan::Plan;

/// Runs a plan without inputs beside `frame`, in the caller's rayon pool.
///
/// # Errors
/// As [`Runner::execute`].
pub(crate) fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    Runner::default().execute(plan, frame, Inputs::default())
}

/// Evaluates an elementary function over a row with the widest vectors of this machine, as the stages do.
pub(crate) fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    simd::Simd::widest().map_row(function, out, x);
}

/// Bits of this machine's widest vectors.
pub(crate) fn vector_bits() -> u32 {
    simd::Simd::widest().bits()
}
