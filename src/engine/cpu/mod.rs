//! The CPU backend: rows in parallel by rayon, the same bits for any number of threads.

pub(crate) mod frame_cache;
#[cfg(feature = "gpu")]
pub(crate) mod gpu_support;
pub(crate) mod lanes;
pub(crate) mod memory;
pub(crate) mod percentile;
pub(crate) mod row_layers;
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
use crate::frame::Frame;
use crate::plan::Plan;

/// Runs a plan without inputs beside `frame`, in the caller's rayon pool.
///
/// # Errors
/// As [`Runner::execute`].
pub(crate) fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    Runner::default().execute(plan, frame, Inputs::default())
}
