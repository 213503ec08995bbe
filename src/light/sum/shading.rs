//! How the lights of a run act: lobes, warping and scaling.

use crate::light::brdf::Lobes;
use crate::params::Magnitude;

/// Shading by lights, shared by all batches of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shading {
    /// Whether directions are warped.
    pub warped: bool,
    /// Radiance scaling, if any.
    pub scaled: Option<Scaled>,
    /// The lobes.
    pub lobes: Lobes,
}

impl Shading {
    /// The same by the diffuse lobe alone.
    pub(crate) fn diffuse(self) -> Self {
        Self {
            lobes: self.lobes.diffuse(),
            ..self
        }
    }
}

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
