//! Lights as samples: what a sum over lights is made of.

use glam::Vec3;

/// Light from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit direction to the light, in view space.
    pub to_light: Vec3,
    /// Red, green and blue: radiance times solid angle over pi, so that a white Lambertian surface
    /// facing a light of 1 shows 1.
    pub intensity: [f32; 3],
}
