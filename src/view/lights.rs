//! The lights of a look, in the forms of their flags: `AZ,EL[,R,G,B]`, `AZ,EL,RADIUS[,R,G,B]` and `X,Y,Z[,R,G,B]`.

use super::look::{ENVIRONMENT, LIT_SPHERE, Look};
use crate::command::relight_args::LightNumbers;
use crate::light::lights::direction_of;
use eframe::egui::{Vec2, vec2};

/// Settings of lights far away, of round ones, and of those near the surface.
const FAR: &str = "light";
const ROUND: &str = "area-light";
const NEAR: &str = "point-light";

/// The settings that have handles in place of controls.
pub(super) const LIGHTS: [&str; 3] = [FAR, ROUND, NEAR];

/// A light far away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FarLight {
    /// Degrees counterclockwise from the right of the picture.
    pub(super) azimuth: f32,
    /// Degrees from the picture plane toward the viewer.
    pub(super) elevation: f32,
    /// Radius of a round light, in degrees.
    pub(super) radius: Option<f32>,
    pub(super) color: Option<[f32; 3]>,
}

impl FarLight {
    /// Parses a value of `--light`.
    fn parse(text: &str) -> Option<Self> {
        let LightNumbers([azimuth, elevation], color) = text.parse().ok()?;
        Some(Self {
            azimuth,
            elevation,
            radius: None,
            color,
        })
    }

    /// The light of the first look.
    pub(super) fn lamp() -> Self {
        let look = Look::default();
        let lamp = look.value(FAR).and_then(Self::parse);
        lamp.expect("the first look has a light")
    }

    fn parse_round(text: &str) -> Option<Self> {
        let LightNumbers([azimuth, elevation, radius], color) = text.parse().ok()?;
        Some(Self {
            azimuth,
            elevation,
            radius: Some(radius),
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

    fn text(&self) -> String {
        let angles = [self.azimuth, self.elevation];
        let numbers = angles.into_iter().chain(self.radius);
        written(numbers, self.color)
    }
}

/// A light near the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NearLight {
    /// Its place in view space.
    pub(super) position: [f32; 3],
    pub(super) color: Option<[f32; 3]>,
}

impl NearLight {
    fn parse(text: &str) -> Option<Self> {
        let LightNumbers(position, color) = text.parse().ok()?;
        Some(Self { position, color })
    }
}

fn written(numbers: impl IntoIterator<Item = f32>, color: Option<[f32; 3]>) -> String {
    let all = numbers.into_iter().chain(color.into_iter().flatten());
    let all: Vec<_> = all.map(|number| number.to_string()).collect();
    all.join(",")
}

/// The lights of a look that are given by numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lights {
    /// Those far away, round ones last.
    pub(super) far: Vec<FarLight>,
    pub(super) near: Vec<NearLight>,
}

impl Lights {
    /// The lights of `look`; `None` if one is not in the form of its flag.
    pub(super) fn of(look: &Look) -> Option<Self> {
        let far = look.values(FAR).iter().map(|text| FarLight::parse(text));
        let round = look
            .values(ROUND)
            .iter()
            .map(|text| FarLight::parse_round(text));
        let near = look.values(NEAR).iter().map(|text| NearLight::parse(text));
        Some(Self {
            far: far.chain(round).collect::<Option<_>>()?,
            near: near.collect::<Option<_>>()?,
        })
    }

    /// Their number.
    pub(super) fn count(&self) -> usize {
        self.far.len() + self.near.len()
    }

    /// Writes those to `look` that differ from `before`; returns the setting that was changed.
    pub(super) fn write(&self, before: &Self, look: &mut Look) -> Option<&'static str> {
        let texts = |lights: &Self, name: &str| -> Vec<String> {
            let far = |is_round: bool| {
                let far = lights.far.iter();
                far.filter(move |light| light.radius.is_some() == is_round)
                    .map(FarLight::text)
            };
            match name {
                NEAR => {
                    let near = lights.near.iter();
                    near.map(|light| written(light.position, light.color))
                        .collect()
                }
                _ => far(name == ROUND).collect(),
            }
        };
        let mut changed = None;
        for name in LIGHTS {
            let text = texts(self, name);
            if text != texts(before, name) {
                make_way(look, name);
                look.set_all(name, text);
                changed = Some(name);
            }
        }
        changed
    }

    /// Adds a light near the surface to `look`.
    pub(super) fn add_near(look: &mut Look, light: NearLight) {
        let mut texts = look.values(NEAR).to_vec();
        texts.push(written(light.position, light.color));
        make_way(look, NEAR);
        look.set_all(NEAR, texts);
    }
}

/// Takes from `look` what cannot be with the light of a setting: a lit sphere holds all light there is.
pub(super) fn make_way(look: &mut Look, setting: &str) {
    let others = LIGHTS.into_iter().chain([ENVIRONMENT]);
    match setting {
        LIT_SPHERE => others.for_each(|name| look.set(name, None)),
        _ if others.into_iter().any(|name| name == setting) => look.set(LIT_SPHERE, None),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_is_where_it_was_dragged() {
        let light = FarLight::parse("135,40,1,0.5,0.25").unwrap();
        assert_eq!(light.text(), "135,40,1,0.5,0.25");
        // Up and to the left of the centre, at cos(40 degrees) of the radius.
        let place = light.on_ball();
        assert!(place.x < 0.0 && place.y < 0.0);
        assert!((place.length() - 40.0_f32.to_radians().cos()).abs() < 1e-6);
        let moved = light.moved_to(vec2(0.0, 0.5));
        // Below the centre; acos(0.5) is 60 degrees.
        assert_eq!((moved.azimuth, moved.elevation), (-90.0, 60.0));
        assert_eq!(moved.color, light.color);
        assert_eq!(light.moved_to(vec2(9.0, 0.0)).elevation, 0.0);
        assert_eq!(light.moved_to(Vec2::ZERO).text(), "135,90,1,0.5,0.25");
    }

    #[test]
    fn only_lights_that_change_are_written() {
        let mut look = Look::default().with("area-light", "30, 50, 8");
        let before = Lights::of(&look).unwrap();
        let mut after = before.clone();
        after.far[1].radius = Some(12.0);
        assert_eq!(after.write(&before, &mut look), Some("area-light"));
        assert_eq!(look.value("area-light"), Some("30,50,12"));
        assert_eq!(after.write(&after, &mut look), None);
        // A lit sphere and lights are not together.
        make_way(&mut look, "lit-sphere");
        assert_eq!(Lights::of(&look).unwrap().count(), 0);
        let mut look = look.with("lit-sphere", "clay.png");
        after.write(&Lights::of(&look).unwrap(), &mut look);
        assert_eq!(
            (look.value("lit-sphere"), look.value("light")),
            (None, Some("135,40"))
        );
    }
}
