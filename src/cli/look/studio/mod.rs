//! The frame in hand, and pictures made of it by one look after another.

mod reading;

use super::{Look, Said};
use crate::cli::args::{OutputArgs, WorkArgs};
use crate::cli::chosen::Chosen;
use crate::cli::commands::Command;
use crate::cli::engine::Engine;
use crate::cli::enhance;
use crate::cli::hatch;
use crate::cli::line_args::HatchArgs;
use crate::cli::message;
use crate::cli::recipe::RecipeText;
use crate::cli::relight_args::RelightArgs;
use crate::cli::{relight, shape};
use crate::engine::cpu::DrawingInputs;
use crate::engine::cpu::live::LiveRunner;
use crate::engine::cpu::strips::StripChoice;
use crate::engine::outcome::Outcome;
use crate::error::Result;
use crate::frame::{ColorPlanes, Frame, SpecularScene};
use crate::io::Loaded;
use crate::io::picture::{Picture, ViewTransform, pixels};
use crate::line::tonal_art_map::TonalArtMap;
use crate::plan::LightKinds;
use crate::plan::{Goal, Plan};
use reading::{Source, SurroundingFiles};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

/// Which file, and which frame of a sequence.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) input: PathBuf,
    pub(crate) frame: Option<i32>,
}

/// Red, green, blue and alpha in 8 bits, not premultiplied: what a PNG would hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Pixels {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) rgba: Vec<[u8; 4]>,
}

impl Pixels {
    pub(crate) fn of(picture: &Picture) -> Self {
        Self {
            width: picture.color.r.width(),
            height: picture.color.r.height(),
            rgba: pixels(picture),
        }
    }
}

/// What is made of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum What {
    /// The picture of the command.
    Picture,
    /// The coloured curvature display.
    Curvature,
    /// All layers of the descriptor.
    Layers,
}

/// What holds a frame.
enum Held {
    /// With all that was read along with it.
    Whole(Box<Loaded>),
    /// Every so many pixels of it.
    Reduced(Box<Frame>),
}

impl AsRef<Frame> for Held {
    fn as_ref(&self) -> &Frame {
        match self {
            Self::Whole(loaded) => &loaded.frame,
            Self::Reduced(frame) => frame,
        }
    }
}

/// The frame in hand.
struct OpenFrame {
    source: Source,
    /// What mirrors and lenses show.
    scene: Option<SpecularScene>,
    /// By the step between the pixels that are left; 1 holds the whole.
    runners: BTreeMap<usize, LiveRunner<Held>>,
}

impl OpenFrame {
    fn runner(&mut self, step: usize) -> &mut LiveRunner<Held> {
        if !self.runners.contains_key(&step) {
            let reduced = self.loaded().frame.reduced(step);
            let held = Held::Reduced(Box::new(reduced));
            self.runners.insert(step, LiveRunner::new(held));
        }
        self.runners.get_mut(&step).expect("it is there by now")
    }

    fn loaded(&self) -> &Loaded {
        match self.runners[&1].held() {
            Held::Whole(loaded) => loaded,
            Held::Reduced(_) => unreachable!("step 1 is the whole"),
        }
    }
}

/// What was made last.
struct Made {
    command: Command,
    what: What,
    step: usize,
    /// What a device made; else the frame's runner holds it.
    on_device: Option<Outcome>,
}

/// Makes pictures of one frame, and keeps what the next ones can use.
pub(crate) struct ViewSession {
    engine: Arc<Engine>,
    /// What was said of devices.
    said: RefCell<BTreeSet<String>>,
    sitter: Option<OpenFrame>,
    around: SurroundingFiles,
    /// The texture of strokes that a folder holds.
    art_map: Option<(PathBuf, crate::params::StrokeScale, TonalArtMap)>,
    made: Option<Made>,
}

const A_COMMAND: &str = "a look is one of the commands of recipes";
const IN_HAND: &str = "a frame has been read";

impl ViewSession {
    /// An empty one that works by `engine`.
    pub(crate) fn new(engine: Arc<Engine>) -> Self {
        Self {
            engine,
            said: RefCell::default(),
            sitter: None,
            around: SurroundingFiles::default(),
            art_map: None,
            made: None,
        }
    }

    /// Makes `what` of a frame by `look`, of every `step`th pixel: [`ViewSession::outcome`] then holds it. Only what changed is
    /// read or made anew.
    ///
    /// # Errors
    /// What is wrong with the settings or the files, as one line.
    pub(crate) fn make(
        &mut self,
        look: &Look,
        reading: &Reading,
        what: What,
        step: usize,
    ) -> std::result::Result<(), Said> {
        self.made = None;
        let parsed = look.parse(&reading.input)?;
        let mut command = parsed.cli.command;
        let recipe = RecipeText::of(&parsed.matches);
        let said = |error| message::line_of(&error);
        self.read(&command, &recipe, reading).map_err(said)?;
        let sitter = self.sitter.as_ref().expect(IN_HAND);
        // What mirrors show is not reduced with the frame.
        let step = if sitter.scene.is_some() {
            1
        } else {
            step.max(1)
        };
        if step > 1 && look.value("reference-height").is_none() {
            // A quick look is meant for the size of the whole.
            let height = sitter.loaded().frame.display_window.height().max(1);
            let at_size = look.with("reference-height", height);
            command = at_size.parse(&reading.input)?.cli.command;
        }
        let on_device = self.run(&command, what, step).map_err(said)?;
        self.made = Some(Made {
            command,
            what,
            step,
            on_device,
        });
        Ok(())
    }

    /// The frame that was last made something of, perhaps reduced.
    pub(crate) fn frame(&self) -> Option<&Frame> {
        Some(self.runner()?.held().as_ref())
    }

    /// What was made last.
    pub(crate) fn outcome(&self) -> Option<&Outcome> {
        let on_device = self.made.as_ref()?.on_device.as_ref();
        Some(on_device.unwrap_or(self.runner()?.outcome()))
    }

    /// Width and height of the whole frame in pixels, and how wide a pixel is for its height.
    pub(crate) fn size(&self) -> Option<([usize; 2], f32)> {
        let frame = &self.sitter.as_ref()?.loaded().frame;
        Some((
            [frame.mask.width(), frame.mask.height()],
            frame.pixel_aspect,
        ))
    }

    /// The step between the pixels that the last picture was made of.
    pub(crate) fn step(&self) -> usize {
        self.made.as_ref().map_or(1, |made| made.step)
    }

    /// How often each pass has run on the whole frame.
    pub(crate) fn counts(&self) -> Option<&BTreeMap<&'static str, u32>> {
        Some(self.sitter.as_ref()?.runners[&1].counts())
    }

    /// The numbers that were chosen automatically for it, by the names of their settings.
    pub(crate) fn chosen_numbers(&self) -> Vec<(String, String)> {
        self.chosen().numbers()
    }

    /// The recipe that the command line would save with it.
    pub(crate) fn recipe(
        &self,
        look: &Look,
        reading: &Reading,
    ) -> std::result::Result<String, Said> {
        look.recipe(&reading.input, &self.chosen())
    }

    fn chosen(&self) -> Chosen {
        match (&self.sitter, self.outcome()) {
            (Some(sitter), Some(outcome)) => Chosen::made(sitter.loaded(), outcome),
            _ => Chosen::default(),
        }
    }

    /// What the user should know of the frame, and of what works on it.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let sitter = self.sitter.iter();
        let of_frame = sitter.flat_map(|sitter| sitter.loaded().warnings.iter().cloned());
        of_frame.chain(self.said.borrow().iter().cloned()).collect()
    }

    fn runner(&self) -> Option<&LiveRunner<Held>> {
        let made = self.made.as_ref()?;
        self.sitter.as_ref()?.runners.get(&made.step)
    }

    /// The picture that was made last, as its file would show it.
    pub(crate) fn picture(&self) -> Option<Pixels> {
        let made = self.made.as_ref()?;
        let (frame, outcome) = (self.frame()?, self.outcome()?);
        let work = work_of(&made.command);
        Some(match (&made.command, made.what) {
            (_, What::Layers) => return None,
            (_, What::Curvature) | (Command::Shape(_), _) => Pixels::of(&shape::display(outcome)),
            (Command::Hatch(_), _) => {
                let drawing = outcome.drawing.as_ref()?;
                let color = hatch::inked(drawing);
                Pixels::of(&hatch::on_a_page(&color, &work.output))
            }
            (Command::Enhance(_), _) => self.shown(enhance::made(frame, outcome), &work.output),
            (_, _) => self.shown(relight::lit(outcome), &work.output),
        })
    }

    /// The picture as it came; normals where there is none.
    pub(crate) fn as_it_came(&self) -> Option<Pixels> {
        let frame = self.frame()?;
        let output = &work_of(&self.made.as_ref()?.command).output;
        if let Some(color) = &frame.color {
            return Some(self.shown(color, output));
        }
        let half = |plane: &crate::frame::Plane| plane.map(|n| 0.5 * n + 0.5);
        let normals = ColorPlanes {
            r: half(&frame.normal.x),
            g: half(&frame.normal.y),
            b: half(&frame.normal.z),
        };
        Some(Pixels::of(&Picture {
            color: &normals,
            alpha: None,
            grey: false,
            bits: 8,
            transform: ViewTransform::None,
        }))
    }

    fn shown(&self, color: &ColorPlanes, output: &OutputArgs) -> Pixels {
        let sitter = self.sitter.as_ref().expect(IN_HAND);
        let turned = output.turned(sitter.loaded(), color);
        let color = turned.as_ref().unwrap_or(color);
        let alpha = self.frame().and_then(|frame| frame.alpha.as_ref());
        Pixels::of(&output.picture(color, alpha, 8))
    }

    /// Has a device make it, or else the runner of the frame, which then holds it.
    fn run(&mut self, command: &Command, what: What, step: usize) -> Result<Option<Outcome>> {
        let work = work_of(command);
        match (command, what) {
            (_, What::Layers) => self.describe(work, Goal::Layers, step),
            (_, What::Curvature) | (Command::Shape(_), _) => {
                self.describe(work, Goal::Display, step)
            }
            (Command::Enhance(args), _) => {
                let live = self.sitter.as_mut().expect(IN_HAND).runner(step);
                let plan = args.plan(live.held().as_ref(), &StripChoice::default())?;
                self.go(&plan, step)
            }
            (Command::Relight(args), _) => self.light(args, step),
            (Command::Hatch(args), _) => self.draw(args, step),
            _ => unreachable!("{A_COMMAND}"),
        }
    }

    fn describe(&mut self, work: &WorkArgs, goal: Goal, step: usize) -> Result<Option<Outcome>> {
        let live = self.sitter.as_mut().expect(IN_HAND).runner(step);
        let plan = work.plan(goal, live.held().as_ref(), &StripChoice::default())?;
        self.go(&plan, step)
    }

    fn go(&mut self, plan: &Plan, step: usize) -> Result<Option<Outcome>> {
        let live = self.sitter.as_mut().expect(IN_HAND).runner(step);
        let frame = live.held().as_ref();
        let made = self
            .engine
            .run_on_device(&say_to(&self.said), plan, frame)?;
        if made.is_none() {
            live.run(plan);
        }
        Ok(made)
    }

    fn light(&mut self, args: &RelightArgs, step: usize) -> Result<Option<Outcome>> {
        let light = self.illumination(args)?;
        let kinds = LightKinds::in_light(&light);
        let sitter = self.sitter.as_mut().expect(IN_HAND);
        let scene = sitter.scene.take();
        let live = sitter.runner(step);
        let warn = say_to(&self.said);
        let plan = args.plan(
            live.held().as_ref(),
            kinds,
            scene.is_some(),
            &StripChoice::default(),
        );
        let made = plan.and_then(|plan| {
            let frame = live.held().as_ref();
            let made = self.engine.relight_on_device(&warn, &plan, frame, &light)?;
            if made.is_none() {
                live.relight(&plan, &light, scene.as_ref());
            }
            Ok(made)
        });
        sitter.scene = scene;
        made
    }

    fn draw(&mut self, args: &HatchArgs, step: usize) -> Result<Option<Outcome>> {
        let looks = args.looks()?;
        self.read_art_map(args, &looks)?;
        let light = self.illumination(&args.relight)?;
        let sitter = self.sitter.as_mut().expect(IN_HAND);
        let scene = sitter.scene.take();
        let live = sitter.runner(step);
        let warn = say_to(&self.said);
        let frame = live.held().as_ref();
        let planned = args.plan(&looks, light, frame, false, scene.is_some());
        let made = planned.and_then(|(plan, light)| {
            let map = args.pictures().and(self.art_map.as_ref());
            let inputs = DrawingInputs {
                specular: scene.as_ref(),
                illumination: Some(&light),
                art_map: map.map(|(_, _, map)| map),
                sequence: None,
            };
            let frame = live.held().as_ref();
            let made = self.engine.draw_on_device(&warn, &plan, frame, inputs)?;
            if made.is_none() {
                live.draw(&plan, inputs);
            }
            Ok(made)
        });
        sitter.scene = scene;
        made
    }
}

/// Says a thing once.
fn say_to(said: &RefCell<BTreeSet<String>>) -> impl Fn(&str) {
    |text| {
        said.borrow_mut().insert(text.into());
    }
}

/// What all commands share.
fn work_of(command: &Command) -> &WorkArgs {
    match command {
        Command::Shape(work) => work,
        Command::Enhance(args) => &args.work,
        Command::Relight(args) => &args.work,
        Command::Hatch(args) => &args.relight.work,
        _ => unreachable!("{A_COMMAND}"),
    }
}

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::*;
    use crate::cli::args::BackendArg;
    use crate::engine::gpu::device::to_test_on;
    use std::path::Path;

    /// The picture of each command, as it is shown.
    fn pictures(studio: &mut ViewSession) -> Vec<Pixels> {
        let reading = Reading {
            input: Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bust.exr"),
            frame: None,
        };
        let shown = Look::commands().iter().map(|command| {
            let mut look = Look::default();
            look.set_command(command);
            studio.make(&look, &reading, What::Picture, 1).unwrap();
            studio.picture().unwrap()
        });
        shown.collect()
    }

    #[test]
    fn a_device_shows_what_the_cpu_shows() {
        let opened = Engine::for_window(BackendArg::Gpu);
        let Some(engine) = to_test_on(opened) else {
            return;
        };
        let expected = pictures(&mut ViewSession::new(Arc::default()));
        let mut studio = ViewSession::new(engine.into());
        let found = pictures(&mut studio);
        // The device did it: no pass has run on the CPU.
        assert_eq!(studio.counts().map(BTreeMap::len), Some(0));
        for (found, expected) in found.iter().zip(&expected) {
            let pixels = found.rgba.iter().zip(&expected.rgba);
            let apart =
                |(a, b): (&[u8; 4], &[u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 1);
            // A rounding may carry a stroke's pixel past a threshold.
            let count = pixels.filter(|&pair| apart(pair)).count();
            assert!(count * 1000 <= expected.rgba.len(), "{count} pixels");
        }
    }
}
