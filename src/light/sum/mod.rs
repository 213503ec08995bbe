//! The sum over lights: the contribution of many lights to a batch of pixels.
//!
//! Theory: [RS] equation 3, `sum of rho_j(l) sigma_j(l) L_j(l)` over terms j and lights; with light warping [LW]
//! equation 2, which evaluates rho at the unwarped direction `l = W^-1(l')` of a light l', weighted by the Jacobian of
//! the inverse. Changes: a warp is linear in the half vector h of light and viewer (see [`super::light_warping`]), so
//! unwarped directions are never computed: with `g = (Lambda^-1 h_xy, h_z)` the dot product of one with a vector a is
//! `2 h_z (a . g) / |g|^2 - a_z`. The parts that depend on the pixel only are prepared once (`Pixels`); each light then
//! costs some twenty operations and a division. A light counts only where it is above the surface both as given and
//! unwarped ([LW] section 6.1), and fades toward that edge (`MOST_BRIGHTENED`).
//!
//! Use: `LightSum::add` light by light, then read the sums.

pub(crate) mod exponent;
mod shading;
pub(crate) mod terms;

pub(crate) use shading::{Scaled, Shading, TowardLight};

use super::batch::{Above, BATCH, Lanes, Pixels};
use super::light_warping::half_vector;
use terms::{Arriving, Scratch, Terms};

/// A directional light, or a point light with a different direction at every pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Incoming<'a> {
    /// Unit direction to the light.
    From([f32; 3]),
    /// Unit directions by pixel, with the attenuation.
    Near(&'a [Lanes; 3], &'a Lanes),
}

/// The intensity of a light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Intensity<'a> {
    /// Red, green and blue, the same for all pixels.
    Even([f32; 3]),
    /// Red, green and blue by pixel, looked up in an environment.
    LookedUp(&'a [Lanes; 3]),
}

/// Lights whose terms are buffered and added together, so that the sums are read and written once for all.
const GROUP: usize = 4;

/// The sums of a batch, and the terms of the lights being added.
#[derive(Debug, Clone)]
pub(crate) struct LightSum {
    /// Red, green and blue of diffusely reflected light, of albedo 1; complete after [`LightSum::finish`].
    pub diffuse: [Lanes; 3],
    /// Red, green and blue of specularly reflected light; complete after [`LightSum::finish`].
    pub specular: [Lanes; 3],
    waiting: usize,
    colors: [[f32; 3]; GROUP],
    terms: [Terms; GROUP],
    scratch: Scratch,
}

const ZERO: Lanes = [0.0; BATCH];

impl Default for LightSum {
    fn default() -> Self {
        Self::new()
    }
}

impl LightSum {
    /// Sums of no light.
    pub(crate) fn new() -> Self {
        Self {
            diffuse: [ZERO; 3],
            specular: [ZERO; 3],
            waiting: 0,
            colors: [[0.0; 3]; GROUP],
            terms: [Terms::NONE; GROUP],
            scratch: Scratch::NONE,
        }
    }

    /// Resets the sums.
    pub(crate) fn clear(&mut self) {
        self.diffuse = [ZERO; 3];
        self.specular = [ZERO; 3];
        self.waiting = 0;
    }

    /// Adds one light.
    #[inline(always)]
    pub(crate) fn add(
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

    /// Multiplies the diffuse light added so far by `share`.
    #[inline(always)]
    pub(crate) fn dim(&mut self, share: &Lanes, shading: &Shading) {
        self.gather_waiting(shading.lobes.are_glossy());
        for sum in &mut self.diffuse {
            for (sum, share) in sum.iter_mut().zip(share) {
                *sum *= share;
            }
        }
    }

    /// Completes the sums.
    #[inline(always)]
    pub(crate) fn finish(&mut self, pixels: &Pixels, shading: &Shading) {
        self.gather_waiting(shading.lobes.are_glossy());
        if shading.warped {
            for sum in self.diffuse.iter_mut().chain(&mut self.specular) {
                for (sum, spread) in sum.iter_mut().zip(&pixels.spread) {
                    *sum *= spread;
                }
            }
        }
    }

    /// Adds the buffered lights.
    #[inline(always)]
    fn gather_waiting(&mut self, glossy: bool) {
        for k in 0..self.waiting {
            let (terms, rgb) = (&self.terms[k], self.colors[k]);
            add_term(&mut self.diffuse, &terms.diffuse, |_| rgb);
            if glossy {
                add_term(&mut self.specular, &terms.specular, |_| rgb);
            }
        }
        self.waiting = 0;
    }

    /// Adds a full group in order: the same bits as one by one.
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
