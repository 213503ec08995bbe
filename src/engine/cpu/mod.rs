//! The CPU backend: rows in parallel by rayon, the same bits for any number of threads.

#[cfg(feature = "cli")]
pub(crate) mod row_layers;
pub(crate) mod runner;

pub(crate) use crate::plan::execution::Runner;

/// Runs a plan without inputs beside `frame`, in the caller's rayon pool.
#[cfg(all(test, feature = "gpu"))]
pub(crate) fn run(
    plan: &crate::plan::Plan,
    frame: &crate::frame::Frame,
) -> crate::Result<crate::engine::Outcome> {
    Runner::default().execute(plan, frame, crate::engine::PlanInputs::default())
}
