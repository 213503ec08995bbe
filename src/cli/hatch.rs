//! `relievo hatch`.

use super::args::{OutputArgs, WorkArgs};
use super::chosen::Chosen;
use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::line_args::HatchArgs;
use super::motion::Steps;
use super::output::{Kind, color_channels};
use super::relight::{illumination, needs};
use super::strips::{refuse_large_surroundings, refuse_too_large};
use crate::engine::outcome::Drawing;
use crate::engine::{self, Engine, Run};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, SpecularScene, Surroundings};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::Inputs;
use crate::io::picture::Picture;
use crate::io::svg;
use crate::io::{self, Loaded, Needs, load_specular};
use crate::light::lights::{DirectionalLight, Illumination, LAMP_DEG};
use crate::line::contours::Contour;
use crate::line::paper::on_paper;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{
    LineParams, Material, RelightParams, ScalingParams, ShapeParams, StrokeParams, StrokeScale,
    Style, ToneSource,
};
use crate::plan::LightKinds;
use crate::plan::{Available, Plan, ToneFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// What all frames that are drawn have in common.
pub(super) struct HatchInputs {
    art_map: Option<TonalArtMap>,
    illumination: Illumination,
    engine: Engine,
    looks: Looks,
    /// The surroundings of a frame before, and their file.
    surroundings: Mutex<Option<(PathBuf, Arc<Surroundings>)>>,
    course: Mutex<SequenceState>,
}

/// What a frame takes from the one before.
#[derive(Default)]
struct SequenceState {
    steps: Steps,
    /// Where the texture of strokes lay.
    coordinates: Option<TextureCoordinates>,
}

/// What its flags say a drawing is to look like.
pub(super) struct Looks {
    shape: ShapeParams,
    scaling: ScalingParams,
    light: RelightParams,
    pub(super) line: LineParams,
}

impl FrameCommand for HatchArgs {
    type Kit = HatchInputs;

    fn work(&self) -> &WorkArgs {
        &self.relight.work
    }

    fn files(&self, frame: Option<i32>) -> Vec<PathBuf> {
        let motion = frame.and_then(|frame| self.motion.of_frame(frame));
        let motion = motion.map(PathBuf::from).filter(|path| path.exists());
        self.relight
            .files(frame)
            .into_iter()
            .chain(motion)
            .collect()
    }

    fn folder(&self) -> Option<&Path> {
        self.pictures()
    }

    fn follows_on(&self) -> bool {
        self.motion.moves()
    }

    fn validate(&self) -> Result<()> {
        self.looks().map(|_| ())
    }

    fn prepare(&self) -> Result<HatchInputs> {
        let looks = self.looks()?;
        Ok(HatchInputs {
            art_map: self.art_map(&looks)?,
            illumination: illumination(
                &self.relight,
                self.relight.work.run.max_memory.for_light(),
            )?,
            engine: self.relight.work.run.compute.backend.engine()?,
            looks,
            surroundings: Mutex::default(),
            course: Mutex::default(),
        })
    }

    fn make(&self, kit: &HatchInputs, job: &Job) -> Result<Chosen> {
        let (mut loaded, read) = self.load(kit, job)?;
        let scene = self.specular_scene(kit, job, &mut loaded)?;
        let moves = job.is_in_sequence() && self.motion.moves();
        let illumination = kit.illumination.clone();
        let (plan, illumination) = self.plan(
            &kit.looks,
            illumination,
            &loaded.frame,
            moves,
            scene.is_some(),
        )?;
        job.tell_plan(&plan)?;
        let inputs = engine::Inputs {
            specular: scene.as_ref(),
            illumination: Some(&illumination),
            art_map: kit.art_map.as_ref(),
            sequence: None,
        };
        let warn = |text: &str| job.warn(text);
        let run = Run::new().warn(&warn);
        let draw = |frame: &mut Frame, inputs: engine::Inputs| {
            kit.engine.execute_sparingly(&plan, frame, inputs, &run)
        };
        let outcome = match (moves, job.frame) {
            (true, Some(number)) => job.in_turn(|| {
                let mut course = kit.course.lock().unwrap_or_else(PoisonError::into_inner);
                let motion = course
                    .steps
                    .motion(number, &mut loaded, |text| job.warn(text));
                let inputs = engine::Inputs {
                    sequence: Some(SequenceInputs {
                        before: course.coordinates.as_ref(),
                        motion: motion.as_ref(),
                    }),
                    ..inputs
                };
                let mut outcome = draw(&mut loaded.frame, inputs)?;
                let drawing = outcome.drawing.as_mut().expect("a drawing was planned");
                course.coordinates = drawing.coordinates.take();
                Ok(outcome)
            }),
            _ => draw(&mut loaded.frame, inputs),
        }?;
        let done = Done {
            loaded,
            plan,
            outcome,
            read,
        };
        let chosen = write(job, &done, kit.looks.line.strokes.dpi)?;
        kit.engine.recycle(done.outcome);
        Ok(chosen)
    }
}

impl HatchArgs {
    /// What its flags say, if it can be drawn.
    pub(super) fn looks(&self) -> Result<Looks> {
        let relight = &self.relight;
        let work = &relight.work;
        work.flags.refuse_more_scales()?;
        let mut line = self.params();
        if is_svg(work) {
            in_lines(&mut line.strokes)?;
        } else {
            work.output.kind()?;
        }
        Ok(Looks {
            shape: work.flags.params.shape,
            scaling: work.flags.params.scaling,
            light: relight.params(),
            line,
        })
    }

    /// The texture of strokes, where it comes from pictures.
    pub(super) fn art_map(&self, looks: &Looks) -> Result<Option<TonalArtMap>> {
        let map = self.pictures();
        let most = self.relight.work.run.max_memory.for_light();
        map.map(|path| own_map(path, &looks.line.strokes, most))
            .transpose()
    }

    /// What is read of a frame.
    pub(super) fn reading(
        &self,
        looks: &Looks,
        illumination: &Illumination,
        job: &Job,
    ) -> (Inputs, Needs) {
        let mut needs = needs(&looks.light, looks.shape.foreshortening, illumination);
        needs.projection = true;
        needs.color |= matches!(self.tone(), ToneSource::Enhance | ToneSource::Picture);
        (self.relight.inputs(job), needs)
    }

    fn load(&self, kit: &HatchInputs, job: &Job) -> Result<(Loaded, Duration)> {
        refuse_too_large(job)?;
        let (mut inputs, mut needs) = self.reading(&kit.looks, &kit.illumination, job);
        if let Some(frame) = job.frame.filter(|_| job.follows()) {
            needs.motion = true;
            inputs.motion = self.motion.of_frame(frame);
        }
        job.load(&inputs, needs)
    }

    /// What mirrors and lenses show, if anything is named; what lies behind fills the frame where it is empty.
    fn specular_scene(
        &self,
        kit: &HatchInputs,
        job: &Job,
        loaded: &mut Loaded,
    ) -> Result<Option<SpecularScene>> {
        let inputs = self.relight.specular.of_frame(job.frame).inputs();
        if inputs.is_empty() {
            return Ok(None);
        }
        refuse_large_surroundings(job, inputs.surroundings.as_deref())?;
        let mut kept = kit
            .surroundings
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let known = kept
            .take()
            .filter(|(path, _)| Some(path) == inputs.surroundings.as_ref());
        let known = known.map(|(_, surroundings)| surroundings);
        let mut scene = load_specular(&inputs, loaded, known)?;
        *kept = inputs.surroundings.zip(scene.surroundings.clone());
        scene.fill_from_behind(&mut loaded.frame);
        Ok(Some(scene))
    }

    /// The plan, and the light, with a lamp where there is none and some is wanted.
    pub(super) fn plan(
        &self,
        looks: &Looks,
        mut illumination: Illumination,
        frame: &Frame,
        moving: bool,
        is_specular: bool,
    ) -> Result<(Plan, Illumination)> {
        let specular = self
            .relight
            .specular
            .params(&self.relight.work.flags.params);
        let available = Available {
            moving,
            specular: is_specular.then_some(specular),
            ..Available::in_frame(frame)
        };
        let is_lit = LightKinds::in_light(&illumination) != LightKinds::default();
        let relit = match self.tone() {
            ToneSource::Relight => true,
            ToneSource::Auto => is_lit || !available.color,
            ToneSource::Enhance | ToneSource::Picture => false,
        };
        let material = looks.light.material.material;
        let is_mirror = matches!(material, Material::Mirror | Material::Glass);
        if relit && !is_lit && !(is_mirror && is_specular) {
            illumination
                .directional
                .push(DirectionalLight::white(LAMP_DEG));
        }
        let kinds = LightKinds::in_light(&illumination);
        let tone = match self.tone() {
            _ if relit => ToneFrom::Relit(looks.light, kinds),
            ToneSource::Picture => ToneFrom::Picture,
            _ => ToneFrom::Enhanced,
        };
        let plan = Plan::hatch(available, looks.shape, looks.scaling, tone, looks.line)?;
        Ok((plan, illumination))
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
fn own_map(path: &Path, strokes: &StrokeParams, most_bytes: u64) -> Result<TonalArtMap> {
    let StrokeScale::Factor(factor) = strokes.scale else {
        return Err(Error::BadParameter {
            name: "--stroke-scale",
            found: "is in millimetres, but how wide the strokes of pictures are is not known"
                .into(),
            remedy: "give a factor".into(),
        });
    };
    Ok(TonalArtMap::of_pictures(
        &io::read_art_map(path, most_bytes)?,
        factor.recip(),
    ))
}

/// Whether a drawing is written as lines.
fn is_svg(work: &WorkArgs) -> bool {
    let extension = work.output.output.as_deref().and_then(Path::extension);
    extension.is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

/// The lines of a drawing on a page.
fn page<'a>(frame: &Frame, drawing: &'a Drawing, dpi: f32) -> svg::Drawing<'a> {
    let strokes = drawing.lines.iter();
    let along = |lines: &'a [Contour]| {
        let lines = lines.iter();
        lines
            .map(|line| (&line.points[..], &line.widths[..]))
            .collect()
    };
    let mut layers = vec![
        (
            "strokes",
            strokes
                .map(|line| (&line.points[..], &line.widths[..]))
                .collect(),
        ),
        ("contours", along(&drawing.contour_lines)),
    ];
    if drawing.interior.is_some() {
        layers.push(("interior", along(&drawing.interior_lines)));
    }
    svg::Drawing {
        display_window: frame.display_window,
        data_window: frame.data_window,
        pixel_aspect: frame.pixel_aspect,
        dpi,
        layers,
    }
}

/// The ink of a drawing on its paper.
pub(super) fn inked(drawing: &Drawing) -> ColorPlanes {
    on_paper(&drawing.layers())
}

/// An inked drawing as a picture.
pub(super) fn on_a_page<'a>(color: &'a ColorPlanes, output: &OutputArgs) -> Picture<'a> {
    Picture {
        color,
        alpha: None,
        grey: true,
        bits: 8,
        transform: output.view_transform,
    }
}

fn write(job: &Job, done: &Done, dpi: f32) -> Result<Chosen> {
    let output = &job.work.output;
    let drawing = done
        .outcome
        .drawing
        .as_ref()
        .expect("a drawing was planned");
    if is_svg(&job.work) {
        return job.write_svg(done, &page(&done.loaded.frame, drawing, dpi));
    }
    let color = &inked(drawing);
    if let Kind::Picture(_) = output.kind()? {
        return job.write_picture(done, &on_a_page(color, output));
    }
    let sample_type = output.depth_of_output.unwrap_or(OutputType::Half);
    let layer = output.color_layer(&done.loaded);
    let mut channels = color_channels(layer, color, None, sample_type);
    channels.push(OutputChannel {
        name: "strokes.hatching".into(),
        plane: &drawing.hatching,
        sample_type,
    });
    let lines = [
        ("strokes.contours", &drawing.contours),
        ("strokes.interior", &drawing.interior),
    ];
    for (name, plane) in lines {
        channels.extend(plane.iter().map(|plane| OutputChannel {
            name: name.into(),
            plane,
            sample_type,
        }));
    }
    job.write_exr(done, &channels)
}
