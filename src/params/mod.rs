//! Every tunable, its meaning, unit, range and default. Nothing else types a default again.

use crate::error::{Error, Result, short};
use std::ops::RangeInclusive;

mod light;
mod line;
mod relight;
mod run;
mod shape;
mod specular;

pub use light::{Adaptive, Magnitudes, ScalingParams, TERMS, TermWhiteLevel, TermWhiteLevels};
pub use line::{
    ContourParams, Fallback, FieldParams, LineParams, MAX_FIELD_PASSES, MAX_LEVELS, Stroke,
    StrokeDirections, StrokeParams, StrokeScale, Style, ToneParams,
};
pub(crate) use relight::ANGLES_DEG;
pub use relight::{
    AUTO_SAMPLES, AlbedoSource, MAX_LIGHTS, Material, MaterialParams, Method, Quantisation,
    RelightParams, Samples, Tangent, WarpBy, WarpingParams,
};
pub use run::{RunOptions, TileSize};
pub(crate) use shape::check_scales;
pub use shape::{MAX_DIRECTION_STEP_PX, MAX_SCALES, Scale, ShapeParams, SoftThreshold, Solver};
pub use specular::{Bend, MAX_SEARCH_STEPS, SearchParams, SpecularParams};

/// Refuses a `value` of the parameter `name` unless it lies in `range`.
///
/// # Errors
/// [`Error::BadParameter`] telling the range.
pub(crate) fn in_range(name: &'static str, value: f32, range: RangeInclusive<f32>) -> Result<()> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(Error::BadParameter {
        name,
        found: format!("is {}", short(value)),
        remedy: format!("give {} to {}", short(*range.start()), short(*range.end())),
    })
}
