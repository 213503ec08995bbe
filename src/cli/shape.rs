//! `relievo shape`.

use super::args::WorkArgs;
use super::chosen::Chosen;
use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::output::Kind;
use super::strips::refuse_too_large;
use crate::backend::cpu::{Outcome, Runner, ScaleShape};
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::io::Needs;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::picture::{Picture, ViewTransform};
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use std::path::PathBuf;

impl FrameCommand for WorkArgs {
    type Kit = Runner;

    fn work(&self) -> &WorkArgs {
        self
    }

    fn files(&self, _frame: Option<i32>) -> Vec<PathBuf> {
        Vec::new()
    }

    fn prepare(&self) -> Result<Runner> {
        if self.goal()? == Goal::Display {
            self.shape.refuse_more_scales()?;
        }
        Ok(Runner::default())
    }

    fn make(&self, runner: &Runner, job: &Job) -> Result<Chosen> {
        let (goal, shape) = (self.goal()?, self.shape.params());
        let scaling = ScalingParams {
            curvature_gain: self.shape.curvature_gain,
            ..ScalingParams::default()
        };
        let needs = Needs {
            projection: shape.foreshortening != 0.0 || goal == Goal::Layers,
            ..Needs::default()
        };
        let inputs = job.work.roles.inputs(&job.work.input);
        refuse_too_large(job)?;
        let (loaded, read) = job.load(&inputs, needs)?;
        let available = Available::in_frame(&loaded.frame);
        let scales = self.shape.more_scales();
        let plan = Plan::at_scales(goal, available, shape, scaling, scales)?;
        job.tell_plan(&plan)?;
        let outcome = runner.run(&plan, &loaded.frame);
        let done = Done {
            loaded,
            outcome,
            read,
        };
        let chosen = self.write(job, goal, &done)?;
        runner.take_back(done.outcome);
        Ok(chosen)
    }
}

impl WorkArgs {
    fn goal(&self) -> Result<Goal> {
        Ok(match self.output.kind()? {
            Kind::Exr => Goal::Layers,
            Kind::Picture(_) => Goal::Display,
        })
    }

    fn write(&self, job: &Job, goal: Goal, done: &Done) -> Result<Chosen> {
        if goal == Goal::Layers {
            let stored = self.output.depth_of_output;
            let stored = stored.map_or(OutputType::Float, Into::into);
            let channels = descriptor_channels(&done.loaded.frame, &done.outcome, stored);
            return job.write_exr(done, &channels);
        }
        let color = done.outcome.color.as_ref();
        let picture = Picture {
            color: color.expect("the plan made a display"),
            alpha: None,
            grey: false,
            bits: 8,
            // The display's colours are meant for the screen as they are.
            transform: ViewTransform::None,
        };
        job.write_picture(done, &picture)
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
