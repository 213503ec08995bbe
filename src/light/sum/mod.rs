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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::brdf::{AshikhminShirley, Lobes};
    use crate::light::light_samples::uniform_directions;
    use crate::light::sum::exponent::Exponent;
    use crate::params::MaterialParams;
    use glam::Vec3;

    fn shading(lobes: Lobes, warped: bool) -> Shading {
        Shading {
            warped,
            scaled: None,
            lobes,
        }
    }

    fn light(to_light: Vec3) -> DirectionalLight {
        DirectionalLight {
            to_light,
            intensity: [0.5, 1.0, 2.0],
        }
    }

    #[test]
    fn a_light_behind_lights_what_faces_it() {
        // Its half vector is in the picture plane, where z is 0. A surface seen from behind, turned by a from it, shows
        // the cosine of a.
        let mut pixels = Pixels::NONE;
        let angle = |i: usize| 1.5 * i as f32 / BATCH as f32;
        for i in 0..BATCH {
            pixels.normal.set(i, [angle(i).sin(), 0.0, -angle(i).cos()]);
        }
        pixels.warp_by(0.0);
        let power = Exponent::Integer(1);
        let mut sum = LightSum::NONE;
        let lights = Directed::all(&[light(-Vec3::Z)]);
        sum.add_directed(&pixels, &shading(Lobes::Diffuse { power }, true), &lights);
        for i in 0..BATCH {
            let error = sum.sums.diffuse[1][i] - angle(i).cos();
            assert!(error.abs() < 5e-6, "{error} at {}", angle(i));
        }
    }

    #[test]
    fn a_light_by_lane_has_the_bits_of_the_same_light_of_one_direction() {
        let mut pixels = Pixels::NONE;
        for (i, normal) in uniform_directions(2 * BATCH)
            .into_iter()
            .take(BATCH)
            .enumerate()
        {
            // All over the visible half sphere, with curvatures of both signs.
            pixels.normal.set(i, [normal.x, normal.y, normal.z.abs()]);
            pixels.mirrored.set(i, normal.to_array());
            pixels.hessian[0][i] = 0.1 * normal.x;
            pixels.hessian[1][i] = 0.05 * normal.y;
            pixels.hessian[2][i] = 0.2 * normal.z - 0.1;
        }
        pixels.set_tangents(false, |_| [1.0, 0.0]);
        pixels.warp_by(20.0);
        pixels.find_facing();
        let power = Exponent::Integer(16);
        let coat = AshikhminShirley::new(&MaterialParams::default());
        let lobes = [
            Lobes::Diffuse { power },
            Lobes::Phong { power },
            Lobes::BlinnPhong { power },
            Lobes::AshikhminShirley(coat),
            Lobes::Base(coat),
            Lobes::Mirror,
        ];
        for (lobes, warped) in lobes.into_iter().flat_map(|l| [(l, false), (l, true)]) {
            let shading = shading(lobes, warped);
            let [mut directed, mut by_lane] = [LightSum::NONE, LightSum::NONE];
            for to_light in uniform_directions(9) {
                let far = light(to_light);
                directed.add_directed(&pixels, &shading, &Directed::all(&[far]));
                let lanes = LightLanes {
                    direction: to_light.to_array().map(|component| [component; BATCH]),
                    share: [1.0; BATCH],
                    rgb: far.intensity.map(|channel| [channel; BATCH]),
                };
                by_lane.add_by_lane(&pixels, &shading, &lanes);
            }
            assert_eq!(directed.sums.diffuse, by_lane.sums.diffuse, "{shading:?}");
            assert_eq!(directed.sums.specular, by_lane.sums.specular, "{shading:?}");
            assert!(directed.sums.diffuse[1].iter().any(|&v| v > 0.1));
        }
    }
}
