//! Running a plan.

pub mod cpu;
pub mod device_times;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod guard;
pub(crate) mod tolerances;

pub use crate::engine::tolerances::{
    Layer, Product, difference, direction_difference, ink_difference, products, relit_tolerance,
};
