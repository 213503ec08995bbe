//! Files to frames, and planes to files.

pub mod camera;
pub mod normal_space;
