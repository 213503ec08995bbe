//! Rays.

use glam::DVec3;

/// A ray: where it starts, and where it leads, of any length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Its foot.
    pub start: DVec3,
    /// Its direction.
    pub direction: DVec3,
}

impl Ray {
    /// How this ray differs from another, foot and direction.
    #[inline]
    pub fn minus(&self, other: &Ray) -> Ray {
        Ray {
            start: self.start - other.start,
            direction: self.direction - other.direction,
        }
    }
}
