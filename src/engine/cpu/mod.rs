//! The plan on the CPU: rows in parallel by rayon, the same bits for any number of threads.

pub(crate) mod frame_cache;
#[cfg(feature = "gpu")]
pub(crate) mod gpu_support;
pub(crate) mod memory;
pub(crate) mod percentile;
pub(crate) mod rows;
pub(crate) mod run;
pub(crate) mod runner;
pub(crate) mod simd;
pub(crate) mod sparing;
pub(crate) mod strips;

pub(crate) use crate::engine::cpu::run::Runner;
use crate::engine::inputs::Inputs;
use crate::engine::outcome::Outcome;
use crate::error::Result;

use crate::fast_math::Function;
use crate::frame::Frame;
use crate::plan::Plan;

/// Runs a plan that takes nothing beside `frame`, in the rayon pool of the caller.
///
/// # Errors
/// As [`Runner::execute`].
pub(crate) fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    Runner::default().execute(plan, frame, Inputs::default())
}

/// Runs an elementary function over a row in the widest vectors that this machine has, as the stages do.
pub(crate) fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    simd::Simd::widest().map_row(function, out, x);
}

/// Bits of the widest vectors that this machine has.
pub(crate) fn vector_bits() -> u32 {
    simd::Simd::widest().bits()
}
