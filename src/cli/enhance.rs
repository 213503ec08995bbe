//! `relievo enhance`.

use super::args::EnhanceArgs;
use super::job::Job;
use super::message;
use super::output::{Kind, color_channels, color_layer};
use crate::error::Result;
use crate::io::exr::OutputType;
use crate::io::picture::Picture;
use crate::light::radiance_scaling::monotone_limit;
use crate::params::ScalingParams;
use crate::plan::Goal;

pub(super) fn run(args: &EnhanceArgs) -> Result<()> {
    let EnhanceArgs {
        work,
        scaling,
        white_level,
    } = args;
    let job = Job::new(work)?;
    let scaling = ScalingParams {
        white_level: *white_level,
        ..scaling.params(work.shape.curvature_gain)
    };
    let done = job.run(Goal::Enhance, scaling)?;
    warn_of_dark_rims(&scaling, work.run.quiet);

    let (loaded, frame) = (&done.loaded, &done.loaded.frame);
    // A plan with nothing to do leaves the picture as it came.
    let scaled = done.outcome.color.as_ref();
    let color = scaled
        .or(frame.color.as_ref())
        .expect("a picture was loaded");
    let alpha = frame.alpha.as_ref();
    match job.kind {
        Kind::Picture(format) => {
            let bits = if loaded.photo_bits == Some(16) { 16 } else { 8 };
            let transform = work.output.view_transform.into();
            job.write_picture(
                &done,
                format,
                &Picture {
                    color,
                    alpha,
                    bits,
                    transform,
                },
            )
        }
        Kind::Exr => {
            let as_read = if loaded.color_is_half {
                OutputType::Half
            } else {
                OutputType::Float
            };
            let sample_type = work.output.depth_of_output.map_or(as_read, Into::into);
            let layer = color_layer(&work.output, loaded);
            job.write_exr(&done, color_channels(layer, color, alpha, sample_type))
        }
    }
}

/// Concavities lose their order of brightness past a limit ([RS] only claims it for convexities).
pub(super) fn warn_of_dark_rims(scaling: &ScalingParams, quiet: bool) {
    let limit = monotone_limit(scaling.invariant_point);
    if scaling.scaling > limit {
        let text = format!(
            "--scaling {} is past {limit:.2}: deep concavities may show new dark rims; lower it or \
             --invariant-point",
            scaling.scaling
        );
        message::warning(quiet, &text);
    }
}
