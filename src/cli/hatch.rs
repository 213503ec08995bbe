//! `relievo hatch`.

use super::frames::FrameCommand;
use super::job::{Done, Job};
use super::motion::Steps;
use super::output::color_channels;
use super::progress::passes_bar;
use super::strip_memory::refuse_large_surroundings;
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::hatch::{Drawn, Looks, inked, is_svg, page};
use crate::command::line_args::HatchArgs;
use crate::command::output::Kind;
use crate::command::relight::illumination;
use crate::engine::run::ENLARGE;
use crate::engine::{self, Engine, Progress, Run};
use crate::error::Result;
use crate::frame::{Frame, SpecularScene, Surroundings};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::{Loaded, load_specular};
use crate::light::lights::Illumination;
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::StrokeParams;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Inputs and state shared by all drawn frames.
pub(super) struct HatchInputs {
    art_map: Option<TonalArtMap>,
    illumination: Illumination,
    engine: Engine,
    looks: Looks,
    /// The surroundings of a frame before, and their file.
    surroundings: Mutex<Option<(PathBuf, Arc<Surroundings>)>>,
    course: Mutex<SequenceState>,
}

/// State carried over from the frame before.
struct SequenceState {
    steps: Steps,
    /// Where the texture of strokes lay.
    coordinates: Option<TextureCoordinates>,
}

impl FrameCommand for HatchArgs {
    type Kit = HatchInputs;

    fn work(&self) -> &WorkArgs {
        &self.relight.work
    }

    fn work_mut(&mut self) -> &mut WorkArgs {
        &mut self.relight.work
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
        self.relight.work.output.refuse_numbers()?;
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
            course: Mutex::new(SequenceState {
                steps: Steps::new(self.motion.convention()),
                coordinates: None,
            }),
        })
    }

    fn make(&self, kit: &HatchInputs, job: &Job) -> Result<Chosen> {
        let (mut loaded, read) = self.load(kit, job)?;
        let mut scene = self.specular_scene(kit, job, &mut loaded)?;
        let is_watched = self.times(&loaded.frame)? != 1.0 && !job.is_in_sequence();
        let bar = passes_bar(&job.work.run, is_watched);
        let warn = |text: &str| bar.suspend(|| job.warn(text));
        let tell = |at: Progress| {
            bar.set_message(at.stage);
            bar.set_position((100.0 * at.done) as u64);
        };
        let run = Run::new().warn(&warn);
        let run = match bar.is_hidden() {
            true => run,
            false => run.progress(&tell),
        };
        let began = Instant::now();
        let times = self.enlarge(job, &mut loaded, &mut scene, &run)?;
        let enlarging = began.elapsed();
        let moves = job.is_in_sequence() && self.motion.moves();
        let illumination = kit.illumination.clone();
        let (mut plan, illumination) = self.plan(
            &kit.looks,
            illumination,
            &loaded.frame,
            Drawn {
                times,
                is_in_sequence: job.is_in_sequence(),
                moves,
                is_specular: scene.is_some(),
            },
        )?;
        job.settle_albedo(&mut plan, &loaded.frame);
        plan.inks_strokes = !is_svg(&job.work);
        plan.keeps_tone = plan.inks_strokes && job.work.output.kind()? == Kind::Exr;
        job.tell_plan(&plan);
        let inputs = engine::Inputs {
            specular: scene.as_ref(),
            illumination: Some(&illumination),
            art_map: kit.art_map.as_ref(),
            sequence: None,
        };
        let draw = |frame: &mut Frame, inputs: engine::Inputs| {
            kit.engine.execute_sparingly(&plan, frame, inputs, &run)
        };
        let mut outcome = match (moves, job.frame) {
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
        bar.finish_and_clear();
        if times != 1.0 {
            outcome.timings.insert(0, (ENLARGE, enlarging));
        }
        job.keep_picture_alone(&kit.engine, &mut outcome);
        if let (Some(drawing), false) = (&mut outcome.drawing, is_svg(&job.work)) {
            self.mix(drawing, &loaded.frame, times);
        }
        let done = Done {
            loaded,
            outcome,
            read,
        };
        let chosen = self.write(job, &done, &kit.looks.line.strokes)?;
        kit.engine.recycle(done.outcome);
        Ok(chosen)
    }
}

impl HatchArgs {
    /// Makes the frame, and what its mirrors show, as large as the drawing is to be; how many times as large.
    fn enlarge(
        &self,
        job: &Job,
        loaded: &mut Loaded,
        scene: &mut Option<SpecularScene>,
        run: &Run,
    ) -> Result<f64> {
        let times = self.times(&loaded.frame)?;
        if times == 1.0 {
            return Ok(times);
        }
        if job.part.is_some() {
            let found = "makes cells larger than those of the sheet".into();
            return Err(self.cannot_enlarge(found, "leave it or --grid out".into()));
        }
        self.refuse_enlarged(&loaded.frame, times, scene.as_ref())?;
        if job.is_in_sequence() && self.motion.moves() {
            let found = "does not go with strokes that move".into();
            return Err(self.cannot_enlarge(found, "give --motion none".into()));
        }
        if job.work.output.color_layer(loaded).is_some()
            && !is_svg(&job.work)
            && job.work.output.kind()? == Kind::Exr
        {
            let found = "makes layers larger than those of the input".into();
            let remedy = "give --layers results, or write a picture".into();
            return Err(self.cannot_enlarge(found, remedy));
        }
        if let Some(scene) = scene {
            *scene = run.install(|| scene.enlarged(&loaded.frame, times));
        }
        loaded.frame = run.enlarged(&loaded.frame, times)?;
        loaded.enlarged = times;
        Ok(times)
    }

    fn load(&self, kit: &HatchInputs, job: &Job) -> Result<(Loaded, Duration)> {
        self.refuse_too_large(&job.work.input)?;
        let (mut inputs, mut needs) = self.reading(&kit.looks, &kit.illumination, job.frame);
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

    /// Writes the drawing and ends the frame.
    fn write(&self, job: &Job, done: &Done, strokes: &StrokeParams) -> Result<Chosen> {
        let output = &job.work.output;
        let drawing = done
            .outcome
            .drawing
            .as_ref()
            .expect("a drawing was planned");
        let frame = &done.loaded.frame;
        if is_svg(&job.work) {
            return job.write_svg(done, &page(frame, drawing, strokes));
        }
        if let Kind::Picture(_) = output.kind()? {
            let color = &self.printed(drawing);
            return job.write_picture(done, &self.on_a_page(color, frame.pixel_aspect));
        }
        let color = &inked(drawing);
        let sample_type = output.depth_of_output.unwrap_or(OutputType::Half);
        let layer = output.color_layer(&done.loaded);
        let mut channels = color_channels(layer, color, None, sample_type);
        channels.push(OutputChannel {
            name: "strokes.hatching".into(),
            plane: &drawing.hatching,
            sample_type,
        });
        let others = [
            ("strokes.contours", &drawing.contours),
            ("strokes.interior", &drawing.interior),
            ("strokes.tone", &drawing.asked),
        ];
        for (name, plane) in others {
            channels.extend(plane.iter().map(|plane| OutputChannel {
                name: name.into(),
                plane,
                sample_type,
            }));
        }
        job.write_channels(done, channels)
    }
}
