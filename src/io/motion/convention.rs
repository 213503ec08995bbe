//! Conventions of motion: the direction of time, that of y, and the unit.

use crate::frame::Window;
use std::fmt;
use std::str::FromStr;

/// A unit of motion.
struct MotionUnit {
    /// The name that `--motion-convention` gives it.
    name: &'static str,
    /// What it is.
    said: &'static str,
    /// The number that stands for no motion.
    rest: f32,
    /// So many pixels, and so many pictures: the width along x, the height along y.
    pixels: f32,
    pictures: f32,
}

const fn unit(
    name: &'static str,
    said: &'static str,
    rest: f32,
    [pixels, pictures]: [f32; 2],
) -> MotionUnit {
    MotionUnit {
        name,
        said,
        rest,
        pixels,
        pictures,
    }
}

/// All units, the most usual first. Half a frame is how long a shutter is often open. 2048 pixels as 0..1 are those of mental
/// ray's LM_2DMV and of Nuke's and After Effects' readers of it.
static UNITS: [MotionUnit; 6] = [
    unit("pixels", "in pixels", 0.0, [1.0, 0.0]),
    unit(
        "pictures",
        "in widths and heights of the picture",
        0.0,
        [0.0, 1.0],
    ),
    unit(
        "half-pictures",
        "in half widths and heights of the picture",
        0.0,
        [0.0, 0.5],
    ),
    unit("half-frame", "in pixels over half a frame", 0.0, [2.0, 0.0]),
    unit(
        "half-pictures-0-1",
        "in half widths and heights of the picture, stored as 0..1",
        0.5,
        [0.0, 1.0],
    ),
    unit(
        "2048-0-1",
        "in 2048 pixels, stored as 0..1",
        0.5,
        [4096.0, 0.0],
    ),
];

/// How two channels hold motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MotionConvention {
    /// Whether it leads on from the frame before, instead of back to it.
    leads_ahead: bool,
    /// Whether y points up.
    y_is_up: bool,
    /// Its place among the units.
    unit: usize,
}

impl MotionConvention {
    /// Where the surface was, from where it is, in pixels, y up: of Blender's `Vector` and Nuke's `backward`.
    pub(super) const BACK: Self = Self {
        leads_ahead: false,
        y_is_up: true,
        unit: 0,
    };

    /// Every convention that motion is tried for, the most usual first.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (0..UNITS.len()).flat_map(|unit| {
            [true, false].into_iter().flat_map(move |y_is_up| {
                [false, true].map(|leads_ahead| Self {
                    leads_ahead,
                    y_is_up,
                    unit,
                })
            })
        })
    }

    /// The way back to the frame before, in pixels, y up, that `stored` means in a picture shown in `display`.
    pub(super) fn back(self, stored: [f32; 2], display: Window) -> [f32; 2] {
        let unit = &UNITS[self.unit];
        let size = [display.width() as f32, display.height() as f32];
        let pixels = size.map(|side| unit.pixels + unit.pictures * side);
        let sign = if self.leads_ahead { -1.0 } else { 1.0 };
        let up = if self.y_is_up { sign } else { -sign };
        [
            sign * pixels[0] * (stored[0] - unit.rest),
            up * pixels[1] * (stored[1] - unit.rest),
        ]
    }

    /// The value of `--motion-convention` that is read as this.
    pub(super) fn flag(self) -> String {
        let lead = if self.leads_ahead { "forward" } else { "back" };
        let y = if self.y_is_up { "up" } else { "down" };
        format!("{lead},{y},{}", UNITS[self.unit].name)
    }
}

impl FromStr for MotionConvention {
    type Err = String;

    /// Reads words with commas between, in any order; where one is left out it is that of [`Self::BACK`].
    fn from_str(text: &str) -> Result<Self, String> {
        let mut convention = Self::BACK;
        for word in text.split(',').map(str::trim) {
            match word {
                "back" => convention.leads_ahead = false,
                "forward" => convention.leads_ahead = true,
                "up" => convention.y_is_up = true,
                "down" => convention.y_is_up = false,
                "world" => {
                    return Err(
                        "motion in world space is not read: render it in pixels of the picture"
                            .into(),
                    );
                }
                unit => {
                    let named = UNITS.iter().position(|own| own.name == unit);
                    convention.unit = named.ok_or_else(|| {
                        let units = UNITS.each_ref().map(|own| own.name).join(", ");
                        format!("expected auto, or of back or forward, up or down, and a unit ({units}), as in forward,down,pixels")
                    })?;
                }
            }
        }
        Ok(convention)
    }
}

impl fmt::Display for MotionConvention {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lead = if self.leads_ahead { "on from" } else { "to" };
        let y = if self.y_is_up { "y up" } else { "y down" };
        write!(f, "{lead} the frame before, {}, {y}", UNITS[self.unit].said)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conventions_mean_pixels_back_and_up() {
        // A surface that came 8 px from the left and 6 px from below, in a picture of 400 x 200: back is (-8, -6), y up.
        let display = Window::from_size(400, 200);
        for (leads_ahead, y_is_up, unit, stored) in [
            (false, true, "pixels", [-8.0, -6.0]),
            (true, false, "pixels", [8.0, -6.0]),
            (true, true, "half-frame", [4.0, 3.0]),
            (false, true, "pictures", [-0.02, -0.03]),
            (false, false, "half-pictures", [-0.04, 0.06]),
            // -0.04 and -0.06 of -1..1 are 0.48 and 0.47 of 0..1.
            (false, true, "half-pictures-0-1", [0.48, 0.47]),
            // 8 and 6 of 2048, halved, beside 0.5.
            (true, true, "2048-0-1", [0.501_953_1, 0.501_464_8]),
        ] {
            let convention = MotionConvention {
                leads_ahead,
                y_is_up,
                unit: UNITS.iter().position(|own| own.name == unit).unwrap(),
            };
            let [x, y] = convention.back(stored, display);
            assert!(
                (x + 8.0).abs() < 1e-3 && (y + 6.0).abs() < 1e-3,
                "{convention}: {x} {y}"
            );
        }
    }

    #[test]
    fn every_convention_is_read_from_its_flag() {
        for convention in MotionConvention::all() {
            assert_eq!(convention.flag().parse(), Ok(convention));
        }
        assert_eq!("pixels".parse(), Ok(MotionConvention::BACK));
        let refused = "world".parse::<MotionConvention>().unwrap_err();
        assert!(refused.contains("render it in pixels"), "{refused}");
    }
}
