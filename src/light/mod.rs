//! Light made to tell of shape: pure kernels per sample.

pub mod radiance_scaling;
