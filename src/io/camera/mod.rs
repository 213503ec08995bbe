//! The camera: read from a file, or recovered from a layer of world-space positions.

mod file;
mod hypotheses;
mod model;
mod recover;
mod samples;

pub use file::read_camera;
pub use recover::{RecoveredCamera, RecoveryFailure, recover_camera};

#[cfg(test)]
mod scenes;
