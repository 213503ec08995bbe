//! A pinhole camera.

use super::geometry::Ray;
use glam::Vec3;

/// A pinhole camera: right, up and backward are its axes, as everywhere in relievo.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Camera {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    back: Vec3,
    /// Width and height of the picture, in pixels.
    pub(crate) size: [usize; 2],
    focal_px: f32,
}

impl Camera {
    /// From `eye` toward `target`, with a picture `height_deg` degrees tall.
    pub(crate) fn new(eye: Vec3, target: Vec3, height_deg: f32, size: [usize; 2]) -> Self {
        let back = (eye - target).normalize();
        let right = Vec3::Y.cross(back).normalize();
        Self {
            eye,
            right,
            up: back.cross(right),
            back,
            size,
            focal_px: 0.5 * size[1] as f32 / (0.5 * height_deg.to_radians()).tan(),
        }
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    pub(crate) fn ray(&self, [x, y]: [f32; 2]) -> Ray {
        let [x, y] = [x - 0.5 * self.size[0] as f32, 0.5 * self.size[1] as f32 - y];
        let direction = x * self.right + y * self.up - self.focal_px * self.back;
        Ray {
            origin: self.eye,
            direction: direction.normalize(),
        }
    }
}
