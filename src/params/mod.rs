//! Every tunable, its meaning, unit, range and default. Nothing else types a default again.

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
pub use relight::{
    AUTO_SAMPLES, AlbedoSource, MAX_LIGHTS, Material, MaterialParams, Method, Quantisation,
    RelightParams, Samples, Tangent, WarpBy, WarpingParams,
};
pub use run::{RunOptions, TileSize};
pub use shape::{MAX_DIRECTION_STEP_PX, Scale, ShapeParams, SoftThreshold, Solver};
pub use specular::{Bend, MAX_SEARCH_STEPS, SearchParams, SpecularParams};
