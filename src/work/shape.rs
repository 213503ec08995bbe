//! `relievo shape`: the descriptor as layers, or its coloured display.

use super::picture::{Form, MadePicture};
use super::{Seen, Work};
use crate::command::args::WorkArgs;
use crate::command::commands::ShapeArgs;
use crate::command::layer_names::names_of;
use crate::command::output::{Kind, MOST_PLANES};
use crate::engine::outcome::{Outcome, ScaleShape};
use crate::error::{Result, bad};
use crate::frame::Frame;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::Inputs;
use crate::io::picture::ViewTransform;
use crate::io::{Loaded, Needs};
use crate::light::lights::Illumination;
use crate::params::Params;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;
use std::borrow::Cow;

impl Work for ShapeArgs {
    fn args(&self) -> &WorkArgs {
        &self.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn check(&self) -> Result<()> {
        let output = &self.work.output;
        match output.kind()? {
            Kind::Numbers(_) if output.write.is_empty() => Err(bad(
                "-o",
                format!("holds up to {MOST_PLANES} planes, and shape makes more"),
                "choose them, as in --write curvature.mean, or write an .exr",
            )),
            Kind::Picture(_) => self.work.flags.refuse_more_scales(),
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
        !matches!(self.work.output.kind(), Ok(Kind::Picture(_)))
    }

    fn plans(&self, seen: &mut Seen) -> Result<Vec<Plan>> {
        Ok(vec![plan(&self.work, self.goes_by_rows(), seen)?])
    }

    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>> {
        display(&self.work, frame, outcome)
    }

    fn channels<'a>(
        &self,
        loaded: &'a Loaded,
        outcome: &'a Outcome,
        _: Option<&'a MadePicture>,
    ) -> Vec<OutputChannel<'a>> {
        descriptor_channels(&self.work, &loaded.frame, outcome)
    }
}

/// The curvature display, whose colours are those of the display already.
pub(crate) fn display<'a>(
    work: &WorkArgs,
    frame: &Frame,
    outcome: &'a Outcome,
) -> Option<MadePicture<'a>> {
    let form = Form::Shown {
        grey: false,
        bits: 8,
        dpi: work.dpi(frame),
        transform: ViewTransform::None,
    };
    let color = Cow::Borrowed(outcome.color.as_ref()?);
    Some(MadePicture::shown(color, form))
}

/// The plan for the shape of a frame, in layers or as the curvature display, by the settings of any command.
pub(crate) fn plan(work: &WorkArgs, in_layers: bool, seen: &Seen) -> Result<Plan> {
    let and = on_request(work);
    let layers = Goal::Layers {
        and: &and,
        more_px: work.flags.more_scales(),
    };
    let goal = if in_layers { layers } else { Goal::Display };
    let Params { shape, scaling, .. } = work.flags.params;
    let (available, scaling) = (Available::in_frame(seen.frame), seen.found.given(scaling));
    Plan::new(goal, available, shape, scaling)
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

/// The layers of the contract, under its names.
pub(crate) fn descriptor_channels<'a>(
    work: &WorkArgs,
    frame: &'a Frame,
    outcome: &'a Outcome,
) -> Vec<OutputChannel<'a>> {
    let sample_type = work.output.depth_of_output.unwrap_or(OutputType::Half);
    let normal = &frame.normal;
    let normals = [("x", &normal.x), ("y", &normal.y), ("z", &normal.z)];
    let normals = normals.map(|(axis, plane)| (format!("normal.{axis}"), plane));
    let confidence = frame.confidence.as_ref();
    let confidence = confidence.map(|plane| ("weights.confidence".to_string(), plane));
    let of_product = |product: Product| {
        // Half floats tell heights to three digits.
        let sample_type = match product == Product::Height {
            true => OutputType::Float,
            false => sample_type,
        };
        let channels = product.channels().zip(outcome.planes(product));
        channels.map(move |(name, plane)| (name, plane, sample_type))
    };
    let more = outcome.shape.more_scales.iter();
    let more = more.flat_map(ScaleShape::channels);
    let typed = |(name, plane)| (name, plane, sample_type);
    let channels = normals.into_iter().chain(confidence).map(typed);
    let channels = channels.chain(Product::all().flat_map(of_product));
    let channels = channels.chain(more.map(typed));
    let channels = channels.map(|(name, plane, sample_type)| OutputChannel {
        name,
        plane,
        sample_type,
    });
    channels.collect()
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
