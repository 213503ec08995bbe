//! The sum over lights: the contribution of many lights to a batch of pixels.
//!
//! Theory: [RS] section 5.1 and equation 3, `sum of rho_j(l) sigma_j(l) L_j(l)` over terms j and lights; with
//! light warping [LW] equation 2, which evaluates rho at the unwarped direction `l = W^-1(l')` of a light l', weighted by the Jacobian of
//! the inverse. Changes: a warp is linear in the half vector h of light and viewer (see [`super::light_warping`]), so
//! unwarped directions are never computed: with `g = (Lambda^-1 h_xy, h_z)` the dot product of one with a vector a is
//! `2 h_z (a . g) / |g|^2 - a_z`. The parts that depend on the pixel only are prepared once (`Pixels`); each light then
//! costs some twenty operations and a division. A light counts only where it is above the surface both as given and
//! unwarped ([LW] section 6.1), and fades toward that edge (`MOST_BRIGHTENED`).
//!
//! Use: prepare lights of one direction once per run ([`Directed`]), add all lights to a [`LightSum`], read its sums.

pub(crate) mod exponent;
mod shading;
pub(crate) mod terms;

pub(crate) use shading::{Scaled, Shading, TowardLight};

use super::batch::{BATCH, Lanes, Pixels, Vectors, at};
use super::light_warping::half_vector;
use super::lights::DirectionalLight;
use terms::{Arriving, Terms};

/// A light of one direction, prepared for all batches of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Directed {
    arriving: Arriving,
    intensity: [f32; 3],
}

impl Directed {
    /// All lights.
    pub(crate) fn all(lights: &[DirectionalLight]) -> Vec<Self> {
        let prepared = |light: &DirectionalLight| {
            let direction = light.to_light.to_array();
            Self {
                arriving: Arriving {
                    direction,
                    half: half_vector(direction),
                    share: 1.0,
                },
                intensity: light.intensity,
            }
        };
        lights.iter().map(prepared).collect()
    }
}

/// A light that differs by pixel: its unit directions, its attenuation, its colours.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct LightLanes {
    pub(crate) direction: Vectors,
    pub(crate) share: Lanes,
    pub(crate) rgb: Vectors,
}

impl LightLanes {
    /// No light.
    pub(crate) const NONE: Self = Self {
        direction: [ZERO; 3],
        share: ZERO,
        rgb: [ZERO; 3],
    };
}

/// Light reflected from a batch.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct Sums {
    /// Red, green and blue of diffusely reflected light, of albedo 1.
    pub diffuse: Vectors,
    /// Red, green and blue of specularly reflected light.
    pub specular: Vectors,
}

/// The sums of a batch, and the terms of the light being added.
#[derive(Debug, Clone)]
pub(crate) struct LightSum {
    pub sums: Sums,
    terms: Terms,
}

const ZERO: Lanes = [0.0; BATCH];

impl Sums {
    /// No light.
    pub(crate) const NONE: Self = Self {
        diffuse: [ZERO; 3],
        specular: [ZERO; 3],
    };
}

impl LightSum {
    /// Sums of no light.
    pub(crate) const NONE: Self = Self {
        sums: Sums::NONE,
        terms: Terms::NONE,
    };

    /// Adds lights of one direction each.
    #[inline(always)]
    pub(crate) fn add_directed(&mut self, pixels: &Pixels, shading: &Shading, lights: &[Directed]) {
        for &Directed {
            arriving,
            intensity,
        } in lights
        {
            if pixels.facing.may_see(arriving.direction) {
                self.add(pixels, shading, |_| (arriving, intensity));
            }
        }
    }

    /// Adds a light that differs by pixel.
    #[inline(always)]
    pub(crate) fn add_by_lane(&mut self, pixels: &Pixels, shading: &Shading, light: &LightLanes) {
        self.add(pixels, shading, |lane| {
            let direction = at(&light.direction, lane);
            let arriving = Arriving {
                direction,
                half: half_vector(direction),
                share: light.share[lane],
            };
            (arriving, at(&light.rgb, lane))
        });
    }

    /// Adds lights that stand for an environment before any others; with `base` they make its highlights alone, and those of
    /// `base` its diffuse light.
    #[inline(always)]
    pub(crate) fn add_around(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        (lights, base): (&[Directed], Option<&[Directed]>),
    ) {
        self.add_directed(pixels, shading, lights);
        if let Some(base) = base {
            self.sums.diffuse = Sums::NONE.diffuse;
            self.add_directed(pixels, &shading.diffuse(), base);
        }
    }

    /// Adds a light, given with its colour by lane.
    #[inline(always)]
    fn add(
        &mut self,
        pixels: &Pixels,
        shading: &Shading,
        light: impl Fn(usize) -> (Arriving, [f32; 3]),
    ) {
        let Self { sums, terms } = self;
        match shading.warped {
            true => terms.reflect::<true>(pixels, shading, |lane| light(lane).0),
            false => terms.reflect::<false>(pixels, shading, |lane| light(lane).0),
        }
        add_term(&mut sums.diffuse, &terms.diffuse, |lane| light(lane).1);
        if shading.lobes.are_glossy() {
            add_term(&mut sums.specular, &terms.specular, |lane| light(lane).1);
        }
    }
}

/// Adds `term * rgb` to the sums.
#[inline(always)]
fn add_term([r, g, b]: &mut Vectors, term: &Lanes, rgb: impl Fn(usize) -> [f32; 3]) {
    for lane in 0..BATCH {
        let rgb = rgb(lane);
        r[lane] += term[lane] * rgb[0];
        g[lane] += term[lane] * rgb[1];
        b[lane] += term[lane] * rgb[2];
    }
}
