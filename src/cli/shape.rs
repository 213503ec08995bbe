//! `relievo shape`.

use super::args::ShapeArgs;
use super::output::{DISPLAY_REFERRED, Job, Kind};
use crate::backend::cpu::{self, Outcome};
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::io;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::photo::Picture;
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use std::time::Instant;

pub(super) fn run(args: &ShapeArgs) -> Result<()> {
    let job = Job::new(&args.input, &args.roles, &args.output, &args.run)?;
    let shape = args.shape.params();
    shape.validate()?;
    let goal = match job.kind {
        Kind::Exr => Goal::Layers,
        Kind::Picture(_) => Goal::Display,
    };

    let start = Instant::now();
    let loaded = io::load(&args.roles.inputs(&args.input), false)?;
    let read = start.elapsed();
    job.tell_findings(&loaded);

    let frame = &loaded.frame;
    let scaling = ScalingParams {
        curvature_gain: args.gain.curvature_gain,
        ..ScalingParams::default()
    };
    let plan = Plan::new(goal, Available::in_frame(frame), shape, scaling)?;
    job.tell_plan(&plan);
    let outcome = cpu::run(&plan, frame);

    let write = match job.kind {
        Kind::Picture(format) => {
            let color = outcome.color.as_ref().expect("the plan made a display");
            let transform = DISPLAY_REFERRED;
            job.write_picture(
                format,
                &Picture {
                    color,
                    alpha: None,
                    bits: 8,
                    transform,
                },
            )?
        }
        Kind::Exr => {
            let stored = args
                .output
                .depth_of_output
                .map_or(OutputType::Float, Into::into);
            job.write_exr(&loaded, descriptor_channels(frame, &outcome, stored))?
        }
    };
    job.finish(frame, &outcome, read, write)
}

/// The layers of the contract, under its names.
fn descriptor_channels<'a>(
    frame: &'a Frame,
    outcome: &'a Outcome,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let shape = &outcome.shape;
    let (gradient, hessian) = (shape.gradient.as_ref(), shape.hessian.as_ref());
    let (curvatures, direction) = (shape.curvatures.as_ref(), shape.direction.as_ref());
    let layers: [(&str, Option<&Plane>); 17] = [
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
    ];
    layers
        .into_iter()
        .filter_map(|(name, plane)| plane.map(|plane| (name, plane)))
        .map(|(name, plane)| OutputChannel {
            name: name.into(),
            plane,
            sample_type,
        })
        .collect()
}
