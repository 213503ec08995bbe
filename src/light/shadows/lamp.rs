//! A round lamp far away, and chords of it.

use crate::light::lights::DirectionalLight;
use glam::DVec3;

/// Slopes are taken no larger: lamps at the zenith have a finite one.
const STEEPEST: f64 = 1e6;

/// A lamp narrower than this has hard shadows, in radians.
const NARROWEST: f64 = 1e-7;

/// A round lamp far away.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lamp {
    /// Counterclockwise from the right of the picture, in radians.
    pub(crate) azimuth: f64,
    /// Above the picture plane, in radians.
    pub(crate) elevation: f64,
    /// Half of its width, in radians.
    pub(crate) radius: f64,
}

/// An upright chord of a lamp, or the whole of it.
pub(super) struct Chord {
    pub(super) azimuth: f64,
    /// The slope of light from its middle.
    pub(super) slope: f32,
    /// One over half of its height in radians.
    pub(super) per_half: f32,
    /// Its share of the lamp, in any unit.
    pub(super) weight: f32,
    /// Whether it stands for all of the lamp, and is as wide.
    pub(super) is_disc: bool,
}

impl Lamp {
    /// The lamp of a light, `width_deg` wide.
    pub(crate) fn of(light: &DirectionalLight, width_deg: f32) -> Self {
        let to = light.to_light.as_dvec3();
        Self {
            azimuth: to.y.atan2(to.x),
            elevation: to.z.atan2(to.x.hypot(to.y)),
            radius: 0.5 * f64::from(width_deg).to_radians(),
        }
    }

    /// The unit direction to it.
    pub(super) fn direction(&self) -> DVec3 {
        let across = self.elevation.cos();
        DVec3::new(
            across * self.azimuth.cos(),
            across * self.azimuth.sin(),
            self.elevation.sin(),
        )
    }

    /// So many chords side by side; one is the whole lamp.
    pub(super) fn chords(&self, count: usize) -> Vec<Chord> {
        let chord = |i: usize| {
            let across = (2 * i + 1) as f64 / count as f64 - 1.0;
            let half = (1.0 - across * across).sqrt();
            let aside = self.radius * across;
            let turn = aside.sin().atan2(aside.cos() * self.elevation.cos());
            let elevation = (self.elevation.sin() * aside.cos()).asin();
            Chord {
                azimuth: self.azimuth + turn,
                slope: elevation.tan().clamp(-STEEPEST, STEEPEST) as f32,
                per_half: (self.radius * half).max(NARROWEST).recip() as f32,
                weight: half as f32,
                is_disc: count == 1,
            }
        };
        (0..count).map(chord).collect()
    }
}
