//! `relievo hatch`.

use super::args::WorkArgs;
use super::job::{Done, Job, refuse_inputs};
use super::line_args::{HatchArgs, ToneArg};
use super::output::{Kind, color_channels, color_layer};
use super::relight::{illumination, needs};
use super::sequence::{Steps, numbered};
use crate::backend::cpu::{
    Drawing, DrawingInputs, Outcome, Runner, SequenceInputs, TextureCoordinates,
};
use crate::compose::on_paper;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene, Surroundings};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::{LightInputs, LobeChoice};
use crate::io::picture::Picture;
use crate::io::sequence::path_of_frame;
use crate::io::svg;
use crate::io::{self, Loaded, load_specular};
use crate::light::lights::{DirectionalLight, Illumination, direction_of};
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{
    Adaptive, LineParams, Material, RelightParams, ScalingParams, ShapeParams, StrokeParams,
    StrokeScale, Style,
};
use crate::plan::{Available, LightKinds, Plan, ToneFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// The light of a drawing that has no other: from the upper left.
const LAMP: [f32; 2] = [135.0, 40.0];

pub(super) fn run(args: &HatchArgs) -> Result<()> {
    let work = &args.relight.work;
    let output = &work.output.output;
    let frames = args.sequence.frames(&work.input, Some(output))?;
    match frames {
        None => {
            let job = Job::new(work)?;
            Hatcher::new(args)?.hatch(&job, work, None)
        }
        Some(frames) => {
            refuse_one_file(work)?;
            // What can be refused is refused before any work is done.
            Job::new(&work.of_frame(frames[0]))?;
            let mut hatcher = Hatcher::new(args)?;
            frames.iter().try_for_each(|&frame| {
                let work = work.of_frame(frame);
                hatcher.hatch(&Job::new(&work)?, &work, Some(frame))
            })
        }
    }
}

/// Timings of every frame need a name of their own.
fn refuse_one_file(work: &WorkArgs) -> Result<()> {
    match &work.run.timings {
        Some(path) if path_of_frame(path, 0).is_none() => Err(Error::BadParameter {
            name: "--timings",
            found: format!("{} is one file for all frames", path.display()),
            remedy: "put #### where their numbers go".into(),
        }),
        _ => Ok(()),
    }
}

/// Draws frames one after another.
struct Hatcher<'a> {
    args: &'a HatchArgs,
    art_map: Option<TonalArtMap>,
    illumination: Illumination,
    runner: Runner,
    looks: Looks,
    steps: Steps,
    /// The surroundings of the frame before, and their file.
    surroundings: Option<(PathBuf, Arc<Surroundings>)>,
    /// Where the texture of strokes lay in the frame before.
    coordinates: Option<TextureCoordinates>,
}

/// What frames of a sequence have in common.
struct Looks {
    shape: ShapeParams,
    scaling: ScalingParams,
    light: RelightParams,
    line: LineParams,
}

impl Looks {
    /// What was chosen from one frame is kept for those that follow: else their tone would flicker.
    fn keep(&mut self, outcome: &Outcome, drawing: &Drawing) {
        let kept = |chosen: &mut Adaptive, used: Option<f32>| {
            if let Some(used) = used {
                *chosen = Adaptive::Fixed(used);
            }
        };
        kept(&mut self.scaling.curvature_gain, outcome.gain);
        kept(&mut self.scaling.white_level, outcome.white_level);
        kept(&mut self.light.environment_gain, outcome.environment_gain);
        kept(&mut self.line.tone.white_point, Some(drawing.white_point));
    }
}

impl<'a> Hatcher<'a> {
    fn new(args: &'a HatchArgs) -> Result<Self> {
        let relight = &args.relight;
        let work = &relight.work;
        let files: Vec<_> = relight.files().collect();
        refuse_inputs(work, files.iter().map(PathBuf::as_path))?;
        work.shape.refuse_more_scales()?;
        let mut line = args.params();
        if is_svg(&work.output.output) {
            in_lines(&mut line.strokes)?;
        } else {
            Kind::of(&work.output.output)?;
        }
        let looks = Looks {
            shape: work.shape.params(),
            scaling: relight.scaling.params(work.shape.curvature_gain),
            light: relight.params(),
            line,
        };
        looks.shape.validate()?;
        looks.scaling.validate()?;
        looks.light.validate()?;
        looks.line.validate()?;
        let art_map = args
            .pictures()
            .map(|path| own_map(path, &looks.line.strokes));
        Ok(Self {
            args,
            art_map: art_map.transpose()?,
            illumination: illumination(&relight.light)?,
            runner: Runner::default(),
            looks,
            steps: Steps::default(),
            surroundings: None,
            coordinates: None,
        })
    }

    /// Draws one picture: that of `work`, a frame of a sequence where it has a number.
    fn hatch(&mut self, job: &Job, work: &WorkArgs, frame: Option<u32>) -> Result<()> {
        let moving = frame.filter(|_| self.args.sequence.moves());
        let (mut loaded, read) = self.load(job, work, frame)?;
        let motion =
            moving.and_then(|number| self.steps.motion(number, &mut loaded, work.run.quiet));
        let scene = self.specular_scene(&mut loaded, frame)?;
        let plan = self.plan(&loaded.frame, moving.is_some(), scene.is_some())?;
        job.tell_plan(&plan)?;
        let inputs = DrawingInputs {
            specular: scene.as_ref(),
            illumination: Some(&self.illumination),
            art_map: self.art_map.as_ref(),
            sequence: moving.map(|_| SequenceInputs {
                before: self.coordinates.as_ref(),
                motion: motion.as_ref(),
            }),
        };
        let outcome = self.runner.draw(&plan, &loaded.frame, inputs);
        let mut done = Done {
            loaded,
            outcome,
            read,
        };
        write(work, job, &done, self.looks.line.strokes.dpi)?;
        let mut drawing = done.outcome.drawing.take().expect("a drawing was planned");
        if frame.is_some() {
            self.looks.keep(&done.outcome, &drawing);
        }
        self.coordinates = drawing.coordinates.take();
        self.runner.take_back(done.outcome);
        Ok(())
    }

    fn load(&self, job: &Job, work: &WorkArgs, frame: Option<u32>) -> Result<(Loaded, Duration)> {
        let relight = &self.args.relight;
        let mut inputs = work.roles.inputs(&work.input);
        inputs.albedo.clone_from(&relight.material.albedo);
        if let (Some(albedo), Some(frame)) = (&mut inputs.albedo, frame) {
            *albedo = numbered(albedo, frame);
        }
        inputs.light = Some(LightInputs {
            lobes: LobeChoice::Off,
            occlusion: relight.dims_by_occlusion(),
            ..LightInputs::default()
        });
        let Looks { shape, light, .. } = &self.looks;
        let mut needs = needs(light, shape.foreshortening, &self.illumination);
        needs.projection = true;
        needs.color |= matches!(self.args.tone.tone, ToneArg::Enhance | ToneArg::Picture);
        if let Some(frame) = frame.filter(|_| self.steps.has_begun()) {
            needs.motion = true;
            inputs.motion = self.args.sequence.motion_of(frame);
        }
        job.load(&inputs, needs)
    }

    /// What mirrors and lenses show, if anything is named; what lies behind fills the frame where it is empty.
    fn specular_scene(
        &mut self,
        loaded: &mut Loaded,
        frame: Option<u32>,
    ) -> Result<Option<SpecularScene>> {
        let mut flags = self.args.relight.specular.clone();
        if let Some(frame) = frame {
            flags.rename(|name| numbered(name, frame));
        }
        let inputs = flags.inputs();
        if inputs.is_empty() {
            return Ok(None);
        }
        let known = self.surroundings.take();
        let known = known.filter(|(path, _)| Some(path) == inputs.surroundings.as_ref());
        let known = known.map(|(_, surroundings)| surroundings);
        let mut scene = load_specular(&inputs, loaded, known)?;
        self.surroundings = inputs.surroundings.zip(scene.surroundings.clone());
        scene.fill_from_behind(&mut loaded.frame);
        Ok(Some(scene))
    }

    fn plan(&mut self, frame: &Frame, moving: bool, is_specular: bool) -> Result<Plan> {
        let relight = &self.args.relight;
        let specular = relight.specular.params(&self.looks.light.material)?;
        let available = Available {
            moving,
            specular: is_specular.then_some(specular),
            ..Available::in_frame(frame)
        };
        let is_lit = LightKinds::in_light(&self.illumination) != LightKinds::default();
        let relit = match self.args.tone.tone {
            ToneArg::Relight => true,
            ToneArg::Auto => is_lit || !available.color,
            ToneArg::Enhance | ToneArg::Picture => false,
        };
        let material = self.looks.light.material.material;
        let is_mirror = matches!(material, Material::Mirror | Material::Glass);
        if relit && !is_lit && !(is_mirror && is_specular) {
            self.illumination.directional.push(lamp());
        }
        let looks = &self.looks;
        let kinds = LightKinds::in_light(&self.illumination);
        let tone = match self.args.tone.tone {
            _ if relit => ToneFrom::Relit(looks.light, kinds),
            ToneArg::Picture => ToneFrom::Picture,
            _ => ToneFrom::Enhanced,
        };
        Plan::hatch(available, looks.shape, looks.scaling, tone, looks.line)
    }
}

/// An SVG holds lines, whatever the pen.
fn in_lines(strokes: &mut StrokeParams) -> Result<()> {
    match strokes.style {
        Style::Pen | Style::Lines => strokes.style = Style::Lines,
        Style::Pencil | Style::Pictures => {
            return Err(Error::BadParameter {
                name: "--style",
                found: "is a texture, and an SVG holds lines".into(),
                remedy: "leave it out, or write a .png".into(),
            });
        }
    }
    Ok(())
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

/// Whether a drawing is written as lines.
fn is_svg(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

/// The lines of a drawing on a page.
fn page<'a>(frame: &Frame, drawing: &'a Drawing, dpi: f32) -> svg::Drawing<'a> {
    let strokes = drawing.lines.iter();
    let contours = drawing.contour_lines.iter();
    svg::Drawing {
        display_window: frame.display_window,
        data_window: frame.data_window,
        pixel_aspect: frame.pixel_aspect,
        dpi,
        layers: vec![
            (
                "strokes",
                strokes
                    .map(|line| (&line.points[..], &line.widths[..]))
                    .collect(),
            ),
            (
                "contours",
                contours
                    .map(|line| (&line.points[..], &line.widths[..]))
                    .collect(),
            ),
        ],
    }
}

fn write(work: &WorkArgs, job: &Job, done: &Done, dpi: f32) -> Result<()> {
    let output = &work.output;
    let drawing = done
        .outcome
        .drawing
        .as_ref()
        .expect("a drawing was planned");
    if is_svg(&output.output) {
        return job.write_svg(done, &page(&done.loaded.frame, drawing, dpi));
    }
    let kind = Kind::of(&output.output)?;
    let layers: Vec<_> = std::iter::once(&drawing.hatching)
        .chain(&drawing.contours)
        .collect();
    let color = &on_paper(&layers);
    match kind {
        Kind::Picture(format) => job.write_picture(
            done,
            format,
            &Picture {
                color,
                alpha: None,
                grey: true,
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
