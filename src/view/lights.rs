//! The lights of a look, in the flag's form: `AZ,EL[,R,G,B]`.

use crate::light::lights::direction_of;
use eframe::egui::{Vec2, vec2};

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Light {
    /// Degrees counterclockwise from the right of the picture.
    pub(super) azimuth: f32,
    /// Degrees from the picture plane toward the viewer.
    pub(super) elevation: f32,
    pub(super) color: Option<[f32; 3]>,
}

impl Light {
    /// Parses a value of the flag.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let numbers = text.split(',').map(|n| n.trim().parse().ok());
        let numbers: Vec<f32> = numbers.collect::<Option<_>>()?;
        let (&[azimuth, elevation], color) = numbers.split_first_chunk()?;
        let color = match color {
            [] => None,
            &[r, g, b] => Some([r, g, b]),
            _ => return None,
        };
        Some(Self {
            azimuth,
            elevation,
            color,
        })
    }

    /// Its place on a ball seen from the front, in radii from the centre, y down.
    pub(super) fn on_ball(&self) -> Vec2 {
        let to_light = direction_of(self.azimuth, self.elevation);
        vec2(to_light.x, -to_light.y)
    }

    /// The light moved to a place on the ball, in whole degrees.
    pub(super) fn moved_to(&self, place: Vec2) -> Self {
        let across = place.length().min(1.0);
        let azimuth = (-place.y).atan2(place.x).to_degrees().round();
        Self {
            // The azimuth is undefined straight above: keep it.
            azimuth: if across < 1e-3 { self.azimuth } else { azimuth },
            elevation: across.acos().to_degrees().round(),
            ..*self
        }
    }
}

impl std::fmt::Display for Light {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{}", self.azimuth, self.elevation)?;
        match self.color {
            Some([r, g, b]) => write!(f, ",{r},{g},{b}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_is_where_it_was_dragged() {
        let light = Light::parse("135,40,1,0.5,0.25").unwrap();
        assert_eq!(light.to_string(), "135,40,1,0.5,0.25");
        // Up and to the left of the centre, at cos(40 degrees) of the radius.
        let place = light.on_ball();
        assert!(place.x < 0.0 && place.y < 0.0);
        assert!((place.length() - 40.0_f32.to_radians().cos()).abs() < 1e-6);
        let moved = light.moved_to(vec2(0.0, 0.5));
        // Below the centre; acos(0.5) is 60 degrees.
        assert_eq!((moved.azimuth, moved.elevation), (-90.0, 60.0));
        assert_eq!(moved.color, light.color);
        assert_eq!(light.moved_to(vec2(9.0, 0.0)).elevation, 0.0);
        assert_eq!(light.moved_to(Vec2::ZERO).to_string(), "135,90,1,0.5,0.25");
        for wrong in ["", "1", "1,2,3", "1,x"] {
            assert_eq!(Light::parse(wrong), None, "{wrong}");
        }
    }
}
