//! Lights of one direction each, and simple lobes that reflect a few of them at a time.
//!
//! The samples of a pixel are loaded once for a group of lights, and one light's division passes while others multiply.
//! A half vector enters divided by its z, which saves multiplications by z; the light's colour makes up for its length.

use super::exponent::Exponent;
use super::lobes::{Lobes, Shading};
use super::terms::{HalfVector, Terms, Unwarped, arrive_unwarped, half_vector_lobe};
use super::{GROUP, LightSums};
use crate::kernel::lanes::multiply_add;
use crate::light::batch::{BATCH, LitPixels};
use crate::light::cosines::{positive, scalar_product};
use crate::light::light_warping::{MOST_BRIGHTENED, half_vector};
use crate::light::lights::DirectionalLight;

/// A light of one direction, prepared for all batches of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Directed {
    pub(crate) direction: [f32; 3],
    pub(super) half: [f32; 3],
    pub(crate) intensity: [f32; 3],
    /// The half vector divided by its z.
    over_z: HalfVector,
    /// The intensity for terms of `over_z`: Jacobians go with the fourth power of its length.
    intensity_over_z: [f32; 3],
    /// The direction times [`MOST_BRIGHTENED`].
    most: [f32; 3],
}

/// Half vectors closer to the picture plane get this z. Their lights, within 2e-6 of -z, only reach surfaces seen from
/// behind; and the fourth power of its reciprocal still leaves room for intensities.
const FLATTEST: f32 = 1e-6;

impl Directed {
    /// All lights, those nearest to the viewer's direction first: neighbours are above the same surfaces.
    pub(crate) fn all(lights: &[DirectionalLight]) -> Vec<Self> {
        let mut lights: Vec<Self> = lights.iter().map(Self::of).collect();
        lights.sort_by(|a, b| b.direction[2].total_cmp(&a.direction[2]));
        lights
    }

    /// The light, prepared.
    fn of(light: &DirectionalLight) -> Self {
        let (direction, intensity) = (light.to_light.to_array(), light.intensity);
        let half = half_vector(direction);
        let per_z = 1.0 / half[2].max(FLATTEST);
        let square = per_z * per_z;
        Self {
            direction,
            half,
            intensity,
            over_z: HalfVector::of([half[0] * per_z, half[1] * per_z, 1.0]),
            intensity_over_z: intensity.map(|c| (c * (square * square)).min(f32::MAX)),
            most: direction.map(|d| MOST_BRIGHTENED * d),
        }
    }

    /// No light.
    pub(super) fn none() -> Self {
        Self::of(&DirectionalLight {
            to_light: glam::Vec3::Z,
            intensity: [0.0; 3],
        })
    }
}

/// Lobes that reflect a group of lights at once: Lambert, and Blinn-Phong seen from far away, not scaled.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroupLobes {
    warped: bool,
    /// The exponent of the highlight, if there is one.
    highlight: Option<Exponent>,
}

impl Shading {
    /// The lobes, if they reflect groups.
    pub(super) fn group_lobes(&self) -> Option<GroupLobes> {
        let highlight = match self.lobes {
            Lobes::Diffuse {
                power: Exponent::Integer(1),
            } => None,
            Lobes::BlinnPhong { power, far: true } => Some(power),
            _ => return None,
        };
        let warped = self.warped;
        self.scaled
            .is_none()
            .then_some(GroupLobes { warped, highlight })
    }
}

impl GroupLobes {
    /// Adds the light reflected from a group. `everywhere` says that all its lights are known to be above the surface
    /// everywhere.
    #[inline(always)]
    pub(super) fn add(
        self,
        fma: bool,
        sums: &mut LightSums,
        terms: &mut [Terms; GROUP],
        pixels: &LitPixels,
        (lights, everywhere): (&[Directed; GROUP], bool),
    ) {
        match self.highlight {
            None => {
                self.arrive::<false>(fma, terms, pixels, (lights, everywhere));
                self.sum::<false>(fma, sums, terms, lights);
            }
            Some(power) => {
                self.arrive::<true>(fma, terms, pixels, (lights, everywhere));
                for terms in terms.iter_mut() {
                    power.raise(&mut terms.specular);
                }
                self.sum::<true>(fma, sums, terms, lights);
            }
        }
    }

    /// Computes the diffuse terms, and as specular ones the square of n . h if there is a highlight.
    #[inline(always)]
    fn arrive<const GLOSSY: bool>(
        self,
        fma: bool,
        terms: &mut [Terms; GROUP],
        pixels: &LitPixels,
        (lights, everywhere): (&[Directed; GROUP], bool),
    ) {
        match (self.warped, everywhere) {
            (true, true) => unwarp::<GLOSSY>(fma, terms, pixels, lights, |_, _| f32::MAX),
            (true, false) => unwarp::<GLOSSY>(fma, terms, pixels, lights, |normal, light| {
                scalar_product(normal, light.most)
            }),
            (false, _) => {
                for i in 0..BATCH {
                    let normal = pixels.normal.at(i);
                    for (terms, light) in terms.iter_mut().zip(lights) {
                        terms.diffuse[i] = positive(scalar_product(normal, light.direction));
                        if GLOSSY {
                            terms.specular[i] = half_vector_lobe(normal, light.half);
                        }
                    }
                }
            }
        }
    }

    /// Adds the terms in the order of the lights.
    #[inline(always)]
    fn sum<const GLOSSY: bool>(
        self,
        fma: bool,
        sums: &mut LightSums,
        terms: &[Terms; GROUP],
        lights: &[Directed; GROUP],
    ) {
        let colors = lights.each_ref().map(|light| match self.warped {
            true => light.intensity_over_z,
            false => light.intensity,
        });
        for i in 0..BATCH {
            let mut diffuse = [sums.diffuse[0][i], sums.diffuse[1][i], sums.diffuse[2][i]];
            let mut specular = [
                sums.specular[0][i],
                sums.specular[1][i],
                sums.specular[2][i],
            ];
            for (terms, color) in terms.iter().zip(&colors) {
                let light = terms.diffuse[i];
                for k in 0..3 {
                    diffuse[k] = multiply_add(fma, light, color[k], diffuse[k]);
                }
                if GLOSSY {
                    let light = light * terms.specular[i];
                    for k in 0..3 {
                        specular[k] = multiply_add(fma, light, color[k], specular[k]);
                    }
                }
            }
            for k in 0..3 {
                sums.diffuse[k][i] = diffuse[k];
                if GLOSSY {
                    sums.specular[k][i] = specular[k];
                }
            }
        }
    }
}

/// [`GroupLobes::arrive`] with light directions unwarped, where `most` bounds the cosine.
#[inline(always)]
fn unwarp<const GLOSSY: bool>(
    fma: bool,
    terms: &mut [Terms; GROUP],
    pixels: &LitPixels,
    lights: &[Directed; GROUP],
    most: impl Fn([f32; 3], &Directed) -> f32,
) {
    let [xx, xy, yy] = &pixels.unwarp_squared;
    let [gx, gy] = &pixels.normal.unwarped;
    for i in 0..BATCH {
        let normal = pixels.normal.at(i);
        let (unwarped, squared) = ([gx[i], gy[i]], [xx[i], xy[i], yy[i]]);
        for (terms, light) in terms.iter_mut().zip(lights) {
            let most = most(normal, light);
            // The z of the half vector as a constant, which the compiler leaves out of products.
            let [x, y, _] = light.over_z.vector;
            let [_, xx, xy, yy] = light.over_z.products;
            let half = HalfVector {
                vector: [x, y, 1.0],
                products: [1.0, xx, xy, yy],
            };
            let Unwarped {
                weight,
                cosine,
                lobe,
                ..
            } = arrive_unwarped(fma, &half, 1.0, (normal, unwarped), squared, most);
            terms.diffuse[i] = weight * positive(cosine);
            if GLOSSY {
                terms.specular[i] = lobe;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::batch::Facing;
    use crate::light::sum::LightSum;
    use glam::Vec3;

    /// Normals all over the visible half sphere, and curvatures of both signs.
    fn pixels() -> LitPixels {
        let mut pixels = LitPixels::new();
        pixels.count = BATCH;
        for i in 0..BATCH {
            let (angle, tilt) = (2.4 * i as f32, i as f32 / BATCH as f32);
            let normal = Vec3::new(tilt * angle.cos(), tilt * angle.sin(), 1.01 - tilt);
            pixels.normal.set(i, normal.normalize().to_array());
            pixels.mirrored.set(i, normal.normalize().to_array());
            pixels.hessian[0][i] = 0.1 * angle.sin();
            pixels.hessian[1][i] = 0.05 * angle.cos();
            pixels.hessian[2][i] = 0.2 * tilt - 0.1;
        }
        pixels.warp_by(20.0);
        pixels.facing = Facing::of(&pixels.normal.vector, BATCH);
        pixels
    }

    fn light(to_light: Vec3) -> Directed {
        let to_light = to_light.normalize();
        Directed::of(&DirectionalLight {
            to_light,
            intensity: [0.5, 1.0, 2.0],
        })
    }

    fn shading(lobes: Lobes, warped: bool) -> Shading {
        Shading {
            warped,
            scaled: None,
            lobes,
        }
    }

    /// Lights from above to below the picture plane.
    fn spiral() -> Vec<Directed> {
        let spiral = (0..9).map(|i| {
            let (angle, z) = (2.4 * i as f32, 1.0 - 0.15 * i as f32);
            light(Vec3::new(angle.cos(), angle.sin(), z))
        });
        spiral.collect()
    }

    #[test]
    fn fused_multiply_adds_change_light_by_rounding() {
        let (pixels, lights) = (pixels(), spiral());
        let power = Exponent::Integer(16);
        for warped in [false, true] {
            let shading = shading(Lobes::BlinnPhong { power, far: true }, warped);
            let [mut fused, mut separate] = [LightSum::new(), LightSum::new()];
            fused.add_directed(true, &pixels, &shading, &lights);
            separate.add_directed(false, &pixels, &shading, &lights);
            let [fused, separate] = [fused.sums, separate.sums].map(|sums| {
                let both = [sums.diffuse, sums.specular];
                both.map(|light| light.as_flattened().to_vec())
            });
            for (fused, separate) in fused.iter().zip(&separate) {
                // The highlight is the eighth power of (n . h)^2, where a difference of four roundings, two of n . h and
                // two of the length, counts eight times: 8 4 2^-24 = 1.9e-6.
                let brightest = separate.iter().copied().fold(0.0, f32::max);
                for (a, b) in fused.iter().zip(separate) {
                    assert!((a - b).abs() <= 2e-6 * brightest, "{warped}: {a} and {b}");
                }
            }
            // Products with these colours, powers of two, are exact.
            assert_eq!(fused != separate, warped);
        }
    }

    #[test]
    fn lights_in_groups_give_the_bits_of_lights_one_by_one() {
        let (pixels, lights) = (pixels(), spiral());
        let power = Exponent::Integer(16);
        let lobes = [
            Lobes::Diffuse {
                power: Exponent::Integer(1),
            },
            Lobes::BlinnPhong { power, far: true },
            Lobes::Phong { power },
        ];
        for shading in lobes
            .into_iter()
            .flat_map(|l| [shading(l, false), shading(l, true)])
        {
            for count in 1..=lights.len() {
                let [mut together, mut apart] = [LightSum::new(), LightSum::new()];
                together.add_directed(true, &pixels, &shading, &lights[..count]);
                for light in &lights[..count] {
                    apart.add_directed(true, &pixels, &shading, std::slice::from_ref(light));
                }
                assert_eq!(together.sums.diffuse, apart.sums.diffuse, "{shading:?}");
                assert_eq!(together.sums.specular, apart.sums.specular, "{shading:?}");
                assert!(together.sums.diffuse[1].iter().any(|&v| v > 0.1));
            }
        }
    }

    #[test]
    fn a_light_behind_lights_what_faces_it() {
        // Its half vector is in the picture plane, where z is 0. A surface seen from behind, turned by a from it, shows
        // the cosine of a.
        let mut pixels = LitPixels::new();
        pixels.count = BATCH;
        let angle = |i: usize| 1.5 * i as f32 / BATCH as f32;
        for i in 0..BATCH {
            pixels.normal.set(i, [angle(i).sin(), 0.0, -angle(i).cos()]);
        }
        pixels.warp_by(0.0);
        let lobes = Lobes::Diffuse {
            power: Exponent::Integer(1),
        };
        let mut sum = LightSum::new();
        sum.add_directed(false, &pixels, &shading(lobes, true), &[light(-Vec3::Z)]);
        for i in 0..BATCH {
            let error = sum.sums.diffuse[1][i] - angle(i).cos();
            assert!(error.abs() < 5e-6, "{error} at {}", angle(i));
        }
    }
}
