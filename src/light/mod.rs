//! Light made to tell of shape: pure kernels per sample.

mod arctangent;
pub mod environment;
pub mod environment_layout;
pub mod glossy;
pub mod irradiance;
pub mod light_samples;
pub mod lights;
pub mod lit_sphere;
pub mod median_cut;
pub mod radiance_scaling;
mod texels;
