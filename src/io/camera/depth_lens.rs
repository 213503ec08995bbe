//! The view-space normal implied by the slope of depth under a given lens.
//!
//! With `(p, q)` the change of the logarithm of planar depth per pixel and `(u, v)` the position in the picture, a
//! perspective of focal length `f` gives the normal `(f p, f q, 1 + u p + v q)`; a parallel projection with `k` pixels
//! per unit gives `(k z p, k z q, 1)`. Both follow from the cross product of the two tangents. So one number is unknown
//! besides the rotation.

use super::depth_samples::Patch;
use nalgebra::Vector3;

/// The projection, with the meaning of its one unknown parameter, and the kind of distance in the depth layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
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
    pub(super) kind: Kind,
    pub(super) number: f64,
}

impl Lens {
    /// The normal of a patch in view space, by its slope, not normalised. Its product with the view vector `(-u, -v, f)
    /// / f` is 1 for a perspective.
    fn raw_normal(&self, patch: &Patch) -> Vector3<f64> {
        let (f, seen, mut slope) = (self.number, patch.seen, patch.slope);
        if self.kind == Kind::Parallel {
            let rise = f * patch.depth * slope;
            return Vector3::new(rise.x, rise.y, 1.0);
        }
        if self.kind == Kind::Ray {
            // Planar depth is the distance times f / sqrt(f^2 + u^2 + v^2).
            slope -= seen / (f * f + seen.norm_squared());
        }
        Vector3::new(f * slope.x, f * slope.y, 1.0 + slope.dot(&seen))
    }

    /// The unit normal of a patch in view space, by its slope.
    pub(super) fn normal(&self, patch: &Patch) -> Vector3<f64> {
        self.raw_normal(patch).normalize()
    }

    /// Cosine between the normal and the direction to the eye.
    pub(super) fn facing(&self, patch: &Patch) -> f64 {
        let lean = match self.kind {
            Kind::Parallel => 1.0,
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
