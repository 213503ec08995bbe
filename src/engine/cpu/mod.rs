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

pub use crate::engine::cpu::run::Runner;
pub use crate::engine::cpu::strips::{StripChoice, StripSearch};
use crate::engine::inputs::Inputs;
pub use crate::engine::outcome::{Drawing, Outcome, ScaleShape, Shape};
use crate::error::Result;
pub use crate::frame::CurvaturePlanes;
pub use crate::line::texture_coordinates::cpu::SequenceInputs;
pub use crate::line::texture_coordinates::cpu::TextureCoordinates;

use crate::fast_math::Function;
use crate::frame::Frame;
use crate::plan::Plan;

/// Runs a plan that takes nothing beside `frame`, in the rayon pool of the caller.
///
/// # Errors
/// As [`Runner::execute`].
pub fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    Runner::default().execute(plan, frame, Inputs::default())
}

/// Runs an elementary function over a row in the widest vectors that this machine has, as the stages do.
pub fn map_row(function: Function, out: &mut [f32], x: &[f32]) {
    simd::Simd::widest().map_row(function, out, x);
}

/// Bits of the widest vectors that this machine has.
pub fn vector_bits() -> u32 {
    simd::Simd::widest().bits()
}
