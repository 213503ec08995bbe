//! What renderers write, each in its own way, read back to the same frame.

mod backgrounds;
#[path = "../common/mod.rs"]
mod common;
mod exr;
mod forced;
mod layout;
mod renderers;
mod truth;
