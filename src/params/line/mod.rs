//! The parameters of line art.

mod contours;
mod field;
mod strokes;
mod tone;

pub use contours::ContourParams;
pub(crate) use field::MAX_FIELD_PASSES;
pub use field::{Fallback, FieldParams, StrokeDirections};
pub(crate) use strokes::MAX_LEVELS;
pub use strokes::{Enlargement, Stroke, StrokeParams, StrokeScale, Style};
pub use tone::{Background, ToneParams, ToneSource};

params! {
    /// How a frame is drawn ([LA] section 6).
    pub struct LineParams in Directions {
        /// What becomes light and dark.
        tone: ToneParams;
        /// Directions of curvature that strokes follow: of the larger, around a cylinder; of the lesser, along
        /// it; both, the dark crossed by a second hatching.
        directions: StrokeDirections = StrokeDirections::Both, flag: "--directions", form: "WHICH";
        /// How those directions are made calm.
        field: FieldParams;
        /// The strokes of the hatching.
        strokes: StrokeParams;
        /// Lines along silhouettes and creases; `None` draws none.
        contours: Option<ContourParams>;
    }
}
