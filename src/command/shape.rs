//! `relievo shape`: the layers it needs, and its plan.

use super::args::WorkArgs;
use super::layer_names::names_of;
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
use crate::product::Product;

/// The curvature display.
pub(crate) fn display(outcome: &Outcome) -> Picture<'_> {
    let color = outcome.color.as_ref();
    Picture {
        color: color.expect("the plan made a display"),
        alpha: None,
        grey: false,
        bits: 8,
        dpi: None,
        // The display's colours are already display-referred.
        transform: ViewTransform::None,
        display: Display::default(),
    }
}

/// Note that the gain was limited, since a greater one would show the steps of quantised normals.
pub(crate) fn held_gain(plan: &Plan, gain: Option<f32>) -> Option<String> {
    plan.holds_gain(gain).then(|| {
        format!(
            "so flat a shape asks for a gain at which normals of 8 bits show their steps: held at {:.0}; \
             a map of 16 bits has no such limit, and --curvature-gain is taken as it is given",
            plan.most_gain()
        )
    })
}

impl WorkArgs {
    /// Inputs and layers to read for the shape of a frame.
    pub(crate) fn reading(&self, goal: Goal, frame: Option<i32>) -> (Inputs, Needs) {
        let needs = Needs {
            projection: true,
            confidence: goal == Goal::Layers,
            ..Needs::default()
        };
        (self.inputs(frame), needs)
    }

    /// The plan for the shape of a frame, with choices made on the whole picture if the frame is a strip of it.
    pub(crate) fn plan(&self, goal: Goal, frame: &Frame, found: &StripChoice) -> Result<Plan> {
        let Params { shape, scaling, .. } = self.flags.params;
        let (available, scaling) = (Available::in_frame(frame), found.given(scaling));
        let more = self.flags.more_scales();
        if goal != Goal::Layers {
            return Plan::at_scales(goal, available, shape, scaling, more);
        }
        let products: Vec<_> = goal.products().chain(self.asked()).collect();
        Plan::of_products(&products, available, shape, scaling, more)
    }

    /// Products that are made since they are named.
    fn asked(&self) -> impl Iterator<Item = Product> {
        let on_request = Product::all().filter(|product| product.row().on_request);
        on_request.filter(|product| {
            let mut names = self.output.write.iter();
            let is_named = |name: &String| {
                let mut channels = product.channels();
                channels.any(|channel| names_of(&channel).any(|own| own == name))
            };
            names.any(is_named)
        })
    }

    /// Refuses a picture that goes in strips with results that take the whole of it.
    pub(crate) fn takes_whole(&self) -> bool {
        self.asked().next().is_some()
    }

    /// The result, by the kind of output: layers or a display.
    pub(crate) fn goal(&self) -> Result<Goal> {
        Ok(match self.output.kind()? {
            Kind::Exr | Kind::Numbers(_) => Goal::Layers,
            Kind::Picture(_) => Goal::Display,
        })
    }
}
