//! How far backends may be apart, for the tests and the report: the reasons for the numbers in the table of products.

use crate::frame::Plane;
use crate::light::lights::Illumination;
use crate::light::sum::lobe_error;
use crate::plan::{EnvironmentUse, Plan};
use crate::product::{Compared, Product};
use glam::DVec2;
use std::f64::consts::PI;

impl Product {
    /// The difference of its planes from the CPU's: the largest one relative to the largest value, or the mean one of ink and
    /// directions; infinite where the numbers of planes differ.
    pub fn difference(self, found: &[&Plane], expected: &[&Plane]) -> f64 {
        if found.len() != expected.len() {
            return f64::INFINITY;
        }
        let mut pairs = found.iter().zip(expected);
        match self.row().compared {
            Compared::Largest => pairs.map(|(f, e)| difference(f, e)).fold(0.0, f64::max),
            Compared::Ink => pairs.map(|(f, e)| ink_difference(f, e)).fold(0.0, f64::max),
            Compared::Directions => match (pairs.next(), pairs.next()) {
                (Some(x), Some(y)) => direction_difference([x.0, y.0], [x.1, y.1]),
                _ => f64::INFINITY,
            },
        }
    }

    /// The most that a layer may be [apart](Self::difference) from the CPU's.
    ///
    /// Kernels use the polynomials of the CPU, and devices round sums of products once or twice: 1e-5. A
    /// Chebyshev expansion adds up as many roundings as it has terms, and derivatives divide what is left of a
    /// difference.
    ///
    /// Places in the texture of strokes are exact to 2^-12 texels four thousand pixels from the origin, and
    /// once or twice rounded; ink changes by a quarter per texel on average: 6e-5. A density whose rounding reaches
    /// the next entry of the response, 1.5e-3 away, is one in a thousand: 1.5e-6. Contours are as much again as their
    /// edges are apart, over the few pixels that are theirs.
    ///
    /// Differences of normals and of points are within three roundings of themselves, 2e-7. Of the direction of a
    /// curvature that is as much over twice the share by which both curvatures differ, which is a hundredth at the
    /// least: 1e-5. A comparison that decides whether there is a direction goes the other way where its sides are as near
    /// as 2e-7; there are three of them, and as many as 16 pixels take the direction of one: 1e-5 again.
    pub fn tolerance(self) -> f64 {
        self.row().tolerance
    }
}

/// Error of a scalar product of unit vectors: two roundings of each half of it, on either side.
const COSINE_ERROR: f64 = 1.0 / (1 << 22) as f64;

/// Error of an angle, in radians: that of the arc tangent, and of the direction it is the angle of.
const ANGLE_ERROR: f64 = 4e-7 + COSINE_ERROR;

impl Plan {
    /// The largest difference between backends of a picture in new light, relative to its largest value; `None` where
    /// the plan relights nothing.
    ///
    /// It is that of [`Product::Picture`], except for light that amplifies a rounding. A lobe with the exponent p is, at
    /// its brightest, p times as far off as the cosine that it is a power of; one with an exponent below 1 is, beside the
    /// terminator, as far off as that power of the rounding itself. A picture that is looked up is read a fraction of a
    /// pixel beside, which counts where neighbours differ. The step between two tones is 1.5 over its softness times as
    /// steep as what it quantises; hard ones may move a pixel to the next tone.
    pub fn relit_tolerance(&self, light: &Illumination) -> Option<f64> {
        let relighting = self.relighting.as_ref()?;
        let params = &relighting.params;
        let lobe = lobe_error(&params.material, COSINE_ERROR);
        let seen = match &light.environment {
            Some(map) if relighting.environment == EnvironmentUse::Mirrored => {
                let [width, height] = [map.width(), map.height()].map(|n| n as f64);
                (width / 2.0 + height) * ANGLE_ERROR / PI
            }
            _ => 0.0,
        };
        let spheres = light.lit_spheres.iter();
        let painted =
            spheres.map(|sphere| sphere.size().iter().sum::<usize>() as f64 * COSINE_ERROR);
        let smooth = [lobe, seen, painted.fold(0.0, f64::max)]
            .into_iter()
            .fold(Product::Picture.tolerance(), f64::max);
        Some(match params.tones() {
            Some(tones) if tones.softness > 0.0 => {
                smooth * (1.5 / f64::from(tones.softness)).max(1.0)
            }
            Some(_) => 1.0,
            None => smooth,
        })
    }
}

/// The largest difference between two planes, relative to the largest value of the second one, or to 1 where it has
/// none. NaN agrees with NaN, and infinite values with themselves, alone.
pub(crate) fn difference(found: &Plane, expected: &Plane) -> f64 {
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

/// The mean difference between two planes of ink, 0..1, where a pixel that is further apart than a sixteenth counts as
/// all wrong.
///
/// A texture of strokes is compared with thresholds, and a rounding that reaches the next one changes the ink of a pixel
/// by a leap: the largest difference says little. A stroke in a wrong place is wrong by more than a sixteenth.
pub(crate) fn ink_difference(found: &Plane, expected: &Plane) -> f64 {
    let pairs = found.samples().iter().zip(expected.samples());
    let apart = pairs.map(|(&found, &expected)| {
        let apart = f64::from((found - expected).abs());
        // NaN fails the comparison.
        if apart <= LEAP { apart } else { 1.0 }
    });
    apart.sum::<f64>() / found.samples().len().max(1) as f64
}

/// Ink by which no rounding changes a pixel: see [`ink_difference`].
const LEAP: f64 = 1.0 / 16.0;

/// The mean difference between directions, over the pixels where either is one: the sine of the angle between both, which
/// is the same for opposites, or by how much one is longer.
///
/// Whether a pixel has a direction at all depends on comparisons with its uncertainty. A rounding that decides one
/// makes of a pixel one that takes its neighbours' direction: the largest difference says little.
pub(crate) fn direction_difference(found: [&Plane; 2], expected: [&Plane; 2]) -> f64 {
    fn vectors<'a>([x, y]: [&'a Plane; 2]) -> impl Iterator<Item = DVec2> + 'a {
        let pairs = x.samples().iter().zip(y.samples());
        pairs.map(|(&x, &y)| DVec2::new(x.into(), y.into()))
    }
    let (mut sum, mut count) = (0.0, 0_u32);
    for (found, expected) in vectors(found).zip(vectors(expected)) {
        if found == DVec2::ZERO && expected == DVec2::ZERO {
            continue;
        }
        let sine = found.perp_dot(expected).abs();
        let apart = sine.max((found.length() - expected.length()).abs());
        // NaN fails the comparison.
        sum += if apart <= 1.0 { apart } else { 1.0 };
        count += 1;
    }
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions(vectors: &[[f32; 2]]) -> [Plane; 2] {
        [0, 1].map(|axis: usize| Plane::from_fn(vectors.len(), 1, |x, _| vectors[x][axis]))
    }

    #[test]
    fn directions_are_compared_up_to_their_sign_and_what_is_none_is_wrong() {
        let expected = directions(&[[0.6, 0.8], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 1.0]]);
        let apart = |second: [f32; 2], last: [f32; 2]| {
            let found = [[-0.6, -0.8], second, [0.0, 0.0], [0.0, 1.0], last];
            Product::Direction.difference(&directions(&found).each_ref(), &expected.each_ref())
        };
        assert!(apart([1.0, 0.0], [0.0, -1.0]) < 1e-7);
        // One of the four that are directions: by the sine of an angle, at right angles, none, no number, too long.
        assert!((apart([0.8, 0.6], [0.0, 1.0]) - 0.15).abs() < 1e-7);
        for wrong in [[1.0, 0.0], [0.0, 0.0], [f32::NAN, 1.0], [0.0, 9.0]] {
            assert!((apart([1.0, 0.0], wrong) - 0.25).abs() < 1e-7, "{wrong:?}");
        }
        // A direction where there is none.
        assert!(
            direction_difference(expected.each_ref(), directions(&[[0.0; 2]; 5]).each_ref()) > 0.99
        );
    }
}
