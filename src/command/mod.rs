//! Arguments and recipes.

pub(crate) mod args;
pub(crate) mod axes;
pub(crate) mod batch;
pub(crate) mod chosen;
pub(crate) mod commands;
pub(crate) mod error_line;
pub(crate) mod flags;
pub(crate) mod frames_there;
pub(crate) mod grid;
pub(crate) mod invocation;
mod light_layers;
pub(crate) mod line_args;
pub(crate) mod map;
pub(crate) mod memory;
pub(crate) mod motion_arg;
pub(crate) mod named;
pub(crate) mod output;
pub mod recipe;
pub(crate) mod relight_args;
pub(crate) mod role_args;
pub(crate) mod sequence;
// Public where the feature `host` exports it.
#[cfg_attr(
    not(feature = "host"),
    allow(unreachable_pub, reason = "the host alone exports it")
)]
pub(crate) mod setting;
mod still_camera;
