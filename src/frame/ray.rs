//! Rays.

use glam::DVec3;

/// A ray; its direction may have any length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Its origin.
    pub start: DVec3,
    /// Its direction.
    pub direction: DVec3,
}

impl Ray {
    /// The difference to another ray, of origin and direction.
    #[inline]
    pub fn minus(&self, other: &Ray) -> Ray {
        Ray {
            start: self.start - other.start,
            direction: self.direction - other.direction,
        }
    }
}
