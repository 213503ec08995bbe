//! Light layers in memory.

use super::FrameBuilder;
use super::samples::{Name, Samples, Size};
use crate::error::{Result, bad};
use crate::frame::coverage::sanitise;
use crate::frame::{ColorPlanes, LightGroup, LightLayers, Plane};
use glam::Vec3;

/// Largest difference of a direction's length from 1.
const LENGTH_ERROR: f32 = 1e-3;

impl FrameBuilder<'_> {
    /// The given light layers of the picture.
    pub(super) fn light_layers(&self) -> Result<LightLayers> {
        let mut layers = LightLayers {
            picture_is_occlusion: self.picture_is_occlusion,
            occlusion: self.scalar("light_occlusion")?.map(finite),
            ..LightLayers::default()
        };
        for (lobe, layer, samples) in &self.lobes {
            *layers.layer_mut(*lobe, *layer) = Some(colors("lobe", samples, self.size)?);
        }
        for (name, samples, to_light) in &self.groups {
            let is_unit = |to: &Vec3| (to.length() - 1.0).abs() <= LENGTH_ERROR;
            if to_light.is_empty() || !to_light.iter().all(is_unit) {
                let found = format!("{name} has no directions of unit length to its lights");
                let remedy = "give at least one, in view space";
                return Err(bad("light_group", found, remedy));
            }
            layers.groups.push(LightGroup {
                name: name.clone(),
                light: colors("light_group", samples, self.size)?,
                to_light: to_light.clone(),
            });
        }
        Ok(layers)
    }
}

/// Linear colour of one or three channels.
pub(super) fn colors(name: Name, samples: &Samples, size: Size) -> Result<ColorPlanes> {
    samples.refuse_integers(name)?;
    Ok(colors_of(samples.planes(name, size, &[1, 3])?))
}

/// The colour of three planes, or of one grey plane, without NaN and infinities.
pub(super) fn colors_of(planes: Vec<Plane>) -> ColorPlanes {
    ColorPlanes::of(planes.into_iter().map(finite).collect())
}

pub(super) fn finite(mut plane: Plane) -> Plane {
    sanitise(&mut plane);
    plane
}
