//! How the lights of a run act: lobes, their exponents, warping and scaling.

use crate::fast_math::{exp, ln};
use crate::light::batch::{Lanes, Pixels};
use crate::light::brdf::AshikhminShirley;
use crate::params::{Material, MaterialParams};

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

/// Radiance scaling inside the sum.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scaled {
    /// Scaling-invariant point.
    pub invariant_point: f32,
    /// The mapping of curvature, if it depends on the direction of light.
    pub toward_light: Option<TowardLight>,
}

/// A mapping of curvature that depends on the direction of light ([RS] section 4.1).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TowardLight {
    /// Curvature gain, in pixels.
    pub gain: f32,
    /// Anisotropy lambda.
    pub anisotropy: f32,
    /// Magnitudes of diffuse and specular light.
    pub magnitudes: [f32; 2],
}

/// The lobes of a material under lights.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Lobes {
    /// The cosine to a power; 1 is Lambert.
    Diffuse {
        /// The exponent zeta.
        power: Exponent,
    },
    /// Lambert, and Phong's lobe about the mirrored view.
    Phong {
        /// The exponent eta.
        power: Exponent,
    },
    /// Lambert, and Blinn's lobe about the normal.
    BlinnPhong {
        /// The exponent eta, halved, since it applies to the square of the cosine.
        power: Exponent,
        /// Whether the viewer is far away, along z at every pixel.
        far: bool,
    },
    /// See [`AshikhminShirley`].
    AshikhminShirley(AshikhminShirley),
}

impl Lobes {
    /// The lobes of a material lit by a sum over lights; `None` for mirrors and glass.
    pub(crate) fn of(params: &MaterialParams, far: bool) -> Option<Self> {
        match params.material {
            Material::Lambert | Material::Toon => Some(Self::Diffuse {
                power: Exponent::of(1.0),
            }),
            Material::Sublambert => Some(Self::Diffuse {
                power: Exponent::of(params.flatness),
            }),
            Material::Phong => Some(Self::Phong {
                power: Exponent::of(params.shininess),
            }),
            Material::BlinnPhong => Some(Self::BlinnPhong {
                power: Exponent::of(0.5 * params.shininess),
                far,
            }),
            Material::AshikhminShirley => {
                Some(Self::AshikhminShirley(AshikhminShirley::new(params)))
            }
            Material::Mirror | Material::Glass => None,
        }
    }

    /// Computes the images under the inverse warps of the vectors that these lobes use beside the normal.
    #[inline(always)]
    pub(crate) fn unwarp_axes(&self, pixels: &mut Pixels) {
        let unwarp = &pixels.unwarp;
        match self {
            Self::Diffuse { .. } | Self::BlinnPhong { far: true, .. } => {}
            Self::Phong { .. } => pixels.mirrored.unwarp(unwarp),
            Self::BlinnPhong { far: false, .. } => pixels.to_eye.unwarp(unwarp),
            Self::AshikhminShirley(_) => {
                pixels.to_eye.unwarp(unwarp);
                pixels.along.unwarp(unwarp);
                pixels.across.unwarp(unwarp);
            }
        }
    }

    /// Whether there is a lobe other than the diffuse one.
    pub(crate) fn are_glossy(&self) -> bool {
        !matches!(self, Self::Diffuse { .. })
    }
}

/// Largest error of a lobe of this material, with peak 1, for a given error of a cosine.
pub(crate) fn lobe_error(params: &MaterialParams, cosine_error: f64) -> f64 {
    let largest = |exponent: f32| f64::from(exponent) * cosine_error;
    match params.material {
        Material::Phong | Material::BlinnPhong => largest(params.shininess),
        Material::AshikhminShirley => largest(params.coat[0].max(params.coat[1])),
        Material::Sublambert => cosine_error.powf(params.flatness.into()),
        Material::Lambert | Material::Toon | Material::Mirror | Material::Glass => 0.0,
    }
}

/// An exponent: small integers are computed by multiplication.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Exponent {
    /// An integer from 1 on.
    Integer(u32),
    /// Any non-negative number.
    Real(f32),
}

impl Exponent {
    /// Largest integer exponent computed by multiplication: ten squarings cost as much as a logarithm.
    const MOST: f32 = 1024.0;

    /// The representation of this exponent, clamped to at least 0.
    pub(crate) fn of(exponent: f32) -> Self {
        if (1.0..=Self::MOST).contains(&exponent) && exponent.fract() == 0.0 {
            Self::Integer(exponent as u32)
        } else {
            Self::Real(exponent)
        }
    }

    /// Raises numbers from 0 to 1 to this exponent; 0 stays 0.
    #[inline(always)]
    pub(crate) fn raise(self, base: &mut Lanes) {
        match self {
            Self::Integer(exponent) => raise_to_whole(base, exponent),
            Self::Real(exponent) => {
                for x in base.iter_mut() {
                    let raised = exp(exponent * ln(x.max(f32::MIN_POSITIVE)));
                    *x = if *x > 0.0 { raised } else { 0.0 };
                }
            }
        }
    }
}

/// Square-and-multiply from the highest bit of the exponent, a few lanes at a time in registers.
#[inline(always)]
fn raise_to_whole(base: &mut Lanes, exponent: u32) {
    let digits = u32::BITS - exponent.leading_zeros();
    for few in base.as_chunks_mut::<32>().0 {
        let (once, mut raised) = (*few, *few);
        for digit in (0..digits - 1).rev() {
            for x in &mut raised {
                *x *= *x;
            }
            if exponent >> digit & 1 == 1 {
                for i in 0..32 {
                    raised[i] *= once[i];
                }
            }
        }
        *few = raised;
    }
}
