//! Running a plan.

pub mod cpu;
pub mod device_times;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod guard;
pub mod outcome;
pub(crate) mod tolerances;

pub use crate::engine::tolerances::{
    difference, direction_difference, ink_difference, relit_tolerance,
};
