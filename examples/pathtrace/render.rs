//! Pictures of a scene: many paths per pixel, from a pinhole camera.

use super::geometry::Ray;
use super::path::{Tracing, light_along};
use super::sampler::Sampler;
use super::scene::Scene;
use glam::{Mat3, Vec3};
use rayon::prelude::*;
use relievo::frame::{ColorPlanes, Plane};

/// A pinhole camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Camera {
    eye: Vec3,
    /// Right, up and backward, as everywhere in relievo.
    axes: Mat3,
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
            axes: Mat3::from_cols(right, back.cross(right), back),
            size,
            focal_px: 0.5 * size[1] as f32 / (0.5 * height_deg.to_radians()).tan(),
        }
    }

    /// The ray through a point of the picture, in pixels from its top left corner.
    pub(crate) fn ray(&self, [x, y]: [f32; 2]) -> Ray {
        let [x, y] = [x - 0.5 * self.size[0] as f32, 0.5 * self.size[1] as f32 - y];
        Ray {
            origin: self.eye,
            direction: (self.axes * Vec3::new(x, y, -self.focal_px)).normalize(),
        }
    }
}

/// Scene, camera and sampling of a rendering.
pub(crate) struct Job<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: Camera,
    pub(crate) tracing: Tracing,
    /// Paths per pixel.
    pub(crate) samples: u32,
    pub(crate) seed: u32,
}

impl Job<'_> {
    /// The picture, row by row: means over the pixels.
    pub(crate) fn pixels(&self) -> Vec<Vec3> {
        let [width, height] = self.camera.size;
        let places = (0..width * height).into_par_iter();
        places.map(|i| self.pixel(i % width, i / width)).collect()
    }

    /// The picture, each pixel as `shown` has it.
    pub(crate) fn picture(&self, shown: fn(Vec3) -> Vec3) -> ColorPlanes {
        let [width, height] = self.camera.size;
        let pixels: Vec<Vec3> = self.pixels().into_iter().map(shown).collect();
        let [r, g, b] =
            [0, 1, 2].map(|c| Plane::from_fn(width, height, |x, y| pixels[y * width + x][c]));
        ColorPlanes { r, g, b }
    }

    fn pixel(&self, x: usize, y: usize) -> Vec3 {
        let place = (y * self.camera.size[0] + x) as u32;
        let paths = (0..self.samples).map(|index| {
            let mut sampler = Sampler::new(self.seed, place, index);
            let [dx, dy] = sampler.pair();
            let ray = self.camera.ray([x as f32 + dx, y as f32 + dy]);
            light_along(self.scene, ray, &self.tracing, &mut sampler)
        });
        paths.sum::<Vec3>() / self.samples as f32
    }
}
