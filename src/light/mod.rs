//! Light made to tell of shape: pure kernels per sample.

pub mod lights;
pub mod radiance_scaling;
