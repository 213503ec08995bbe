//! Running a plan.

mod agreement;
mod around;
mod choice;
pub mod cpu;
pub mod device_times;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod guard;
mod importance;
mod light_terms;
mod palette;
mod stroke_field;
mod surface_rays;

pub use agreement::{
    Layer, Product, difference, direction_difference, ink_difference, products, relit_tolerance,
};
