//! The parameters of line art.

use crate::params::Group;

#[macro_use]
mod on_off;
mod contours;
mod field;
mod interior;
mod levels;
mod object_angle;
mod print;
mod strokes;
mod tone;

pub use contours::ContourParams;
pub(crate) use field::MAX_FIELD_PASSES;
pub use field::{Fallback, FieldParams, StrokeDirections};
pub use interior::InteriorParams;
pub use levels::{Levels, LineLevels, ToneLevels};
pub use object_angle::ObjectAngle;
pub use print::PaperSize;
pub use strokes::{AtEdges, Enlargement, Ink, Plotter, Stroke, StrokeParams, StrokeScale, Style};
pub(crate) use strokes::{MAX_LEVELS, MM_PER_INCH};
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
        /// Lines inside surfaces; `None` draws none.
        interior: Option<InteriorParams>;
        /// A drawing of contours and interior lines alone, without strokes.
        lines_only: bool = false, flag: "--lines-only", group: Group::Contours;
    }
}
