//! The flags of `enhance` that name layers of light.

use super::named::{Named, given};
use crate::io::inputs::{GroupInput, LightInputs};
use crate::light::lights::direction_of;
use crate::params::Params;
use crate::params::table::rows;
use glam::Vec3;
use std::str::FromStr;

rows! {
    /// Layers of light to scale separately.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Light layers")]
    pub(crate) struct LightLayerFlags {
        named: LightInputs as flatten;
        /// Scale a light group, layer Combined_NAME or RGBA_NAME, by the direction of its light: degrees counterclockwise
        /// from the right of the picture, and degrees from the picture plane toward the viewer. Repeatable, for other
        /// groups or further directions of one: an area light is a set of directions.
        light_group: Vec<GroupDirection> = [long, value_name = "NAME=AZ,EL"];
    }
}

/// A light group and one direction to its light.
#[derive(Debug, Clone, PartialEq)]
struct GroupDirection {
    name: String,
    to_light: Vec3,
}

impl FromStr for GroupDirection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected NAME=AZ,EL in degrees, as in key=135,40";
        let (name, angles) = text.rsplit_once('=').ok_or(expected)?;
        let (azimuth, elevation) = angles.split_once(',').ok_or(expected)?;
        let angle = |text: &str| text.trim().parse().ok().filter(|a: &f32| a.is_finite());
        let (azimuth, elevation) = angle(azimuth).zip(angle(elevation)).ok_or(expected)?;
        if name.is_empty() {
            return Err(expected.into());
        }
        if !(-90.0..=90.0).contains(&elevation) {
            return Err("an elevation is -90 to 90 degrees".into());
        }
        Ok(Self {
            name: name.into(),
            to_light: direction_of(azimuth, elevation),
        })
    }
}

impl LightLayerFlags {
    /// Layers of light to read, only those whose magnitude in `params` is not zero.
    pub(crate) fn inputs(&self, params: &Params) -> LightInputs {
        let magnitudes = params.scaling.magnitudes();
        let ambient = params.scaling.scaling_ambient.is_some_and(|g| g > 0.0);
        let mut groups: Vec<GroupInput> = Vec::new();
        for GroupDirection { name, to_light } in &self.light_group {
            match groups.iter_mut().find(|group| group.name == *name) {
                Some(group) => group.to_light.push(*to_light),
                None => groups.push(GroupInput {
                    name: name.clone(),
                    to_light: vec![*to_light],
                }),
            }
        }
        LightInputs {
            lobes: params.lobes,
            without_diffuse: magnitudes.diffuse.largest() == 0.0 && !ambient,
            without_specular: magnitudes.specular.largest() == 0.0,
            groups,
            occlusion: ambient,
            ..self.named.clone()
        }
    }

    /// The layers and files that are named.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        let LightInputs {
            diffuse,
            specular,
            albedo,
            ..
        } = &mut self.named;
        given([diffuse, specular, albedo], [])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_turn_counterclockwise_and_rise_toward_the_viewer() {
        let toward = |text: &str| text.parse::<GroupDirection>().unwrap();
        let near = |text, x, y, z| {
            let group = toward(text);
            assert_eq!(group.name, "key");
            assert!(
                group.to_light.abs_diff_eq(Vec3::new(x, y, z), 1e-6),
                "{group:?}"
            );
        };
        near("key=0,0", 1.0, 0.0, 0.0);
        near("key=90,0", 0.0, 1.0, 0.0);
        near("key=17,90", 0.0, 0.0, 1.0);
        // An elevation of 60 degrees leaves cos 60 = 1/2 in the picture plane.
        near("key=180,60", -0.5, 0.0, 0.75_f32.sqrt());
        for bad in ["key", "key=1", "=1,2", "key=1,x", "key=1,nan", "key=0,91"] {
            assert!(bad.parse::<GroupDirection>().is_err(), "{bad}");
        }
    }
}
