//! Plans: which stages run, in what order, and why. They follow from the products wanted and the inputs present. A plan
//! touches no pixel. Beside it stands what a run hands to the stages of a plan, and what it gets back.

pub(crate) mod available;
pub(crate) mod drawing;
pub(crate) mod execution;
pub(crate) mod frame_cache;
pub(crate) mod goal;
pub(crate) mod outcome;
pub(crate) mod planned;
#[cfg(feature = "gpu")]
pub(crate) mod recording;
pub(crate) mod search;
pub(crate) mod stage;
pub(crate) mod watch;

pub use crate::plan::available::{Available, LightAvailable};
pub use crate::plan::goal::{Goal, Tone};
pub use crate::plan::planned::{Decision, Plan, Points};
