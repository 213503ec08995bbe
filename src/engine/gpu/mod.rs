//! The GPU backend: compute passes over storage buffers, on Vulkan, Metal or DirectX 12.
//!
//! This module holds the parts that know no stage, and the runner that combines stages. Kernels and passes of a stage
//! are in its own module: `gpu.rs` beside `cpu.rs`, and WGSL beside the Rust file it mirrors statement by statement;
//! constants, structs and buffers are declared in Rust. Where the CPU uses double precision, devices work on
//! differences. Between stages of shape and picture nothing is read back but what the CPU makes automatic choices from.
//! What is followed from pixel to pixel, the lines and directions of a drawing, comes after that, on the CPU; only strokes
//! of a texture are drawn on the device again.

mod buffers;
pub(crate) mod constants;
pub(crate) mod device;
#[cfg(test)]
pub(crate) mod failures;
pub(crate) mod fault;
pub(crate) mod kernels;
pub(crate) mod limits;
pub(crate) mod recorder;
pub(crate) mod recording;
pub(crate) mod runner;
pub(crate) mod sight;
pub(crate) mod surface;
#[cfg(test)]
mod twins;
pub(crate) mod uniforms;
pub(crate) mod wait;
pub(crate) mod wgsl;

#[cfg(test)]
pub(crate) use crate::engine::gpu::device::to_test_on;
pub use crate::engine::gpu::device::{Choice, Device};
pub use crate::engine::gpu::runner::Runner;
pub(crate) use crate::kernel::last;
