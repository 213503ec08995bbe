//! What renderers write, each in its own way, read back to the same frame.

mod backgrounds;
mod forced;
mod layout;
mod renderers;
mod truth;
