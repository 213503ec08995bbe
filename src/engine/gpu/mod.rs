//! The GPU backend: compute passes over storage buffers, on Vulkan, Metal or DirectX 12.
//!
//! This module holds the runner that combines stages; the tools that it shares with them are in `crate::gpu`. Kernels and
//! passes of a stage are in its own module: `gpu.rs` beside `cpu.rs`, and WGSL beside the Rust file it mirrors statement
//! by statement; constants, structs and buffers are declared in Rust. Where the CPU uses double precision, devices work
//! on differences. Between stages of shape and picture nothing is read back but what the CPU makes automatic choices
//! from. What is followed from pixel to pixel, the lines and directions of a drawing, comes after that, on the CPU; only
//! strokes of a texture are drawn on the device again.

#[cfg(test)]
pub(crate) mod failures;
pub(crate) mod runner;
#[cfg(test)]
mod twins;

pub use crate::engine::gpu::runner::DeviceRunner;
#[cfg(test)]
pub(crate) use crate::gpu::device::to_test_on;
pub use crate::gpu::device::{AdapterKind, Device};
