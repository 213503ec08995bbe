//! The camera: read from a file or from attributes, or recovered from a layer of world-space positions or, except for
//! its position, from depth and world-space normals.

mod attributes;
mod depth_fit;
mod depth_lens;
mod depth_samples;
mod file;
mod find;
mod from_depth;
mod hypotheses;
mod model;
mod panorama;
mod recover;
mod samples;

#[cfg(feature = "host")]
pub(crate) use file::camera_of_text;
pub use file::read_camera;
pub(crate) use file::read_pose;
pub(super) use find::{CAMERA, CameraSearch, FoundCamera};
pub use from_depth::{DepthCamera, recover_camera_from_depth};
pub(crate) use panorama::{PanoramaPose, recover_panorama};
pub use recover::{RecoveredCamera, RecoveryFailure, recover_camera};
pub(super) use samples::median;
