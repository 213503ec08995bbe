//! Distance maps: the surroundings of an object, seen from a point inside it.

use super::{ColorPlanes, Vector3Planes};
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// The surroundings of a point in every direction: an equirectangular map with its centre straight ahead (-z of the
/// map's own space, y up) and its left and right edges behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Surroundings {
    /// The viewpoint, in world space.
    pub center: DVec3,
    /// Rotation from world space to the map's own space.
    pub map_from_world: DMat3,
    /// Points of the surfaces in world space, relative to the centre; 0 where there are none.
    pub points: Vector3Planes,
    /// Unit normals in world space; 0 where there are none.
    pub normal: Vector3Planes,
    /// Largest rounding error of a component of the normals as stored.
    pub normal_rounding: f32,
    /// The picture, scene-linear.
    pub color: Option<ColorPlanes>,
}

impl Surroundings {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.points.x.width()
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.points.x.height()
    }

    /// The position on the map, in pixels from its upper left corner, of a non-zero world-space direction.
    #[inline]
    pub fn position(&self, world: DVec3) -> DVec2 {
        let to = self.map_from_world * world;
        let across = to.x.atan2(-to.z) / TAU + 0.5;
        let down = 0.5 - to.y.atan2((to.x * to.x + to.z * to.z).sqrt()) / PI;
        DVec2::new(across * self.width() as f64, down * self.height() as f64)
    }

    /// The point of a pixel, relative to the centre; 0 if there is none.
    #[inline]
    pub fn point_at(&self, x: usize, y: usize) -> DVec3 {
        self.points.at(x, y)
    }

    /// The unit normal of a pixel, or 0.
    #[inline]
    pub fn normal_at(&self, x: usize, y: usize) -> DVec3 {
        self.normal.at(x, y)
    }
}

/// The unit direction, in the map's own space, of a pixel centre of an equirectangular map.
pub fn map_direction(x: usize, y: usize, width: usize, height: usize) -> DVec3 {
    let azimuth = ((x as f64 + 0.5) / width as f64 - 0.5) * TAU;
    let elevation = (0.5 - (y as f64 + 0.5) / height as f64) * PI;
    let ((sin_a, cos_a), (sin_e, cos_e)) = (azimuth.sin_cos(), elevation.sin_cos());
    DVec3::new(cos_e * sin_a, sin_e, -cos_e * cos_a)
}
