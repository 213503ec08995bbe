//! Pictures of a scene: many paths per pixel.

use super::camera::Camera;
use super::path::{Tracing, light_along};
use super::sampler::Sampler;
use super::scene::Scene;
use glam::Vec3;
use rayon::prelude::*;

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
