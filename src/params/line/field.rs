//! The parameters of stroke directions.

use crate::params::range::ANGLES_DEG;
use crate::params::table::{Unit, even};

params! {
    /// How the field of stroke directions is made ([LA] section 6.1).
    pub struct FieldParams in Directions {
        /// Where strokes go that curvature does not lead, on planes and balls: degrees in the picture, or
        /// surface for an upright direction on it.
        ///
        /// By default from the lower left to the upper right, as a right hand draws.
        fallback: Fallback = Fallback::Angle(45.0),
            flag: "--fallback", form: "DEG|surface", unit: Unit::Degrees, valid: ANGLES_DEG;
        /// How often directions are averaged with those around them: more make calmer strokes.
        ///
        /// More give longer strokes and lose small forms; 0 shows every facet.
        passes: u32 = 3,
            flag: "--passes", alias: Some("field-passes"), form: "N",
            valid: 0.0..=MAX_FIELD_PASSES as f32, useful: even(0.0, MAX_FIELD_PASSES as f64);
        /// How far around, in pixels of a quarter of the picture's size.
        ///
        /// The pixels that one pass averages over lie no farther away; their weight falls linearly to 0 there. In
        /// perspective it holds at the median depth, and goes with the inverse of depth, so that what is far keeps its
        /// small forms. With a [reference height](crate::params::ShapeParams::reference_height) it counts pixels of the
        /// reference.
        radius_px: f32 = 6.0,
            flag: "--smoothing", alias: Some("field-radius"), form: "PX", unit: Unit::Pixels, valid: 1.0..=64.0, useful: even(1.0, 16.0);
        /// Pixels of the picture along the side of one pixel of the field.
        ///
        /// 4 makes it of a quarter of the picture's size. Less takes longer; the radius stays what it is in the picture.
        cell_px: u32 = 4, unit: Unit::Pixels, valid: 1.0..=8.0;
    }
}

number_or_word! {
    /// The direction of strokes where curvature gives none: on planes, and on balls.
    pub enum Fallback {
        /// The first of the axes x, y, z of the view that is not along the normal, crossed with it ([LA]
        /// section 4.2): upright where sight lines are parallel.
        Surface = "surface",
        /// This one in the picture, in degrees, counterclockwise from the right.
        Angle(f32),
    }
    whole: false,
    numbers: |degrees| degrees.is_finite(),
    expected: "expected surface or an angle in degrees",
}

choices! {
    /// Which of the two directions of curvature strokes follow.
    pub enum StrokeDirections {
        /// That of the curvature larger in size: around a cylinder.
        Max = "max",
        /// That of the lesser one: along it.
        Min = "min",
        /// One after the other: hatching across hatching.
        Both = "both",
    }
}

/// The most passes over a field of directions.
pub(crate) const MAX_FIELD_PASSES: u32 = 6;

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
