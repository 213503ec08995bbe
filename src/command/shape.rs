//! `relievo shape`: the layers it needs, and its plan.

use super::args::WorkArgs;
use super::output::Kind;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::error::Result;
use crate::frame::Frame;
use crate::io::Needs;
use crate::io::inputs::Inputs;
use crate::io::picture::{Display, Picture, ViewTransform};
use crate::params::Params;
use crate::plan::{Available, Goal, Plan};

/// The curvature display.
pub(crate) fn display(outcome: &Outcome) -> Picture<'_> {
    let color = outcome.color.as_ref();
    Picture {
        color: color.expect("the plan made a display"),
        alpha: None,
        grey: false,
        bits: 8,
        dpi: None,
        // The display's colours are meant for the screen as they are.
        transform: ViewTransform::None,
        display: Display::default(),
    }
}

impl WorkArgs {
    /// What is read of a frame whose shape is looked for.
    pub(crate) fn reading(&self, goal: Goal, frame: Option<i32>) -> (Inputs, Needs) {
        let needs = Needs {
            projection: self.flags.params.shape.foreshortening != 0.0 || goal == Goal::Layers,
            confidence: goal == Goal::Layers,
            ..Needs::default()
        };
        (self.inputs(frame), needs)
    }

    /// The plan for the shape in a frame, with what was found in the whole of which it is a strip.
    pub(crate) fn plan(&self, goal: Goal, frame: &Frame, found: &StripChoice) -> Result<Plan> {
        let Params { shape, scaling, .. } = self.flags.params;
        let (available, scaling) = (Available::in_frame(frame), found.given(scaling));
        Plan::at_scales(goal, available, shape, scaling, self.flags.more_scales())
    }

    /// What is made: layers or a display, as the output has it.
    pub(crate) fn goal(&self) -> Result<Goal> {
        Ok(match self.output.kind()? {
            Kind::Exr => Goal::Layers,
            Kind::Picture(_) => Goal::Display,
        })
    }
}
