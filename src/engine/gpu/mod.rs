//! The plan on a device of Vulkan, Metal or DirectX 12, as compute passes over storage buffers.
//!
//! A kernel in `shaders` does what the file of the same name in [`crate::shape`], [`crate::light`] or [`crate::line`] does,
//! by the same statements in the same order; numbers and structs come from Rust. Where the CPU uses
//! double precision, devices work on differences. Between the stages nothing is read back but lists of what lies along the edges of a drawing,
//! and its tone where strokes are lines: lines are found on the CPU.

mod all_kernels;
pub(crate) mod bindings;
mod buffers;
pub(crate) mod choose;
pub(crate) mod constants;
pub(crate) mod device;
pub(crate) mod diffusion;
pub(crate) mod direction_field;
pub(crate) mod direction_fill;
pub(crate) mod draw;
pub(crate) mod draw_strips;
pub(crate) mod edge_lists;
pub(crate) mod enhance;
#[cfg(test)]
pub(crate) mod failures;
pub(crate) mod fault;
pub(crate) mod hatching;
pub(crate) mod kernels;
pub(crate) mod light;
pub(crate) mod light_layers;
pub(crate) mod limits;
pub(crate) mod line_coverage;
pub(crate) mod normal_rays;
pub(crate) mod patches;
pub(crate) mod recorder;
pub(crate) mod relight;
pub(crate) mod run;
pub(crate) mod runner;
pub(crate) mod shape;
pub(crate) mod sheets;
pub(crate) mod sight;
pub(crate) mod strips;
pub(crate) mod surface;
#[cfg(test)]
mod twins;
pub(crate) mod uniforms;
pub(crate) mod wait;

pub use crate::engine::gpu::all_kernels::kernel_sources;
#[cfg(test)]
pub(crate) use crate::engine::gpu::device::to_test_on;
pub use crate::engine::gpu::device::{Choice, Device};
pub use crate::engine::gpu::runner::Runner;
