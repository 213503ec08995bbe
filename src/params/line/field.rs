//! The parameters of stroke directions.

use crate::params::range::ANGLES_DEG;
use crate::params::table::{Unit, even};

params! {
    /// Smoothing of the field of stroke directions ([LA] section 6.1).
    pub struct FieldParams in Directions {
        /// Stroke direction where curvature gives none, on planes and balls: degrees in the picture, or surface for an
        /// upright direction on it.
        ///
        /// By default from the lower left to the upper right, as a right hand draws.
        fallback: Fallback = Fallback::Angle(45.0),
            flag: "--fallback", form: "DEG|surface", unit: Unit::Degrees, valid: ANGLES_DEG;
        /// Number of smoothing passes over the directions: more make calmer strokes.
        ///
        /// More passes give longer strokes and lose small forms; 0 shows every facet.
        passes: u32 = 3,
            flag: "--passes", alias: Some("field-passes"), form: "N",
            valid: 0.0..=MAX_FIELD_PASSES as f32, useful: even(0.0, MAX_FIELD_PASSES as f64);
        /// Radius of the smoothing, in pixels of a quarter of the picture's size.
        ///
        /// Each pass averages over pixels within this radius, with weights falling linearly to 0 at its rim. In
        /// perspective the radius holds at the median depth and scales with the inverse of depth, so that distant
        /// objects keep their small forms. With a [reference height](crate::params::ShapeParams::reference_height) it
        /// is in pixels of the reference.
        radius_px: f32 = 6.0,
            flag: "--smoothing", alias: Some("field-radius"), form: "PX", unit: Unit::Pixels, valid: 1.0..=64.0, useful: even(1.0, 16.0);
        /// Size of a cell of the direction field, in pixels of the picture.
        ///
        /// 4 gives a field of a quarter of the picture's size. Smaller cells take longer; the radius in the picture
        /// stays the same.
        cell_px: u32 = 4, unit: Unit::Pixels, valid: 1.0..=8.0;
    }
}

number_or_word! {
    /// The stroke direction where curvature gives none: on planes and balls.
    pub enum Fallback {
        /// The cross product of the normal with the first of the view axes x, y, z that is not along it ([LA] section
        /// 4.2): upright where sight lines are parallel.
        Surface = "surface",
        /// A fixed direction in the picture, in degrees counterclockwise from the right.
        Angle(f32),
    }
    whole: false,
    numbers: |degrees| degrees.is_finite(),
    expected: "expected surface or an angle in degrees",
}

choices! {
    /// The principal direction that strokes follow.
    pub enum StrokeDirections {
        /// The direction of the larger curvature by magnitude: around a cylinder.
        Max = "max",
        /// The direction of the smaller curvature: along a cylinder.
        Min = "min",
        /// Both, one hatching over the other.
        Both = "both",
    }
}

/// Maximum number of passes over a field of directions.
pub(crate) const MAX_FIELD_PASSES: u32 = 6;

impl StrokeDirections {
    /// Whether strokes follow the larger curvature, and the smaller.
    pub fn wanted(self) -> [bool; 2] {
        match self {
            Self::Max => [true, false],
            Self::Min => [false, true],
            Self::Both => [true, true],
        }
    }
}
