//! The fuzz targets, and the mutation of command lines.

pub mod mutate;
pub mod targets;
