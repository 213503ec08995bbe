//! Lights as samples: what a sum over lights is made of.

use super::environment::Environment;
use super::lit_sphere::LitSphere;
use glam::Vec3;
use std::sync::Arc;

/// Light from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit direction to the light, in view space.
    pub to_light: Vec3,
    /// Red, green and blue: radiance times solid angle over pi, so that a white Lambertian surface
    /// facing a light of 1 shows 1.
    pub intensity: [f32; 3],
}

/// Light from a point near the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// View-space position, in the units of depth; the eye is at 0 and looks toward -z.
    pub position: Vec3,
    /// Red, green and blue that a white Lambertian surface facing it shows at a distance of 1; it falls with
    /// the square of the distance.
    pub intensity: [f32; 3],
}

/// Azimuth and elevation, in degrees, of the lamp that lights what has no other light: from the upper left.
pub(crate) const LAMP_DEG: [f32; 2] = [135.0, 40.0];

/// The unit direction at `azimuth_deg` counterclockwise from the right of the picture and `elevation_deg`
/// from the picture plane toward the viewer.
pub fn direction_of(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let (azimuth, elevation) = (
        f64::from(azimuth_deg).to_radians(),
        f64::from(elevation_deg).to_radians(),
    );
    let across = elevation.cos();
    Vec3::new(
        (across * azimuth.cos()) as f32,
        (across * azimuth.sin()) as f32,
        elevation.sin() as f32,
    )
}

/// All the light of a scene.
#[derive(Debug, Clone, Default)]
pub struct Illumination {
    /// Lights from one direction; an area light is many.
    pub directional: Vec<DirectionalLight>,
    /// Lights at a point.
    pub points: Vec<PointLight>,
    /// Light from all around, attached to the view. A runner that meets the same one again does not filter
    /// it again.
    pub environment: Option<Arc<Environment>>,
    /// A lit sphere in place of all other light; or one for convexities, then one for concavities.
    pub lit_spheres: Vec<LitSphere>,
}
