//! Every tunable, its meaning, unit, range and default. Nothing else types a default again.

mod light;
mod run;
mod shape;

pub use light::{Adaptive, Magnitudes, ScalingParams};
pub use run::{RunOptions, TileSize};
pub use shape::{MAX_DIRECTION_STEP_PX, Scale, ShapeParams, SoftThreshold, Solver};
