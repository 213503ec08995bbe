//! Files to frames, and planes to files.

pub mod exr;
mod fence;
pub mod output;
pub mod photo;
