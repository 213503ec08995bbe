//! What the fuzz targets run, and how command lines are altered.

pub mod mutate;
pub mod targets;
