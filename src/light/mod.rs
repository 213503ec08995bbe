//! Light made to tell of shape: pure kernels per sample.

pub mod layers;
pub mod lights;
pub mod radiance_scaling;
