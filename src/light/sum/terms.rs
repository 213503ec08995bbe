//! The terms of one light at every pixel of a batch: arrival, reflection by the lobes, scaling.

use super::scaled::{Scaled, TowardLight};
use crate::kernel::fast_math::exp_to_normal;
use crate::kernel::lanes::multiply_add;
use crate::light::batch::{Axis, BATCH, CurveLanes, Lanes, LitPixels};
use crate::light::brdf::{
    AshikhminShirley, MIRROR_PEAK, entering, facets, grazing, mirror_lobe, share_seen,
};
use crate::light::cosines::{at_most_1, positive, scalar_product};
use crate::light::light_warping::MOST_BRIGHTENED;
use crate::light::radiance_scaling::ScalingCurve;
use crate::shape::curvature::mapped_curvature_toward;

/// Squared length below which a light is opposite the eye, and has no half vector with it.
pub(crate) const SHORTEST: f32 = 1e-12;

/// The contribution of one light at every pixel, without its colour.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Terms {
    pub(super) diffuse: Lanes,
    pub(super) specular: Lanes,
}

/// Inputs of the terms of one light.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(super) struct TermInputs {
    /// Jacobian (without the pixel's factor) and attenuation; 0 if the light is below the surface.
    pub(super) weight: Lanes,
    /// n . l, undefined where the weight is 0.
    pub(super) cosine: Lanes,
    /// One over |g|^2.
    pub(super) inverse: Lanes,
    /// The intensity of the glossy lobe, 0..1.
    pub(super) lobe: Lanes,
    /// Dot products of l with other vectors.
    pub(super) products: [Lanes; 3],
    /// Scaling curves for this light, if they depend on its direction.
    pub(super) curves: [CurveLanes; 2],
}

/// A light by lane: its direction, its half vector with z, its attenuation; and whether it is known to be above the
/// surface everywhere.
#[derive(Clone, Copy)]
pub(super) struct Arriving<D, H, S> {
    pub(super) direction: D,
    pub(super) half: H,
    pub(super) share: S,
    pub(super) everywhere: bool,
}

const ZERO: Lanes = [0.0; BATCH];

impl Terms {
    pub(super) const NONE: Self = Self {
        diffuse: ZERO,
        specular: ZERO,
    };
}

/// A half vector of any length, with the products that its length under a warp consists of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfVector {
    pub(super) vector: [f32; 3],
    /// z z, x x, x y, y y.
    pub(super) products: [f32; 4],
}

impl HalfVector {
    #[inline(always)]
    pub(crate) fn of([x, y, z]: [f32; 3]) -> Self {
        Self {
            vector: [x, y, z],
            products: [z * z, x * x, x * y, y * y],
        }
    }
}

/// An unwarped light at one pixel.
pub(crate) struct Unwarped {
    /// Jacobian, without the pixel's factor, and attenuation.
    pub(crate) weight: f32,
    /// n . l, at most [`MOST_BRIGHTENED`] times that of the light as given.
    pub(crate) cosine: f32,
    /// 1 / |g|^2.
    pub(crate) inverse: f32,
    /// The square of n . h for an eye on the axis: there g is the half vector up to its length.
    pub(crate) lobe: f32,
}

/// Unwarps the light with this half vector and attenuation `share` at a pixel with normal `n`, whose x and y under the
/// inverse of Lambda are `g`; `squared` is the square of that inverse and `most` the largest cosine.
///
/// For a half vector that is not of length 1, the weight lacks the fourth power of its length.
#[inline(always)]
pub(crate) fn arrive_unwarped(
    fma: bool,
    half: &HalfVector,
    share: f32,
    (n, g): ([f32; 3], [f32; 2]),
    squared: [f32; 3],
    most: f32,
) -> Unwarped {
    let ([x, y, z], [zz, xx, xy, yy]) = (half.vector, half.products);
    let length = multiply_add(fma, squared[0], xx, zz);
    let length = multiply_add(fma, squared[1], xy, length);
    let length = multiply_add(fma, squared[2], yy, length);
    let inverse = 1.0 / length;
    let along = multiply_add(fma, g[1], y, g[0] * x);
    let along = multiply_add(fma, n[2], z, along);
    let part = along * inverse;
    let cosine = multiply_add(fma, 2.0 * z, part, -n[2]);
    Unwarped {
        weight: share * (inverse * inverse),
        cosine: if cosine < most { cosine } else { most },
        inverse,
        lobe: at_most_1(positive(along) * part),
    }
}

/// The dot product of a vector and the direction of light: as given, or for an unwarped half vector, where `inverse` is
/// [`Unwarped::inverse`] and `unwarped` the vector's x and y under the inverse of Lambda.
#[inline(always)]
pub(crate) fn product(
    direction: [f32; 3],
    half: Option<[f32; 3]>,
    inverse: f32,
    (vector, unwarped): ([f32; 3], [f32; 2]),
) -> f32 {
    match half {
        None => scalar_product(vector, direction),
        Some(h) => {
            let along = unwarped[0] * h[0] + unwarped[1] * h[1] + vector[2] * h[2];
            2.0 * h[2] * inverse * along - vector[2]
        }
    }
}

/// x and y of the unwarped direction of light, with `inverse` from [`Unwarped::inverse`].
#[inline(always)]
pub(crate) fn unwarped_xy([xx, xy, yy]: [f32; 3], [x, y, z]: [f32; 3], inverse: f32) -> [f32; 2] {
    let twice = 2.0 * z * inverse;
    [twice * (xx * x + xy * y), twice * (xy * x + yy * y)]
}

/// The square of n . h for an eye on the axis.
#[inline(always)]
pub(crate) fn half_vector_lobe(normal: [f32; 3], half: [f32; 3]) -> f32 {
    let along = positive(scalar_product(normal, half));
    at_most_1(along * along)
}

/// The square of n . h, with h half-way between light and an eye off the axis, from the dot products of light, eye and
/// normal.
#[inline(always)]
pub(crate) fn half_way(light_eye: f32, light_normal: f32, normal_eye: f32) -> f32 {
    let along = positive(light_normal + normal_eye);
    let squared = 2.0 + 2.0 * light_eye;
    at_most_1(along * along / squared.max(SHORTEST))
}

/// Calls `each` for every lane with the unwarped light there.
#[inline(always)]
fn each_unwarped<D, H, S>(
    pixels: &LitPixels,
    light: Arriving<D, H, S>,
    each: impl FnMut(usize, Unwarped),
) where
    D: Fn(usize) -> [f32; 3],
    H: Fn(usize) -> [f32; 3],
    S: Fn(usize) -> f32,
{
    if light.everywhere {
        each_below(pixels, light, |_, _| f32::MAX, each);
    } else {
        let most = |n, direction| MOST_BRIGHTENED * scalar_product(n, direction);
        each_below(pixels, light, most, each);
    }
}

/// [`each_unwarped`], where `most` bounds the cosine, given a normal and the unwarped direction.
#[inline(always)]
fn each_below<D, H, S>(
    pixels: &LitPixels,
    light: Arriving<D, H, S>,
    most: impl Fn([f32; 3], [f32; 3]) -> f32,
    mut each: impl FnMut(usize, Unwarped),
) where
    D: Fn(usize) -> [f32; 3],
    H: Fn(usize) -> [f32; 3],
    S: Fn(usize) -> f32,
{
    let [xx, xy, yy] = &pixels.unwarp_squared;
    let [gx, gy] = &pixels.normal.unwarped;
    for i in 0..BATCH {
        let n = pixels.normal.at(i);
        let most = most(n, (light.direction)(i));
        let (g, squared) = ([gx[i], gy[i]], [xx[i], xy[i], yy[i]]);
        let share = (light.share)(i);
        let half = HalfVector::of((light.half)(i));
        each(
            i,
            arrive_unwarped(false, &half, share, (n, g), squared, most),
        );
    }
}

impl TermInputs {
    pub(super) const NONE: Self = Self {
        weight: ZERO,
        cosine: ZERO,
        inverse: [1.0; BATCH],
        lobe: ZERO,
        products: [ZERO; 3],
        curves: [CurveLanes::FLAT; 2],
    };

    /// Weights and cosines of a light as given, without warping.
    #[inline(always)]
    pub(super) fn arrive<D, H, S>(&mut self, pixels: &LitPixels, light: Arriving<D, H, S>)
    where
        D: Fn(usize) -> [f32; 3],
        S: Fn(usize) -> f32,
    {
        for i in 0..BATCH {
            let cosine = scalar_product(pixels.normal.at(i), (light.direction)(i));
            self.weight[i] = if cosine > 0.0 { (light.share)(i) } else { 0.0 };
            self.cosine[i] = cosine;
        }
    }

    /// Sets the lobe to the square of n . h, for an eye on the axis.
    #[inline(always)]
    pub(super) fn half_vector_lobe(
        &mut self,
        pixels: &LitPixels,
        half: impl Fn(usize) -> [f32; 3],
    ) {
        for i in 0..BATCH {
            self.lobe[i] = half_vector_lobe(pixels.normal.at(i), half(i));
        }
    }

    /// [`TermInputs::arrive`] with light directions unwarped, and their Jacobian; with the lobe for an eye on the axis.
    #[inline(always)]
    pub(super) fn arrive_unwarped<D, H, S>(&mut self, pixels: &LitPixels, light: Arriving<D, H, S>)
    where
        D: Fn(usize) -> [f32; 3],
        H: Fn(usize) -> [f32; 3],
        S: Fn(usize) -> f32,
    {
        each_unwarped(pixels, light, |i, unwarped| {
            let Unwarped {
                weight,
                cosine,
                inverse,
                lobe,
            } = unwarped;
            self.weight[i] = if cosine > 0.0 { weight } else { 0.0 };
            self.cosine[i] = cosine;
            self.inverse[i] = inverse;
            self.lobe[i] = lobe;
        });
    }

    /// Dot products with the vectors of `axis`, as product `k`.
    #[inline(always)]
    pub(super) fn product(
        &mut self,
        axis: &Axis,
        unwarped: Option<impl Fn(usize) -> [f32; 3]>,
        direction: impl Fn(usize) -> [f32; 3],
        k: usize,
    ) {
        let out = &mut self.products[k];
        match unwarped {
            None => {
                for (i, out) in out.iter_mut().enumerate() {
                    *out = product(direction(i), None, 1.0, (axis.at(i), [0.0; 2]));
                }
            }
            Some(half) => {
                let [gx, gy] = &axis.unwarped;
                for i in 0..BATCH {
                    let axis = (axis.at(i), [gx[i], gy[i]]);
                    out[i] = product([0.0; 3], Some(half(i)), self.inverse[i], axis);
                }
            }
        }
    }

    /// Sets the lobe to the square of n . h, with h half-way between light and an eye off the axis.
    #[inline(always)]
    pub(super) fn half_way(
        &mut self,
        pixels: &LitPixels,
        unwarped: Option<impl Fn(usize) -> [f32; 3] + Copy>,
        direction: impl Fn(usize) -> [f32; 3] + Copy,
    ) {
        self.product(&pixels.to_eye, unwarped, direction, 0);
        // Recomputed, since the stored cosine may be limited.
        self.product(&pixels.normal, unwarped, direction, 1);
        for i in 0..BATCH {
            let eye = scalar_product(pixels.normal.at(i), pixels.to_eye.at(i));
            self.lobe[i] = half_way(self.products[0][i], self.products[1][i], eye);
        }
    }

    /// Scaling curves for the light's direction.
    #[inline(always)]
    pub(super) fn curve_toward(
        &mut self,
        pixels: &LitPixels,
        toward: TowardLight,
        unwarped: Option<impl Fn(usize) -> [f32; 3]>,
        direction: impl Fn(usize) -> [f32; 3],
    ) {
        let [across_x, across_y, _] = &mut self.products;
        for i in 0..BATCH {
            let [x, y] = match &unwarped {
                None => {
                    let [x, y, _] = direction(i);
                    [x, y]
                }
                Some(half) => {
                    let [xx, xy, yy] = &pixels.unwarp;
                    unwarped_xy([xx[i], xy[i], yy[i]], half(i), self.inverse[i])
                }
            };
            (across_x[i], across_y[i]) = (x, y);
        }
        let [xx, xy, yy] = &pixels.hessian;
        for (curves, magnitude) in self.curves.iter_mut().zip(toward.magnitudes) {
            for i in 0..BATCH {
                let (hessian, l_xy) = ([xx[i], xy[i], yy[i]], [across_x[i], across_y[i]]);
                let kappa = mapped_curvature_toward(hessian, l_xy, toward.gain, toward.anisotropy);
                curves.set(i, ScalingCurve::of(magnitude.exponent(kappa)));
            }
        }
    }

    /// The diffuse term: the cosine lobe, scaled by its own intensity.
    #[inline(always)]
    pub(super) fn scale_cosine(
        &self,
        diffuse: &mut Lanes,
        pixels: &LitPixels,
        scaled: Option<Scaled>,
    ) {
        let Self { weight, cosine, .. } = self;
        match scaled {
            None => {
                for i in 0..BATCH {
                    diffuse[i] = weight[i] * cosine[i];
                }
            }
            Some(scaled) => {
                let curves = scaled.curves(pixels, &self.curves, 0);
                for i in 0..BATCH {
                    let sigma = curves.at(i).at(cosine[i], scaled.invariant_point);
                    diffuse[i] = weight[i] * cosine[i] * sigma;
                }
            }
        }
    }

    /// The specular term: `weigh(cosine, weight)` times the lobe, scaled by the lobe's intensity.
    #[inline(always)]
    pub(super) fn scale_lobe(
        &self,
        specular: &mut Lanes,
        pixels: &LitPixels,
        scaled: Option<Scaled>,
        weigh: impl Fn(f32, f32) -> f32,
    ) {
        let Self {
            weight,
            cosine,
            lobe,
            ..
        } = self;
        match scaled {
            None => {
                for i in 0..BATCH {
                    specular[i] = weigh(cosine[i], weight[i]) * lobe[i];
                }
            }
            Some(scaled) => {
                let curves = scaled.curves(pixels, &self.curves, 1);
                for i in 0..BATCH {
                    let sigma = curves.at(i).at(lobe[i], scaled.invariant_point);
                    specular[i] = weigh(cosine[i], weight[i]) * lobe[i] * sigma;
                }
            }
        }
    }

    /// Mirrored light from l . e and the square of n . h: that of the reflectance and that of grazing, scaled alike.
    #[inline(always)]
    pub(super) fn mirror(&mut self, terms: &mut Terms, pixels: &LitPixels, scaled: Option<Scaled>) {
        for i in 0..BATCH {
            let (nl, ne) = (
                positive(self.cosine[i]),
                positive(scalar_product(pixels.normal.at(i), pixels.to_eye.at(i))),
            );
            // h.e is half of |l + e|.
            let he = 0.5 * positive(2.0 + 2.0 * self.products[0][i]).sqrt();
            let (facets, grazing) = (facets(self.lobe[i]), grazing(he));
            let light = self.weight[i] * mirror_lobe(facets, nl, ne);
            terms.diffuse[i] = light * (1.0 - grazing);
            terms.specular[i] = light * grazing;
            self.lobe[i] = at_most_1(MIRROR_PEAK * facets);
        }
        if let Some(scaled) = scaled {
            let curves = scaled.curves(pixels, &self.curves, 1);
            for i in 0..BATCH {
                let sigma = curves.at(i).at(self.lobe[i], scaled.invariant_point);
                terms.diffuse[i] *= sigma;
                terms.specular[i] *= sigma;
            }
        }
    }

    /// Both terms of the coated model, from l . e, l . u and l . v.
    ///
    /// In steps, of which each is short enough that several vectors of lanes are under way at a time.
    #[inline(always)]
    pub(super) fn coat(
        &mut self,
        terms: &mut Terms,
        pixels: &LitPixels,
        scaled: Option<Scaled>,
        brdf: &AshikhminShirley,
    ) {
        let [nu, nv] = brdf.coat;
        if nu == nv {
            let exponent = brdf.exponent(1.0, 1.0);
            self.see_coat(terms, pixels, brdf, |_, _| exponent);
        } else {
            self.see_coat(terms, pixels, brdf, |uu, vv| brdf.exponent(uu, vv));
        }
        let [logarithms, exponents, _] = &mut self.products;
        for i in 0..BATCH {
            logarithms[i] = AshikhminShirley::log_lobe(self.lobe[i], exponents[i]);
        }
        for (specular, logarithm) in terms.specular.iter_mut().zip(&*logarithms) {
            *specular *= exp_to_normal(*logarithm);
        }
        if let Some(scaled) = scaled {
            for square in &mut self.lobe {
                *square = positive(*square).sqrt();
            }
            let intensities = [&self.cosine, &self.lobe];
            let terms = [&mut terms.diffuse, &mut terms.specular];
            for (k, (term, intensity)) in terms.into_iter().zip(intensities).enumerate() {
                let curves = scaled.curves(pixels, &self.curves, k);
                for i in 0..BATCH {
                    term[i] *= curves.at(i).at(intensity[i], scaled.invariant_point);
                }
            }
        }
    }

    /// The terms of the coated model without its lobe; the square of n . h as the lobe, and its exponent as the second
    /// product.
    #[inline(always)]
    fn see_coat(
        &mut self,
        terms: &mut Terms,
        pixels: &LitPixels,
        brdf: &AshikhminShirley,
        exponent: impl Fn(f32, f32) -> f32,
    ) {
        let [le, lu, lv] = &mut self.products;
        let [eye_along, eye_across] = &pixels.coat.eye;
        for i in 0..BATCH {
            // h = (l + e) / |l + e|, |l + e|^2 = 2 + 2 l.e, and h.e is half of |l + e|.
            let squared = (2.0 + 2.0 * le[i]).max(SHORTEST);
            let inverse = 1.0 / squared.sqrt();
            let [along, across] = [lu[i] + eye_along[i], lv[i] + eye_across[i]];
            let (uu, vv) = (along * along, across * across);
            // n . h, from the parts of h along and across the grain.
            self.lobe[i] = 1.0 - (uu + vv) * (inverse * inverse);
            lu[i] = exponent(uu, vv);
            let (weight, nl) = (self.weight[i], positive(self.cosine[i]));
            terms.diffuse[i] = weight * (pixels.coat.base[i] * entering(nl));
            let seen = share_seen(nl, pixels.coat.per_cosine[i], 2.0 * inverse);
            let reflected = brdf.reflected(0.5 * squared * inverse);
            terms.specular[i] = weight * brdf.normalisation * (reflected * seen);
        }
    }
}

impl Scaled {
    /// The curves of diffuse (0) or specular (1) light.
    #[inline(always)]
    fn curves<'a>(
        &self,
        pixels: &'a LitPixels,
        toward_light: &'a [CurveLanes; 2],
        term: usize,
    ) -> &'a CurveLanes {
        match self.toward_light {
            Some(_) => &toward_light[term],
            None => pixels.curve(1 + term),
        }
    }
}
