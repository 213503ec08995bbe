//! The plan on a device of Vulkan, Metal or DirectX 12, as compute passes over storage buffers.
//!
//! A kernel in `shaders` does what the file of the same name in [`crate::shape`], [`crate::light`] or [`crate::line`] does,
//! by the same statements in the same order; numbers and structs come from Rust. What takes double precision there is
//! told by differences here. Between the stages nothing is read back but lists of what lies along the edges of a drawing,
//! and its tone where strokes are lines: lines are found on the CPU.

mod bindings;
mod buffers;
mod choose;
mod constants;
mod device;
mod diffusion;
mod direction_field;
mod direction_fill;
mod draw;
mod draw_strips;
mod edge_lists;
mod enhance;
#[cfg(test)]
mod failures;
mod fault;
mod hatching;
mod kernels;
mod light;
mod light_layers;
mod limits;
mod line_coverage;
mod normal_rays;
mod patches;
mod recorder;
mod relight;
mod run;
mod runner;
mod shape;
mod sheets;
mod sight;
mod strips;
mod surface;
#[cfg(test)]
mod twins;
mod uniforms;
mod wait;

#[cfg(test)]
pub(crate) use device::to_test_on;
pub use device::{Choice, Device};
pub use kernels::kernel_sources;
pub use runner::Runner;
