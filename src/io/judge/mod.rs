//! What data tell of conventions: spaces, axes, encodings, kinds of depth.

pub(super) mod axes;
pub(super) mod borders;
pub(super) mod depth;
pub(super) mod integrability;
pub(super) mod map_codes;
pub(super) mod map_writers;
pub(super) mod normal_encoding;
pub mod normal_space;
pub(super) mod numbers;
pub(super) mod rims;
pub(super) mod samples_of_layers;
pub(super) mod sight_turned;
pub(super) mod silhouettes;
pub(super) mod step_fit;
pub(super) mod surface;
