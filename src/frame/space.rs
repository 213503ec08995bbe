//! Spaces, and the camera that relates them.
//!
//! View space has x right, y up and z toward the viewer; picture coordinates have x right and y
//! down, pixel edges at integers, so the centre of the first pixel is (0.5, 0.5).

use super::Window;
use crate::error::short;
use glam::{DAffine3, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// The space a normal map is stored in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalSpace {
    /// x right, y up, z toward the viewer.
    View,
    /// The scene's own axes; transforming to view space needs a camera.
    World,
    /// View space turned to each pixel's own sight line, as V-Ray writes it: z toward the eye, or away from it where a
    /// surface is seen from behind. Transforming to view space needs a camera.
    Sight,
}

impl NormalSpace {
    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::View => "view",
            Self::World => "world",
            Self::Sight => "sight",
        }
    }
}

/// The kind of a frame's depth.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DepthKind {
    /// Distance along the view axis.
    #[default]
    Planar,
    /// Distance along the sight line, from the eye.
    Ray,
    /// A value that varies with distance, or distance too coarse for positions: it shows where depth jumps, not where
    /// the surface is.
    Relative,
}

impl std::fmt::Display for DepthKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planar => "depth along the view axis",
            Self::Ray => "depth along the sight line",
            Self::Relative => "relative depth",
        })
    }
}

/// Projection of view space onto the picture, in pixels of the display window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", tag = "type")]
pub enum Projection {
    /// All sight lines meet in the eye.
    Perspective {
        /// Focal length in pixel widths.
        fx: f64,
        /// Focal length in pixel heights.
        fy: f64,
        /// Column of the principal point.
        cx: f64,
        /// Row of the principal point.
        cy: f64,
    },
    /// All sight lines are parallel.
    Orthographic {
        /// Pixel widths per unit of length.
        sx: f64,
        /// Pixel heights per unit of length.
        sy: f64,
        /// Column of the view axis.
        cx: f64,
        /// Row of the view axis.
        cy: f64,
    },
}

impl Projection {
    /// That of parallel sight lines or of those through an eye, with so many pixels per unit of length or of slope along x
    /// and y, and this view axis.
    pub(crate) fn new(are_parallel: bool, [x, y]: [f64; 2], axis: DVec2) -> Self {
        let DVec2 { x: cx, y: cy } = axis;
        let (sx, sy, fx, fy) = (x, y, x, y);
        match are_parallel {
            true => Self::Orthographic { sx, sy, cx, cy },
            false => Self::Perspective { fx, fy, cx, cy },
        }
    }
}

/// The pose of the viewer and the projection of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// World to view space: a rotation and a translation, without scale; mirrored for left-handed worlds.
    pub view_from_world: DAffine3,
    /// View space to pixels.
    pub projection: Projection,
}

/// Focal lengths in pixels. With `PRINCIPAL_PX` they keep slopes of sight lines below 1e9 and 1e9 times the size of a
/// picture: fourth powers fit single precision.
pub(crate) const FOCAL_PX: RangeInclusive<f64> = 0.01..=1e9;
/// Pixels per unit of length of parallel projections: from pictures of stars to pictures of atoms.
pub(crate) const PIXELS_PER_UNIT: RangeInclusive<f64> = 1e-6..=1e9;
/// Largest distance of the view axis from the corner of the display window, in pixels.
pub(crate) const PRINCIPAL_PX: f64 = 1e7;
/// Largest distance of the eye from the world's origin along an axis, in scene units; depths end at 1e9.
pub(crate) const PLACE: f64 = 1e12;

/// A camera parameter outside the range that stages can handle in single precision.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{}; {}", self.found(), self.remedy())]
pub struct OutOfRange {
    name: &'static str,
    unit: &'static str,
    value: f64,
    least: f64,
    most: f64,
}

impl OutOfRange {
    /// The parameter and its value.
    pub fn found(&self) -> String {
        format!("its {} is {}{}", self.name, short(self.value), self.unit)
    }

    /// Its range.
    pub fn remedy(&self) -> String {
        format!("give {} to {}", short(self.least), short(self.most))
    }
}

/// Refuses a `value` outside `range`.
fn check(
    name: &'static str,
    value: f64,
    unit: &'static str,
    range: &RangeInclusive<f64>,
) -> Result<(), OutOfRange> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(OutOfRange {
        name,
        unit,
        value,
        least: *range.start(),
        most: *range.end(),
    })
}

/// Refuses a world-space position too far from the origin.
///
/// # Errors
/// [`OutOfRange`] naming the first coordinate beyond `PLACE`.
pub(crate) fn check_place(place: DVec3) -> Result<(), OutOfRange> {
    let mut coordinates = place.to_array().into_iter();
    coordinates.try_for_each(|at| check("distance from the origin", at, "", &(-PLACE..=PLACE)))
}

impl Camera {
    /// Refuses parameters beyond the stages' single precision: those outside `FOCAL_PX`, `PIXELS_PER_UNIT`,
    /// `PRINCIPAL_PX` and `PLACE`.
    ///
    /// # Errors
    /// [`OutOfRange`] naming the first one.
    pub fn check(&self, display: Window) -> Result<(), OutOfRange> {
        let (name, unit, scales, range, [cx, cy]) = match self.projection {
            Projection::Perspective { fx, fy, cx, cy } => {
                ("focal length", " px", [fx, fy], FOCAL_PX, [cx, cy])
            }
            Projection::Orthographic { sx, sy, cx, cy } => {
                let name = "number of pixels per unit";
                (name, "", [sx, sy], PIXELS_PER_UNIT, [cx, cy])
            }
        };
        for scale in scales {
            // Recovered cameras may have an axis of negative scale.
            check(name, scale.abs(), unit, &range)?;
        }
        for offset in [cx - f64::from(display.x0), cy - f64::from(display.y0)] {
            check(
                "principal point",
                offset,
                " px",
                &(-PRINCIPAL_PX..=PRINCIPAL_PX),
            )?;
        }
        check_place(self.view_from_world.translation)
    }

    /// The picture position of a world-space point; `None` at or behind the eye.
    pub fn pixel_of(&self, world: DVec3) -> Option<DVec2> {
        self.projection
            .pixel_of(self.view_from_world.transform_point3(world))
    }
}

impl Projection {
    /// The picture position of a view-space point; `None` at or behind the eye.
    pub fn pixel_of(&self, view: DVec3) -> Option<DVec2> {
        match *self {
            Self::Perspective { fx, fy, cx, cy } => (view.z < 0.0)
                .then(|| DVec2::new(cx - fx * view.x / view.z, cy + fy * view.y / view.z)),
            Self::Orthographic { sx, sy, cx, cy } => {
                Some(DVec2::new(cx + sx * view.x, cy - sy * view.y))
            }
        }
    }

    /// The direction to the eye from the surface seen at picture position (`x`, `y`), scaled to z = 1; only x and y are
    /// returned. Zero for an orthographic camera.
    pub fn to_eye(&self, x: f64, y: f64) -> DVec2 {
        match *self {
            // A view ray is (X, Y, -1) with X = (x - cx)/fx and Y = (cy - y)/fy; the eye lies in the opposite
            // direction.
            Self::Perspective { fx, fy, cx, cy } => DVec2::new((cx - x) / fx, (y - cy) / fy),
            Self::Orthographic { .. } => DVec2::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_past_single_precision_are_refused() {
        let display = Window::at(-1_000_000_000, 0, 640, 480);
        let good = Camera {
            view_from_world: DAffine3::IDENTITY,
            projection: Projection::Perspective {
                fx: 0.01,
                fy: 1e9,
                cx: -1e9 + 320.0,
                cy: -1e7,
            },
        };
        assert_eq!(good.check(display), Ok(()));
        let with = |change: fn(&mut f64, &mut f64, &mut f64)| {
            let mut camera = good;
            let Projection::Perspective { fx, cy, .. } = &mut camera.projection else {
                unreachable!()
            };
            change(fx, cy, &mut camera.view_from_world.translation.z);
            camera.check(display).unwrap_err().to_string()
        };
        for (said, expected) in [
            (
                with(|f, _, _| *f = 1e-300),
                "its focal length is 1e-300 px; give 0.01 to 1e9",
            ),
            (
                with(|f, _, _| *f = f64::NAN),
                "its focal length is NaN px; give 0.01 to 1e9",
            ),
            (
                with(|_, c, _| *c = 1e300),
                "its principal point is 1e300 px; give -1e7 to 1e7",
            ),
            (
                with(|_, _, z| *z = -2e12),
                "its distance from the origin is -2e12; give -1e12 to 1e12",
            ),
        ] {
            assert_eq!(said, expected);
        }
        let parallel = Projection::Orthographic {
            sx: 1.0,
            sy: 1e-30,
            cx: -1e9,
            cy: 0.0,
        };
        let parallel = Camera {
            projection: parallel,
            ..good
        };
        let said = parallel.check(display).unwrap_err().to_string();
        assert_eq!(
            said,
            "its number of pixels per unit is 1e-30; give 1e-6 to 1e9"
        );
    }
}
