//! What mends stored samples: missing depth, rounded and noisy normals, and pixels that mix several surfaces.

mod confidence;
mod holes;
mod noise;
mod noise_left;
pub(super) mod squares;
mod tiled;
mod unrounded;

#[cfg(feature = "cli")]
pub(crate) use confidence::CONFIDENCE_REACH;
pub(crate) use confidence::{confidence, lift_out_of_fog};
#[cfg(feature = "cli")]
pub(crate) use holes::HOLE_REACH;
pub(super) use holes::fill;
pub(crate) use noise::{DENOISING_REACH, denoise};
pub(crate) use noise_left::noise_left;
pub(super) use unrounded::unround_values;
pub(crate) use unrounded::{UNROUNDING_PHASE, UNROUNDING_REACH, unround, unround_wrapped};
