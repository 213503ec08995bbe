//! The camera: read from a file, or recovered from a layer of world-space positions, or as far as that
//! goes from depth and world-space normals.

mod depth_fit;
mod depth_lens;
mod depth_samples;
mod file;
mod from_depth;
mod hypotheses;
mod model;
mod recover;
mod samples;

pub use file::read_camera;
pub use from_depth::{DepthCamera, recover_camera_from_depth};
pub use recover::{RecoveredCamera, RecoveryFailure, recover_camera};
