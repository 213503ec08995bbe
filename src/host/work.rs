//! A command with its settings, and what it makes of a scene.

use super::made::Made;
use crate::command::chosen::Chosen;
use crate::command::commands::{Command, command_named, long};
use crate::command::enhance::{dark_rims, idle_magnitudes};
use crate::command::error_line::misuse_line;
use crate::command::flags::Flag;
use crate::command::hatch::{Drawn, is_svg, page};
use crate::command::invocation::Invocation;
use crate::command::line_args::HatchArgs;
use crate::command::map::{MapArgs, Samples};
use crate::command::memory::MaxMemory;
use crate::command::output::MadePicture;
use crate::command::reading::{Source, light_of, plan_of, work_of};
use crate::command::recipe::{COMMANDS, Recipe, RecipeText, is_setting, is_switch};
use crate::command::relight::{illumination, light_or_lamp, lit};
use crate::command::sequence::SequenceArgs;
use crate::engine::outcome::Outcome;
use crate::engine::{Engine, Inputs, Run};
use crate::error::{Error, Result};
use crate::frame::{Frame, Mask, Plane, SpecularScene};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::pixels;
use crate::io::svg::write_svg;
use crate::io::{Finding, wrapped};
use crate::light::lights::Illumination;
use crate::plan::planned::DrawnAs;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Stands for the file that the command line would write, whose kind tells what is made.
const LAYERS: &str = "made.exr";
const LINES: &str = "made.svg";

/// Stands for the file that the command line would read, for scenes of arrays.
const ARRAYS: &str = "arrays";

/// A command with its settings.
#[derive(Debug)]
pub struct Work {
    command: Command,
    recipe: RecipeText,
    settings: Vec<(String, String)>,
    light: Illumination,
    warnings: Vec<String>,
}

/// A file as input: a picture, or one frame of a sequence, whose name has a placeholder for the number.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    /// The render or photo.
    pub path: PathBuf,
    /// The number of the frame.
    pub number: Option<i32>,
}

/// A frame, with what else a command has read.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The frame.
    pub frame: Frame,
    /// Conclusions about the inputs.
    pub findings: Vec<Finding>,
    /// Warnings about the inputs.
    pub warnings: Vec<String>,
    /// A mask of 0..1: where and how far a picture is changed, or for other commands where a surface is, above one half.
    pub(super) mask: Option<Plane>,
    pub(super) specular: Option<SpecularScene>,
    /// The primaries of its picture, if a file names them.
    pub(super) primaries: Option<Chromaticities>,
    /// Choices made in reading it.
    pub(super) chosen: Chosen,
    /// What it was read from, if from files.
    pub(super) source: Option<Source>,
}

impl Scene {
    /// A scene of nothing but a frame.
    pub(super) fn of_frame(frame: Frame) -> Self {
        Self {
            frame,
            findings: Vec::new(),
            warnings: Vec::new(),
            mask: None,
            specular: None,
            primaries: None,
            chosen: Chosen::default(),
            source: None,
        }
    }
}

impl Work {
    /// A command with these settings, by their names in recipes; one that takes several values may be given several
    /// times. For a file, settings tell how it is read, too.
    ///
    /// # Errors
    /// [`Error::Arguments`] for an unknown command, setting or value; [`Error::BadParameter`] for values outside their
    /// ranges, and for light that cannot be used; any [`Error`] of reading files of light.
    pub fn new(command: &str, settings: &[(String, String)], file: Option<&File>) -> Result<Self> {
        if !COMMANDS.contains(&command) {
            let found = format!("{command} is no command; give {}", COMMANDS.join(", "));
            return Err(Error::Arguments { found });
        }
        let start = ["relievo".into(), command.into()];
        let flags = words(command, settings)?;
        let typed = Invocation::of(start.into_iter().chain(flags).chain(end(file)));
        Self::parsed(&typed, settings.to_vec())
    }

    /// The same drawing in lines: what is made of it then is an SVG.
    ///
    /// # Errors
    /// [`Error::Arguments`] for commands that draw nothing; [`Error::BadParameter`] for strokes that are no lines.
    pub fn in_lines(mut self) -> Result<Self> {
        let Command::Hatch(args) = &mut self.command else {
            let found = "only hatch draws lines".into();
            return Err(Error::Arguments { found });
        };
        args.relight.work.output.output = Some(LINES.into());
        args.looks()?;
        Ok(self)
    }

    /// How and from where frames are read.
    pub(super) fn inputs(&self) -> crate::io::inputs::Inputs {
        let work = work_of(&self.command);
        work.roles.inputs(&work.input)
    }

    /// The frames that all automatic settings are chosen from.
    pub(super) fn sequence(&self) -> &SequenceArgs {
        &work_of(&self.command).sequence
    }

    /// The command of a recipe, with further settings, which overrule it. Its automatic choices apply to frames of the
    /// names that they were made for.
    ///
    /// # Errors
    /// As [`Work::new`]; [`Error::Recipe`] for settings that the command does not take.
    pub fn of_recipe(
        recipe: &Recipe,
        settings: &[(String, String)],
        file: Option<&File>,
    ) -> Result<Self> {
        let rest = words(&recipe.command, settings)?;
        let rest: Vec<_> = rest.into_iter().chain(end(file)).collect();
        let typed = Invocation::of(["relievo".into()]).of_recipe(recipe, &rest)?;
        let own = recipe.flags(&command_named(&recipe.command))?;
        let own = own.iter().map(named);
        Self::parsed(&typed, own.chain(settings.iter().cloned()).collect())
    }

    fn parsed(invocation: &Invocation, settings: Vec<(String, String)>) -> Result<Self> {
        let parsed = invocation.parse().map_err(|error| Error::Arguments {
            found: misuse_line(&error).replacen("error: ", "", 1),
        })?;
        let command = parsed.cli.command;
        let flags = &work_of(&command).flags;
        flags.validate()?;
        match &command {
            Command::Shape(_) => {}
            Command::Map(args) => args.check()?,
            Command::Hatch(args) => args.looks().map(|_| ())?,
            _ => flags.refuse_more_scales()?,
        }
        let scaling = &flags.params.scaling;
        let mut warnings = match &command {
            Command::Enhance(_) => dark_rims(scaling),
            Command::Relight(args) if args.params().method.scales() => dark_rims(scaling),
            _ => Vec::new(),
        };
        let light = match light_of(&command) {
            Some(args) => illumination(args, MaxMemory::Auto.for_light())?,
            None => Illumination::default(),
        };
        let light = match &command {
            Command::Relight(args) => {
                let (light, said) = light_or_lamp(args, light);
                warnings.extend(said);
                warnings.extend(args.past_the_zenith());
                light
            }
            _ => light,
        };
        Ok(Self {
            recipe: RecipeText::of(&parsed.matches, invocation.kept()),
            command,
            settings,
            light,
            warnings,
        })
    }

    /// Its settings, by their names in recipes.
    pub fn settings(&self) -> &[(String, String)] {
        &self.settings
    }

    /// It as a recipe, with the choices made for `made`, if anything has been made.
    pub fn recipe(&self, made: Option<&Made>) -> String {
        let none = Chosen::default();
        self.recipe.with(made.map_or(&none, |made| &made.chosen))
    }

    /// Reads `file` as far as the command needs it; `held` is returned if the same was read for it.
    ///
    /// # Errors
    /// As [`crate::io::load`].
    pub fn load(&self, file: &File, held: Option<Arc<Scene>>) -> Result<Arc<Scene>> {
        let source = Source::of(&self.command, &self.light, file.number)?;
        if let Some(held) = held.filter(|held| held.source.as_ref() == Some(&source)) {
            return Ok(held);
        }
        let (loaded, specular) = source.load(&self.command)?;
        Ok(Arc::new(Scene {
            specular,
            chosen: Chosen::in_loading(&loaded),
            primaries: loaded.chromaticities,
            findings: loaded.findings,
            warnings: loaded.warnings,
            source: Some(source),
            ..Scene::of_frame(loaded.frame)
        }))
    }

    /// What the command makes of a scene.
    ///
    /// # Errors
    /// As [`Engine::run`]; [`Error::BadParameter`] for settings that the frame does not allow.
    pub fn run(&self, engine: &Engine, scene: &Scene, run: &Run) -> Result<Made> {
        let fitted = self.fitted(scene);
        let frame = fitted.as_ref().unwrap_or(&scene.frame);
        let made = match &self.command {
            Command::Map(args) => maps(args, engine, frame, run)?,
            Command::Hatch(args) => self.draw(args, engine, scene, frame, run)?,
            _ => self.picture(engine, scene, frame, run)?,
        };
        let mut warnings = self.warnings.clone();
        if let Command::Enhance(args) = &self.command {
            let scaling = &args.work.flags.params.scaling;
            warnings.extend(idle_magnitudes(scaling, &frame.light));
        }
        Ok(Made {
            chosen: scene.chosen.clone().running(&made.outcome),
            warnings,
            ..made
        })
    }

    /// Layers or a picture.
    fn picture(&self, engine: &Engine, scene: &Scene, frame: &Frame, run: &Run) -> Result<Made> {
        let (plan, light) = plan_of(
            &self.command,
            frame,
            self.light.clone(),
            drawn(1.0, scene.specular.is_some()),
        )?;
        let inputs = Inputs {
            specular: scene.specular.as_ref(),
            ..Inputs::lit_by(&light)
        };
        let mut outcome = engine.execute(&plan, frame, inputs, run)?;
        work_of(&self.command).mix(frame, &mut outcome);
        if let Command::Enhance(_) = self.command {
            // A plan with nothing to do leaves the picture as it is.
            outcome.color = outcome.color.take().or_else(|| frame.color.clone());
        }
        Ok(Made {
            outcome,
            ..Made::default()
        })
    }

    /// A picture or a drawing as a PNG of 8 bits would hold it: columns and rows, and red, green, blue and alpha, not
    /// premultiplied; `None` for other commands. An exposure that is chosen for it is one of the choices from then on.
    pub fn shown(&self, scene: &Scene, made: &mut Made) -> Option<([usize; 2], Vec<[u8; 4]>)> {
        let (work, frame) = (work_of(&self.command), &scene.frame);
        let chosen = made.chosen.clone();
        let color = made.picture()?;
        let before = match &self.command {
            Command::Enhance(_) => frame.color.as_ref(),
            Command::Relight(_) => lit(frame, &made.outcome, work.flags.params.mix).before,
            Command::Hatch(args) => {
                let page = args.on_a_page(color, frame.pixel_aspect);
                return Some(([color.r.width(), color.r.height()], pixels(&page)));
            }
            _ => return None,
        };
        let picture = MadePicture { color, before };
        let exposure = picture.exposure(&work.flags.params.display, &frame.mask);
        let displayed = work.displayed(frame, scene.primaries, picture, exposure);
        let size = [color.r.width(), color.r.height()];
        let shown = pixels(&displayed.picture());
        made.chosen = chosen.exposed(exposure);
        Some((size, shown))
    }

    /// The frame of a scene of arrays, with its mask and its borders as the command has them; `None` where it is as it
    /// is, as all frames of files are.
    fn fitted(&self, scene: &Scene) -> Option<Frame> {
        if scene.source.is_some() {
            return None;
        }
        let wraps = wrapped(&scene.frame.normal, self.inputs().wrap);
        if scene.mask.is_none() && wraps == scene.frame.wraps {
            return None;
        }
        let mut frame = scene.frame.clone();
        frame.wraps = wraps;
        let changes_picture = match &self.command {
            Command::Hatch(args) => !is_svg(&args.relight.work),
            Command::Enhance(_) | Command::Relight(_) => true,
            _ => false,
        };
        match (&scene.mask, changes_picture) {
            (Some(given), true) => frame.strength = Some(given.clone()),
            (Some(given), false) => {
                let (width, height) = (given.width(), given.height());
                let is_in = |x: usize, y: usize| frame.mask.at(x, y) && given.row(y)[x] > 0.5;
                frame.mask = Mask::new(Plane::from_fn(width, height, is_in));
            }
            (None, _) => {}
        }
        Some(frame)
    }

    fn draw(
        &self,
        args: &HatchArgs,
        engine: &Engine,
        scene: &Scene,
        frame: &Frame,
        run: &Run,
    ) -> Result<Made> {
        let looks = args.looks()?;
        let art_map = args.art_map(&looks)?;
        let times = args.times(frame)?;
        let is_specular = scene.specular.is_some();
        if times != 1.0 && is_specular {
            return Err(Error::BadParameter {
                name: "--enlarge",
                found: "does not go with mirrors and lenses".into(),
                remedy: "leave it out".into(),
            });
        }
        let enlarged = (times != 1.0).then(|| frame.enlarged(times));
        let frame = enlarged.as_ref().unwrap_or(frame);
        let drawn = drawn(times, is_specular);
        let (mut plan, light) = plan_of(&self.command, frame, self.light.clone(), drawn)?;
        let in_lines = is_svg(&args.relight.work);
        plan.drawn_as = match in_lines {
            true => DrawnAs::Lines,
            false => DrawnAs::Layers,
        };
        let inputs = Inputs {
            specular: scene.specular.as_ref(),
            art_map: art_map.as_ref(),
            ..Inputs::lit_by(&light)
        };
        let mut outcome = engine.execute(&plan, frame, inputs, run)?;
        let drawing = outcome.drawing.as_mut().expect("a drawing was planned");
        if in_lines {
            let mut text = Vec::new();
            let drawn = page(frame, drawing, &looks.line.strokes);
            write_svg(&mut text, Path::new(LINES), &drawn)?;
            return Ok(Made {
                svg: Some(String::from_utf8(text).expect("an SVG is text")),
                outcome,
                ..Made::default()
            });
        }
        args.mix(drawing, frame, times);
        Ok(Made {
            printed: Some(args.printed(drawing)),
            outcome,
            ..Made::default()
        })
    }
}

fn maps(args: &MapArgs, engine: &Engine, frame: &Frame, run: &Run) -> Result<Made> {
    let (mut samples, mut outcome) = (Samples::default(), Outcome::default());
    for pass in args.passes(frame)? {
        let mut of_pass = engine.execute(&pass.plan, frame, Inputs::default(), run)?;
        outcome.gain = outcome.gain.or(of_pass.gain);
        samples.take(&pass, &mut of_pass);
        engine.recycle(of_pass);
    }
    let parts = args.parts().into_iter();
    let maps = parts.map(|part| {
        let made = args.made(&part, &samples, &frame.mask);
        (part.name, made.plane)
    });
    Ok(Made {
        maps: maps.collect(),
        outcome,
        ..Made::default()
    })
}

fn drawn(times: f64, is_specular: bool) -> Drawn {
    Drawn {
        times,
        is_in_sequence: false,
        moves: false,
        is_specular,
    }
}

/// Settings as words of the command line.
fn words(command: &str, settings: &[(String, String)]) -> Result<Vec<OsString>> {
    let command = command_named(command);
    let word = |(name, value): &(String, String)| {
        let known = long(&command, name).filter(|arg| is_setting(arg));
        let arg = known.ok_or_else(|| Error::Arguments {
            found: format!("{} takes no {name}", command.get_name()),
        })?;
        Ok(match (is_switch(arg), &value[..]) {
            (true, "false") => None,
            (true, "true") => Some(Flag::switch(name).word()),
            _ => Some(Flag::new(name, value).word()),
        })
    };
    settings
        .iter()
        .filter_map(|pair| word(pair).transpose())
        .collect()
}

/// The last words of a command line.
fn end(file: Option<&File>) -> Vec<OsString> {
    let path = file.map_or(Path::new(ARRAYS), |file| &file.path);
    vec!["-o".into(), LAYERS.into(), "--".into(), path.into()]
}

/// A flag as a setting.
fn named(flag: &Flag) -> (String, String) {
    (flag.name().into(), flag.value().unwrap_or("true").into())
}
