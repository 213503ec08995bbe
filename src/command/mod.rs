//! Arguments and recipes, and the plans they make for a frame.

pub(crate) mod args;
pub(crate) mod axes;
pub(crate) mod batch;
pub(crate) mod chosen;
pub(crate) mod commands;
pub(crate) mod enhance;
pub(crate) mod error_line;
pub(crate) mod flags;
pub(crate) mod frames_there;
pub(crate) mod grid;
pub(crate) mod hatch;
pub(crate) mod invocation;
pub(crate) mod layer_names;
mod light_layers;
pub(crate) mod line_args;
#[cfg(feature = "view")]
pub(crate) mod look;
pub(crate) mod making;
pub(crate) mod map;
pub(crate) mod memory;
mod motion_arg;
pub(crate) mod output;
pub(crate) mod reading;
mod rec709;
pub mod recipe;
pub(crate) mod relight;
pub(crate) mod relight_args;
pub(crate) mod role_args;
pub(crate) mod sequence;
#[cfg(any(feature = "view", feature = "host"))]
// Public where the feature `host` exports it.
#[cfg_attr(
    not(feature = "host"),
    allow(unreachable_pub, reason = "the host alone exports it")
)]
pub(crate) mod setting;
pub(crate) mod shape;
mod specular_args;
mod still_camera;
