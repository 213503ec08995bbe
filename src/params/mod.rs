//! Every tunable, its meaning, unit, range and default. Nothing else types a default again.

mod light;
mod run;
mod shape;

pub use light::{Adaptive, ScalingParams};
pub use run::{RunOptions, TileSize};
pub use shape::{MAX_DIRECTION_STEP_PX, Scale, ShapeParams, SoftThreshold, Solver};
