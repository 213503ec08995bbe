//! Lines along the surface: the directions they follow. Pure kernels, no files, threads or clock.

pub mod direction;
pub mod direction_field;
pub mod normal_rays;
pub mod patches;
