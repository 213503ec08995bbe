//! The command and the frame of a report: read once, run again and again with one thing changed.

use super::clock::{Spent, timed};
use super::difference::Codes;
use crate::command::args::BackendArg;
use crate::command::chosen::look_at_depth;
use crate::command::commands::{COMMANDS, Command, ReportArgs};
use crate::command::error_line::misuse_line;
use crate::command::flags::Flag;
use crate::command::invocation::Invocation;
use crate::command::recipe::Recipe;
use crate::engine::{Engine, Outcome, Run};
use crate::error::{Error, Result, bad};
use crate::frame::{ColorPlanes, Frame, LightLayers, SpecularScene};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::pixels_16;
use crate::light::lights::Illumination;
use crate::params::{Parameters, Solver};
use crate::plan::Plan;
use crate::work::making::Making;
use crate::work::source::FrameSource;
use crate::work::{Results, light_of};
use std::ffi::OsString;

/// Stands for the output, a picture: nothing is written there.
const OUTPUT: &str = "report.png";

/// The command that is reported on if none is named.
const DEFAULT: &str = "enhance";

/// The setting of the backend, which is none of the parameters.
pub(super) const BACKEND: &str = "backend";

/// A command, what it reads, and its light.
pub(super) struct ReportSubject {
    typed: Invocation,
    /// As typed, but for the program, the input and the output.
    pub(super) words: Vec<String>,
    pub(super) command: Command,
    pub(super) light: Illumination,
    pub(super) frame: Frame,
    specular: Option<SpecularScene>,
    primaries: Option<Chromaticities>,
    pub(super) is_in_sequence: bool,
    pub(super) engine: Engine,
    /// The engine of the other backend, where this machine has a device.
    other: Option<Engine>,
    pub(super) warnings: Vec<String>,
    /// Time that reading took.
    pub(super) read: Spent,
}

/// An input, by what takes it out of a frame.
pub(super) type Removal = fn(&mut Frame);

/// Depth, and the camera that turns it to positions.
pub(super) const DEPTH: Removal = |frame| (frame.depth, frame.camera) = (None, None);
pub(super) const OCCLUSION: Removal = |frame| frame.occlusion = None;
pub(super) const ALBEDO: Removal = |frame| frame.albedo = None;
pub(super) const LIGHT: Removal = |frame| frame.light = LightLayers::default();

/// What a run differs in from the command as given.
#[derive(Clone, Default)]
pub(super) struct Variation {
    /// Settings by their names.
    pub(super) settings: Vec<(&'static str, String)>,
    pub(super) without: Option<Removal>,
}

impl Variation {
    pub(super) fn setting(name: &'static str, value: impl ToString) -> Self {
        Self {
            settings: vec![(name, value.to_string())],
            without: None,
        }
    }

    pub(super) fn without(input: Removal) -> Self {
        Self {
            without: Some(input),
            ..Self::default()
        }
    }

    /// As it is typed.
    pub(super) fn flags(&self) -> String {
        let flags = self.settings.iter();
        let flags = flags.map(|(name, value)| format!("--{name} {value}"));
        flags.collect::<Vec<_>>().join(" ")
    }
}

/// What a run made.
pub(super) struct Shot {
    pub(super) codes: Codes,
    pub(super) size: [usize; 2],
    pub(super) made: Results,
    pub(super) used: Spent,
}

impl ReportSubject {
    /// Reads the frame for the command of a report; `typed` are settings given to the report itself.
    ///
    /// # Errors
    /// As the command itself, of its arguments and of reading; [`Error::BadParameter`] where --for names no command.
    pub(super) fn read(args: &ReportArgs, typed: &[Flag], number: Option<i32>) -> Result<Self> {
        let mut words = match (&args.command, &args.recipe) {
            (Some(text), _) => split(text)?,
            (None, Some(_)) => Vec::new(),
            (None, None) => vec![DEFAULT.into()],
        };
        let (name, own) = match &args.recipe {
            Some(_) => (String::new(), &words[..]),
            None => (words[0].clone(), &words[1..]),
        };
        let end = ["-o", OUTPUT, "--"].map(OsString::from);
        let rest = own.iter().map(OsString::from);
        let rest = rest.chain(typed.iter().map(Flag::word));
        let rest: Vec<OsString> = rest.chain(end).chain([args.input.clone().into()]).collect();
        let typed = match &args.recipe {
            Some(path) => {
                let recipe = Recipe::read(path)?;
                words = vec!["run".into(), path.display().to_string()];
                Invocation::of(["relievo".into()]).of_recipe(&recipe, &rest)?
            }
            None => {
                let start = ["relievo".into(), OsString::from(name)];
                Invocation::of(start.into_iter().chain(rest))
            }
        };
        let command = parsed(typed.clone())?.of_frame(number);
        let work = command.work();
        work.args().flags.validate()?;
        let mut warnings = work.warnings();
        let (light, said) = light_of(work)?;
        warnings.extend(said);
        let backend = work.args().run.compute.backend;
        let engine = backend.engine()?;
        let other = match backend {
            BackendArg::Cpu => Some(Engine::auto()).filter(Engine::has_device),
            _ => engine.has_device().then(Engine::cpu),
        };
        let source = FrameSource::of(work, &light, number.is_some())?;
        let (loaded, read) = timed(|| source.load(work));
        let (mut loaded, specular) = loaded?;
        look_at_depth(&mut loaded);
        warnings.extend(loaded.warnings);
        Ok(Self {
            typed,
            words,
            command,
            light,
            frame: loaded.frame,
            specular,
            primaries: loaded.chromaticities,
            is_in_sequence: number.is_some(),
            engine,
            other,
            warnings,
            read,
        })
    }

    /// The command as it is typed, without IN and OUT.
    pub(super) fn line(&self) -> String {
        let words = shlex::try_join(self.words.iter().map(String::as_str));
        let words = words.unwrap_or_else(|_| self.words.join(" "));
        format!("relievo {words}")
    }

    /// The command with some settings changed.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a value out of range.
    pub(super) fn command_with(&self, settings: &[(&'static str, String)]) -> Result<Command> {
        let mut command = parsed(self.typed.clone())?;
        let params = &mut command.work_mut().args_mut().flags.params;
        for (name, value) in settings.iter().filter(|(name, _)| *name != BACKEND) {
            params
                .set(name, value)
                .map_err(|expected| Error::Arguments {
                    found: format!("{name} {value}: {expected}"),
                })?;
        }
        params.validate()?;
        Ok(command)
    }

    /// Runs the command with one thing changed.
    ///
    /// # Errors
    /// As the command.
    pub(super) fn shot(&self, change: &Variation) -> Result<Shot> {
        let command = self.command_with(&change.settings)?;
        let moves = change.settings.iter().any(|(name, _)| *name == BACKEND);
        let other = self.other.as_ref().filter(|_| moves);
        let engine = other.unwrap_or(&self.engine);
        match change.without {
            None => self.run(&command, &self.frame, engine),
            Some(remove) => {
                let mut frame = self.frame.clone();
                remove(&mut frame);
                self.run(&command, &frame, engine)
            }
        }
    }

    fn run(&self, command: &Command, frame: &Frame, engine: &Engine) -> Result<Shot> {
        let making = self.making(command, frame);
        // A command of one picture prepares its light.
        engine.forget_environment();
        let (made, used) = timed(|| making.run(engine, &Run::new()));
        let made = made?;
        let shown = making.shown(&made, self.primaries).map(|(shown, _)| {
            let picture = shown.picture();
            let size = [picture.color.r.width(), picture.color.r.height()];
            (pixels_16(&picture), size)
        });
        let (codes, size) = shown.unwrap_or_else(|| {
            let codes = made.planes.iter().flat_map(|(_, map)| map.samples());
            let codes = codes.map(|v| (65_535.0 * v.clamp(0.0, 1.0)) as u16);
            let codes = codes.map(|code| [code, code, code, u16::MAX]);
            (codes.collect(), [frame.mask.width(), frame.mask.height()])
        });
        Ok(Shot {
            codes,
            size,
            made,
            used,
        })
    }

    /// The picture that the command begins from, as a display has it.
    pub(super) fn before(&self) -> Option<Codes> {
        let is_light = matches!(self.command, Command::Enhance(_) | Command::Relight(_));
        let color = self.frame.color.as_ref().filter(|_| is_light)?;
        self.displayed(color.clone(), false)
    }

    /// A picture in place of the one that the command makes, as a display has it: where it takes the frame's picture for its
    /// albedo, as bright as that.
    pub(super) fn displayed(&self, color: ColorPlanes, takes_picture: bool) -> Option<Codes> {
        let made = Results {
            outcome: Outcome {
                color: Some(color),
                takes_picture,
                ..Outcome::default()
            },
            ..Results::default()
        };
        let shown = self
            .making(&self.command, &self.frame)
            .shown(&made, self.primaries)?;
        Some(pixels_16(&shown.0.picture()))
    }

    fn making<'a>(&'a self, command: &'a Command, frame: &'a Frame) -> Making<'a> {
        Making {
            work: command.work(),
            light: &self.light,
            frame,
            specular: self.specular.as_ref(),
            is_in_sequence: self.is_in_sequence,
        }
    }

    /// The pixels that count: those of the surface, or of the whole page for a drawing. `size` is that of the picture.
    pub(super) fn counts(&self, size: [usize; 2]) -> Vec<bool> {
        let mask = &self.frame.mask;
        match self.command {
            Command::Hatch(_) => vec![true; size[0] * size[1]],
            _ => mask.plane().samples().to_vec(),
        }
    }

    /// The plan of a command, `None` for maps, which have several.
    pub(super) fn plan(&self, command: &Command) -> Option<Plan> {
        let making = self.making(command, &self.frame);
        let is_single = making.work.maps().is_none();
        let plans = is_single.then(|| making.work.plans(&mut making.seen()));
        plans?.ok()?.pop()
    }

    /// Whether a change of settings leaves every stage as it is.
    pub(super) fn is_same(&self, change: &Variation) -> bool {
        let key = |command: &Command| {
            let mut plan = self.plan(command)?;
            // The sweeps that follow from these are compared.
            (plan.shape.tolerance, plan.shape.solver) = (0.0, Solver::Chebyshev);
            Some(format!("{plan:?}"))
        };
        let changed = self.command_with(&change.settings);
        let keys = changed
            .ok()
            .and_then(|c| Some((key(&c)?, key(&self.command)?)));
        let moves = change.settings.iter().any(|(name, _)| *name == BACKEND);
        change.without.is_none() && !moves && keys.is_some_and(|(changed, given)| changed == given)
    }

    /// The backend that the command does not run on, if this machine has it.
    pub(super) fn other_backend(&self) -> Option<&'static str> {
        let other = self.other.as_ref()?;
        Some(if other.has_device() { "gpu" } else { "cpu" })
    }

    /// Whether mirrors or lenses are traced.
    pub(super) fn is_specular(&self) -> bool {
        self.specular.is_some()
    }
}

/// The words of --for: a command with its flags.
fn split(text: &str) -> Result<Vec<String>> {
    let words = shlex::split(text);
    let words = words.ok_or_else(|| bad("--for", "has a quote that does not end", "end it"))?;
    let start = usize::from(words.first().is_some_and(|word| word == "relievo"));
    let words = words[start..].to_vec();
    match words.first() {
        Some(name) if COMMANDS.contains(&&name[..]) => Ok(words),
        other => Err(bad(
            "--for",
            format!("begins with {}", other.map_or("nothing", String::as_str)),
            format!("begin it with one of {}, without IN", COMMANDS.join(", ")),
        )),
    }
}

fn parsed(typed: Invocation) -> Result<Command> {
    let parsed = typed.parse().map_err(|error| {
        let found = misuse_line(&error).replacen("error: ", "", 1);
        let remedy = "give a command with its flags, without IN and -o";
        bad("--for", found, remedy)
    })?;
    Ok(parsed.command)
}
