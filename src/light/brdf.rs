//! Reflectance: the share of the light from one direction that is reflected toward the eye.
//!
//! Lobes are in units of lights as in [`super::lights::DirectionalLight`], radiance times solid angle over pi: they are
//! the BRDF times pi times the cosine, so that a white Lambertian surface shows the cosine.

use super::cosines::{at_most_1, positive};
use crate::kernel::fast_math::{exp_to_normal, ln_of_normal};
use crate::params::MaterialParams;

/// The Ashikhmin-Shirley model ([RS] section 5.2; M. Ashikhmin, P. Shirley: An Anisotropic Phong BRDF Model, 2000): a
/// diffuse base under a glossy coat, which reduces the base by the share it reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AshikhminShirley {
    /// Exponents along and across the grain.
    pub(crate) coat: [f32; 2],
    /// Reflectance of the coat at normal incidence.
    pub(crate) reflectance: f32,
    /// Normalisation of the highlight that conserves its energy.
    pub(crate) normalisation: f32,
}

/// Cosines between unit vectors: `n` the normal, `l` to the light, `e` to the eye, `h` the half vector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cosines {
    /// n . l, at least 0.
    pub nl: f32,
    /// n . e, at least 0.
    pub ne: f32,
    /// h . e, equal to h . l.
    pub he: f32,
    /// h along the grain.
    pub hu: f32,
    /// h across the grain.
    pub hv: f32,
}

/// Below this cosine neither light nor eye is visible from the surface.
pub(crate) const GRAZING: f32 = 1e-6;

/// Normalisation of the base: light from all directions that passes the coat is reflected in full.
pub(crate) const BASE_SCALE: f32 = 28.0 / 23.0;

impl AshikhminShirley {
    /// The model with these exponents and reflectance.
    pub fn new(params: &MaterialParams) -> Self {
        let [nu, nv] = params.coat;
        Self {
            coat: params.coat,
            reflectance: params.reflectance,
            normalisation: ((nu + 1.0) * (nv + 1.0)).sqrt() / 8.0,
        }
    }

    /// The base, of albedo 1.
    ///
    /// Its albedo toward the eye over all lights is `(1 - R_s)(1 - (1 - n.e/2)^5)`.
    #[inline(always)]
    pub fn diffuse(&self, nl: f32, ne: f32) -> f32 {
        self.leaving(ne) * entering(nl)
    }

    /// The coat.
    #[inline(always)]
    pub fn specular(&self, c: Cosines) -> f32 {
        let (uu, vv) = (c.hu * c.hu, c.hv * c.hv);
        let lobe = exp_to_normal(Self::log_lobe(1.0 - (uu + vv), self.exponent(uu, vv)));
        let [per_ne, per_he] = [c.ne, c.he].map(|cosine| 1.0 / cosine.max(GRAZING));
        self.normalisation * lobe * (self.reflected(c.he) * share_seen(c.nl, per_ne, per_he))
    }

    /// Share of the light in the base that leaves at an angle of this cosine.
    #[inline(always)]
    pub(crate) fn leaving(&self, cosine: f32) -> f32 {
        BASE_SCALE * (1.0 - self.reflectance) * passed(cosine)
    }

    /// The exponent of the square of n.h, for the squares of the components of h along the grain and across it, or any
    /// multiple of both: `(nu uu + nv vv) / (2 (1 - n.h^2))`, where `1 - n.h^2 = uu + vv`.
    #[inline(always)]
    pub(crate) fn exponent(&self, uu: f32, vv: f32) -> f32 {
        let [nu, nv] = self.coat;
        if nu == nv {
            return 0.5 * nu;
        }
        0.5 * (nu * uu + nv * vv) / (uu + vv).max(f32::MIN_POSITIVE)
    }

    /// The logarithm of the lobe, its peak 1, from the square of n.h and its exponent; at least [`FAINTEST`].
    #[inline(always)]
    pub(crate) fn log_lobe(nh_squared: f32, exponent: f32) -> f32 {
        (exponent * ln_of_normal(nh_squared.max(f32::MIN_POSITIVE))).max(FAINTEST)
    }

    /// Share of the light that the coat reflects, for the cosine of incidence.
    #[inline(always)]
    pub(crate) fn reflected(&self, he: f32) -> f32 {
        self.reflectance + (1.0 - self.reflectance) * fifth_power(1.0 - he)
    }
}

/// Logarithm of the faintest lobe, e^-64 or 2e-28 of its peak: its products with other small numbers are normal, since
/// others take many times as long.
pub(crate) const FAINTEST: f32 = -64.0;

/// The coat's `n.l / (h.e max(n.l, n.e))`, from the reciprocals of n.e and h.e.
#[inline(always)]
pub(crate) fn share_seen(nl: f32, per_ne: f32, per_he: f32) -> f32 {
    (nl * per_ne).min(1.0) * per_he
}

/// The light that enters the base from a light of this cosine.
#[inline(always)]
pub(crate) fn entering(nl: f32) -> f32 {
    passed(nl) * nl
}

/// Share of the light at an angle of this cosine that passes the coat, its reflectance aside.
#[inline(always)]
pub(crate) fn passed(cosine: f32) -> f32 {
    1.0 - fifth_power(1.0 - 0.5 * cosine)
}

#[inline(always)]
pub(crate) fn fifth_power(x: f32) -> f32 {
    let square = x * x;
    square * square * x
}

/// Roughness of metals and of gloss, squared: no layer tells it.
pub(crate) const MIRROR_ALPHA: f32 = 0.12;

/// The largest value of [`mirror_lobe`]'s distribution is 1 over this.
pub(crate) const MIRROR_PEAK: f32 = MIRROR_ALPHA * MIRROR_ALPHA;

/// The distribution of microfacets about the normal, times pi, of B. Walter et al.: Microfacet Models for Refraction through
/// Rough Surfaces, 2007 (GGX), from the square of n.h.
#[inline(always)]
pub(crate) fn facets(nh_squared: f32) -> f32 {
    let width = 1.0 - nh_squared * (1.0 - MIRROR_PEAK);
    MIRROR_PEAK / (width * width)
}

/// The lobe of a reflectance of 1 with this distribution of [`facets`], which hide each other as E. Heitz has it
/// (Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, 2014, equation 99).
#[inline(always)]
pub(crate) fn mirror_lobe(facets: f32, nl: f32, ne: f32) -> f32 {
    let hidden = |cosine: f32| (MIRROR_PEAK + (1.0 - MIRROR_PEAK) * cosine * cosine).sqrt();
    let ne = ne.max(GRAZING);
    // D G / (4 n.l n.e) times pi n.l, with G / (n.l n.e) = 2 / (n.l hidden(n.e) + n.e hidden(n.l)).
    facets * 0.5 * nl / (nl * hidden(ne) + ne * hidden(nl))
}

/// Share of a mirror's light that comes of grazing, for the cosine of incidence (C. Schlick: An Inexpensive BRDF Model for
/// Physically-Based Rendering, 1994).
#[inline(always)]
pub(crate) fn grazing(cosine: f32) -> f32 {
    fifth_power(1.0 - at_most_1(positive(cosine)))
}

/// Share of unpolarised light reflected by a clear surface, for the cosine of incidence, 0..1, and the ratio of the
/// indices inside to outside; 1 for total reflection.
pub fn fresnel(cosine: f32, ior: f32) -> f32 {
    let cosine = cosine.clamp(0.0, 1.0);
    let inside = 1.0 - (1.0 - cosine * cosine) / (ior * ior);
    if inside <= 0.0 {
        return 1.0;
    }
    let inside = inside.sqrt();
    let parallel = (ior * cosine - inside) / (ior * cosine + inside);
    let across = (cosine - ior * inside) / (cosine + ior * inside);
    0.5 * (parallel * parallel + across * across)
}

/// The direction `to_eye` mirrored at the unit normal `n`.
#[inline(always)]
pub fn mirrored(n: [f32; 3], to_eye: [f32; 3]) -> [f32; 3] {
    let twice = 2.0 * (n[0] * to_eye[0] + n[1] * to_eye[1] + n[2] * to_eye[2]);
    std::array::from_fn(|i| twice * n[i] - to_eye[i])
}

/// The direction of a sight line refracted into a surface of relative index `ior`; `None` for total reflection.
pub fn refracted(n: [f32; 3], to_eye: [f32; 3], ior: f32) -> Option<[f32; 3]> {
    let cosine = n[0] * to_eye[0] + n[1] * to_eye[1] + n[2] * to_eye[2];
    let inside = 1.0 - (1.0 - cosine * cosine) / (ior * ior);
    (inside >= 0.0).then(|| {
        // Snell: the component along the surface shrinks by the index.
        let along = cosine / ior - inside.sqrt();
        std::array::from_fn(|i| along * n[i] - to_eye[i] / ior)
    })
}

/// The share of light that glass seen from `to_eye` mirrors, and the direction in which the rest is seen through it.
#[inline(always)]
pub(crate) fn seen_in_glass(
    n: [f32; 3],
    to_eye: [f32; 3],
    material: &MaterialParams,
) -> (f32, [f32; 3]) {
    let cosine = n[0] * to_eye[0] + n[1] * to_eye[1] + n[2] * to_eye[2];
    let one_surface = fresnel(cosine, material.ior);
    let straight_on = to_eye.map(|component| -component);
    match material.thin {
        true => (thin_sheet(one_surface), straight_on),
        false => match refracted(n, to_eye, material.ior) {
            Some(through) => (one_surface, through),
            None => (1.0, straight_on),
        },
    }
}

/// Reflectance of a glass sheet between two parallel surfaces that each reflect the share `r`, summed over all internal
/// reflections.
pub(crate) fn thin_sheet(r: f32) -> f32 {
    2.0 * r / (1.0 + r)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::RelightParams;
    use std::f32::consts::PI;

    fn model(coat: [f32; 2], reflectance: f32) -> AshikhminShirley {
        AshikhminShirley::new(&MaterialParams {
            coat,
            reflectance,
            ..RelightParams::default().material
        })
    }

    fn unit(v: [f32; 3]) -> [f32; 3] {
        let length = v.iter().map(|c| c * c).sum::<f32>().sqrt();
        v.map(|c| c / length)
    }

    fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    /// Cosines for the normal z and the grain x.
    fn cosines(l: [f32; 3], e: [f32; 3]) -> Cosines {
        let h = unit(std::array::from_fn(|i| l[i] + e[i]));
        Cosines {
            nl: l[2],
            ne: e[2],
            he: dot(h, e),
            hu: h[0],
            hv: h[1],
        }
    }

    #[test]
    fn the_base_has_the_albedo_of_the_closed_form() {
        // 2 pi times the integral over mu of diffuse / (pi mu) mu, here in steps of 1e-4; the integral of
        // (1 - (1 - mu/2)^5) mu is 23/56, which 28/23 makes one half.
        for (ne, reflectance) in [(1.0_f32, 0.0_f32), (0.7, 0.05), (0.3, 0.4), (0.05, 0.9)] {
            let brdf = model([10.0, 1000.0], reflectance);
            let steps = 10_000;
            let sum: f64 = (0..steps)
                .map(|i| f64::from(brdf.diffuse((i as f32 + 0.5) / steps as f32, ne)))
                .sum();
            let albedo = 2.0 * sum / f64::from(steps);
            let expected = (1.0 - reflectance) * (1.0 - (1.0 - ne / 2.0).powi(5));
            assert!(
                (albedo - f64::from(expected)).abs() < 1e-5,
                "{albedo}, not {expected}"
            );
        }
    }

    #[test]
    fn light_and_eye_can_change_places() {
        let directions = [[0.3, 0.4, 0.9], [-0.8, 0.1, 0.2], [0.0, 0.6, 0.5]].map(unit);
        for coat in [[0.0, 0.0], [10.0, 200.0], [1000.0, 3.0]] {
            let brdf = model(coat, 0.1);
            for l in directions {
                for e in directions {
                    // A lobe is the BRDF times pi times n.l.
                    let there = brdf.specular(cosines(l, e)) / l[2];
                    let back = brdf.specular(cosines(e, l)) / e[2];
                    assert!(
                        (there - back).abs() <= 1e-5 * there.max(1e-3),
                        "{there} {back}"
                    );
                    let there = brdf.diffuse(l[2], e[2]) / l[2];
                    let back = brdf.diffuse(e[2], l[2]) / e[2];
                    assert!((there - back).abs() <= 1e-5 * there);
                }
            }
        }
    }

    #[test]
    fn base_and_coat_together_return_no_more_than_came() {
        for coat in [[1.0, 1.0], [30.0, 30.0], [20.0, 300.0]] {
            let brdf = model(coat, 0.2);
            for e in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.9, 0.435_889_9]] {
                let (rings, spokes) = (400, 800);
                let mut sum = 0.0;
                for ring in 0..rings {
                    for spoke in 0..spokes {
                        let z = (ring as f32 + 0.5) / rings as f32;
                        let azimuth = 2.0 * PI * (spoke as f32 + 0.5) / spokes as f32;
                        let side = (1.0 - z * z).sqrt();
                        let l = [side * azimuth.cos(), side * azimuth.sin(), z];
                        let c = cosines(l, e);
                        sum += f64::from(brdf.specular(c) + brdf.diffuse(c.nl, c.ne));
                    }
                }
                // Equal solid angles of 2 pi / count; a lobe includes a factor pi.
                let albedo = 2.0 * sum / f64::from(rings * spokes);
                assert!(albedo < 1.0 && albedo > 0.2, "{coat:?}: {albedo}");
            }
        }
    }

    #[test]
    fn the_highlight_of_a_round_coat_is_phong_about_the_half_vector() {
        // (n + 1)/8 pi times (n.h)^n / (h.e) F / max(n.l, n.e), at l = e = n: (n + 1)/(8 pi) R_s.
        let c = cosines([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
        let brdf = model([50.0, 50.0], 0.3);
        let expected = 51.0 / 8.0 * 0.3;
        assert!((brdf.specular(c) - expected).abs() < 1e-5 * expected);
        let off = unit([0.2, -0.3, 0.9]);
        let (c, nh) = (cosines(off, [0.0, 0.0, 1.0]), ((1.0 + off[2]) / 2.0).sqrt());
        let fresnel = 0.3 + 0.7 * (1.0 - nh).powi(5);
        let expected = 51.0 / 8.0 * nh.powi(50) / nh * fresnel * off[2];
        assert!((brdf.specular(c) - expected).abs() < 2e-5 * expected);
    }

    #[test]
    fn mirrors_follow_the_closed_form_and_return_no_more_than_came() {
        // At l = e = n: D pi = 1/a, G / (4 n.l n.e) = 1/4, so 1/(4 a); at 60 degrees each, h = n, the hiding is
        // sqrt(a + (1 - a)/4) = 0.510686: 69.4444 0.5 0.5 / 0.510686 = 33.996.
        let lobe = |nl, ne| mirror_lobe(facets(1.0), nl, ne);
        assert!((lobe(1.0, 1.0) - 0.25 / 0.0144).abs() < 1e-4);
        assert!((lobe(0.5, 0.5) - 33.996).abs() < 1e-2);
        assert!((grazing(0.5) - 1.0 / 32.0).abs() < 1e-7);
        for e in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.9, 0.435_889_9]] {
            let (rings, spokes) = (1000, 1000);
            let mut sum = 0.0;
            for i in 0..rings * spokes {
                let z = ((i / spokes) as f32 + 0.5) / rings as f32;
                let azimuth = 2.0 * PI * ((i % spokes) as f32 + 0.5) / spokes as f32;
                let side = (1.0 - z * z).sqrt();
                let c = cosines([side * azimuth.cos(), side * azimuth.sin(), z], e);
                let squared = 1.0 - c.hu * c.hu - c.hv * c.hv;
                sum += f64::from(mirror_lobe(facets(squared), c.nl, c.ne));
            }
            // Equal solid angles; a lobe includes a factor pi.
            let albedo = 2.0 * sum / f64::from(rings * spokes);
            assert!(albedo < 1.001 && albedo > 0.9, "{albedo}");
        }
    }

    #[test]
    fn extreme_coats_and_cosines_stay_finite() {
        for coat in [[0.0, 0.0], [1e5, 1e5], [0.0, 1e5], [f32::MAX, 0.0]] {
            for reflectance in [0.0, 1.0] {
                let brdf = model(coat, reflectance);
                for value in [0.0, 1e-20, 1e-3, 1.0] {
                    for side in [0.0, 1e-30, 0.7, 1.0] {
                        let c = Cosines {
                            nl: value,
                            ne: 1.0 - value,
                            he: value,
                            hu: side,
                            hv: side,
                        };
                        assert!(brdf.specular(c) >= 0.0, "{coat:?} {c:?}");
                        assert!(brdf.diffuse(value, side) >= 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn glass_mirrors_as_fresnel_says() {
        // At normal incidence ((n - 1)/(n + 1))^2 = 0.04; no parallel component at Brewster's angle; total at grazing.
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((fresnel(0.0, 1.5) - 1.0).abs() < 1e-6);
        let brewster = 1.0 / (1.0 + 1.5_f32 * 1.5).sqrt();
        let across = ((1.5_f32 * 1.5 - 1.0) / (1.5 * 1.5 + 1.0)).powi(2);
        assert!((fresnel(brewster, 1.5) - 0.5 * across).abs() < 1e-6);
        // From the denser side beyond the critical angle.
        assert_eq!(fresnel(0.5, 1.0 / 1.5), 1.0);
        assert!((thin_sheet(0.04) - 0.08 / 1.04).abs() < 1e-7);
    }

    #[test]
    fn sight_lines_bend_as_snell_says() {
        let n = unit([0.3, -0.2, 0.8]);
        let e = [0.0, 0.0, 1.0];
        let sine = |d: [f32; 3]| (1.0 - dot(d, n).powi(2)).sqrt();
        let inside = refracted(n, e, 1.5).unwrap();
        assert!((dot(inside, inside) - 1.0).abs() < 1e-6);
        assert!((sine(inside) - sine(e) / 1.5).abs() < 1e-6);
        assert!(dot(inside, n) < 0.0);
        // An index of 1 does not deflect.
        let straight = refracted(n, e, 1.0).unwrap();
        assert!(dot(straight, [0.0, 0.0, -1.0]) > 1.0 - 1e-6);
        assert_eq!(refracted(unit([1.0, 0.0, 0.3]), e, 1.0 / 1.5), None);
        let r = mirrored(n, e);
        assert!((dot(r, n) - dot(e, n)).abs() < 1e-6 && (dot(r, r) - 1.0).abs() < 1e-6);
    }
}
