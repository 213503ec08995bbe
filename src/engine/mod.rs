//! Engines: run requests and plans on frames.

pub(crate) mod backends;
pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
mod in_strips;
pub(crate) mod inputs;
mod outcome;
pub(crate) mod part;
pub(crate) mod request;
pub(crate) mod run;
pub(crate) mod session;
pub(crate) mod strip_search;
pub(crate) mod target;
pub(crate) mod tiles;
pub(crate) mod tolerances;

pub use crate::engine::backends::Engine;
pub use crate::engine::inputs::PlanInputs;
pub use crate::engine::request::Request;
pub use crate::engine::run::Run;
pub use crate::engine::session::Session;
pub use crate::engine::target::Target;
pub use crate::kernel::cancel::CancelToken;
pub use crate::plan::drawing::Drawing;
pub use crate::plan::drawing::{SequenceInputs, TextureCoordinates};
pub use crate::plan::outcome::{Outcome, ScaleShape, Shape};
pub use crate::plan::watch::Progress;
