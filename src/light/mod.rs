//! Light made to tell of shape: pure kernels per sample.

pub mod light_warping;
pub mod lights;
pub mod radiance_scaling;
