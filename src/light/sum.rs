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

use super::batch::{Above, Axis, BATCH, CurveLanes, Lanes, Pixels};
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

/// Multiplies from the highest digit of the exponent on, a few lanes at a time in registers.
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

/// Lights whose terms wait to be added together: the sums are then read and written once for all.
const GROUP: usize = 4;

/// The sums of a batch, and the terms of the lights being added.
#[derive(Debug, Clone)]
pub struct LightSum {
    /// Red, green and blue of diffusely reflected light, of albedo 1; complete after [`LightSum::finish`].
    pub diffuse: [Lanes; 3],
    /// Red, green and blue of specularly reflected light, likewise.
    pub specular: [Lanes; 3],
    waiting: usize,
    colors: [[f32; 3]; GROUP],
    terms: [Terms; GROUP],
    scratch: Scratch,
}

/// Squared length below which a light lies opposite to the eye, and has no half vector with it.
const SHORTEST: f32 = 1e-12;

/// What one light does at every pixel, before its colour.
#[derive(Debug, Clone, Copy)]
struct Terms {
    diffuse: Lanes,
    specular: Lanes,
}

/// What the terms of one light are made of.
#[derive(Debug, Clone)]
struct Scratch {
    /// Jacobian (but for the pixel's share of it) and fall-off; 0 where the light is below the surface.
    weight: Lanes,
    /// n . l, of no meaning where the weight is 0.
    cosine: Lanes,
    /// One over |g|^2.
    inverse: Lanes,
    /// The intensity of the glossy lobe, 0..1.
    lobe: Lanes,
    /// Scalar products of l and other vectors.
    products: [Lanes; 3],
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
        let terms = Terms {
            diffuse: ZERO,
            specular: ZERO,
        };
        Self {
            diffuse: [ZERO; 3],
            specular: [ZERO; 3],
            waiting: 0,
            colors: [[0.0; 3]; GROUP],
            terms: [terms; GROUP],
            scratch: Scratch {
                weight: ZERO,
                cosine: ZERO,
                inverse: [1.0; BATCH],
                lobe: ZERO,
                products: [ZERO; 3],
                curves: [CurveLanes::FLAT; 2],
            },
        }
    }

    /// Forgets the lights.
    pub fn clear(&mut self) {
        self.diffuse = [ZERO; 3];
        self.specular = [ZERO; 3];
        self.waiting = 0;
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
        let terms = &mut self.terms[self.waiting];
        match incoming {
            Incoming::From(direction) => {
                let above = pixels.facing.above(direction);
                if above == Above::Nowhere {
                    return;
                }
                let half = half_vector(direction);
                let everywhere = above == Above::Everywhere;
                self.scratch.reflect(
                    terms,
                    pixels,
                    shading,
                    Arriving {
                        direction: |_| direction,
                        half: |_| half,
                        share: |_| 1.0,
                        everywhere,
                    },
                );
            }
            Incoming::Near(directions, share) => {
                let direction = |i: usize| [directions[0][i], directions[1][i], directions[2][i]];
                self.scratch.reflect(
                    terms,
                    pixels,
                    shading,
                    Arriving {
                        direction,
                        half: |i| half_vector(direction(i)),
                        share: |i| share[i],
                        everywhere: false,
                    },
                );
            }
        }
        let glossy = shading.lobes.are_glossy();
        match intensity {
            Intensity::Even(rgb) => {
                self.colors[self.waiting] = rgb;
                self.waiting += 1;
                if self.waiting == GROUP {
                    self.gather_group(glossy);
                }
            }
            Intensity::LookedUp(rgb) => {
                add_term(&mut self.diffuse, &terms.diffuse, |i| {
                    [rgb[0][i], rgb[1][i], rgb[2][i]]
                });
                if glossy {
                    add_term(&mut self.specular, &terms.specular, |i| {
                        [rgb[0][i], rgb[1][i], rgb[2][i]]
                    });
                }
            }
        }
    }

    /// Completes the sums.
    #[inline(always)]
    pub fn finish(&mut self, pixels: &Pixels, shading: &Shading) {
        let glossy = shading.lobes.are_glossy();
        for k in 0..self.waiting {
            let (terms, rgb) = (&self.terms[k], self.colors[k]);
            add_term(&mut self.diffuse, &terms.diffuse, |_| rgb);
            if glossy {
                add_term(&mut self.specular, &terms.specular, |_| rgb);
            }
        }
        self.waiting = 0;
        if shading.warped {
            for sum in self.diffuse.iter_mut().chain(&mut self.specular) {
                for (sum, spread) in sum.iter_mut().zip(&pixels.spread) {
                    *sum *= spread;
                }
            }
        }
    }

    /// Adds a full group, light after light: the same bits as one by one.
    #[inline(always)]
    fn gather_group(&mut self, glossy: bool) {
        let [a, b, c, d] = &self.terms;
        let colors = self.colors;
        add_group(
            &mut self.diffuse,
            [&a.diffuse, &b.diffuse, &c.diffuse, &d.diffuse],
            colors,
        );
        if glossy {
            add_group(
                &mut self.specular,
                [&a.specular, &b.specular, &c.specular, &d.specular],
                colors,
            );
        }
        self.waiting = 0;
    }
}

/// Adds `term * intensity` to the sums.
#[inline(always)]
fn add_term(sums: &mut [Lanes; 3], term: &Lanes, intensity: impl Fn(usize) -> [f32; 3]) {
    let [r, g, b] = sums;
    for i in 0..BATCH {
        let rgb = intensity(i);
        r[i] += term[i] * rgb[0];
        g[i] += term[i] * rgb[1];
        b[i] += term[i] * rgb[2];
    }
}

/// Adds several terms, each times its colour.
#[inline(always)]
fn add_group(sums: &mut [Lanes; 3], terms: [&Lanes; GROUP], colors: [[f32; 3]; GROUP]) {
    let [r, g, b] = sums;
    let [a, c, d, e] = terms;
    let [ca, cc, cd, ce] = colors;
    for i in 0..BATCH {
        let term = [a[i], c[i], d[i], e[i]];
        let add = |sum: f32, channel: usize| {
            let sum = sum + term[0] * ca[channel];
            let sum = sum + term[1] * cc[channel];
            let sum = sum + term[2] * cd[channel];
            sum + term[3] * ce[channel]
        };
        r[i] = add(r[i], 0);
        g[i] = add(g[i], 1);
        b[i] = add(b[i], 2);
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

#[inline(always)]
fn at_most_1(x: f32) -> f32 {
    if x < 1.0 { x } else { 1.0 }
}

/// A light by lane: its direction, its half vector with z, how much of it arrives; and whether it is known
/// to be above the surface everywhere.
#[derive(Clone, Copy)]
struct Arriving<D, H, S> {
    direction: D,
    half: H,
    share: S,
    everywhere: bool,
}

impl Scratch {
    /// Makes the diffuse and specular terms of a light.
    #[inline(always)]
    fn reflect<D, H, S>(
        &mut self,
        terms: &mut Terms,
        pixels: &Pixels,
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
            (false, false) => self.arrive(pixels, light),
            (false, true) => {
                self.arrive(pixels, light);
                self.half_vector_lobe(pixels, half);
            }
            (true, false) => self.arrive_unwarped(pixels, light, |_, _, _| 0.0),
            // For an eye on the axis g is the half vector, but for its length.
            (true, true) => self.arrive_unwarped(pixels, light, |along, inverse, z| {
                let half = positive(along) * (0.5 / z.max(SHORTEST));
                at_most_1(half * half * inverse)
            }),
        }
        if let Some(toward) = shading.scaled.and_then(|scaled| scaled.toward_light) {
            self.curve_toward(pixels, toward, unwarped, direction);
        }
        match shading.lobes {
            Lobes::Diffuse { power } => {
                if power != Power::Whole(1) {
                    power.raise(&mut self.cosine);
                }
                self.scale_cosine(&mut terms.diffuse, pixels, shading);
            }
            Lobes::Phong { power } => {
                self.product(&pixels.mirrored, unwarped, direction, 0);
                for i in 0..BATCH {
                    self.lobe[i] = at_most_1(positive(self.products[0][i]));
                }
                power.raise(&mut self.lobe);
                self.scale_cosine(&mut terms.diffuse, pixels, shading);
                self.scale_lobe(&mut terms.specular, pixels, shading, |_, weight| weight);
            }
            Lobes::BlinnPhong { power, far } => {
                if !far {
                    self.half_way(pixels, unwarped, direction);
                }
                power.raise(&mut self.lobe);
                self.scale_cosine(&mut terms.diffuse, pixels, shading);
                match shading.scaled {
                    None => {
                        for i in 0..BATCH {
                            terms.specular[i] = terms.diffuse[i] * self.lobe[i];
                        }
                    }
                    Some(_) => {
                        let weigh = |cosine, weight| weight * cosine;
                        self.scale_lobe(&mut terms.specular, pixels, shading, weigh);
                    }
                }
            }
            Lobes::AshikhminShirley(brdf) => {
                let axes = [&pixels.to_eye, &pixels.along, &pixels.across];
                for (k, axis) in axes.into_iter().enumerate() {
                    self.product(axis, unwarped, direction, k);
                }
                self.coat(terms, pixels, shading, &brdf);
            }
        }
    }

    /// Weights and cosines of a light as it stands.
    #[inline(always)]
    fn arrive<D, H, S>(&mut self, pixels: &Pixels, light: Arriving<D, H, S>)
    where
        D: Fn(usize) -> [f32; 3],
        S: Fn(usize) -> f32,
    {
        for i in 0..BATCH {
            let cosine = dot(pixels.normal.at(i), (light.direction)(i));
            self.weight[i] = if cosine > 0.0 { (light.share)(i) } else { 0.0 };
            self.cosine[i] = cosine;
        }
    }

    /// The square of n . h as lobe, for an eye on the axis.
    #[inline(always)]
    fn half_vector_lobe(&mut self, pixels: &Pixels, half: impl Fn(usize) -> [f32; 3]) {
        for i in 0..BATCH {
            let along = positive(dot(pixels.normal.at(i), half(i)));
            self.lobe[i] = at_most_1(along * along);
        }
    }

    /// [`Scratch::arrive`] for a light whose direction is unwarped, with its Jacobian. `lobe` makes a lobe of
    /// `2 h_z n . g`, `1 / |g|^2` and `h_z`.
    #[inline(always)]
    fn arrive_unwarped<D, H, S>(
        &mut self,
        pixels: &Pixels,
        light: Arriving<D, H, S>,
        lobe: impl Fn(f32, f32, f32) -> f32 + Copy,
    ) where
        D: Fn(usize) -> [f32; 3],
        H: Fn(usize) -> [f32; 3],
        S: Fn(usize) -> f32,
    {
        if light.everywhere {
            self.arrive_above(pixels, light, lobe, |_, _| true);
        } else {
            let above = |n, direction| dot(n, direction) > 0.0;
            self.arrive_above(pixels, light, lobe, above);
        }
    }

    /// [`Scratch::arrive_unwarped`], where `above` tells of a normal and the direction as it stands whether
    /// that is above the surface.
    #[inline(always)]
    fn arrive_above<D, H, S>(
        &mut self,
        pixels: &Pixels,
        light: Arriving<D, H, S>,
        lobe: impl Fn(f32, f32, f32) -> f32,
        above: impl Fn([f32; 3], [f32; 3]) -> bool,
    ) where
        D: Fn(usize) -> [f32; 3],
        H: Fn(usize) -> [f32; 3],
        S: Fn(usize) -> f32,
    {
        let [xx, xy, yy] = &pixels.unwarp_squared;
        let [gx, gy] = &pixels.normal.unwarped;
        for i in 0..BATCH {
            let n = pixels.normal.at(i);
            let [x, y, z] = (light.half)(i);
            let length = z * z + xx[i] * (x * x) + xy[i] * (x * y) + yy[i] * (y * y);
            let inverse = 1.0 / length;
            let twice = 2.0 * z;
            let along = gx[i] * (twice * x) + gy[i] * (twice * y) + n[2] * (twice * z);
            let cosine = inverse * along - n[2];
            let weight = (light.share)(i) * (inverse * inverse);
            let lit = (cosine > 0.0) & above(n, (light.direction)(i));
            self.weight[i] = if lit { weight } else { 0.0 };
            self.cosine[i] = cosine;
            self.inverse[i] = inverse;
            self.lobe[i] = lobe(along, inverse, z);
        }
    }

    /// Scalar products with the vectors of `axis` as product `k`.
    #[inline(always)]
    fn product(
        &mut self,
        axis: &Axis,
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

    /// The square of n . h as lobe, h half-way between light and an eye that is not on the axis.
    #[inline(always)]
    fn half_way(
        &mut self,
        pixels: &Pixels,
        unwarped: Option<impl Fn(usize) -> [f32; 3]>,
        direction: impl Fn(usize) -> [f32; 3],
    ) {
        self.product(&pixels.to_eye, unwarped, direction, 0);
        for i in 0..BATCH {
            let eye = dot(pixels.normal.at(i), pixels.to_eye.at(i));
            let along = positive(self.cosine[i] + eye);
            let squared = 2.0 + 2.0 * self.products[0][i];
            self.lobe[i] = at_most_1(along * along / squared.max(SHORTEST));
        }
    }

    /// Scaling curves toward the light.
    #[inline(always)]
    fn curve_toward(
        &mut self,
        pixels: &Pixels,
        toward: TowardLight,
        unwarped: Option<impl Fn(usize) -> [f32; 3]>,
        direction: impl Fn(usize) -> [f32; 3],
    ) {
        let across = &mut self.products;
        for i in 0..BATCH {
            let [x, y] = match &unwarped {
                None => {
                    let [x, y, _] = direction(i);
                    [x, y]
                }
                Some(half) => {
                    let [x, y, z] = half(i);
                    let [xx, xy, yy] = [
                        pixels.unwarp[0][i],
                        pixels.unwarp[1][i],
                        pixels.unwarp[2][i],
                    ];
                    let twice = 2.0 * z * self.inverse[i];
                    [twice * (xx * x + xy * y), twice * (xy * x + yy * y)]
                }
            };
            (across[0][i], across[1][i]) = (x, y);
        }
        let [xx, xy, yy] = &pixels.hessian;
        for (curves, magnitude) in self.curves.iter_mut().zip(toward.magnitudes) {
            for i in 0..BATCH {
                let (hessian, l_xy) = ([xx[i], xy[i], yy[i]], [across[0][i], across[1][i]]);
                let kappa = mapped_curvature_toward(hessian, l_xy, toward.gain, toward.anisotropy);
                curves.set(i, ScalingCurve::of(magnitude * kappa));
            }
        }
    }

    /// The diffuse term: the cosine lobe, scaled as its own intensity asks.
    #[inline(always)]
    fn scale_cosine(&self, diffuse: &mut Lanes, pixels: &Pixels, shading: &Shading) {
        let Self { weight, cosine, .. } = self;
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
        &self,
        specular: &mut Lanes,
        pixels: &Pixels,
        shading: &Shading,
        weigh: impl Fn(f32, f32) -> f32,
    ) {
        let Self {
            weight,
            cosine,
            lobe,
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
    fn coat(
        &mut self,
        terms: &mut Terms,
        pixels: &Pixels,
        shading: &Shading,
        brdf: &AshikhminShirley,
    ) {
        for i in 0..BATCH {
            let eye = pixels.to_eye.at(i);
            let [le, lu, lv] = [0, 1, 2].map(|k| self.products[k][i]);
            // h = (l + e) / |l + e|, |l + e|^2 = 2 + 2 l.e.
            let inverse = 1.0 / (2.0 + 2.0 * le).max(SHORTEST).sqrt();
            let ne = positive(dot(pixels.normal.at(i), eye)).min(1.0);
            let cosines = Cosines {
                nl: positive(self.cosine[i]),
                ne,
                he: ((1.0 + le) * inverse).clamp(0.0, 1.0),
                hu: (lu + dot(pixels.along.at(i), eye)) * inverse,
                hv: (lv + dot(pixels.across.at(i), eye)) * inverse,
            };
            self.lobe[i] = ((self.cosine[i] + ne) * inverse).clamp(0.0, 1.0);
            terms.diffuse[i] = self.weight[i] * brdf.diffuse(cosines.nl, ne);
            let specular = brdf.specular(cosines);
            // Weights are 0 below the horizon, where the lobe may be anything.
            let lit = self.weight[i] > 0.0;
            terms.specular[i] = if lit { self.weight[i] * specular } else { 0.0 };
        }
        if let Some(scaled) = shading.scaled {
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
