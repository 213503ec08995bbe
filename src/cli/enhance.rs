//! `relievo enhance`.

use super::args::EnhanceArgs;
use super::job::{Job, refuse_inputs};
use super::message;
use super::output::{Kind, color_channels, color_layer};
use crate::error::Result;
use crate::frame::LightLayers;
use crate::io::exr::OutputType;
use crate::io::picture::Picture;
use crate::light::radiance_scaling::monotone_limit;
use crate::params::ScalingParams;
use crate::plan::{Goal, LightAvailable};
use std::path::PathBuf;

pub(super) fn run(args: &EnhanceArgs) -> Result<()> {
    let EnhanceArgs {
        work,
        light,
        scaling,
        white_level,
    } = args;
    let light_files: Vec<_> = light.files().collect();
    refuse_inputs(work, light_files.iter().map(PathBuf::as_path))?;
    let kind = Kind::of(&work.output.output)?;
    let job = Job::new(work)?;
    let light = light.inputs(scaling);
    let scaling = ScalingParams {
        white_level: *white_level,
        ..scaling.params(work.shape.curvature_gain)
    };
    let done = job.run_on_light(Goal::Enhance, scaling, Some(light))?;
    let told = dark_rims(&scaling).into_iter();
    for warning in told.chain(idle_magnitudes(&scaling, &done.loaded.frame.light)) {
        message::warning(work.run.quiet, &warning);
    }

    let (loaded, frame) = (&done.loaded, &done.loaded.frame);
    // A plan with nothing to do leaves the picture as it came.
    let scaled = done.outcome.color.as_ref();
    let color = scaled
        .or(frame.color.as_ref())
        .expect("a picture was loaded");
    let alpha = frame.alpha.as_ref();
    match kind {
        Kind::Picture(format) => {
            let bits = if loaded.photo_bits == Some(16) { 16 } else { 8 };
            let transform = work.output.view_transform.into();
            job.write_picture(
                &done,
                format,
                &Picture {
                    color,
                    alpha,
                    grey: false,
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
pub(super) fn dark_rims(scaling: &ScalingParams) -> Vec<String> {
    let limit = monotone_limit(scaling.invariant_point);
    let magnitudes = [
        ("--scaling", Some(scaling.scaling)),
        ("--scaling-ambient", scaling.scaling_ambient),
        ("--scaling-diffuse", scaling.scaling_diffuse),
        ("--scaling-specular", scaling.scaling_specular),
    ];
    let past = magnitudes
        .into_iter()
        .filter_map(|(name, magnitude)| Some((name, magnitude.filter(|&g| g > limit)?)));
    past.map(|(name, magnitude)| {
        format!(
            "{name} {magnitude} is past {limit:.2}: deep concavities may show new dark rims; lower it or \
             --invariant-point"
        )
    })
    .collect()
}

/// Magnitudes that were asked for and have no light to scale.
fn idle_magnitudes(scaling: &ScalingParams, light: &LightLayers) -> Vec<String> {
    let available = LightAvailable::of(light);
    let LightAvailable {
        groups,
        occlusion,
        picture_is_occlusion,
        ..
    } = available;
    let ambient = occlusion || picture_is_occlusion || (available.diffuse_indirect && !groups);
    let terms = [
        ("--scaling-ambient", scaling.scaling_ambient, ambient),
        (
            "--scaling-diffuse",
            scaling.scaling_diffuse,
            available.diffuse || groups,
        ),
        (
            "--scaling-specular",
            scaling.scaling_specular,
            available.specular && !groups,
        ),
    ];
    let idle = terms.into_iter().filter(|&(_, magnitude, used)| {
        // A magnitude of 0 is at peace with nothing to scale.
        magnitude.is_some_and(|g| g > 0.0) && !used
    });
    idle.map(|(name, ..)| format!("{name} changes nothing: no layer of such light is scaled here"))
        .collect()
}
