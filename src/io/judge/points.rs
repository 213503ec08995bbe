//! Positions as they were read.

use crate::frame::depth::depth_of_position;
use crate::frame::{Camera, Plane, Vector3Planes};
use glam::DVec3;
use half::f16;

/// The components of world-space positions. Half floats stay such: of a whole layer a few thousand points are looked at.
#[derive(Clone, Copy)]
pub(crate) enum Points<'a> {
    Floats([&'a Plane; 3]),
    Halves([&'a Plane<f16>; 3]),
}

impl<'a> From<&'a Vector3Planes> for Points<'a> {
    fn from(planes: &'a Vector3Planes) -> Self {
        Self::Floats([&planes.x, &planes.y, &planes.z])
    }
}

impl Points<'_> {
    /// Columns and rows of each component.
    pub(crate) fn sizes(self) -> [(usize, usize); 3] {
        match self {
            Self::Floats(planes) => planes.map(|plane| (plane.width(), plane.height())),
            Self::Halves(planes) => planes.map(|plane| (plane.width(), plane.height())),
        }
    }

    /// Distances along the view axis; 0 without a position.
    pub(crate) fn depth(self, camera: &Camera) -> Plane {
        let [(width, height), ..] = self.sizes();
        Plane::from_fn(width, height, |x, y| {
            depth_of_position(self.at(x, y), camera)
        })
    }

    /// The position at column `x` of row `y`, as stored.
    pub(crate) fn at(self, x: usize, y: usize) -> DVec3 {
        match self {
            Self::Floats(planes) => DVec3::from_array(planes.map(|plane| plane.at(x, y).into())),
            Self::Halves(planes) => DVec3::from_array(planes.map(|plane| plane.at(x, y).into())),
        }
    }
}
