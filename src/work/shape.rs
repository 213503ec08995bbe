//! `relievo shape`: the descriptor as layers, or its coloured display.

use super::{FrameSeen, FrameWork};
use crate::command::args::WorkArgs;
use crate::command::commands::ShapeArgs;
use crate::command::output::MOST_PLANES;
use crate::engine::request::Request;
use crate::error::{Result, bad};
use crate::frame::Frame;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::Inputs;
use crate::io::output::OutputKind;
use crate::io::output::layers::shape_channels;
use crate::io::output::names_of;
use crate::io::output::picture::MadePicture;
use crate::io::{Loaded, Needs};
use crate::light::lights::Illumination;
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;

impl FrameWork for ShapeArgs {
    fn args(&self) -> &WorkArgs {
        &self.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn check(&self) -> Result<()> {
        let output = &self.work.output;
        match output.kind()? {
            OutputKind::Numbers(_) if output.write.is_empty() => Err(bad(
                "-o",
                format!("holds up to {MOST_PLANES} planes, and shape makes more"),
                "choose them, as in --write curvature.mean, or write an .exr",
            )),
            OutputKind::Picture(_) => self.work.flags.refuse_more_scales(),
            _ => Ok(()),
        }
    }

    fn reading(&self, _: &Illumination) -> Result<(Inputs, Needs)> {
        let needs = Needs {
            projection: true,
            confidence: self.goes_by_rows(),
            ..Needs::default()
        };
        Ok((self.work.inputs(), needs))
    }

    fn takes_whole(&self) -> bool {
        !on_request(&self.work).is_empty()
    }

    fn goes_by_rows(&self) -> bool {
        !matches!(self.work.output.kind(), Ok(OutputKind::Picture(_)))
    }

    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>> {
        Ok(vec![plan(&self.work, self.goes_by_rows(), seen)?])
    }

    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>> {
        MadePicture::curvature(frame, outcome, &self.work.flags.params)
    }

    fn channels<'a>(
        &self,
        loaded: &'a Loaded,
        outcome: &'a Outcome,
        _: Option<&'a MadePicture>,
    ) -> Vec<OutputChannel<'a>> {
        channels(&self.work, &loaded.frame, outcome)
    }
}

/// The layers of the contract, under its names.
pub(crate) fn channels<'a>(
    work: &WorkArgs,
    frame: &'a Frame,
    outcome: &'a Outcome,
) -> Vec<OutputChannel<'a>> {
    let sample_type = work.output.depth_of_output.unwrap_or(OutputType::Half);
    shape_channels(frame, outcome, sample_type)
}

/// The plan for the shape of a frame, in layers or as the curvature display, by the settings of any command.
pub(crate) fn plan(work: &WorkArgs, in_layers: bool, seen: &FrameSeen) -> Result<Plan> {
    let and = on_request(work);
    let layers = Goal::Layers {
        and: &and,
        more_px: work.flags.more_scales(),
    };
    let goal = if in_layers { layers } else { Goal::Display };
    Request::new(goal, work.flags.params).plan(Available::in_frame(seen.frame))
}

/// Products that are made since they are named.
fn on_request(work: &WorkArgs) -> Vec<Product> {
    let on_request = Product::all().filter(|product| product.row().on_request);
    let named = on_request.filter(|product| {
        let mut names = work.output.write.iter();
        let is_named = |name: &String| {
            let mut channels = product.channels();
            channels.any(|channel| names_of(&channel).any(|own| own == name))
        };
        names.any(is_named)
    });
    named.collect()
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
