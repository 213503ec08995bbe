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

pub use contours::{ContourParams, ObjectLines};
pub use field::{Fallback, FieldParams, StrokeDirections};
pub use interior::InteriorParams;
pub use levels::{Levels, LineLevels, ToneLevels};
pub use object_angle::ObjectAngle;
pub use print::{Landscape, PaperSize};
pub(crate) use strokes::MM_PER_INCH;
pub use strokes::{AtEdges, Enlargement, Ink, Plotter, Stroke, StrokeParams, StrokeScale, Style};
pub use tone::{Background, ToneParams, ToneSource};

params! {
    /// Drawing of a frame ([LA] section 6).
    pub struct LineParams in Directions {
        /// Tone: light and dark in the drawing.
        tone: ToneParams;
        /// Principal directions that strokes follow: max (larger curvature, around a cylinder), min (smaller, along
        /// it), or both, crossing a second hatching in dark areas.
        directions: StrokeDirections = StrokeDirections::Both, flag: "--directions", common: true, form: "WHICH";
        /// Smoothing of stroke directions.
        field: FieldParams;
        /// Strokes of the hatching.
        strokes: StrokeParams;
        /// Lines along silhouettes and creases; `None` draws none.
        contours: Option<ContourParams>;
        /// Lines inside surfaces; `None` draws none.
        interior: Option<InteriorParams>;
        /// Draw contours and interior lines only, without strokes.
        lines_only: bool = false, flag: "--lines-only", common: true, group: Group::Contours;
    }
}
