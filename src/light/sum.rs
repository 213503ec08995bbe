//! The sum over lights: what each of many lights adds to a batch of pixels.
//!
//! Theory: [RS] equation 3, `sum of rho_j(l) sigma_j(l) L_j(l)` over terms j and lights; with light warping
//! [LW] equation 2, in which rho is asked for the unwarped direction `l = W^-1(l')` of a light l', and the
//! Jacobian of the inverse weighs it. Changes: a warp is linear in the half vector h of light and viewer
//! (see [`super::light_warping`]), so unwarped directions are never made: with `g = (Lambda^-1 h_xy, h_z)`
//! the scalar product of one with a vector a is `2 h_z (a . g) / |g|^2 - a_z`. What of this belongs to the
//! pixel alone is prepared once ([`Pixels`]); what is left per light is some twenty operations and a
//! division. A light counts only where it is above the surface both as it stands and as unwarped ([LW]
//! section 6.1).
//!
//! Use: [`LightSum::add`] light by light, then read the sums.

use super::batch::{BATCH, CurveLanes, Lanes, Pixels};
use super::brdf::{AshikhminShirley, Cosines};
use super::light_warping::half_vector;
use super::radiance_scaling::ScalingCurve;
use crate::fast_math::{exp, ln};
use crate::params::{Material, MaterialParams};
use crate::shape::curvature::mapped_curvature_toward;

/// How lights act on the pixels of a run: everything that all batches share.
#[derive(Debug, Clone, Copy)]
pub struct Shading {
    /// Whether directions are warped.
    pub warped: bool,
    /// Radiance scaling, where there is any.
    pub scaled: Option<Scaled>,
    /// The lobes.
    pub lobes: Lobes,
}

/// Radiance scaling inside the sum.
#[derive(Debug, Clone, Copy)]
pub struct Scaled {
    /// Scaling-invariant point.
    pub invariant_point: f32,
    /// The mapping of curvature, where it depends on the direction of light.
    pub toward_light: Option<TowardLight>,
}

/// A mapping of curvature that depends on the direction of light ([RS] section 4.1).
#[derive(Debug, Clone, Copy)]
pub struct TowardLight {
    /// Curvature gain, in pixels.
    pub gain: f32,
    /// Anisotropy lambda.
    pub anisotropy: f32,
    /// Magnitudes of diffuse and specular light.
    pub magnitudes: [f32; 2],
}

/// The lobes of a material under lights.
#[derive(Debug, Clone, Copy)]
pub enum Lobes {
    /// The cosine to a power: 1 is Lambert.
    Diffuse {
        /// The power zeta.
        power: Power,
    },
    /// Lambert, and Phong's lobe about the mirrored view.
    Phong {
        /// The power eta.
        power: Power,
    },
    /// Lambert, and Blinn's lobe about the normal.
    BlinnPhong {
        /// The power eta, halved: of the square of the cosine.
        power: Power,
        /// Whether the viewer is far away, along z at every pixel.
        far: bool,
    },
    /// See [`AshikhminShirley`].
    AshikhminShirley(AshikhminShirley),
}

impl Lobes {
    /// Those of a material that lights can be summed on; `None` for a mirror and for glass.
    pub fn of(params: &MaterialParams, far: bool) -> Option<Self> {
        match params.material {
            Material::Lambert | Material::Toon => Some(Self::Diffuse {
                power: Power::of(1.0),
            }),
            Material::Sublambert => Some(Self::Diffuse {
                power: Power::of(params.flatness),
            }),
            Material::Phong => Some(Self::Phong {
                power: Power::of(params.shininess),
            }),
            Material::BlinnPhong => Some(Self::BlinnPhong {
                power: Power::of(0.5 * params.shininess),
                far,
            }),
            Material::AshikhminShirley => {
                Some(Self::AshikhminShirley(AshikhminShirley::new(params)))
            }
            Material::Mirror | Material::Glass => None,
        }
    }

    /// Whether there is more than the diffuse lobe.
    pub fn are_glossy(&self) -> bool {
        !matches!(self, Self::Diffuse { .. })
    }
}

/// An exponent: whole ones that are not large take multiplications alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Power {
    /// A whole number from 1 on.
    Whole(u32),
    /// Any number from 0 on.
    Any(f32),
}

impl Power {
    /// Largest whole exponent that is reached by multiplying: ten squarings, as dear as a logarithm.
    const MOST: f32 = 1024.0;

    /// The power with this exponent, at least 0.
    pub fn of(exponent: f32) -> Self {
        if (1.0..=Self::MOST).contains(&exponent) && exponent.fract() == 0.0 {
            Self::Whole(exponent as u32)
        } else {
            Self::Any(exponent)
        }
    }

    /// Raises numbers from 0 to 1 to this power; 0 stays 0.
    #[inline(always)]
    fn raise(self, base: &mut Lanes) {
        match self {
            Self::Whole(exponent) => raise_to_whole(base, exponent),
            Self::Any(exponent) => {
                for x in base.iter_mut() {
                    let raised = exp(exponent * ln(x.max(f32::MIN_POSITIVE)));
                    *x = if *x > 0.0 { raised } else { 0.0 };
                }
            }
        }
    }
}

/// Multiplies from the highest digit of the exponent on.
#[inline(always)]
fn raise_to_whole(base: &mut Lanes, exponent: u32) {
    let digits = u32::BITS - exponent.leading_zeros();
    let once = *base;
    for digit in (0..digits - 1).rev() {
        for x in base.iter_mut() {
            *x *= *x;
        }
        if exponent >> digit & 1 == 1 {
            for (x, once) in base.iter_mut().zip(&once) {
                *x *= once;
            }
        }
    }
}

/// Light from one direction, or from a point at another one for every pixel.
#[derive(Debug, Clone, Copy)]
pub enum Incoming<'a> {
    /// Unit direction to the light.
    From([f32; 3]),
    /// Unit directions by pixel, with the share of the intensity that arrives.
    Near(&'a [Lanes; 3], &'a Lanes),
}

/// The intensity of a light.
#[derive(Debug, Clone, Copy)]
pub enum Intensity<'a> {
    /// Red, green and blue.
    Even([f32; 3]),
    /// Red, green and blue by pixel: what was looked up in an environment.
    LookedUp(&'a [Lanes; 3]),
}

/// The sums of a batch, and the terms of the lights being added.
#[derive(Debug, Clone)]
pub struct LightSum {
    /// Red, green and blue of diffusely reflected light, of albedo 1.
    pub diffuse: [Lanes; 3],
    /// Red, green and blue of specularly reflected light.
    pub specular: [Lanes; 3],
    terms: Terms,
}

/// What one light does at every pixel.
#[derive(Debug, Clone)]
struct Terms {
    /// Jacobian and fall-off; 0 where the light is below the surface.
    weight: Lanes,
    /// n . l, at least 0.
    cosine: Lanes,
    /// One over |g|^2.
    inverse: Lanes,
    /// a . l of other vectors, then intensities that are powers of them.
    lobe: Lanes,
    /// Further scalar products.
    products: [Lanes; 3],
    /// What diffuse light is multiplied by.
    diffuse: Lanes,
    /// What specular light is multiplied by.
    specular: Lanes,
    /// Scaling curves toward this light, where they depend on it.
    curves: [CurveLanes; 2],
}

const ZERO: Lanes = [0.0; BATCH];

impl Default for LightSum {
    fn default() -> Self {
        Self::new()
    }
}

impl LightSum {
    /// Sums of no light.
    pub fn new() -> Self {
        Self {
            diffuse: [ZERO; 3],
            specular: [ZERO; 3],
            terms: Terms {
                weight: ZERO,
                cosine: ZERO,
                inverse: [1.0; BATCH],
                lobe: ZERO,
                products: [ZERO; 3],
                diffuse: ZERO,
                specular: ZERO,
                curves: [CurveLanes::FLAT; 2],
            },
        }
    }

    /// Forgets the lights.
    pub fn clear(&mut self) {
        self.diffuse = [ZERO; 3];
        self.specular = [ZERO; 3];
    }

    /// Adds one light.
    #[inline(always)]
    pub fn add(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        incoming: Incoming,
        intensity: Intensity,
    ) {
        match incoming {
            Incoming::From(direction) => {
                let half = half_vector(direction);
                self.terms
                    .reflect(pixels, shading, |_| direction, |_| half, |_| 1.0);
            }
            Incoming::Near(directions, share) => {
                let direction = |i: usize| [directions[0][i], directions[1][i], directions[2][i]];
                let half = |i: usize| half_vector(direction(i));
                self.terms
                    .reflect(pixels, shading, direction, half, |i| share[i]);
            }
        }
        self.gather(shading.lobes.are_glossy(), intensity);
    }

    /// Adds what the terms reflect.
    #[inline(always)]
    fn gather(&mut self, glossy: bool, intensity: Intensity) {
        let Self {
            diffuse,
            specular,
            terms,
        } = self;
        match intensity {
            Intensity::Even(rgb) => {
                add_scaled(diffuse, &terms.diffuse, |channel, _| rgb[channel]);
                if glossy {
                    add_scaled(specular, &terms.specular, |channel, _| rgb[channel]);
                }
            }
            Intensity::LookedUp(rgb) => {
                add_scaled(diffuse, &terms.diffuse, |channel, i| rgb[channel][i]);
                if glossy {
                    add_scaled(specular, &terms.specular, |channel, i| rgb[channel][i]);
                }
            }
        }
    }
}

/// Adds `term * intensity` to the sums.
#[inline(always)]
fn add_scaled(sums: &mut [Lanes; 3], term: &Lanes, intensity: impl Fn(usize, usize) -> f32) {
    let [r, g, b] = sums;
    for i in 0..BATCH {
        r[i] += term[i] * intensity(0, i);
        g[i] += term[i] * intensity(1, i);
        b[i] += term[i] * intensity(2, i);
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn positive(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

impl Terms {
    /// Makes the diffuse and specular terms of a light that comes from `direction(i)` at pixel i, where
    /// its half vector is `half(i)` and the share `share(i)` of it arrives.
    #[inline(always)]
    fn reflect(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        direction: impl Fn(usize) -> [f32; 3] + Copy,
        half: impl Fn(usize) -> [f32; 3] + Copy,
        share: impl Fn(usize) -> f32 + Copy,
    ) {
        let unwarped = shading.warped.then_some(half);
        match unwarped {
            None => self.arrive(pixels, direction, share),
            Some(half) => self.arrive_unwarped(pixels, direction, half, share),
        }
        if let Some(toward) = shading.scaled.and_then(|scaled| scaled.toward_light) {
            match unwarped {
                None => self.curve_toward(pixels, toward, |_, i| {
                    let [x, y, _] = direction(i);
                    [x, y]
                }),
                Some(half) => self.curve_toward(pixels, toward, |terms, i| {
                    let [x, y, z] = half(i);
                    let [xx, xy, yy] = [0, 1, 2].map(|k| pixels.unwarp[k][i]);
                    let twice = 2.0 * z * terms.inverse[i];
                    [twice * (xx * x + xy * y), twice * (xy * x + yy * y)]
                }),
            }
        }
        match shading.lobes {
            Lobes::Diffuse { power } => {
                if power != Power::Whole(1) {
                    power.raise(&mut self.cosine);
                }
                self.scale_cosine(pixels, shading);
            }
            Lobes::Phong { power } => {
                self.product(&pixels.mirrored, unwarped, direction, 0);
                for i in 0..BATCH {
                    self.lobe[i] = positive(self.products[0][i]).min(1.0);
                }
                power.raise(&mut self.lobe);
                self.scale_cosine(pixels, shading);
                self.scale_lobe(pixels, shading, |_, weight| weight);
            }
            Lobes::BlinnPhong { power, far } => {
                self.half_way(pixels, unwarped, direction, half, far);
                power.raise(&mut self.lobe);
                self.scale_cosine(pixels, shading);
                self.scale_lobe(pixels, shading, |cosine, weight| weight * cosine);
            }
            Lobes::AshikhminShirley(brdf) => {
                for (k, axis) in [&pixels.to_eye, &pixels.along, &pixels.across]
                    .into_iter()
                    .enumerate()
                {
                    self.product(axis, unwarped, direction, k);
                }
                self.coat(pixels, shading, &brdf);
            }
        }
    }

    /// Weights and cosines of a light as it stands.
    #[inline(always)]
    fn arrive(
        &mut self,
        pixels: &Pixels,
        direction: impl Fn(usize) -> [f32; 3],
        share: impl Fn(usize) -> f32,
    ) {
        for i in 0..BATCH {
            let cosine = dot(pixels.normal.at(i), direction(i));
            self.weight[i] = if cosine > 0.0 { share(i) } else { 0.0 };
            self.cosine[i] = positive(cosine).min(1.0);
        }
    }

    /// The same of a light whose direction is unwarped: with its Jacobian.
    #[inline(always)]
    fn arrive_unwarped(
        &mut self,
        pixels: &Pixels,
        direction: impl Fn(usize) -> [f32; 3],
        half: impl Fn(usize) -> [f32; 3],
        share: impl Fn(usize) -> f32,
    ) {
        let [xx, xy, yy] = &pixels.unwarp_squared;
        let [gx, gy] = &pixels.normal.unwarped;
        for i in 0..BATCH {
            let n = pixels.normal.at(i);
            let [x, y, z] = half(i);
            let length = z * z + xx[i] * (x * x) + xy[i] * (x * y) + yy[i] * (y * y);
            let inverse = 1.0 / length;
            let along = gx[i] * x + gy[i] * y + n[2] * z;
            let cosine = 2.0 * z * inverse * along - n[2];
            let above = (cosine > 0.0) & (dot(n, direction(i)) > 0.0);
            let weight = share(i) * pixels.spread[i] * (inverse * inverse);
            self.weight[i] = if above { weight } else { 0.0 };
            self.cosine[i] = positive(cosine).min(1.0);
            self.inverse[i] = inverse;
        }
    }

    /// Scalar products with the vectors of `axis` as product `k`.
    #[inline(always)]
    fn product(
        &mut self,
        axis: &super::batch::Axis,
        unwarped: Option<impl Fn(usize) -> [f32; 3]>,
        direction: impl Fn(usize) -> [f32; 3],
        k: usize,
    ) {
        let out = &mut self.products[k];
        match unwarped {
            None => {
                for i in 0..BATCH {
                    out[i] = dot(axis.at(i), direction(i));
                }
            }
            Some(half) => {
                let [gx, gy] = &axis.unwarped;
                let z = &axis.vector[2];
                for i in 0..BATCH {
                    let h = half(i);
                    let along = gx[i] * h[0] + gy[i] * h[1] + z[i] * h[2];
                    out[i] = 2.0 * h[2] * self.inverse[i] * along - z[i];
                }
            }
        }
    }

    /// The square of n . h as lobe, h half-way between light and eye.
    #[inline(always)]
    fn half_way(
        &mut self,
        pixels: &Pixels,
        unwarped: Option<impl Fn(usize) -> [f32; 3] + Copy>,
        direction: impl Fn(usize) -> [f32; 3] + Copy,
        half: impl Fn(usize) -> [f32; 3],
        far: bool,
    ) {
        match (far, unwarped.is_some()) {
            // For an eye on the axis g is the half vector itself, up to its length.
            (true, true) => {
                let [gx, gy] = &pixels.normal.unwarped;
                for i in 0..BATCH {
                    let [x, y, z] = half(i);
                    let along = positive(gx[i] * x + gy[i] * y + pixels.normal.vector[2][i] * z);
                    self.lobe[i] = (along * along * self.inverse[i]).min(1.0);
                }
            }
            (true, false) => {
                for i in 0..BATCH {
                    let along = positive(dot(pixels.normal.at(i), half(i)));
                    self.lobe[i] = (along * along).min(1.0);
                }
            }
            (false, _) => {
                self.product(&pixels.to_eye, unwarped, direction, 0);
                for i in 0..BATCH {
                    let eye = dot(pixels.normal.at(i), pixels.to_eye.at(i));
                    let along = positive(self.cosine[i] + eye);
                    let squared = 2.0 + 2.0 * self.products[0][i];
                    self.lobe[i] = (along * along / squared.max(f32::MIN_POSITIVE)).min(1.0);
                }
            }
        }
    }

    /// Scaling curves toward a light whose direction has the x and y `across`.
    #[inline(always)]
    fn curve_toward(
        &mut self,
        pixels: &Pixels,
        toward: TowardLight,
        across: impl Fn(&Self, usize) -> [f32; 2],
    ) {
        for i in 0..BATCH {
            let hessian = [
                pixels.hessian[0][i],
                pixels.hessian[1][i],
                pixels.hessian[2][i],
            ];
            let across = across(self, i);
            let kappa = mapped_curvature_toward(hessian, across, toward.gain, toward.anisotropy);
            for (curves, magnitude) in self.curves.iter_mut().zip(toward.magnitudes) {
                curves.set(i, ScalingCurve::of(magnitude * kappa));
            }
        }
    }

    /// The diffuse term: the cosine lobe, scaled as its own intensity asks.
    #[inline(always)]
    fn scale_cosine(&mut self, pixels: &Pixels, shading: &Shading) {
        let Self {
            weight,
            cosine,
            diffuse,
            ..
        } = self;
        match shading.scaled {
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

    /// The specular term: `weigh(cosine, weight)` times the lobe, scaled as the lobe asks.
    #[inline(always)]
    fn scale_lobe(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        weigh: impl Fn(f32, f32) -> f32,
    ) {
        let Self {
            weight,
            cosine,
            lobe,
            specular,
            ..
        } = self;
        match shading.scaled {
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

    /// Both terms of the coated model, from l . e, l . u and l . v.
    #[inline(always)]
    fn coat(&mut self, pixels: &Pixels, shading: &Shading, brdf: &AshikhminShirley) {
        for i in 0..BATCH {
            let eye = pixels.to_eye.at(i);
            let [le, lu, lv] = [0, 1, 2].map(|k| self.products[k][i]);
            // h = (l + e) / |l + e|, |l + e|^2 = 2 + 2 l.e.
            let inverse = 1.0 / (2.0 + 2.0 * le).max(f32::MIN_POSITIVE).sqrt();
            let ne = positive(dot(pixels.normal.at(i), eye)).min(1.0);
            let cosines = Cosines {
                nl: self.cosine[i],
                ne,
                he: ((1.0 + le) * inverse).clamp(0.0, 1.0),
                hu: (lu + dot(pixels.along.at(i), eye)) * inverse,
                hv: (lv + dot(pixels.across.at(i), eye)) * inverse,
            };
            self.lobe[i] = ((self.cosine[i] + ne) * inverse).clamp(0.0, 1.0);
            self.diffuse[i] = self.weight[i] * brdf.diffuse(cosines.nl, ne);
            let specular = brdf.specular(cosines);
            // Weights are 0 below the horizon, where the lobe may be anything.
            let lit = self.weight[i] > 0.0;
            self.specular[i] = if lit { self.weight[i] * specular } else { 0.0 };
        }
        if let Some(scaled) = shading.scaled {
            let intensities = [&self.cosine, &self.lobe];
            let terms = [&mut self.diffuse, &mut self.specular];
            for (k, (term, intensity)) in terms.into_iter().zip(intensities).enumerate() {
                let curves = scaled.curves(pixels, &self.curves, k);
                for i in 0..BATCH {
                    term[i] *= curves.at(i).at(intensity[i], scaled.invariant_point);
                }
            }
        }
    }
}

impl Scaled {
    /// The curves of diffuse (0) or specular (1) light.
    #[inline(always)]
    fn curves<'a>(
        &self,
        pixels: &'a Pixels,
        toward_light: &'a [CurveLanes; 2],
        term: usize,
    ) -> &'a CurveLanes {
        match self.toward_light {
            Some(_) => &toward_light[term],
            None => &pixels.curves[1 + term],
        }
    }
}
