//! What renderers write, each in its own way, read back to the same frame.

#[path = "../common/mod.rs"]
mod common;
mod exr;
mod forced;
mod renderers;
mod truth;
