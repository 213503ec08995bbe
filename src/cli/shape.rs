//! `relievo shape`.

use super::args::WorkArgs;
use super::job::Job;
use super::output::Kind;
use crate::backend::cpu::{Outcome, ScaleShape};
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::picture::{Picture, ViewTransform};
use crate::params::ScalingParams;
use crate::plan::Goal;

pub(super) fn run(args: &WorkArgs) -> Result<()> {
    let kind = Kind::of(&args.output.output)?;
    let job = Job::new(args)?;
    let goal = match kind {
        Kind::Exr => Goal::Layers,
        Kind::Picture(_) => Goal::Display,
    };
    let curvature_gain = args.shape.curvature_gain;
    let done = job.run(
        goal,
        ScalingParams {
            curvature_gain,
            ..ScalingParams::default()
        },
    )?;
    match kind {
        Kind::Picture(format) => {
            let color = done
                .outcome
                .color
                .as_ref()
                .expect("the plan made a display");
            // The display's colours are meant for the screen as they are.
            let transform = ViewTransform::None;
            job.write_picture(
                &done,
                format,
                &Picture {
                    color,
                    alpha: None,
                    grey: false,
                    bits: 8,
                    transform,
                },
            )
        }
        Kind::Exr => {
            let stored = args
                .output
                .depth_of_output
                .map_or(OutputType::Float, Into::into);
            let channels = descriptor_channels(&done.loaded.frame, &done.outcome, stored);
            job.write_exr(&done, channels)
        }
    }
}

/// The layers of the contract, under its names.
fn descriptor_channels<'a>(
    frame: &'a Frame,
    outcome: &'a Outcome,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let shape = &outcome.shape;
    let (gradient, hessian) = (shape.gradient.as_ref(), shape.hessian.as_ref());
    let curvatures = shape.curvatures.as_ref();
    let (direction, direction_view) = (shape.direction.as_ref(), shape.direction_view.as_ref());
    let layers: [(&str, Option<&Plane>); 19] = [
        ("normal.x", Some(&frame.normal.x)),
        ("normal.y", Some(&frame.normal.y)),
        ("normal.z", Some(&frame.normal.z)),
        ("weights.silhouette", shape.silhouette.as_ref()),
        ("weights.crease", shape.crease.as_ref()),
        ("weights.conductance", shape.conductance.as_ref()),
        ("gradient.x", gradient.map(|g| &g.x)),
        ("gradient.y", gradient.map(|g| &g.y)),
        ("hessian.xx", hessian.map(|h| &h.xx)),
        ("hessian.xy", hessian.map(|h| &h.xy)),
        ("hessian.yy", hessian.map(|h| &h.yy)),
        ("curvature.u", curvatures.map(|c| &c.u)),
        ("curvature.v", curvatures.map(|c| &c.v)),
        ("curvature.mean", curvatures.map(|c| &c.mean)),
        ("curvature.kappa", shape.kappa.as_ref()),
        ("direction.x", direction.map(|d| &d.x)),
        ("direction.y", direction.map(|d| &d.y)),
        ("direction_view.x", direction_view.map(|d| &d.x)),
        ("direction_view.y", direction_view.map(|d| &d.y)),
    ];
    layers
        .into_iter()
        .filter_map(|(name, plane)| plane.map(|plane| (name.to_string(), plane)))
        .chain(shape.more_scales.iter().flat_map(curvature_at_scale))
        .map(|(name, plane)| OutputChannel {
            name,
            plane,
            sample_type,
        })
        .collect()
}

/// The layer of a scale beyond the first, named after it: `curvature_8px`, `curvature_2_5px`.
fn curvature_at_scale(scale: &ScaleShape) -> [(String, &Plane); 4] {
    // A dot would end the layer's name.
    let sigma = scale.sigma_px.to_string().replace('.', "_");
    let name = |component: &str| format!("curvature_{sigma}px.{component}");
    [
        (name("u"), &scale.curvatures.u),
        (name("v"), &scale.curvatures.v),
        (name("mean"), &scale.curvatures.mean),
        (name("kappa"), &scale.kappa),
    ]
}
