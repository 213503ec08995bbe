//! The terms of one light at every pixel of a batch: arrival, reflection by the lobes, scaling.

use super::exponent::Exponent;
use super::shading::{Scaled, Shading, TowardLight};
use crate::light::batch::{Axis, BATCH, CurveLanes, Lanes, Pixels, Term, at};
use crate::light::brdf::{
    AshikhminShirley, Cosines, Lobes, MIRROR_PEAK, facets, grazing, mirror_lobe,
};
use crate::light::cosines::{at_most_1, positive, scalar_product};
use crate::light::light_warping::MOST_BRIGHTENED;
use crate::light::radiance_scaling::ScalingCurve;
use crate::shape::curvature::mapped_curvature_toward;

/// Squared length below which a light is opposite the eye, and has no half vector with it.
pub(crate) const SHORTEST: f32 = 1e-12;

/// A light at a pixel: its direction, its half vector with z, its attenuation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arriving {
    pub(crate) direction: [f32; 3],
    pub(crate) half: [f32; 3],
    pub(crate) share: f32,
}

/// Inputs of the terms of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Incidence {
    /// Jacobian, without the pixel's factor, and attenuation.
    pub(crate) weight: f32,
    /// n . l, at most [`MOST_BRIGHTENED`] times that of the light as given.
    pub(crate) cosine: f32,
    /// One over the squared length of the half vector under the inverse warp.
    pub(crate) inverse: f32,
}

/// Unwarps a light, with its Jacobian, for the given normal, its x and y under the inverse of Lambda, and the square of
/// that inverse (xx, twice xy, yy).
#[inline(always)]
pub(crate) fn arrive_unwarped(
    light: Arriving,
    (n, g): ([f32; 3], [f32; 2]),
    squared: [f32; 3],
) -> Incidence {
    let [x, y, z] = light.half;
    let length = z * z + squared[0] * (x * x) + squared[1] * (x * y) + squared[2] * (y * y);
    let inverse = 1.0 / length;
    let along = g[0] * x + g[1] * y + n[2] * z;
    let cosine = 2.0 * z * (along * inverse) - n[2];
    let most = MOST_BRIGHTENED * scalar_product(n, light.direction);
    Incidence {
        weight: light.share * (inverse * inverse),
        cosine: if cosine < most { cosine } else { most },
        inverse,
    }
}

/// The dot product of a vector and the direction of light: as given, or unwarped, where `inverse` is
/// [`Incidence::inverse`] and `unwarped` the vector's x and y under the inverse of Lambda.
#[inline(always)]
pub(crate) fn product<const WARPED: bool>(
    light: Arriving,
    inverse: f32,
    (vector, unwarped): ([f32; 3], [f32; 2]),
) -> f32 {
    if !WARPED {
        return scalar_product(vector, light.direction);
    }
    let h = light.half;
    let along = unwarped[0] * h[0] + unwarped[1] * h[1] + vector[2] * h[2];
    2.0 * h[2] * inverse * along - vector[2]
}

/// x and y of the unwarped direction of light, with `inverse` from [`Incidence::inverse`].
#[inline(always)]
pub(crate) fn unwarped_xy([xx, xy, yy]: [f32; 3], [x, y, z]: [f32; 3], inverse: f32) -> [f32; 2] {
    let twice = 2.0 * z * inverse;
    [twice * (xx * x + xy * y), twice * (xy * x + yy * y)]
}

/// The square of n . h, with h half-way between light and eye, from the dot products of light, eye and normal.
#[inline(always)]
pub(crate) fn half_way(light_eye: f32, light_normal: f32, normal_eye: f32) -> f32 {
    let along = positive(light_normal + normal_eye);
    let squared = 2.0 + 2.0 * light_eye;
    at_most_1(along * along / squared.max(SHORTEST))
}

/// A light that meets the surface at one pixel.
struct Meeting<'a, const WARPED: bool> {
    pixels: &'a Pixels,
    lane: usize,
    light: Arriving,
    arrived: Incidence,
}

impl<'a, const WARPED: bool> Meeting<'a, WARPED> {
    #[inline(always)]
    fn new(pixels: &'a Pixels, lane: usize, light: Arriving) -> Self {
        let (normal, unwarped) = pixels.normal.pair(lane);
        let mut arrived = match WARPED {
            true => {
                let squared = at(&pixels.unwarp_squared, lane);
                let arrived = arrive_unwarped(light, (normal, unwarped), squared);
                Incidence {
                    weight: arrived.weight * pixels.spread[lane],
                    ..arrived
                }
            }
            false => Incidence {
                weight: light.share,
                cosine: scalar_product(normal, light.direction),
                inverse: 1.0,
            },
        };
        let is_above = arrived.cosine > 0.0;
        if !is_above {
            (arrived.weight, arrived.cosine) = (0.0, 0.0);
        }
        Self {
            pixels,
            lane,
            light,
            arrived,
        }
    }

    /// The dot product of the direction of light with a vector of the pixel.
    #[inline(always)]
    fn product(&self, axis: &Axis) -> f32 {
        product::<WARPED>(self.light, self.arrived.inverse, axis.pair(self.lane))
    }

    /// The square of n . h.
    #[inline(always)]
    fn half_way(&self) -> f32 {
        let Pixels { normal, to_eye, .. } = self.pixels;
        // n . l is recomputed, since the cosine may be limited.
        let normal_eye = scalar_product(normal.at(self.lane), to_eye.at(self.lane));
        half_way(self.product(to_eye), self.product(normal), normal_eye)
    }

    /// x and y of the direction of light.
    #[inline(always)]
    fn direction_xy(&self) -> [f32; 2] {
        if WARPED {
            let unwarp = at(&self.pixels.unwarp, self.lane);
            return unwarped_xy(unwarp, self.light.half, self.arrived.inverse);
        }
        let [x, y, _] = self.light.direction;
        [x, y]
    }

    /// Diffuse light, before its cosine is raised to a power.
    #[inline(always)]
    fn diffuse(&self) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        Reflected {
            cosine,
            diffuse: weight,
            ..Reflected::NONE
        }
    }

    /// Lambert, and Phong's lobe before it is raised to a power.
    #[inline(always)]
    fn phong(&self) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        Reflected {
            cosine,
            lobe: at_most_1(positive(self.product(&self.pixels.mirrored))),
            diffuse: weight * cosine,
            specular: weight,
        }
    }

    /// Lambert, and Blinn's lobe before it is raised to a power.
    #[inline(always)]
    fn blinn_phong(&self) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        Reflected {
            cosine,
            lobe: self.half_way(),
            diffuse: weight * cosine,
            specular: weight * cosine,
        }
    }

    /// The base of the coated model.
    #[inline(always)]
    fn base(&self, brdf: &AshikhminShirley) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        Reflected {
            cosine,
            diffuse: weight * brdf.diffuse(cosine, self.pixels.normal_eye(self.lane)),
            ..Reflected::NONE
        }
    }

    /// Light reflected by the coated model.
    #[inline(always)]
    fn coat(&self, brdf: &AshikhminShirley) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        let Pixels {
            to_eye,
            along,
            across,
            ..
        } = self.pixels;
        let eye = to_eye.at(self.lane);
        let part = |axis: &Axis| self.product(axis) + scalar_product(axis.at(self.lane), eye);
        // h = (l + e) / |l + e|, |l + e|^2 = 2 + 2 l.e, and h.e is half of |l + e|.
        let squared = (2.0 + 2.0 * self.product(to_eye)).max(SHORTEST);
        let inverse = 1.0 / squared.sqrt();
        let cosines = Cosines {
            nl: cosine,
            ne: self.pixels.normal_eye(self.lane),
            he: at_most_1(0.5 * squared * inverse),
            hu: part(along) * inverse,
            hv: part(across) * inverse,
        };
        // n . h, from the parts of h along and across the grain.
        let aside = cosines.hu * cosines.hu + cosines.hv * cosines.hv;
        Reflected {
            cosine,
            lobe: positive(1.0 - aside).sqrt(),
            diffuse: weight * brdf.diffuse(cosine, cosines.ne),
            specular: weight * brdf.specular(cosines),
        }
    }

    /// Mirrored light: that of the reflectance as diffuse, that of grazing as specular.
    #[inline(always)]
    fn mirror(&self) -> Reflected {
        let Incidence { weight, cosine, .. } = self.arrived;
        // h.e is half of |l + e|.
        let he = 0.5 * positive(2.0 + 2.0 * self.product(&self.pixels.to_eye)).sqrt();
        let (facets, grazing) = (facets(self.half_way()), grazing(he));
        let light = weight * mirror_lobe(facets, cosine, self.pixels.normal_eye(self.lane));
        let lobe = at_most_1(MIRROR_PEAK * facets);
        Reflected {
            cosine: lobe,
            lobe,
            diffuse: light * (1.0 - grazing),
            specular: light * grazing,
        }
    }
}

/// A light reflected by the lobes at one pixel, and the intensities that radiance scaling takes of it.
struct Reflected {
    cosine: f32,
    lobe: f32,
    diffuse: f32,
    specular: f32,
}

impl Reflected {
    const NONE: Self = Self {
        cosine: 0.0,
        lobe: 0.0,
        diffuse: 0.0,
        specular: 0.0,
    };
}

/// A light reflected by the lobes at every pixel, as [`Reflected`].
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct Terms {
    pub(super) diffuse: Lanes,
    pub(super) specular: Lanes,
    cosine: Lanes,
    lobe: Lanes,
    /// Scaling curves for this light, if they depend on its direction.
    curves: [CurveLanes; 2],
}

impl Terms {
    pub(super) const NONE: Self = Self {
        diffuse: [0.0; BATCH],
        specular: [0.0; BATCH],
        cosine: [0.0; BATCH],
        lobe: [0.0; BATCH],
        curves: [CurveLanes::FLAT; 2],
    };

    /// Computes the diffuse and specular terms of a light.
    #[inline(always)]
    pub(super) fn reflect<const WARPED: bool>(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        light: impl Fn(usize) -> Arriving,
    ) {
        // Loops, not closures: large ones are not inlined into kernels for wider vectors. And lobes by value: they are not
        // read again after each store.
        match shading.lobes {
            Lobes::Diffuse { power } => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.diffuse());
                }
                raise(&mut self.diffuse, &mut self.cosine, power);
            }
            Lobes::Phong { power } => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.phong());
                }
                raise(&mut self.specular, &mut self.lobe, power);
            }
            Lobes::BlinnPhong { power } => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.blinn_phong());
                }
                raise(&mut self.specular, &mut self.lobe, power);
            }
            Lobes::Base(brdf) => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.base(&brdf));
                }
            }
            Lobes::AshikhminShirley(brdf) => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.coat(&brdf));
                }
            }
            Lobes::Mirror => {
                for lane in 0..BATCH {
                    let met = Meeting::<WARPED>::new(pixels, lane, light(lane));
                    self.put(lane, met.mirror());
                }
            }
        }
        let Some(scaled) = shading.scaled else {
            return;
        };
        if let Some(toward) = scaled.toward_light {
            for lane in 0..BATCH {
                let l_xy = Meeting::<WARPED>::new(pixels, lane, light(lane)).direction_xy();
                self.curve_toward(lane, at(&pixels.hessian, lane), l_xy, toward);
            }
        }
        self.scale(pixels, &scaled, matches!(shading.lobes, Lobes::Mirror));
    }

    #[inline(always)]
    fn put(&mut self, lane: usize, reflected: Reflected) {
        self.cosine[lane] = reflected.cosine;
        self.lobe[lane] = reflected.lobe;
        self.diffuse[lane] = reflected.diffuse;
        self.specular[lane] = reflected.specular;
    }

    /// Scaling curves for a light from a direction with these x and y.
    #[inline(always)]
    fn curve_toward(&mut self, lane: usize, hessian: [f32; 3], l_xy: [f32; 2], by: TowardLight) {
        let kappa = mapped_curvature_toward(hessian, l_xy, by.gain, by.anisotropy);
        for (curves, magnitude) in self.curves.iter_mut().zip(by.magnitudes) {
            curves.set(lane, ScalingCurve::of(magnitude * kappa));
        }
    }

    /// Scales both terms by their own intensities; what a mirror reflects, as a highlight.
    #[inline(always)]
    fn scale(&mut self, pixels: &Pixels, scaled: &Scaled, is_mirror: bool) {
        let [mut diffuse, specular] = match scaled.toward_light {
            Some(_) => self.curves.each_ref(),
            None => [Term::Diffuse, Term::Specular].map(|term| pixels.curve(term)),
        };
        if is_mirror {
            diffuse = specular;
        }
        let alpha = scaled.invariant_point;
        for lane in 0..BATCH {
            self.diffuse[lane] *= diffuse.at(lane).at(self.cosine[lane], alpha);
            self.specular[lane] *= specular.at(lane).at(self.lobe[lane], alpha);
        }
    }
}

/// Raises the intensity of a lobe to its exponent, and multiplies the term by it.
#[inline(always)]
fn raise(term: &mut Lanes, intensity: &mut Lanes, power: Exponent) {
    power.raise(intensity);
    for (term, intensity) in term.iter_mut().zip(intensity) {
        *term *= *intensity;
    }
}
