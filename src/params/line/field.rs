//! What the directions of strokes can be told.

use crate::error::{Error, Result};
use crate::params::{ANGLES_DEG, in_range};
use serde::Serialize;

/// How the field of stroke directions is made ([LA] section 6.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FieldParams {
    /// How often directions are averaged with those around them, 0 to [`MAX_FIELD_PASSES`]. More passes
    /// give longer and calmer strokes and lose small forms; 0 shows every facet.
    pub passes: u32,
    /// How far away the pixels lie that one pass averages over, in pixels of a field of a quarter of the
    /// picture's size, 1 to 64; the weight falls linearly to 0 there. In perspective it holds at the
    /// median depth, and goes with the inverse of depth, so that what is far keeps its small forms. With a
    /// [reference height](crate::params::ShapeParams::reference_height) it counts pixels of the reference.
    pub radius_px: f32,
    /// Where strokes go that curvature does not lead.
    pub fallback: Fallback,
    /// Pixels of the picture along the side of one pixel of the field, 1 to 8: 4 makes it of a quarter of
    /// the picture's size. Less takes longer; the radius stays what it is in the picture.
    pub cell_px: u32,
}

/// The direction of strokes where curvature tells none: on planes, and on balls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Fallback {
    /// This one in the picture, in degrees, counterclockwise from the right.
    Angle(f32),
    /// The first of the axes x, y, z of the view that is not along the normal, crossed with it ([LA]
    /// section 4.2): upright where sight lines are parallel.
    Surface,
}

impl std::fmt::Display for Fallback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Angle(degrees) => write!(f, "{degrees}"),
            Self::Surface => f.write_str("surface"),
        }
    }
}

impl std::str::FromStr for Fallback {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let angle = || text.parse().ok().filter(|v: &f32| v.is_finite());
        match text {
            "surface" => Ok(Self::Surface),
            _ => angle()
                .map(Self::Angle)
                .ok_or("expected surface or an angle in degrees".into()),
        }
    }
}

/// Which of the two directions of curvature strokes follow.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StrokeDirections {
    /// That of the curvature larger in size: around a cylinder.
    #[default]
    Max,
    /// That of the lesser one: along it.
    Min,
    /// One after the other: hatching across hatching.
    Both,
}

/// The most passes over a field of directions.
pub const MAX_FIELD_PASSES: u32 = 6;

impl Default for FieldParams {
    /// Strokes from the lower left to the upper right where nothing leads them, as a right hand draws.
    fn default() -> Self {
        Self {
            passes: 3,
            radius_px: 6.0,
            fallback: Fallback::Angle(45.0),
            cell_px: 4,
        }
    }
}

impl FieldParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let bad = |name, found: String, remedy: &str| {
            Err(Error::BadParameter {
                name,
                found,
                remedy: remedy.into(),
            })
        };
        if self.passes > MAX_FIELD_PASSES {
            return bad("--passes", format!("is {}", self.passes), "give 0 to 6");
        }
        if !(1.0..=64.0).contains(&self.radius_px) {
            return bad(
                "--smoothing",
                format!("is {} px", self.radius_px),
                "give 1 to 64 pixels",
            );
        }
        if let Fallback::Angle(degrees) = self.fallback {
            in_range("--fallback", degrees, ANGLES_DEG)?;
        }
        if !(1..=8).contains(&self.cell_px) {
            return bad(
                "cell_px",
                format!("is {}", self.cell_px),
                "give 1 to 8 pixels",
            );
        }
        Ok(())
    }
}

impl StrokeDirections {
    /// Whether strokes follow the larger curvature, and the lesser one.
    pub fn wanted(self) -> [bool; 2] {
        match self {
            Self::Max => [true, false],
            Self::Min => [false, true],
            Self::Both => [true, true],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_refused() {
        let good = FieldParams::default();
        good.validate().unwrap();
        let bad = [
            FieldParams { passes: 7, ..good },
            FieldParams {
                radius_px: 0.0,
                ..good
            },
            FieldParams {
                radius_px: f32::NAN,
                ..good
            },
            FieldParams { cell_px: 0, ..good },
            FieldParams {
                fallback: Fallback::Angle(f32::INFINITY),
                ..good
            },
        ];
        for params in bad {
            assert!(params.validate().is_err(), "{params:?}");
        }
        FieldParams { passes: 0, ..good }.validate().unwrap();
    }
}
