//! Every tunable, its meaning, unit, range and default. Nothing else types a default again.

mod light;
mod shape;

pub use light::{CurvatureGain, ScalingParams, WhiteLevel};
pub use shape::{ShapeParams, SoftThreshold};
