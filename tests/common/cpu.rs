//! Plans run on the CPU.

use relievo::Result;
use relievo::engine::{Drawing, Engine, Outcome, PlanInputs, Run};
use relievo::frame::Frame;
use relievo::params::{LineParams, ScalingParams, ShapeParams};
use relievo::plan::{Available, Goal, Plan, Tone};

/// Runs a plan with no inputs beside `frame`.
pub fn run(plan: &Plan, frame: &Frame) -> Result<Outcome> {
    execute(plan, frame, PlanInputs::default())
}

/// Runs a plan with its `inputs` beside `frame`.
pub fn execute(plan: &Plan, frame: &Frame, inputs: PlanInputs) -> Result<Outcome> {
    Engine::cpu().execute(plan, frame, inputs, &Run::new())
}

/// A plan for a goal that takes nothing but the frame, with the defaults of scaling.
pub fn plan(goal: Goal, frame: &Frame, shape: ShapeParams) -> Result<Plan> {
    let available = Available::in_frame(frame);
    Plan::new(goal, available, shape, ScalingParams::default())
}

/// All layers of a frame's shape.
pub fn described(frame: &Frame, shape: ShapeParams) -> Outcome {
    run(&plan(Goal::LAYERS, frame, shape).unwrap(), frame).unwrap()
}

/// A drawing of a frame.
pub fn drawn(frame: &Frame, tone: Tone, line: LineParams) -> Drawing {
    let plan = plan(Goal::Hatch(tone, line), frame, ShapeParams::default());
    let outcome = run(&plan.unwrap(), frame).unwrap();
    outcome.drawing.expect("a drawing was asked for")
}
