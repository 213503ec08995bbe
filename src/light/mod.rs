//! Light that brings out shape: radiance scaling, light warping, lights and reflectance, as pure per-sample kernels.

pub mod albedo;
pub(crate) mod alignment;
pub(crate) mod batch;
pub mod brdf;
pub(crate) mod cosines;
pub(crate) mod enhancement;
pub mod environment;
pub mod environment_layout;
pub(crate) mod glossy;
pub(crate) mod intensity;
pub mod irradiance;
pub(crate) mod layers;
pub mod light_samples;
pub mod light_warping;
pub mod lights;
pub mod lit_sphere;
pub mod median_cut;
pub(crate) mod mixing;
pub(crate) mod occlusion_grain;
pub(crate) mod octahedral;
pub(crate) mod prepared_environment;
pub mod radiance_scaling;
pub(crate) mod relight;
pub(crate) mod shadows;
pub(crate) mod sum;
pub(crate) mod texels;
pub(crate) mod tones;
pub(crate) mod white_level;
mod white_search;

pub(crate) use texels::sane;
