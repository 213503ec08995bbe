//! Plans: which stages run, in what order, and why. They follow from the products wanted and the inputs present. A plan
//! touches no pixel.

pub(crate) mod available;
pub(crate) mod goal;
pub(crate) mod planned;
pub(crate) mod stage;

pub use crate::light::enhancement::LightAvailable;
pub(crate) use crate::light::relight::setting::{Albedo, EnvironmentUse, Relighting, ToError};
pub use crate::plan::available::Available;
pub use crate::plan::goal::{Goal, Tone};
pub use crate::plan::planned::{Decision, Plan, Points};
