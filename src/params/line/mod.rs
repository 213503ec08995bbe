//! What line art can be told.

mod contours;
mod field;
mod strokes;
mod tone;

pub use contours::ContourParams;
pub use field::{Fallback, FieldParams, MAX_FIELD_PASSES, StrokeDirections};
pub use strokes::{MAX_LEVELS, Stroke, StrokeParams, StrokeScale, Style};
pub use tone::ToneParams;

use crate::error::Result;
use serde::Serialize;

/// How a frame is drawn ([LA] section 6).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LineParams {
    /// Which directions of curvature strokes follow.
    pub directions: StrokeDirections,
    /// How those directions are made calm.
    pub field: FieldParams,
    /// The strokes of the hatching.
    pub strokes: StrokeParams,
    /// What becomes light and dark.
    pub tone: ToneParams,
    /// Lines along silhouettes and creases; `None` draws none.
    pub contours: Option<ContourParams>,
}

impl Default for LineParams {
    fn default() -> Self {
        Self {
            directions: StrokeDirections::default(),
            field: FieldParams::default(),
            strokes: StrokeParams::default(),
            tone: ToneParams::default(),
            contours: Some(ContourParams::default()),
        }
    }
}

impl LineParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        self.field.validate()?;
        self.strokes.validate()?;
        self.tone.validate()?;
        self.contours.map_or(Ok(()), |contours| contours.validate())
    }
}
