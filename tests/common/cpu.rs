//! Plans run on the CPU.

use relievo::Result;
use relievo::engine::{Engine, Inputs, Outcome, Run};
use relievo::frame::Frame;
use relievo::plan::Plan;

/// Runs a plan with no inputs beside `frame`.
pub fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    execute(plan, frame, Inputs::default())
}

/// Runs a plan with its `inputs` beside `frame`.
pub fn execute(plan: &Plan, frame: &Frame, inputs: Inputs) -> Result<Outcome> {
    Engine::cpu().execute(plan, frame, inputs, &Run::new())
}
