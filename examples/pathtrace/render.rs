//! Pictures of a scene: many paths per pixel, and the surface at each pixel's centre.

use super::camera::Camera;
use super::geometry::Ray;
use super::material::Material;
use super::path::{Passes, Tracing, Vertex, light_along};
use super::sampler::Sampler;
use super::scene::{Point, Scene};
use glam::Vec3;
use rayon::prelude::*;
use relievo::light::brdf::{fresnel, mirrored, refracted};

/// Scene, camera and sampling of a rendering.
pub(crate) struct Job<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) camera: Camera,
    pub(crate) tracing: Tracing,
    /// Paths per pixel.
    pub(crate) samples: u32,
    pub(crate) seed: u32,
}

/// The mean over a pixel.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pixel {
    pub(crate) passes: Passes,
    /// Diffuse albedo.
    pub(crate) albedo: Vec3,
    /// Share of the pixel that shows a surface.
    pub(crate) coverage: f32,
    /// Cosine-weighted share of directions from which light could come.
    pub(crate) ambient: f32,
}

/// The surface at a pixel's centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Middle {
    /// Unit normal, toward the eye.
    pub(crate) normal: Vec3,
    pub(crate) position: Vec3,
    pub(crate) depth: f32,
    /// On mirrors and glass, the position seen there.
    pub(crate) seen_by_way: Option<Vec3>,
}

/// Clear surfaces that a line of sight is followed by.
const MOST_CLEAR: usize = 16;

impl Job<'_> {
    /// The picture, row by row.
    pub(crate) fn pixels(&self) -> Vec<Pixel> {
        self.each_pixel(|x, y| self.pixel(x, y))
    }

    /// The surface at each pixel's centre.
    pub(crate) fn middles(&self) -> Vec<Option<Middle>> {
        self.each_pixel(|x, y| {
            let ray = self.camera.ray([x as f32 + 0.5, y as f32 + 0.5]);
            let (point, _) = self.scene.met(&ray)?;
            let clear = point.object.material.is_clear();
            Some(Middle {
                normal: point.normal,
                position: point.position,
                depth: self.camera.depth(point.position),
                seen_by_way: clear.then(|| self.seen_by(&ray, point)).flatten(),
            })
        })
    }

    fn each_pixel<T: Send>(&self, pixel: impl Fn(usize, usize) -> T + Sync) -> Vec<T> {
        let [width, height] = self.camera.size;
        let places = (0..width * height).into_par_iter();
        places.map(|i| pixel(i % width, i / width)).collect()
    }

    fn pixel(&self, x: usize, y: usize) -> Pixel {
        let mut pixel = Pixel::default();
        let place = (y * self.camera.size[0] + x) as u32;
        for index in 0..self.samples {
            let mut sampler = Sampler::new(self.seed, place, index);
            let [dx, dy] = sampler.pair();
            let ray = self.camera.ray([x as f32 + dx, y as f32 + dy]);
            pixel
                .passes
                .add(&light_along(self.scene, ray, &self.tracing, &mut sampler));
        }
        let share = 1.0 / self.samples as f32;
        for lobe in 0..2 {
            pixel.passes.direct[lobe] *= share;
            pixel.passes.indirect[lobe] *= share;
        }
        pixel.passes.emission *= share;
        pixel.passes.background *= share;
        pixel
    }

    /// Fills in data not needed for pictures: colour, coverage and ambient occlusion, unoccluded beyond `reach`.
    pub(crate) fn describe(&self, pixels: &mut [Pixel], reach: f32) {
        let width = self.camera.size[0];
        pixels.par_iter_mut().enumerate().for_each(|(i, pixel)| {
            let share = 1.0 / self.samples as f32;
            for index in 0..self.samples {
                let mut sampler = Sampler::new(self.seed, i as u32, index);
                let [dx, dy] = sampler.pair();
                let ray = self
                    .camera
                    .ray([(i % width) as f32 + dx, (i / width) as f32 + dy]);
                let Some((point, _)) = self.scene.met(&ray) else {
                    continue;
                };
                pixel.coverage += share;
                pixel.albedo += share * point.object.material.albedo();
                let vertex = Vertex::new(point, &ray, 0, &self.tracing.enhancement);
                if vertex.is_open_ambiently(self.scene, reach, &mut sampler) {
                    pixel.ambient += share;
                }
            }
        });
    }

    /// The first surface along a sight line that is neither mirror nor glass. Sight lines pass through glass, unless it
    /// mirrors all or most of the light.
    fn seen_by(&self, ray: &Ray, first: Point) -> Option<Vec3> {
        let (mut point, mut to_eye) = (first, -ray.direction);
        for _ in 0..MOST_CLEAR {
            let (n, e) = (point.normal.to_array(), to_eye.to_array());
            let through = match point.object.material {
                Material::Glass(ior) => {
                    let ior = if point.inside { 1.0 / ior } else { ior };
                    let mirrors = fresnel(point.normal.dot(to_eye), ior) > 0.5;
                    refracted(n, e, ior).filter(|_| !mirrors)
                }
                Material::Mirror(_) => None,
                Material::Matte(_) | Material::Glossy(_) => return Some(point.position),
            };
            let direction = Vec3::from(through.unwrap_or(mirrored(n, e))).normalize();
            (point, _) = self.scene.met(&point.leaving(direction))?;
            to_eye = -direction;
        }
        None
    }
}
