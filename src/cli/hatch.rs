//! `relievo hatch`.

use super::job::{Done, Job, refuse_inputs};
use super::line_args::{HatchArgs, ToneArg};
use super::output::{Kind, color_channels, color_layer};
use super::relight::{illumination, needs};
use crate::backend::cpu::{DrawingInputs, Runner};
use crate::compose::on_paper;
use crate::error::{Error, Result};
use crate::io;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::{LightInputs, LobeChoice};
use crate::io::picture::Picture;
use crate::light::lights::{DirectionalLight, direction_of};
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{StrokeParams, StrokeScale};
use crate::plan::{Available, LightKinds, Plan, ToneFrom};
use std::path::{Path, PathBuf};

/// The light of a drawing that has no other: from the upper left.
const LAMP: [f32; 2] = [135.0, 40.0];

pub(super) fn run(args: &HatchArgs) -> Result<()> {
    let relight = &args.relight;
    let work = &relight.work;
    let files: Vec<_> = relight.files().collect();
    refuse_inputs(work, files.iter().map(PathBuf::as_path))?;
    let job = Job::new(work)?;
    work.shape.refuse_more_scales()?;
    let (shape, light, line) = (work.shape.params(), relight.params(), args.params());
    let scaling = relight.scaling.params(work.shape.curvature_gain);
    shape.validate()?;
    scaling.validate()?;
    light.validate()?;
    line.validate()?;

    let art_map = args.pictures().map(|path| own_map(path, &line.strokes));
    let art_map = art_map.transpose()?;
    let mut illumination = illumination(&relight.light)?;
    let mut inputs = work.roles.inputs(&work.input);
    inputs.albedo.clone_from(&relight.material.albedo);
    inputs.light = Some(LightInputs {
        lobes: LobeChoice::Off,
        occlusion: relight.dims_by_occlusion(),
        ..LightInputs::default()
    });
    let mut needs = needs(&light, shape.foreshortening, &illumination);
    needs.projection = true;
    needs.color |= matches!(args.tone.tone, ToneArg::Enhance | ToneArg::Picture);
    let (loaded, read) = job.load(&inputs, needs)?;
    let available = Available::in_frame(&loaded.frame);
    let is_lit = LightKinds::in_light(&illumination) != LightKinds::default();
    let relit = match args.tone.tone {
        ToneArg::Relight => true,
        ToneArg::Auto => is_lit || !available.color,
        ToneArg::Enhance | ToneArg::Picture => false,
    };
    if relit && !is_lit {
        illumination.directional.push(lamp());
    }
    let tone = match args.tone.tone {
        _ if relit => ToneFrom::Relit(light, LightKinds::in_light(&illumination)),
        ToneArg::Picture => ToneFrom::Picture,
        _ => ToneFrom::Enhanced,
    };
    let plan = Plan::hatch(available, shape, scaling, tone, line)?;
    job.tell_plan(&plan)?;
    let inputs = DrawingInputs {
        illumination: Some(&illumination),
        art_map: art_map.as_ref(),
    };
    let outcome = Runner::default().draw(&plan, &loaded.frame, inputs);
    write(
        args,
        &job,
        &Done {
            loaded,
            outcome,
            read,
        },
    )
}

/// The texture of strokes in a folder of pictures.
fn own_map(path: &Path, strokes: &StrokeParams) -> Result<TonalArtMap> {
    let StrokeScale::Factor(factor) = strokes.scale else {
        return Err(Error::BadParameter {
            name: "--stroke-scale",
            found: "is in millimetres, but how wide the strokes of pictures are is not known"
                .into(),
            remedy: "give a factor".into(),
        });
    };
    Ok(TonalArtMap::of_pictures(
        &io::read_art_map(path)?,
        factor.recip(),
    ))
}

fn lamp() -> DirectionalLight {
    let [azimuth, elevation] = LAMP;
    DirectionalLight {
        to_light: direction_of(azimuth, elevation),
        intensity: [1.0; 3],
    }
}

fn write(args: &HatchArgs, job: &Job, done: &Done) -> Result<()> {
    let output = &args.relight.work.output;
    let drawing = done
        .outcome
        .drawing
        .as_ref()
        .expect("a drawing was planned");
    let layers: Vec<_> = std::iter::once(&drawing.hatching)
        .chain(&drawing.contours)
        .collect();
    let color = &on_paper(&layers);
    match job.kind {
        Kind::Picture(format) => job.write_picture(
            done,
            format,
            &Picture {
                color,
                alpha: None,
                bits: 8,
                transform: output.view_transform.into(),
            },
        ),
        Kind::Exr => {
            let sample_type = output.depth_of_output.map_or(OutputType::Half, Into::into);
            let layer = color_layer(output, &done.loaded);
            let mut channels = color_channels(layer, color, None, sample_type);
            channels.push(OutputChannel {
                name: "strokes.hatching".into(),
                plane: &drawing.hatching,
                sample_type,
            });
            channels.extend(drawing.contours.iter().map(|plane| OutputChannel {
                name: "strokes.contours".into(),
                plane,
                sample_type,
            }));
            job.write_exr(done, channels)
        }
    }
}
