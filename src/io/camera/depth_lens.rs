//! The view-space normal implied by the slope of depth under a given lens.
//!
//! With `(p, q)` the change of the logarithm of planar depth per pixel and `(u, v)` the position in the picture, a
//! perspective of focal length `f` gives the normal `(f p, f q, 1 + u p + v q)`; a parallel projection with `k` pixels
//! per unit gives `(k z p, k z q, 1)`. Both follow from the cross product of the two tangents. So one number is unknown
//! besides the rotation.

use super::depth_samples::Facet;
use nalgebra::Vector3;

/// The projection, with the meaning of its one unknown parameter, and the kind of distance in the depth layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LensKind {
    /// Perspective, depth along the view axis; the number is the focal length.
    Planar,
    /// Perspective, depth along the sight line; the number is the focal length.
    Ray,
    /// Parallel; the number is pixels per unit.
    Parallel,
}

/// A lens: its kind, and its focal length or pixels per unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lens {
    pub(super) kind: LensKind,
    pub(super) number: f64,
}

impl Lens {
    /// The normal of a patch in view space, by its slope, not normalised. Its product with the view vector `(-u, -v, f)
    /// / f` is 1 for a perspective.
    fn raw_normal(&self, patch: &Facet) -> Vector3<f64> {
        let (f, seen, mut slope) = (self.number, patch.seen, patch.slope);
        if self.kind == LensKind::Parallel {
            let rise = f * patch.depth * slope;
            return Vector3::new(rise.x, rise.y, 1.0);
        }
        if self.kind == LensKind::Ray {
            // Planar depth is the distance times f / sqrt(f^2 + u^2 + v^2).
            slope -= seen / (f * f + seen.norm_squared());
        }
        Vector3::new(f * slope.x, f * slope.y, 1.0 + slope.dot(&seen))
    }

    /// The unit normal of a patch in view space, by its slope.
    pub(super) fn normal(&self, patch: &Facet) -> Vector3<f64> {
        self.raw_normal(patch).normalize()
    }

    /// The unit normal, and its change with the logarithm of the lens's number.
    pub(super) fn normal_and_slope(&self, patch: &Facet) -> (Vector3<f64>, Vector3<f64>) {
        let raw = self.raw_normal(patch);
        let mut change = Vector3::new(raw.x, raw.y, 0.0);
        if self.kind == LensKind::Ray {
            let (square, seen) = (self.number * self.number, patch.seen);
            let slope = 2.0 * square / (square + seen.norm_squared()).powi(2) * seen;
            let along = self.number * slope;
            change += Vector3::new(along.x, along.y, slope.dot(&seen));
        }
        let length = raw.norm();
        let normal = raw / length;
        (normal, (change - normal.dot(&change) * normal) / length)
    }

    /// Cosine between the normal and the direction to the eye.
    pub(super) fn facing(&self, patch: &Facet) -> f64 {
        let lean = match self.kind {
            LensKind::Parallel => 1.0,
            _ => 1f64.hypot(patch.seen.norm() / self.number),
        };
        1.0 / (self.raw_normal(patch).norm() * lean)
    }

    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            number: self.number * factor,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    /// The change by the logarithm of the number is that between two lenses that differ a little.
    #[test]
    fn slopes_are_those_of_differences() {
        let patch = Facet {
            seen: Vector2::new(300.0, -170.0),
            depth: 7.0,
            slope: Vector2::new(2e-3, 5e-4),
            normal: Vector3::z(),
            bend: 0.0,
            tile: 0,
        };
        for (kind, number) in [
            (LensKind::Planar, 900.0),
            (LensKind::Ray, 900.0),
            (LensKind::Parallel, 80.0),
        ] {
            let lens = Lens { kind, number };
            let (normal, slope) = lens.normal_and_slope(&patch);
            let [ahead, behind] = [1e-4, -1e-4].map(|h: f64| lens.times(h.exp()).normal(&patch));
            assert!((normal - lens.normal(&patch)).norm() < 1e-14);
            // The error of a central difference is a sixth of the third derivative, about 1, times 1e-8.
            assert!((slope - (ahead - behind) / 2e-4).norm() < 1e-8, "{kind:?}");
            assert!(slope.norm() > 0.05, "{kind:?}");
        }
    }
}
