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

mod directed;
pub(crate) mod exponent;
pub(crate) mod lobes;
mod scaled;
pub(crate) mod terms;

pub(crate) use directed::Directed;
pub(crate) use lobes::Shading;
pub(crate) use scaled::{Scaled, TowardLight};

use super::batch::{Above, BATCH, Lanes, LitPixels};
use super::light_warping::half_vector;
use terms::{Arriving, TermInputs, Terms};

/// Lights whose terms are buffered and added together, so that the sums are read and written once for all.
const GROUP: usize = 4;

/// Lights that are tried before any of them is added: tests between sums wait for what these store.
const AT_ONCE: usize = 64;

/// Light reflected from a batch.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct LightSums {
    /// Red, green and blue of diffusely reflected light, of albedo 1.
    pub diffuse: [Lanes; 3],
    /// Red, green and blue of specularly reflected light.
    pub specular: [Lanes; 3],
}

/// The sums of a batch, and the terms of the lights being added.
#[derive(Debug, Clone)]
pub(crate) struct LightSum {
    /// The light added so far; complete after [`LightSum::finish`].
    pub sums: LightSums,
    group: [Directed; GROUP],
    terms: [Terms; GROUP],
    scratch: TermInputs,
}

const ZERO: Lanes = [0.0; BATCH];

impl LightSums {
    /// No light.
    pub(crate) const NONE: Self = Self {
        diffuse: [ZERO; 3],
        specular: [ZERO; 3],
    };

    /// Adds the terms of one light of colour `rgb`.
    #[inline(always)]
    fn add(&mut self, terms: &Terms, rgb: impl Fn(usize) -> [f32; 3], glossy: bool) {
        add_term(&mut self.diffuse, &terms.diffuse, &rgb);
        if glossy {
            add_term(&mut self.specular, &terms.specular, &rgb);
        }
    }

    /// Adds the terms of a full group in order: the same bits as one by one.
    #[inline(always)]
    fn add_group(&mut self, terms: &[Terms; GROUP], colors: [[f32; 3]; GROUP], glossy: bool) {
        let [a, b, c, d] = terms;
        let diffuse = [&a.diffuse, &b.diffuse, &c.diffuse, &d.diffuse];
        add_group(&mut self.diffuse, diffuse, colors);
        if glossy {
            let specular = [&a.specular, &b.specular, &c.specular, &d.specular];
            add_group(&mut self.specular, specular, colors);
        }
    }
}

impl Default for LightSum {
    fn default() -> Self {
        Self::new()
    }
}

impl LightSum {
    /// Sums of no light.
    pub(crate) fn new() -> Self {
        Self {
            sums: LightSums::NONE,
            group: [Directed::none(); GROUP],
            terms: [Terms::NONE; GROUP],
            scratch: TermInputs::NONE,
        }
    }

    /// Resets the sums.
    pub(crate) fn clear(&mut self) {
        self.sums = LightSums::NONE;
    }

    /// Adds lights of one direction each.
    #[inline(always)]
    pub(crate) fn add_directed(
        &mut self,
        fma: bool,
        pixels: &LitPixels,
        shading: &Shading,
        lights: &[Directed],
    ) {
        for some in lights.chunks(AT_ONCE) {
            let mut tried = [Above::Nowhere; AT_ONCE];
            for (tried, light) in tried.iter_mut().zip(some) {
                *tried = pixels.facing.above(light.direction);
            }
            let mut found = some.iter().zip(tried);
            loop {
                // The next few that reach any of the pixels.
                let (mut count, mut above) = (0, [Above::Everywhere; GROUP]);
                while count < GROUP
                    && let Some((light, tried)) = found.next()
                {
                    above[count] = tried;
                    if tried != Above::Nowhere {
                        self.group[count] = *light;
                        count += 1;
                    }
                }
                if count == 0 {
                    break;
                }
                self.add_group(fma, pixels, shading, &above[..count]);
            }
        }
    }

    /// Adds the first lights of the group, as many as `above` has entries.
    #[inline(always)]
    fn add_group(&mut self, fma: bool, pixels: &LitPixels, shading: &Shading, above: &[Above]) {
        let Self {
            sums,
            group,
            terms,
            scratch,
        } = self;
        if let Some(lobes) = shading.group_lobes() {
            group[above.len()..].fill(Directed::none());
            let everywhere = above.iter().all(|&above| above == Above::Everywhere);
            lobes.add(fma, sums, terms, pixels, (group, everywhere));
            return;
        }
        for ((light, above), terms) in group.iter().zip(above).zip(&mut *terms) {
            // By value: loops over lanes do not read them again after each store.
            let (direction, half) = (light.direction, light.half);
            let arriving = Arriving {
                direction: |_| direction,
                half: |_| half,
                share: |_| 1.0,
                everywhere: *above == Above::Everywhere,
            };
            scratch.reflect(terms, pixels, shading, arriving);
        }
        let glossy = shading.lobes.are_glossy();
        let colors = group.map(|light| light.intensity);
        if above.len() == GROUP {
            sums.add_group(terms, colors, glossy);
        } else {
            for (terms, rgb) in terms.iter().zip(colors).take(above.len()) {
                sums.add(terms, |_| rgb, glossy);
            }
        }
    }

    /// Adds light from one direction, of colour `rgb` by pixel.
    #[inline(always)]
    pub(crate) fn add_looked_up(
        &mut self,
        pixels: &LitPixels,
        shading: &Shading,
        direction: [f32; 3],
        rgb: &[Lanes; 3],
    ) {
        let above = pixels.facing.above(direction);
        if above == Above::Nowhere {
            return;
        }
        let half = half_vector(direction);
        let arriving = Arriving {
            direction: |_| direction,
            half: |_| half,
            share: |_| 1.0,
            everywhere: above == Above::Everywhere,
        };
        self.scratch
            .reflect(&mut self.terms[0], pixels, shading, arriving);
        let rgb = |i: usize| [rgb[0][i], rgb[1][i], rgb[2][i]];
        let glossy = shading.lobes.are_glossy();
        self.sums.add(&self.terms[0], rgb, glossy);
    }

    /// Adds a light near the surface, with its unit directions and its attenuation by pixel.
    #[inline(always)]
    pub(crate) fn add_near(
        &mut self,
        pixels: &LitPixels,
        shading: &Shading,
        (directions, share): (&[Lanes; 3], &Lanes),
        rgb: [f32; 3],
    ) {
        let direction = |i: usize| [directions[0][i], directions[1][i], directions[2][i]];
        let arriving = Arriving {
            direction,
            half: |i| half_vector(direction(i)),
            share: |i| share[i],
            everywhere: false,
        };
        self.scratch
            .reflect(&mut self.terms[0], pixels, shading, arriving);
        let glossy = shading.lobes.are_glossy();
        self.sums.add(&self.terms[0], |_| rgb, glossy);
    }

    /// Multiplies the diffuse light added so far by `share`.
    #[inline(always)]
    pub(crate) fn dim(&mut self, share: &Lanes) {
        for sum in &mut self.sums.diffuse {
            for (sum, share) in sum.iter_mut().zip(share) {
                *sum *= share;
            }
        }
    }

    /// Completes the sums.
    #[inline(always)]
    pub(crate) fn finish(&mut self, pixels: &LitPixels, shading: &Shading) {
        if shading.warped {
            let LightSums { diffuse, specular } = &mut self.sums;
            for sum in diffuse.iter_mut().chain(specular) {
                for (sum, spread) in sum.iter_mut().zip(&pixels.spread) {
                    *sum *= spread;
                }
            }
        }
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
