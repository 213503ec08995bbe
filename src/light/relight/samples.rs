//! Filtered importance sampling: the highlight that an environment makes, from directions that each pixel chooses by its
//! own lobe, looked up in maps as blurred as the directions are apart.
//!
//! Theory: M. Colbert, J. Krivanek: GPU-Based Importance Sampling, GPU Gems 3 (2007), chapter 20. A sample of density p
//! among K stands for the solid angle 1/(K p), and reads a map whose pixels have it. Since directions are as dense as the
//! lobe is bright, the lobe cancels: what is left of a coat is its reflectance. Changes: no pixel has random numbers of its
//! own, so neighbours err alike and nothing is grainy; maps are a step finer than that, not one coarser, which halves the
//! error of the few samples used here; and what is far brighter than the mean is left to lights, see [`super::pilot`].

use crate::light::batch::{BATCH, Lanes, LitPixels, Term, Vectors};
use crate::light::cosines::{at_most_1, positive, scalar_product};
use crate::light::light_warping::{MOST_BRIGHTENED, Warp};
use crate::light::octahedral::OctahedralMaps;
use crate::light::shadows::horizons::{HorizonLanes, hide_each};
use crate::light::sum::lobes::Lobes;
use crate::light::sum::terms::SHORTEST;
use crate::light::sum::{LightSum, Shading};
use crate::light::texels::Texel;
use crate::params::{Material, MaterialParams};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Share of a sample's solid angle that a blurred pixel has.
const SHARPER: f64 = 0.25;

/// The share of a turn between samples: the golden ratio's.
const TURN: f64 = 0.618_033_988_749_895;

/// Samples whose texels are added together, so that the sums are read and written once for all.
pub(super) const AT_ONCE: usize = 4;

/// Cosine of h and e below which maps get no finer.
const SLANTED: f32 = 0.25;

/// The directions of a lobe, and the environment at every resolution.
#[derive(Debug)]
pub(crate) struct FilteredSamples {
    pattern: Vec<LobeSample>,
    maps: Arc<OctahedralMaps>,
    /// The intensity of a sample of radiance 1, but for what depends on the pixel.
    intensity: f32,
}

/// A direction of a lobe: a half vector about the normal, or a direction about the eye mirrored at the normal.
#[derive(Debug, Clone, Copy)]
struct LobeSample {
    /// By tangents and axis.
    direction: [f32; 3],
    /// Solid angle of a pixel of the map; of half vectors, for h.e = 1.
    solid_angle: f32,
    /// What radiance scaling takes for the intensity of the highlight.
    seen: f32,
}

/// A few samples of every pixel: the direction of the last of them, and the shares and texels of all.
struct SampleScratch {
    toward: Vectors,
    /// h . e.
    slant: Lanes,
    /// n . l.
    cosine: Lanes,
    solid_angle: Lanes,
    share: [Lanes; AT_ONCE],
    texels: [[u32; BATCH]; AT_ONCE],
    /// The warp, xx, xy and yy, and its determinant.
    warp: [Lanes; 4],
}

impl FilteredSamples {
    /// `count` samples, a multiple of [`AT_ONCE`], of the highlight of `material` in what `maps` show, times `gain`.
    pub(crate) fn new(
        material: &MaterialParams,
        maps: &Arc<OctahedralMaps>,
        count: usize,
        gain: f32,
    ) -> Self {
        let exponents = exponents(material);
        let lobe_of = |i: usize| {
            let share = (i as f64 + 0.5) / count as f64;
            lobe(exponents, share, (i as f64 * TURN).fract())
        };
        let sample = |i: usize| {
            let LobeDirection { direction, density } = lobe_of(i);
            let [_, _, z] = direction;
            LobeSample {
                direction,
                solid_angle: (solid_angle(material, density) / count as f64) as f32,
                seen: match material.material {
                    Material::AshikhminShirley => z,
                    _ => z.powf(material.shininess),
                },
            }
        };
        // A lobe of peak 1 has 2 pi over its exponent and 1; that of directions is four h.e times that of half vectors.
        let peak = match material.material {
            Material::AshikhminShirley => 1.0,
            Material::Phong => 2.0 / (material.shininess + 1.0),
            _ => 8.0 / (material.shininess + 1.0),
        };
        Self {
            pattern: (0..count).map(sample).collect(),
            maps: maps.clone(),
            intensity: gain * peak / count as f32,
        }
    }

    /// The least solid angle of a pixel of the maps for that many samples, in steradians.
    pub(crate) fn finest(material: &MaterialParams, count: usize) -> f32 {
        let peak = lobe(exponents(material), 0.0, 0.0).density;
        SLANTED * (solid_angle(material, peak) / count as f64) as f32
    }

    /// Number of samples.
    pub(crate) fn count(&self) -> usize {
        self.pattern.len()
    }

    /// Adds the highlight, but for what `horizons` hide of it. Directions are bent as look-ups are ([LW] equation 1) where
    /// `shading` warps light, and are hidden as they were before.
    #[inline(always)]
    pub(crate) fn add(
        &self,
        pixels: &LitPixels,
        sum: &mut LightSum,
        shading: &Shading,
        horizons: Option<&HorizonLanes>,
    ) {
        let mut scratch = SampleScratch::NONE;
        if shading.warped {
            scratch.find_warp(pixels);
        }
        let mut light = [[0.0; 4]; BATCH];
        for some in self.pattern.as_chunks::<AT_ONCE>().0 {
            for (at, sample) in some.iter().enumerate() {
                match shading.lobes {
                    Lobes::Phong { .. } => scratch.aim::<false>(sample, pixels),
                    _ => scratch.aim::<true>(sample, pixels),
                }
                let mut seen = [1.0; BATCH];
                if let Some(horizons) = horizons {
                    hide_each(horizons, &scratch.toward, &mut seen);
                }
                if shading.warped {
                    scratch.bend(pixels);
                }
                scratch.weigh(at, pixels, &shading.lobes);
                if horizons.is_some() {
                    let shares = scratch.share[at].iter_mut().zip(seen);
                    shares.for_each(|(share, seen)| *share *= seen);
                }
                if let Some(scaled) = shading.scaled {
                    let curves = pixels.curve(Term::Specular as usize);
                    for i in 0..BATCH {
                        let sigma = curves.at(i).at(sample.seen, scaled.invariant_point);
                        scratch.share[at][i] *= sigma;
                    }
                }
                let texels = &mut scratch.texels[at];
                self.maps
                    .find(texels, &scratch.toward, &scratch.solid_angle);
            }
            for (i, light) in light.iter_mut().enumerate() {
                for at in 0..AT_ONCE {
                    let texel = self.maps.at(scratch.texels[at][i]);
                    *light = add(*light, texel, scratch.share[at][i]);
                }
            }
        }
        for i in 0..BATCH {
            for (sum, light) in sum.sums.specular.iter_mut().zip(light[i]) {
                sum[i] += self.intensity * light;
            }
        }
    }
}

/// Adds a texel times `share`.
#[inline(always)]
fn add(sum: Texel, texel: Texel, share: f32) -> Texel {
    // Written out: a closure is not always inlined into kernels for wider vectors.
    [
        sum[0] + share * texel[0],
        sum[1] + share * texel[1],
        sum[2] + share * texel[2],
        sum[3] + share * texel[3],
    ]
}

impl SampleScratch {
    const NONE: Self = Self {
        toward: [[0.0; BATCH]; 3],
        slant: [0.0; BATCH],
        cosine: [0.0; BATCH],
        solid_angle: [0.0; BATCH],
        share: [[0.0; BATCH]; AT_ONCE],
        texels: [[0; BATCH]; AT_ONCE],
        warp: [[0.0; BATCH]; 4],
    };

    #[inline(always)]
    fn find_warp(&mut self, pixels: &LitPixels) {
        let ([xx, xy, yy], [to_xx, to_xy, to_yy, determinant]) = (&pixels.unwarp, &mut self.warp);
        for i in 0..BATCH {
            let inverse = Warp {
                xx: xx[i],
                xy: xy[i],
                yy: yy[i],
            };
            let warp = inverse.inverse();
            (to_xx[i], to_xy[i], to_yy[i]) = (warp.xx, warp.xy, warp.yy);
            determinant[i] = warp.determinant();
        }
    }

    /// Directions, cosines and solid angles of a sample.
    #[inline(always)]
    fn aim<const IS_HALF: bool>(&mut self, sample: &LobeSample, pixels: &LitPixels) {
        let [toward_x, toward_y, toward_z] = &mut self.toward;
        let [x, y, z] = sample.direction;
        for i in 0..BATCH {
            let (u, v) = (pixels.along.at(i), pixels.across.at(i));
            let (n, eye) = (pixels.normal.at(i), pixels.to_eye.at(i));
            let axis = if IS_HALF { n } else { eye };
            let d = [
                x * u[0] + y * v[0] + z * axis[0],
                x * u[1] + y * v[1] + z * axis[1],
                x * u[2] + y * v[2] + z * axis[2],
            ];
            // Half vectors mirror the eye; about the eye, the normal mirrors directions.
            let (mirror, image) = if IS_HALF { (d, eye) } else { (n, d) };
            let along = scalar_product(mirror, image);
            toward_x[i] = 2.0 * along * mirror[0] - image[0];
            toward_y[i] = 2.0 * along * mirror[1] - image[1];
            toward_z[i] = 2.0 * along * mirror[2] - image[2];
            let slant = if IS_HALF { positive(along) } else { 1.0 };
            self.slant[i] = slant;
            self.cosine[i] = if IS_HALF {
                2.0 * slant * z - scalar_product(n, eye)
            } else {
                along
            };
            self.solid_angle[i] = slant * sample.solid_angle;
        }
    }

    /// Bends the directions, with cosines limited by [`MOST_BRIGHTENED`]; solid angles change as a bend gathers them.
    #[inline(always)]
    fn bend(&mut self, pixels: &LitPixels) {
        let ([x, y, z], [xx, xy, yy, determinant]) = (&mut self.toward, &self.warp);
        for i in 0..BATCH {
            // The half vector of light and z, of the length that makes it cheap.
            let half = [x[i], y[i], 1.0 + z[i]];
            let square = (2.0 * half[2]).max(SHORTEST);
            let bent_x = xx[i] * half[0] + xy[i] * half[1];
            let bent_y = xy[i] * half[0] + yy[i] * half[1];
            let (across, along) = (bent_x * bent_x + bent_y * bent_y, half[2] * half[2]);
            let unit = 1.0 / (across + along).max(SHORTEST * SHORTEST);
            let twice = 2.0 * half[2] * unit;
            (x[i], y[i], z[i]) = (twice * bent_x, twice * bent_y, (along - across) * unit);
            self.solid_angle[i] *= determinant[i] * (square * unit) * (square * unit);
            let most = MOST_BRIGHTENED * scalar_product(pixels.normal.at(i), [x[i], y[i], z[i]]);
            let cosine = self.cosine[i];
            self.cosine[i] = if cosine < most { cosine } else { most };
        }
    }

    /// The shares of their radiance that samples add, but for what they have in common.
    #[inline(always)]
    fn weigh(&mut self, at: usize, pixels: &LitPixels, lobes: &Lobes) {
        let (share, cosine, slant) = (&mut self.share[at], &self.cosine, &self.slant);
        match lobes {
            Lobes::AshikhminShirley(coat) => {
                let per_cosine = &pixels.coat.per_cosine;
                for i in 0..BATCH {
                    let seen = at_most_1(positive(cosine[i] * per_cosine[i]));
                    share[i] = coat.reflected(slant[i]) * seen;
                }
            }
            Lobes::BlinnPhong { .. } => {
                for i in 0..BATCH {
                    share[i] = slant[i] * positive(cosine[i]);
                }
            }
            _ => {
                for i in 0..BATCH {
                    share[i] = if cosine[i] > 0.0 { 1.0 } else { 0.0 };
                }
            }
        }
    }
}

/// The exponents of the lobe along and across the grain.
fn exponents(material: &MaterialParams) -> [f64; 2] {
    match material.material {
        Material::AshikhminShirley => material.coat.map(f64::from),
        _ => [f64::from(material.shininess); 2],
    }
}

/// The solid angle of a pixel for one sample of this density; of half vectors, for h.e = 1.
fn solid_angle(material: &MaterialParams, density: f64) -> f64 {
    let per_half = if material.material.glows_about_mirrored_view() {
        1.0
    } else {
        4.0
    };
    SHARPER * per_half / density
}

/// A direction of a lobe, and its density by solid angle.
struct LobeDirection {
    direction: [f32; 3],
    density: f64,
}

/// The direction of the lobe `cos^(nu cos^2 + nv sin^2)` that is `share` of its energy from the axis, at `turn` of a turn
/// (Ashikhmin and Shirley, equations 6, 9 and 10).
fn lobe([nu, nv]: [f64; 2], share: f64, turn: f64) -> LobeDirection {
    // A quarter of a turn, stretched along the smaller exponent, in each quarter of the azimuth.
    let (quarter, within) = ((4.0 * turn).floor(), (4.0 * turn).fract());
    let stretch = ((nu + 1.0) / (nv + 1.0)).sqrt();
    let flipped = quarter % 2.0 == 1.0;
    let within = if flipped { 1.0 - within } else { within };
    let angle = (stretch * (within * FRAC_PI_2).tan()).atan();
    let azimuth = quarter * FRAC_PI_2 + if flipped { FRAC_PI_2 - angle } else { angle };
    let (sin, cos) = azimuth.sin_cos();
    let exponent = nu * cos * cos + nv * sin * sin;
    let z = (1.0 - share).powf(1.0 / (exponent + 1.0));
    let across = (1.0 - z * z).max(0.0).sqrt();
    LobeDirection {
        direction: [across * cos, across * sin, z].map(|c| c as f32),
        density: ((nu + 1.0) * (nv + 1.0)).sqrt() / TAU * z.powf(exponent),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn densities_are_those_of_the_directions() {
        // Integrals over the half sphere: of z^20, 2 pi/21; of x^2 z^20 and y^2 z^20, pi (1/21 - 1/23).
        for exponents in [[15.0, 15.0], [4.0, 15.0], [15.0, 4.0]] {
            let (mut sums, count) = ([0.0; 3], 4096);
            for i in 0..count {
                let share = (f64::from(i) + 0.5) / f64::from(count);
                let found = lobe(exponents, share, (f64::from(i) * TURN).fract());
                let [x, y, z] = found.direction.map(f64::from);
                let weight = z.powi(20) / found.density / f64::from(count);
                sums = [
                    sums[0] + weight,
                    sums[1] + x * x * weight,
                    sums[2] + y * y * weight,
                ];
            }
            let side = PI * (1.0 / 21.0 - 1.0 / 23.0);
            for (sum, truth) in sums.into_iter().zip([TAU / 21.0, side, side]) {
                assert!(
                    (sum / truth - 1.0).abs() < 5e-3,
                    "{exponents:?}: {sum}, not {truth}"
                );
            }
        }
    }
}
