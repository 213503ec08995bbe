//! How far backends may be apart: one table, for the tests and the report.

use super::cpu::Outcome;
use crate::frame::Plane;
use crate::light::lights::Illumination;
use crate::params::{Material, MaterialParams};
use crate::plan::{EnvironmentUse, Relighting};
use serde::Serialize;
use std::f64::consts::PI;

/// What a run gives, as far as backends are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Product {
    /// Silhouette, crease and conductance.
    Weights,
    /// The gradient after diffusion.
    Gradient,
    /// The Hessian.
    Hessian,
    /// Principal and mean curvature.
    Curvature,
    /// Mapped curvature.
    MappedCurvature,
    /// The picture, enhanced or in new light, and the curvature display.
    Picture,
}

impl Product {
    /// All there are.
    pub const ALL: [Self; 6] = [
        Self::Weights,
        Self::Gradient,
        Self::Hessian,
        Self::Curvature,
        Self::MappedCurvature,
        Self::Picture,
    ];

    /// The largest difference from the CPU, relative to the largest value of the plane.
    ///
    /// Kernels use the polynomials of the CPU, and devices round sums of products once or twice: 1e-5. A
    /// Chebyshev expansion adds up as many roundings as it has terms, and derivatives divide what is left of a
    /// difference.
    pub const fn tolerance(self) -> f64 {
        match self {
            Self::Weights | Self::Gradient | Self::Picture => 1e-5,
            Self::Hessian | Self::Curvature | Self::MappedCurvature => 2e-5,
        }
    }
}

/// Error of a scalar product of unit vectors: two roundings of each half of it, on either side.
const COSINE_ERROR: f64 = 1.0 / (1 << 22) as f64;

/// Error of an angle, in radians: that of the arc tangent, and of the direction it is the angle of.
const ANGLE_ERROR: f64 = 4e-7 + COSINE_ERROR;

/// The largest difference from the CPU of a picture in new light, relative to its largest value: that of
/// [`Product::Picture`], but for light that turns a rounding into more.
///
/// A lobe with the exponent p is, at its brightest, p times as far off as the cosine that it is a power of; one with an
/// exponent below 1 is, beside the terminator, as far off as that power of the rounding itself. A picture that is looked
/// up is read a share of a pixel beside, which counts where neighbours are unlike. The step between two tones is 1.5
/// over its softness times as steep as what it quantises; hard ones may put a pixel to the next tone.
pub fn relit_tolerance(relighting: &Relighting, light: &Illumination) -> f64 {
    let params = &relighting.params;
    let lobe = lobe_error(&params.material);
    let seen = match &light.environment {
        Some(map) if relighting.environment == EnvironmentUse::Mirrored => {
            let [width, height] = [map.width(), map.height()].map(|n| n as f64);
            (width / 2.0 + height) * ANGLE_ERROR / PI
        }
        _ => 0.0,
    };
    let spheres = light.lit_spheres.iter();
    let painted = spheres.map(|sphere| sphere.size().iter().sum::<usize>() as f64 * COSINE_ERROR);
    let smooth = [lobe, seen, painted.fold(0.0, f64::max)]
        .into_iter()
        .fold(Product::Picture.tolerance(), f64::max);
    match params.tones() {
        Some(tones) if tones.softness > 0.0 => smooth * (1.5 / f64::from(tones.softness)).max(1.0),
        Some(_) => 1.0,
        None => smooth,
    }
}

/// How far a lobe of this material, 1 at its brightest, may be off.
fn lobe_error(material: &MaterialParams) -> f64 {
    let largest = |exponent: f32| f64::from(exponent) * COSINE_ERROR;
    match material.material {
        Material::Phong | Material::BlinnPhong => largest(material.shininess),
        Material::AshikhminShirley => largest(material.coat[0].max(material.coat[1])),
        Material::Sublambert => COSINE_ERROR.powf(material.flatness.into()),
        Material::Lambert | Material::Toon | Material::Mirror | Material::Glass => 0.0,
    }
}

/// The planes of an outcome, each as one of the products.
pub fn products(outcome: &Outcome) -> impl Iterator<Item = (Product, &Plane)> {
    let shape = &outcome.shape;
    let weights = [&shape.silhouette, &shape.crease, &shape.conductance];
    let weights = weights.into_iter().flatten();
    let gradient = shape.gradient.iter().flat_map(|g| [&g.x, &g.y]);
    let hessian = shape.hessian.iter().flat_map(|h| [&h.xx, &h.xy, &h.yy]);
    let scales = shape.more_scales.iter();
    let curvatures = shape.curvatures.iter();
    let curvatures = curvatures.chain(scales.clone().map(|scale| &scale.curvatures));
    let curvatures = curvatures.flat_map(|c| [&c.u, &c.v, &c.mean]);
    let kappa = shape.kappa.iter().chain(scales.map(|scale| &scale.kappa));
    let picture = outcome.color.iter().flat_map(|c| [&c.r, &c.g, &c.b]);
    fn of<'a>(
        product: Product,
        planes: impl Iterator<Item = &'a Plane>,
    ) -> impl Iterator<Item = (Product, &'a Plane)> {
        planes.map(move |plane| (product, plane))
    }
    of(Product::Weights, weights)
        .chain(of(Product::Gradient, gradient))
        .chain(of(Product::Hessian, hessian))
        .chain(of(Product::Curvature, curvatures))
        .chain(of(Product::MappedCurvature, kappa))
        .chain(of(Product::Picture, picture))
}

/// The largest difference between two planes, relative to the largest value of the second one, or to 1 where it has
/// none. NaN agrees with NaN, and infinite values with themselves, alone.
pub fn difference(found: &Plane, expected: &Plane) -> f64 {
    let sizes = expected.samples().iter().map(|value| value.abs());
    let largest = sizes.filter(|size| size.is_finite()).fold(0.0, f32::max);
    let unit = if largest > 0.0 {
        f64::from(largest)
    } else {
        1.0
    };
    let pairs = found.samples().iter().zip(expected.samples());
    let apart = pairs.map(|(&found, &expected)| {
        if found == expected || found.is_nan() && expected.is_nan() {
            return 0.0;
        }
        let apart = (f64::from(found) - f64::from(expected)).abs() / unit;
        if apart.is_nan() { f64::INFINITY } else { apart }
    });
    apart.fold(0.0, f64::max)
}
