//! What automatic choices count: curvature by its weight, and luminance.

use crate::frame::percentile::percentile;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, luminance};
pub(crate) use crate::shape::auto_levels::WHITE_PERCENT;

/// Curvature, and how much each pixel counts for the gain.
pub(crate) struct Counted<'a> {
    pub(crate) trace: &'a Plane,
    pub(crate) conductance: &'a Plane,
    /// Confidence and strength, where they are known.
    pub(crate) weights: [Option<&'a Plane>; 2],
}

impl<'a> Counted<'a> {
    pub(crate) fn of(frame: &'a Frame, [trace, conductance]: [&'a Plane; 2]) -> Self {
        Self {
            trace,
            conductance,
            weights: [frame.confidence.as_ref(), frame.strength.as_ref()],
        }
    }

    /// The magnitude of the trace at a pixel and its weight, off edges and where the surface is not flat.
    pub(super) fn at(&self, flat: f32, [x, y]: [usize; 2]) -> Option<[f32; 2]> {
        let size = self.trace.at(x, y).abs();
        let weights = self.weights.iter().flatten();
        let weight: f32 = weights.map(|plane| plane.at(x, y)).product();
        let counts = size > flat && self.conductance.at(x, y) > 0.5 && weight > 0.0;
        counts.then_some([size, weight])
    }
}

/// A high percentile of the luminance of the covered pixels; 1 if all are black.
pub(crate) fn white_level(color: &ColorPlanes, weights: [f32; 3], mask: &Mask) -> f32 {
    white_of(percentile(mask, WHITE_PERCENT, |x, y| {
        Some(luminance_at(color, weights, x, y))
    }))
}

/// The luminance of a pixel.
#[inline]
pub(crate) fn luminance_at(color: &ColorPlanes, weights: [f32; 3], x: usize, y: usize) -> f32 {
    luminance(
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y)),
        weights,
    )
}

/// The white level from a percentile of luminance.
pub(crate) fn white_of(percentile: Option<f32>) -> f32 {
    percentile.filter(|&white| white > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::percentile::InLooks;
    use crate::frame::{Extent, Vector3Planes};
    use crate::plan::search::ChosenFrom;
    use crate::shape::auto_levels::gain_search::GainSearch;
    use crate::shape::auto_levels::most_gain;

    /// The gain of a whole picture without edges.
    fn gain(trace: &Plane, factor: f32, most: f32) -> f32 {
        weighted(trace, None, factor, most)
    }

    fn weighted(trace: &Plane, weight: Option<&Plane>, factor: f32, most: f32) -> f32 {
        let (width, height) = (trace.width(), trace.height());
        let normal = Vector3Planes::from_fn(width, height, |_, _| glam::DVec3::Z);
        let frame = Frame::of_normals(normal, Mask::full(width, height));
        let counted = Counted {
            trace,
            conductance: &Plane::filled(width, height, 1.0),
            weights: [weight, None],
        };
        let mut search = GainSearch::new(factor, most);
        search.sample.begin(&Extent::of(&frame.mask));
        while search.sample.is_open() {
            search.add(&ChosenFrom::whole(&frame), &counted);
            search.sample.end_look();
        }
        search.gain()
    }

    /// A hero 40 pixels square whose curvature is .04 and .08 in turn, upper left in a picture with a flat wall.
    fn hero(width: usize, height: usize, wall: f32) -> Plane {
        Plane::from_fn(width, height, |x, y| match (x < 40 && y < 40, x % 2) {
            (true, 0) => 0.04,
            (true, _) => -0.08,
            _ => wall,
        })
    }

    #[test]
    fn a_wall_adds_area_and_hardly_weight() {
        // (.04^2 + .08^2) / (.04 + .08) = .0667; atanh(.38) / .0667 = 6.001.
        let alone = gain(&hero(40, 40, 0.0), 1.0, 200.0);
        assert!((alone - 6.001).abs() < 1e-3, "{alone}");
        // Three times the area at a tenth of the mean curvature, .006: (.004 + 3 * .006^2) / (.06 + 3 * .006) = .0527, and
        // x 1.266. A percentile of the whole would be that of the wall.
        let with_wall = gain(&hero(80, 80, 0.006), 1.0, 200.0);
        assert!((with_wall / alone - 1.266).abs() < 1e-3, "{with_wall}");
        // Flatter still, it does not count: a diagonal of 113 pixels that turns by less than .25.
        assert_eq!(gain(&hero(80, 80, 0.002), 1.0, 200.0), alone);
        // Twice as large and half as curved per pixel: twice the gain.
        let of_double = Plane::from_fn(80, 80, |x, y| hero(40, 40, 0.0).at(x / 2, y / 2) / 2.0);
        assert!((gain(&of_double, 1.0, 200.0) / alone - 2.0).abs() < 1e-6);
        // Per pixel of a reference a fifth as high, a fifth of it; pixels too flat to count remain so.
        let per_reference = hero(80, 80, 0.002).map(|t| 5.0 * t);
        assert!((5.0 * gain(&per_reference, 5.0, 200.0) / alone - 1.0).abs() < 1e-6);
    }

    #[test]
    fn weights_say_what_counts() {
        let trace = hero(80, 80, 0.006);
        let object = Plane::from_fn(80, 80, |x, y| f32::from(x < 40 && y < 40));
        let alone = gain(&hero(40, 40, 0.0), 1.0, 200.0);
        assert_eq!(weighted(&trace, Some(&object), 1.0, 200.0), alone);
        // A wall of weight a third adds as much as one of a third of the area: (.004 + .006^2) / (.06 + .006).
        let faint = object.map(|w| w.max(1.0 / 3.0));
        let gain = weighted(&trace, Some(&faint), 1.0, 200.0);
        assert!((gain / alone - 1.0902).abs() < 1e-3, "{gain}");
    }

    #[test]
    fn hostile_curvature_gives_a_gain_in_range() {
        // A plane: rounding noise is not amplified without limit.
        assert_eq!(gain(&Plane::filled(4, 4, 1e-9), 1.0, 200.0), 200.0);
        assert_eq!(gain(&Plane::filled(0, 0, 1.0), 1.0, 200.0), 200.0);
        // One wrong pixel in 1600 counts as 8 times the 80th percentile, .64: (.0667 * 96 + .64^2) / (96 + .64) = .0705,
        // for sums of 96 and 6.4.
        let mut trace = hero(40, 40, 0.0);
        for wrong in [1e30, f32::MAX] {
            trace.samples_mut()[0] = wrong;
            let found = gain(&trace, 1.0, 200.0);
            assert!((found - 5.677).abs() < 0.01, "{found}");
        }
        // What is not finite does not count, nor does its weight.
        let sane = gain(&hero(40, 40, 0.0), 1.0, 200.0);
        for hostile in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let broken = Plane::from_fn(40, 40, |x, y| match x < 2 {
                true => hostile,
                false => hero(40, 40, 0.0).at(x, y),
            });
            assert!((gain(&broken, 1.0, 200.0) / sane - 1.0).abs() < 1e-6);
            let weights = Plane::from_fn(40, 40, |x, _| if x < 2 { hostile } else { 1.0 });
            let found = weighted(&hero(40, 40, 0.0), Some(&weights), 1.0, 200.0);
            assert!((found / sane - 1.0).abs() < 1e-6, "{found}");
        }
        let none = Plane::filled(40, 40, 0.0);
        assert_eq!(weighted(&trace, Some(&none), 1.0, 200.0), 200.0);
    }

    #[test]
    fn steps_of_coarse_normals_stay_out_of_sight() {
        // A sixth of 2/255, differenced over two pixels, is a ridge of 6.5e-4: tanh(153 * 6.5e-4) = 0.1.
        let at_8_bits = most_gain(1.0 / 255.0, 0.5, 1.0);
        assert!((at_8_bits - 153.4).abs() < 0.1, "{at_8_bits}");
        // Measured in pixels of a reference a third as high, the ridge is three times as high.
        assert!((most_gain(1.0 / 255.0, 0.5, 3.0) - 51.1).abs() < 0.1);
        // Diffused by two pixels it is a fifth as high.
        assert_eq!(most_gain(1.0 / 255.0, 2.0, 1.0), 200.0);
        // Steps of half floats are too fine to be visible.
        assert_eq!(most_gain(1.0 / 4096.0, 1.0, 1.0), 200.0);
        assert_eq!(most_gain(0.0, 0.0, 1.0), 200.0);
        assert_eq!(gain(&Plane::filled(4, 4, 1e-9), 1.0, 30.0), 30.0);
    }
}
