//! Tolerances between backends: the reasons for the numbers in the table of products.

use crate::frame::Plane;
use crate::product::{Compared, Product};
use glam::DVec2;

impl Product {
    /// The difference of its planes from the CPU's: the largest one relative to the largest value, or the mean for ink
    /// and directions; infinite if the numbers of planes differ.
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

    /// The largest [difference](Self::difference) allowed between a layer and the CPU's.
    ///
    /// Kernels use the polynomials of the CPU, and devices round sums of products once or twice: 1e-5. A Chebyshev
    /// expansion accumulates as many roundings as it has terms, and derivatives amplify the remainder of a difference.
    ///
    /// Positions in the stroke texture are exact to 2^-12 texels at four thousand pixels from the origin, with one or
    /// two roundings; ink changes by a quarter per texel on average: 6e-5. One density in a thousand lies so close to
    /// the next entry of the response, 1.5e-3 away, that rounding reaches it: 1.5e-6. Contours differ by as much again
    /// as their edges, over the few pixels they cover.
    ///
    /// Differences of normals and of points are within three roundings of themselves, 2e-7. For the direction of a
    /// curvature that error is divided by twice the relative difference of both curvatures, at least a hundredth: 1e-5.
    /// A comparison that decides whether a direction exists can flip if its sides are within 2e-7; there are three of
    /// them, and up to 16 pixels take the direction of one: 1e-5 again.
    pub fn tolerance(self) -> f64 {
        self.row().tolerance
    }
}

/// The largest difference between two planes, relative to the largest value of the second one, or to 1 if that is 0.
/// NaN equals only NaN, and infinities only themselves.
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

/// The mean difference between two planes of ink, 0..1, where a pixel that differs by more than a sixteenth counts as
/// completely wrong.
///
/// A stroke texture is compared with thresholds, and rounding past one of them makes the ink of a pixel jump, so the
/// largest difference says little. A misplaced stroke is wrong by more than a sixteenth.
pub(crate) fn ink_difference(found: &Plane, expected: &Plane) -> f64 {
    let pairs = found.samples().iter().zip(expected.samples());
    let apart = pairs.map(|(&found, &expected)| {
        let apart = f64::from((found - expected).abs());
        // NaN fails the comparison.
        if apart <= LEAP { apart } else { 1.0 }
    });
    apart.sum::<f64>() / found.samples().len().max(1) as f64
}

/// A change of ink larger than rounding alone causes: see [`ink_difference`].
const LEAP: f64 = 1.0 / 16.0;

/// The mean difference between directions, over the pixels where either exists: the sine of the angle between them,
/// which is the same for opposites, or the difference of their lengths.
///
/// Whether a pixel has a direction at all depends on comparisons with its uncertainty. Rounding can flip one, and the
/// pixel then takes its neighbours' direction: the largest difference says little.
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
        // One of four directions is wrong: by the sine of an angle, at right angles, missing, NaN, too long.
        assert!((apart([0.8, 0.6], [0.0, 1.0]) - 0.15).abs() < 1e-7);
        for wrong in [[1.0, 0.0], [0.0, 0.0], [f32::NAN, 1.0], [0.0, 9.0]] {
            assert!((apart([1.0, 0.0], wrong) - 0.25).abs() < 1e-7, "{wrong:?}");
        }
        // A direction where none is expected.
        assert!(
            direction_difference(expected.each_ref(), directions(&[[0.0; 2]; 5]).each_ref()) > 0.99
        );
    }
}
