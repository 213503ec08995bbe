//! The open frame, and pictures made of it with successive looks.

mod reading;

use super::{Look, OneLine};
use crate::command::args::WorkArgs;
use crate::command::chosen::Chosen;
use crate::command::commands::Command;
use crate::command::error_line::line_of;
use crate::engine::{Engine, PlanInputs, Run, Session};
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, SpecularScene};
use crate::io::Loaded;
use crate::io::output::picture::{Form, MadePicture};
use crate::io::picture::{Picture, ViewTransform, pixels};
use crate::light::lights::Illumination;
use crate::plan::Plan;
use crate::plan::outcome::Outcome;
use crate::work::source::FrameSource;
use crate::work::{FrameSeen, shape};
use reading::LookFiles;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A file, and the frame number if it is a sequence.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ShownFile {
    pub(crate) input: PathBuf,
    pub(crate) frame: Option<i32>,
}

/// Red, green, blue and alpha in 8 bits, not premultiplied: what a PNG would hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ViewPixels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgba: Vec<[u8; 4]>,
}

impl ViewPixels {
    pub(crate) fn of(picture: &Picture) -> Self {
        Self {
            width: picture.color.r.width(),
            height: picture.color.r.height(),
            rgba: pixels(picture),
        }
    }
}

/// The kind of result made of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum What {
    /// The picture of the command.
    Picture,
    /// The coloured curvature display.
    Curvature,
    /// All layers of the descriptor.
    Layers,
}

/// The open frame.
struct OpenFrame {
    source: FrameSource,
    /// The scene that mirrors and lenses show.
    scene: Option<SpecularScene>,
    /// Engine sessions by pixel step; step 1 holds the whole frame.
    sessions: BTreeMap<usize, Session<Loaded>>,
}

impl OpenFrame {
    fn session(&mut self, engine: &Arc<Engine>, step: usize) -> &mut Session<Loaded> {
        if !self.sessions.contains_key(&step) {
            let reduced = self.loaded().reduced(step);
            let session = Session::new(engine.clone(), reduced);
            self.sessions.insert(step, session);
        }
        self.sessions.get_mut(&step).expect("it is there by now")
    }

    /// Runs a plan for the frame of [`OpenFrame::session`] and its mirrored scene; repeated device messages are
    /// dropped.
    fn execute(
        &mut self,
        step: usize,
        plan: &Plan,
        inputs: PlanInputs,
        said: &Mutex<BTreeSet<String>>,
    ) -> Result<()> {
        let warn = |text: &str| {
            let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
            said.insert(text.into());
        };
        let inputs = PlanInputs {
            specular: self.scene.as_ref(),
            ..inputs
        };
        let session = self.sessions.get_mut(&step);
        let session = session.expect("the plan was made for its frame");
        let run = Run::new().warn(&warn);
        session.execute(plan, inputs, &run).map(|_| ())
    }

    fn loaded(&self) -> &Loaded {
        self.sessions[&1].held()
    }
}

/// The last result.
struct MadeWithLook {
    command: Command,
    what: What,
    step: usize,
    /// Warnings about its settings.
    warnings: Vec<String>,
}

/// Makes pictures of one frame, and caches what later ones can reuse.
pub(crate) struct ViewSession {
    engine: Arc<Engine>,
    /// The longest side of frames, in pixels; longer ones are reduced as they are read.
    longest: Option<usize>,
    /// Device messages shown so far.
    said: Mutex<BTreeSet<String>>,
    sitter: Option<OpenFrame>,
    around: LookFiles,
    made: Option<MadeWithLook>,
}

const IN_HAND: &str = "a frame has been read";

impl ViewSession {
    /// An empty session that runs on `engine`.
    pub(crate) fn new(engine: Arc<Engine>) -> Self {
        Self {
            engine,
            longest: None,
            said: Mutex::default(),
            sitter: None,
            around: LookFiles::default(),
            made: None,
        }
    }

    /// An empty session for small pictures: of frames with no side longer than `longest` pixels.
    pub(crate) fn small(engine: Arc<Engine>, longest: usize) -> Self {
        Self {
            longest: Some(longest),
            ..Self::new(engine)
        }
    }

    /// Makes `what` of a frame with `look`, from every `step`th pixel; [`ViewSession::outcome`] then holds the result.
    /// Only changed inputs and stages are redone.
    ///
    /// # Errors
    /// One line for invalid settings or unreadable files.
    pub(crate) fn make(
        &mut self,
        look: &Look,
        reading: &ShownFile,
        what: What,
        step: usize,
    ) -> std::result::Result<(), OneLine> {
        self.make_beside(None, look, reading, what, step)
    }

    /// The small picture of a frame with `look`; `None` if there is none. The frame is taken from the session `beside`
    /// this one, where that holds it.
    pub(crate) fn small_picture(
        &mut self,
        beside: &Self,
        look: &Look,
        reading: &ShownFile,
    ) -> Option<ViewPixels> {
        self.make_beside(Some(beside), look, reading, What::Picture, 1)
            .ok()?;
        self.picture()
    }

    fn make_beside(
        &mut self,
        beside: Option<&Self>,
        look: &Look,
        reading: &ShownFile,
        what: What,
        step: usize,
    ) -> std::result::Result<(), OneLine> {
        self.made = None;
        let parsed = look.parse(&reading.input)?;
        let mut command = parsed.command;
        let said = |error| line_of(&error);
        self.read(&command, reading, beside).map_err(said)?;
        let sitter = self.sitter.as_ref().expect(IN_HAND);
        if self.longest.is_some() && sitter.scene.is_some() {
            return Err("what mirrors and lenses show is not reduced".into());
        }
        // The scene in mirrors is not reduced with the frame, so neither is the frame.
        let step = if sitter.scene.is_some() {
            1
        } else {
            step.max(1)
        };
        if step > 1 && look.value("reference-height").is_none() {
            // Previews use lengths in pixels of the whole frame.
            let height = sitter.loaded().frame.display_window.height().max(1);
            let at_size = look.with("reference-height", height);
            command = at_size.parse(&reading.input)?.command;
        }
        let warnings = self.run(&command, what, step).map_err(said)?;
        self.made = Some(MadeWithLook {
            command,
            what,
            step,
            warnings,
        });
        Ok(())
    }

    /// The whole frame.
    pub(crate) fn whole(&self) -> Option<&Frame> {
        Some(&self.sitter.as_ref()?.loaded().frame)
    }

    /// The frame used last, perhaps reduced.
    pub(crate) fn frame(&self) -> Option<&Frame> {
        Some(self.session()?.held().as_ref())
    }

    /// The last result.
    pub(crate) fn outcome(&self) -> Option<&Outcome> {
        Some(self.session()?.outcome())
    }

    /// Width and height of the whole frame in pixels, and the pixel aspect ratio (width / height).
    pub(crate) fn size(&self) -> Option<([usize; 2], f32)> {
        let frame = self.whole()?;
        Some((
            [frame.mask.width(), frame.mask.height()],
            frame.pixel_aspect,
        ))
    }

    /// The pixel step of the last picture.
    pub(crate) fn step(&self) -> usize {
        self.made.as_ref().map_or(1, |made| made.step)
    }

    /// How often each pass has run on the whole frame.
    pub(crate) fn counts(&self) -> Option<&BTreeMap<&'static str, u32>> {
        Some(self.sitter.as_ref()?.sessions[&1].counts())
    }

    /// Numbers chosen automatically for the last picture, by setting name.
    pub(crate) fn chosen_numbers(&self) -> Vec<(String, String)> {
        self.chosen().numbers()
    }

    /// The recipe that the command line would save with the last picture.
    pub(crate) fn recipe(
        &self,
        look: &Look,
        reading: &ShownFile,
    ) -> std::result::Result<String, OneLine> {
        look.recipe(&reading.input, &self.chosen())
    }

    fn chosen(&self) -> Chosen {
        match (&self.sitter, self.outcome()) {
            (Some(sitter), Some(outcome)) => Chosen::made(sitter.loaded(), outcome),
            _ => Chosen::default(),
        }
    }

    /// Warnings about the frame, about the settings of the last picture and about devices, as the command line says
    /// them.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let sitter = self.sitter.iter();
        let of_frame = sitter.flat_map(|sitter| sitter.loaded().warnings.iter().cloned());
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        let of_settings = self.made.iter().flat_map(|made| made.warnings.iter());
        let more = of_settings.chain(said.iter()).cloned();
        of_frame.chain(more).collect()
    }

    fn session(&self) -> Option<&Session<Loaded>> {
        let made = self.made.as_ref()?;
        self.sitter.as_ref()?.sessions.get(&made.step)
    }

    /// The last picture, as its file would show it.
    pub(crate) fn picture(&self) -> Option<ViewPixels> {
        let made = self.made.as_ref()?;
        let (frame, outcome, work) = (self.frame()?, self.outcome()?, made.command.work());
        match made.what {
            What::Layers => None,
            What::Curvature => {
                let params = &work.args().flags.params;
                let picture = MadePicture::curvature(frame, outcome, params)?;
                Some(self.shown(picture, work.args()))
            }
            What::Picture => {
                let mut mixed = Outcome {
                    color: outcome.color.clone(),
                    drawing: outcome.drawing.clone(),
                    takes_picture: outcome.takes_picture,
                    ..Outcome::default()
                };
                mixed.mix(frame, 1.0, &work.args().flags.params);
                Some(self.shown(work.picture(frame, &mixed)?, work.args()))
            }
        }
    }

    /// The input picture, or the normals where there is none.
    pub(crate) fn as_it_came(&self) -> Option<ViewPixels> {
        let frame = self.frame()?;
        if let Some(color) = &frame.color {
            let work = self.made.as_ref()?.command.work();
            let as_it_is = MadePicture {
                color: Cow::Borrowed(color),
                before: Some(color),
                like: None,
                form: Form::Light,
            };
            return Some(self.shown(as_it_is, work.args()));
        }
        let half = |plane: &crate::frame::Plane| plane.map(|n| 0.5 * n + 0.5);
        let normals = ColorPlanes {
            r: half(&frame.normal.x),
            g: half(&frame.normal.y),
            b: half(&frame.normal.z),
        };
        Some(ViewPixels::of(&Picture::of(&normals, ViewTransform::None)))
    }

    fn shown(&self, made: MadePicture, args: &WorkArgs) -> ViewPixels {
        let primaries = self.sitter.as_ref().expect(IN_HAND).loaded().chromaticities;
        let frame = self.frame().expect(IN_HAND);
        let params = &args.flags.params;
        let exposure = made.exposure(&params.display, &frame.mask);
        let shown = params.displayed(frame, primaries, made, 8, exposure);
        ViewPixels::of(&shown.picture())
    }

    /// Runs the stages for `what`, and returns the warnings about the settings; the frame's engine session then holds
    /// the result.
    fn run(&mut self, command: &Command, what: What, step: usize) -> Result<Vec<String>> {
        let work = command.work();
        let in_layers = match what {
            What::Layers => Some(true),
            What::Curvature => Some(false),
            What::Picture => None,
        };
        let (light, lamp) = match in_layers {
            None => self.illumination(work)?,
            Some(_) => (Illumination::default(), None),
        };
        let mut warnings = work.warnings();
        warnings.extend(lamp);
        let sitter = self.sitter.as_mut().expect(IN_HAND);
        let (is_in_sequence, is_specular) = (sitter.source.is_in_sequence, sitter.scene.is_some());
        let frame = sitter.session(&self.engine, step).held().as_ref();
        let mut seen = FrameSeen {
            is_in_sequence,
            is_specular,
            ..FrameSeen::new(frame, &light)
        };
        let plans = match in_layers {
            Some(in_layers) => vec![shape::plan(work.args(), in_layers, &seen)?],
            None => work.plans(&mut seen)?,
        };
        let light = seen.light;
        let inputs = PlanInputs {
            art_map: self.around.art_map.as_ref(),
            ..PlanInputs::lit_by(&light)
        };
        for plan in &plans {
            sitter.execute(step, plan, inputs, &self.said)?;
            let session = &sitter.sessions[&step];
            warnings.extend(shape::held_gain(plan, session.outcome().gain));
            warnings.extend(work.warnings_on(session.held().as_ref()));
        }
        Ok(warnings)
    }
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::command::args::BackendArg;
    use crate::gpu::device::to_test_on;
    use std::path::Path;

    /// The picture of each command, as shown in the window.
    fn pictures(session: &mut ViewSession) -> Vec<ViewPixels> {
        let reading = ShownFile {
            input: Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bust.exr"),
            frame: None,
        };
        let shown = Look::commands().iter().map(|command| {
            let mut look = Look::default();
            look.set_command(command);
            // The GPU has no kernels for engraved lines and for shape-showing tones.
            look.set("style", Some("pen".into()));
            look.set("tone", Some("enhance".into()));
            session.make(&look, &reading, What::Picture, 1).unwrap();
            session.picture().unwrap()
        });
        shown.collect()
    }

    #[test]
    fn a_device_shows_what_the_cpu_shows() {
        let opened = BackendArg::Gpu.engine().map(Engine::or_cpu);
        let Some(engine) = to_test_on(opened) else {
            return;
        };
        let expected = pictures(&mut ViewSession::new(Arc::default()));
        let mut session = ViewSession::new(engine.into());
        let found = pictures(&mut session);
        // Everything ran on the GPU: no CPU pass was counted.
        assert_eq!(session.counts().map(BTreeMap::len), Some(0));
        for (found, expected) in found.iter().zip(&expected) {
            let pixels = found.rgba.iter().zip(&expected.rgba);
            let apart =
                |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
            // Rounding may push a pixel of a stroke across a threshold.
            let count = pixels.filter(|&pair| apart(pair)).count();
            assert!(count * 1000 <= expected.rgba.len(), "{count} pixels");
        }
    }
}
