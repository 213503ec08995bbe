//! Radiance scaling of the lights of a run.

use crate::params::Magnitude;

/// Radiance scaling inside the sum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scaled {
    /// Scaling-invariant point.
    pub invariant_point: f32,
    /// The mapping of curvature, if it depends on the direction of light.
    pub toward_light: Option<TowardLight>,
}

/// A mapping of curvature that depends on the direction of light ([RS] section 4).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TowardLight {
    /// Curvature gain, in pixels.
    pub gain: f32,
    /// Anisotropy lambda.
    pub anisotropy: f32,
    /// Magnitudes of diffuse and specular light.
    pub magnitudes: [Magnitude; 2],
}
