//! Materials under lights: what each reflects of one light.

use super::exponent::Exponent;
use super::scaled::Scaled;
use super::terms::{Arriving, TermInputs, Terms};
use crate::light::batch::{BATCH, Lanes, LitPixels};
use crate::light::brdf::{AshikhminShirley, BASE_SCALE, GRAZING, passed};
use crate::light::cosines::{at_most_1, positive, scalar_product};
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

impl Shading {
    /// The same by the diffuse lobe alone.
    pub(crate) fn diffuse(self) -> Self {
        Self {
            lobes: self.lobes.diffuse(),
            ..self
        }
    }
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
    /// Mirrored light alone, as [`mirror_lobe`] has it: in place of diffuse light what follows the reflectance, in place of
    /// specular light what is mirrored at grazing angles.
    Mirror,
    /// Its base alone.
    Base,
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

    /// The diffuse lobe alone.
    pub(crate) fn diffuse(self) -> Self {
        match self {
            Self::Phong { .. } | Self::BlinnPhong { .. } => Self::Diffuse {
                power: Exponent::Integer(1),
            },
            Self::AshikhminShirley(_) => Self::Base,
            Self::Diffuse { .. } | Self::Mirror | Self::Base => self,
        }
    }

    /// The share of diffuse light, prefiltered as the base's, that the surface shows.
    #[inline(always)]
    pub(crate) fn base_share(&self, pixels: &LitPixels) -> Lanes {
        match self {
            Self::AshikhminShirley(_) => pixels.coat.base.map(|leaving| leaving / BASE_SCALE),
            _ => [1.0; BATCH],
        }
    }

    /// Computes the images under the inverse warps of the vectors that these lobes use beside the normal.
    #[inline(always)]
    pub(crate) fn unwarp_axes(&self, pixels: &mut LitPixels) {
        let unwarp = &pixels.unwarp;
        match self {
            Self::Diffuse { .. } | Self::Base | Self::BlinnPhong { far: true, .. } => {}
            Self::Phong { .. } => pixels.mirrored.unwarp(unwarp),
            Self::BlinnPhong { far: false, .. } | Self::Mirror => pixels.to_eye.unwarp(unwarp),
            Self::AshikhminShirley(_) => {
                pixels.to_eye.unwarp(unwarp);
                pixels.along.unwarp(unwarp);
                pixels.across.unwarp(unwarp);
            }
        }
    }

    /// Computes what these lobes show toward the eye of every pixel, if that takes more than directions.
    #[inline(always)]
    pub(crate) fn see(&self, pixels: &mut LitPixels) {
        let Self::AshikhminShirley(brdf) = self else {
            return;
        };
        for i in 0..BATCH {
            let eye = pixels.to_eye.at(i);
            pixels.coat.eye[0][i] = scalar_product(pixels.along.at(i), eye);
            pixels.coat.eye[1][i] = scalar_product(pixels.across.at(i), eye);
            let cosine = at_most_1(positive(scalar_product(pixels.normal.at(i), eye)));
            pixels.coat.per_cosine[i] = 1.0 / cosine.max(GRAZING);
            pixels.coat.base[i] = brdf.leaving(cosine);
        }
    }

    /// Whether there is a lobe other than the diffuse one.
    pub(crate) fn are_glossy(&self) -> bool {
        !matches!(self, Self::Diffuse { .. } | Self::Base)
    }
}

/// What `brdf.wgsl` takes of the lobes.
#[cfg(feature = "gpu")]
impl Lobes {
    /// Its switches: which lobes these are.
    pub(crate) fn switches(this: Option<Self>) -> [(&'static str, bool); 3] {
        [
            ("PHONG", matches!(this, Some(Self::Phong { .. }))),
            ("BLINN_PHONG", matches!(this, Some(Self::BlinnPhong { .. }))),
            (
                "ASHIKHMIN_SHIRLEY",
                matches!(this, Some(Self::AshikhminShirley(_))),
            ),
        ]
    }

    /// The exponent of the lobe; 1 if it has none or others.
    pub(crate) fn exponent(&self) -> Exponent {
        match self {
            Self::Diffuse { power } | Self::Phong { power } | Self::BlinnPhong { power, .. } => {
                *power
            }
            Self::AshikhminShirley(_) | Self::Mirror | Self::Base => Exponent::Integer(1),
        }
    }

    /// Its other numbers, `params.lobe_0` to `lobe_3`.
    pub(crate) fn numbers(&self) -> [f32; 4] {
        match self {
            Self::Diffuse { .. }
            | Self::Phong { .. }
            | Self::BlinnPhong { .. }
            | Self::Mirror
            | Self::Base => [0.0; 4],
            Self::AshikhminShirley(coat) => {
                let [along, across] = coat.coat;
                [along, across, coat.normalisation, coat.reflectance]
            }
        }
    }
}

impl TermInputs {
    /// Computes the diffuse and specular terms of a light.
    #[inline(always)]
    pub(super) fn reflect<D, H, S>(
        &mut self,
        terms: &mut Terms,
        pixels: &LitPixels,
        shading: &Shading,
        light: Arriving<D, H, S>,
    ) where
        D: Fn(usize) -> [f32; 3] + Copy,
        H: Fn(usize) -> [f32; 3] + Copy,
        S: Fn(usize) -> f32 + Copy,
    {
        let Arriving {
            direction, half, ..
        } = light;
        let unwarped = shading.warped.then_some(half);
        let far = matches!(shading.lobes, Lobes::BlinnPhong { far: true, .. });
        match (shading.warped, far) {
            (false, _) => self.arrive(pixels, light),
            (true, _) => self.arrive_unwarped(pixels, light),
        }
        if far && !shading.warped {
            self.half_vector_lobe(pixels, half);
        }
        if let Some(toward) = shading.scaled.and_then(|scaled| scaled.toward_light) {
            self.curve_toward(pixels, toward, unwarped, direction);
        }
        match shading.lobes {
            Lobes::Diffuse { power } => {
                if power != Exponent::Integer(1) {
                    power.raise(&mut self.cosine);
                }
                self.scale_cosine(&mut terms.diffuse, pixels, shading.scaled);
            }
            Lobes::Phong { power } => {
                self.product(&pixels.mirrored, unwarped, direction, 0);
                for i in 0..BATCH {
                    self.lobe[i] = at_most_1(positive(self.products[0][i]));
                }
                power.raise(&mut self.lobe);
                self.scale_cosine(&mut terms.diffuse, pixels, shading.scaled);
                self.scale_lobe(&mut terms.specular, pixels, shading.scaled, |_, weight| {
                    weight
                });
            }
            Lobes::BlinnPhong { power, far } => {
                if !far {
                    self.half_way(pixels, unwarped, direction);
                }
                power.raise(&mut self.lobe);
                self.scale_cosine(&mut terms.diffuse, pixels, shading.scaled);
                let weigh = |cosine, weight| weight * cosine;
                self.scale_lobe(&mut terms.specular, pixels, shading.scaled, weigh);
            }
            Lobes::Base => {
                self.scale_cosine(&mut terms.diffuse, pixels, shading.scaled);
                for i in 0..BATCH {
                    let passed = passed(positive(self.cosine[i]));
                    terms.diffuse[i] *= pixels.coat.base[i] * passed;
                }
            }
            Lobes::AshikhminShirley(brdf) => {
                let axes = [&pixels.to_eye, &pixels.along, &pixels.across];
                for (k, axis) in axes.into_iter().enumerate() {
                    self.product(axis, unwarped, direction, k);
                }
                self.coat(terms, pixels, shading.scaled, &brdf);
            }
            Lobes::Mirror => {
                self.half_way(pixels, unwarped, direction);
                self.mirror(terms, pixels, shading.scaled);
            }
        }
    }
}
