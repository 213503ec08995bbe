//! `relievo enhance`.

use super::args::EnhanceArgs;
use super::output::{Job, Kind, color_channels};
use crate::backend::cpu;
use crate::error::Result;
use crate::io::exr::OutputType;
use crate::io::photo::Picture;
use crate::io::{self, Loaded};
use crate::light::radiance_scaling::monotone_limit;
use crate::params::ScalingParams;
use crate::plan::{Available, Goal, Plan};
use std::time::Instant;

pub(super) fn run(args: &EnhanceArgs) -> Result<()> {
    let job = Job::new(&args.input, &args.roles, &args.output, &args.run)?;
    let (shape, scaling) = (args.shape.params(), args.scaling.params(&args.gain));
    shape.validate()?;
    scaling.validate()?;

    let start = Instant::now();
    let loaded = io::load(&args.roles.inputs(&args.input), true)?;
    let read = start.elapsed();
    job.tell_findings(&loaded);
    warn_of_dark_rims(&scaling, args.run.quiet);

    let frame = &loaded.frame;
    let plan = Plan::new(Goal::Enhance, Available::in_frame(frame), shape, scaling)?;
    job.tell_plan(&plan);
    let outcome = cpu::run(&plan, frame);

    let color = outcome
        .color
        .as_ref()
        .or(frame.color.as_ref())
        .expect("a picture was loaded");
    let write = match job.kind {
        Kind::Picture(format) => job.write_picture(
            format,
            &Picture {
                color,
                alpha: frame.alpha.as_ref(),
                bits: if loaded.photo_bits == Some(16) { 16 } else { 8 },
                transform: args.output.view_transform.into(),
            },
        )?,
        Kind::Exr => {
            let stored = args
                .output
                .depth_of_output
                .map_or(loaded.color_type(), Into::into);
            let layer = job.color_layer(&loaded);
            let channels = color_channels(layer, color, frame.alpha.as_ref(), stored);
            job.write_exr(&loaded, channels)?
        }
    };
    job.finish(frame, &outcome, read, write)
}

/// Concavities lose their order of brightness past a limit ([RS] only claims it for convexities).
fn warn_of_dark_rims(scaling: &ScalingParams, quiet: bool) {
    let limit = monotone_limit(scaling.invariant_point);
    if scaling.scaling > limit {
        super::message::warning(
            quiet,
            &format!(
                "--scaling {} is past {limit:.2}: deep concavities may show new dark rims; \
                 lower it or --invariant-point",
                scaling.scaling
            ),
        );
    }
}

impl Loaded {
    /// The sample type that holds the picture as exactly as its input did.
    fn color_type(&self) -> OutputType {
        match self.color_is_half {
            true => OutputType::Half,
            false => OutputType::Float,
        }
    }
}
