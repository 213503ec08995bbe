//! Files in the conventions of renderers, all read back to the same frame.

mod backgrounds;
mod forced;
mod layout;
mod renderers;
mod truth;
