//! What line art can be told.

mod field;
mod strokes;
mod tone;

pub use field::{Fallback, FieldParams, MAX_FIELD_PASSES, StrokeDirections};
pub use strokes::{MAX_LEVELS, Stroke, StrokeParams, StrokeScale, Style};
pub use tone::ToneParams;

use crate::error::{Error, Result};
use serde::Serialize;

/// How a frame is drawn ([LA] section 6).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct LineParams {
    /// Which directions of curvature strokes follow.
    pub directions: StrokeDirections,
    /// How those directions are made calm.
    pub field: FieldParams,
    /// The strokes of the hatching.
    pub strokes: StrokeParams,
    /// What becomes light and dark.
    pub tone: ToneParams,
}

impl LineParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        self.field.validate()?;
        self.strokes.validate()?;
        self.tone.validate()
    }
}

/// Refuses `value` unless it lies in `range`.
fn in_range(name: &'static str, value: f32, range: std::ops::RangeInclusive<f32>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(Error::BadParameter {
        name,
        found: format!("is {value}"),
        remedy: format!("give {} to {}", range.start(), range.end()),
    })
}
