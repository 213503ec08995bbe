//! Materials, and the reflection of light.

use glam::Vec3;
use relievo::light::brdf::{AshikhminShirley, Cosines};
use relievo::params::{MaterialParams, RelightParams};
use std::f32::consts::{FRAC_1_PI, PI, TAU};

/// Material of a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Material {
    /// Diffuse with one albedo; black for purely emissive surfaces.
    Matte(Vec3),
    /// Diffuse under a glossy coat.
    Glossy(Glossy),
    /// A perfect mirror of this tint.
    Mirror(Vec3),
}

/// An Ashikhmin-Shirley surface without grain ([RS] section 5.2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glossy {
    albedo: Vec3,
    exponent: f32,
    model: AshikhminShirley,
}

/// Diffuse and specular: lobes are kept apart all the way, as they are scaled and written apart.
pub(crate) type PerLobe<T> = [T; 2];

/// Directions at a point: all of unit length and away from it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Directions {
    pub(crate) normal: Vec3,
    pub(crate) to_eye: Vec3,
    pub(crate) to_light: Vec3,
}

impl Glossy {
    pub(crate) fn new(albedo: Vec3, exponent: f32, reflectance: f32) -> Self {
        Self {
            albedo,
            exponent,
            model: AshikhminShirley::new(&MaterialParams {
                coat: [exponent; 2],
                reflectance,
                ..RelightParams::default().material
            }),
        }
    }

    /// Solid-angle density of sampling directions to light by the coat: half vectors by `(n.h)^exponent`, each standing
    /// for `4 h.e` times its solid angle of directions.
    fn coat_density(&self, d: &Directions) -> f32 {
        let half = (d.to_eye + d.to_light).normalize_or(d.normal);
        let cosine = half.dot(d.normal).max(0.0);
        let halves = (self.exponent + 1.0) / TAU * cosine.powf(self.exponent);
        halves / (4.0 * half.dot(d.to_eye).max(1e-6))
    }
}

impl Material {
    /// Whether light leaves in one direction alone.
    pub(crate) fn is_clear(&self) -> bool {
        matches!(self, Self::Mirror(_))
    }

    /// Light from a direction above the surface reflected to the eye: BRDF times the cosine, per lobe.
    #[inline]
    pub(crate) fn reflected(&self, d: &Directions) -> PerLobe<Vec3> {
        let (nl, ne) = (d.normal.dot(d.to_light), d.normal.dot(d.to_eye));
        if nl <= 0.0 || ne <= 0.0 {
            return [Vec3::ZERO; 2];
        }
        match self {
            Self::Matte(albedo) => [*albedo * (nl * FRAC_1_PI), Vec3::ZERO],
            Self::Glossy(Glossy { albedo, model, .. }) => {
                let half = (d.to_eye + d.to_light).normalize_or(d.normal);
                let cosines = Cosines {
                    nl,
                    ne,
                    he: half.dot(d.to_eye).clamp(0.0, 1.0),
                    // Without grain any tangent will do: all of the half vector's lean along one.
                    hu: d.normal.cross(half).length(),
                    hv: 0.0,
                };
                // The library's lobes are BRDF times pi times the cosine.
                [
                    *albedo * (model.diffuse(nl, ne) * FRAC_1_PI),
                    Vec3::splat(model.specular(cosines) * FRAC_1_PI),
                ]
            }
            Self::Mirror(_) => [Vec3::ZERO; 2],
        }
    }

    /// Intensities of the lobes in [RS] section 5.2: n . l, and n . h.
    #[inline]
    pub(crate) fn intensities(d: &Directions) -> PerLobe<f32> {
        let half = (d.to_eye + d.to_light).normalize_or(d.normal);
        [d.normal.dot(d.to_light), d.normal.dot(half)]
    }

    /// A direction to light, by importance; it may be below the surface. On a glossy surface half of them are for its
    /// coat.
    #[inline]
    pub(crate) fn sampled(&self, normal: Vec3, to_eye: Vec3, lobe: f32, at: [f32; 2]) -> Vec3 {
        match self {
            Self::Glossy(coat) if lobe < 0.5 => {
                let height = (1.0 - at[0]).powf(1.0 / (coat.exponent + 1.0));
                let half = around(normal, height, TAU * at[1]);
                // Off the eye's side, h would face away from it and the light would be below it.
                2.0 * half.dot(to_eye) * half - to_eye
            }
            _ => around(normal, (1.0 - at[0]).sqrt(), TAU * at[1]),
        }
    }

    /// Solid-angle density of [`Material::sampled`].
    #[inline]
    pub(crate) fn density(&self, d: &Directions) -> f32 {
        let even = d.normal.dot(d.to_light).max(0.0) / PI;
        match self {
            Self::Glossy(coat) => 0.5 * (even + coat.coat_density(d)),
            _ => even,
        }
    }

    /// Probability that a long path continues: at most about the reflectance, and the same with or without scaled
    /// light.
    pub(crate) fn survival(&self) -> f32 {
        let share = match self {
            Self::Matte(albedo) => albedo.max_element(),
            Self::Glossy(coat) => coat.albedo.max_element().max(0.5),
            Self::Mirror(tint) => tint.max_element(),
        };
        share.clamp(0.05, 0.95)
    }
}

/// The direction `height` along `axis`, and the rest of its length aside.
fn around(axis: Vec3, height: f32, azimuth: f32) -> Vec3 {
    let (a, b) = axis.any_orthonormal_pair();
    let aside = (1.0 - height * height).max(0.0).sqrt();
    let (sin, cos) = azimuth.sin_cos();
    height * axis + aside * (cos * a + sin * b)
}
