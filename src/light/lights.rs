//! Lights as samples for sums over lights.

use super::environment::Environment;
use super::lit_sphere::LitSphere;
use crate::error::Result;
use crate::params::in_range;
pub use crate::plan::available::LightKinds;
use crate::plan::execution::Execution;
pub use crate::plan::outcome::LightChoice;
use glam::Vec3;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Light from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    /// Unit direction to the light, in view space.
    pub to_light: Vec3,
    /// Red, green and blue: radiance times solid angle over pi, so that a white Lambertian surface facing a light of
    /// intensity 1 shows 1.
    pub intensity: [f32; 3],
}

impl DirectionalLight {
    /// White light of intensity 1 from this azimuth and elevation, in degrees.
    pub fn white([azimuth, elevation]: [f32; 2]) -> Self {
        Self {
            to_light: direction_of(azimuth, elevation),
            intensity: [1.0; 3],
        }
    }

    /// Whether it is above the picture plane, by less than 45 degrees.
    pub(crate) fn is_raking(&self) -> bool {
        let Vec3 { x, y, z } = self.to_light;
        z > 0.0 && z < x.hypot(y)
    }
}

/// Light from a point near the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// View-space position, in the units of depth; the eye is at 0 and looks toward -z.
    pub position: Vec3,
    /// Red, green and blue shown by a white Lambertian surface facing it at a distance of 1; falls off with the square
    /// of the distance.
    pub intensity: [f32; 3],
}

/// Azimuth and elevation, in degrees, of the default lamp: from the upper left.
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

/// Red, green and blue of a light; for a light near the surface, at a distance of 1: in scenes measured in micrometres
/// it lights from a metre away.
const INTENSITIES: RangeInclusive<f32> = 0.0..=1e12;

/// Coordinates of lights near the surface: the range of depth.
const POSITIONS: RangeInclusive<f32> = -1e9..=1e9;

impl Illumination {
    /// Refuses lights beyond the range of single precision: colours below 0 or above 1e12, positions farther than 1e9
    /// from the eye along an axis.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] naming the kind of the first invalid light.
    pub fn validate(&self) -> Result<()> {
        for light in &self.directional {
            check_all("--light", light.intensity, INTENSITIES)?;
        }
        for light in &self.points {
            check_all("--point-light", light.intensity, INTENSITIES)?;
            check_all("--point-light", light.position.to_array(), POSITIONS)?;
        }
        Ok(())
    }
}

fn check_all(name: &'static str, numbers: [f32; 3], range: RangeInclusive<f32>) -> Result<()> {
    let mut numbers = numbers.into_iter();
    numbers.try_for_each(|number| in_range(name, number, range.clone()))
}

/// All the light of a scene.
#[derive(Debug, Clone, Default)]
pub struct Illumination {
    /// Directional lights; an area light is many of them.
    pub directional: Vec<DirectionalLight>,
    /// Widths in degrees, as seen from the surface, of directional lights that have their own: of samples of area lights.
    /// Those without, and those beyond the end, are as wide as [`crate::params::RelightParams::light_size`].
    pub widths_deg: Vec<Option<f32>>,
    /// Point lights.
    pub points: Vec<PointLight>,
    /// Light from all around, attached to the view. A runner caches its filtered maps while the same one is used.
    pub environment: Option<Arc<Environment>>,
    /// A lit sphere in place of all other light; or two, for convexities and for concavities.
    pub lit_spheres: Vec<LitSphere>,
}

impl Illumination {
    /// The kinds of light present.
    pub fn kinds(&self) -> LightKinds {
        LightKinds {
            directional: !self.directional.is_empty(),
            points: !self.points.is_empty(),
            environment: self.environment.is_some(),
            lit_spheres: self.lit_spheres.len().min(2) as u8,
            raking: self.directional.iter().any(DirectionalLight::is_raking),
        }
    }
}

/// The lights, `gain` times as bright.
pub(crate) fn brightened(mut lights: Vec<DirectionalLight>, gain: f32) -> Vec<DirectionalLight> {
    for light in &mut lights {
        light.intensity = light.intensity.map(|channel| gain * channel);
    }
    lights
}

impl<'a> Execution<'a> {
    /// New light, if it is given.
    pub(crate) fn illumination(&self) -> Option<&'a Illumination> {
        self.inputs.others.get()
    }
}
