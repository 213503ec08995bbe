//! The commands that make something of a frame, each in a file of its own: what it reads, the plans that it runs, and its
//! results. Doors add the rest: files and messages, arrays, or a session.

mod enhance;
mod hatch;
pub(crate) mod making;
pub(crate) mod map;
mod relight;
pub(crate) mod shape;
pub(crate) mod source;

pub(crate) use enhance::dark_rims;
#[cfg(feature = "view")]
pub(crate) use relight::{illumination, lights};

use crate::command::args::WorkArgs;
use crate::command::commands::Command;
use crate::command::map::MapArgs;
use crate::command::motion_arg::MotionArg;
use crate::command::named::Named;
use crate::command::relight_args::RelightArgs;
use crate::error::Result;
use crate::frame::{Frame, Plane};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::Inputs;
use crate::io::output::layers::color_channels;
use crate::io::output::picture::MadePicture;
use crate::io::{Loaded, Needs, SpecularInputs, svg};
use crate::light::lights::Illumination;
use crate::line::tonal_art_map::TonalArtMap;
use crate::plan::Plan;
use crate::plan::outcome::Outcome;
use map::MapSamples;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// A frame, and how a command meets it.
pub(crate) struct FrameSeen<'f, 'l> {
    pub(crate) frame: &'f Frame,
    pub(crate) light: Cow<'l, Illumination>,
    /// Whether mirrors or lenses are traced.
    pub(crate) is_specular: bool,
    /// How many times as large as it was read.
    pub(crate) times: f64,
    /// Whether it belongs to a sequence, whose frames need consistent tones and lines.
    pub(crate) is_in_sequence: bool,
    /// Whether strokes move with the surface.
    pub(crate) moves: bool,
}

impl<'f, 'l> FrameSeen<'f, 'l> {
    /// A single frame as it was read, in this light.
    pub(crate) fn new(frame: &'f Frame, light: &'l Illumination) -> Self {
        Self {
            frame,
            light: Cow::Borrowed(light),
            is_specular: false,
            times: 1.0,
            is_in_sequence: false,
            moves: false,
        }
    }
}

/// What a command has made of a frame.
#[derive(Debug, Default)]
pub(crate) struct Results {
    pub(crate) outcome: Outcome,
    /// What maps are made of.
    pub(crate) maps: MapSamples,
    /// What there is to say of it, and to warn of.
    pub(crate) notes: Vec<String>,
    pub(crate) warnings: Vec<String>,
    /// Planes of maps by name, where they are kept in memory.
    pub(crate) planes: Vec<(String, Plane)>,
    /// A drawing as the text of an SVG, likewise.
    pub(crate) svg: Option<String>,
}

/// A command that makes something of a frame, with its settings.
pub(crate) trait FrameWork: Sync {
    /// The arguments that all commands share.
    fn args(&self) -> &WorkArgs;

    fn args_mut(&mut self) -> &mut WorkArgs;

    /// The layers and files that are named.
    fn names(&mut self) -> Vec<Named<'_>> {
        self.args_mut().names()
    }

    /// A folder whose files are all inputs.
    fn folder(&self) -> Option<&Path> {
        None
    }

    /// The arguments of light.
    fn light(&self) -> Option<&RelightArgs> {
        None
    }

    /// The arguments of maps, if those are made.
    fn maps(&self) -> Option<&MapArgs> {
        None
    }

    /// The motion between frames, if a frame depends on the ones before it.
    fn motion(&self) -> Option<&MotionArg> {
        None
    }

    /// Refuses settings that contradict each other or the output: what does not go with a single picture.
    fn check(&self) -> Result<()> {
        self.args().check_one_picture()
    }

    /// Refuses what mirrors and lenses are to show where it cannot be shown.
    fn check_specular(&self, _inputs: &SpecularInputs) -> Result<()> {
        Ok(())
    }

    /// Warnings about its settings, whatever they are applied to.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Warnings about its settings on this frame.
    fn warnings_on(&self, _frame: &Frame) -> Vec<String> {
        Vec::new()
    }

    /// Adds a lamp to light that would leave all dark, and says so.
    fn add_lamp(&self, _light: &mut Illumination) -> Option<String> {
        None
    }

    /// The stroke texture, if it comes from pictures.
    fn art_map(&self) -> Result<Option<TonalArtMap>> {
        Ok(None)
    }

    /// Files and layers to read, in this light.
    fn reading(&self, light: &Illumination) -> Result<(Inputs, Needs)>;

    /// Whether the picture cannot go in strips.
    fn takes_whole(&self) -> bool {
        false
    }

    /// Refuses a `picture` over the memory limit, by its header.
    fn refuse_too_large(&self, picture: &Path) -> Result<()> {
        self.args().refuse_too_large(picture)
    }

    /// Bytes for what lies around the tile `picture`, beside its frame, by its header.
    fn bytes_around_tile(&self, _picture: &Path) -> u64 {
        0
    }

    /// The enlargement of a frame, and whether the memory limit allows it.
    fn times(&self, _frame: &Frame, _is_specular: bool, _is_alone: bool) -> Result<f64> {
        Ok(1.0)
    }

    /// Whether layers are made that can be written some rows at a time.
    fn goes_by_rows(&self) -> bool {
        false
    }

    /// Begins to make something of a frame: reads what is laid over it.
    fn begin(&self, _inputs: &Inputs, _frame: &Frame) -> Result<Results> {
        Ok(Results::default())
    }

    /// The plans that are run on a frame, one after another. A lamp is added to its light where tones need one.
    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>>;

    /// Takes the results of a plan; what is left of them can be recycled.
    fn take(&self, made: &mut Results, _plan: &Plan, outcome: Outcome) -> Outcome {
        made.outcome = outcome;
        Outcome::default()
    }

    /// The picture that was made, if one was.
    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>>;

    /// The layers that were made, with the colours of the picture.
    fn channels<'a>(
        &self,
        loaded: &'a Loaded,
        outcome: &'a Outcome,
        picture: Option<&'a MadePicture>,
    ) -> Vec<OutputChannel<'a>> {
        let _ = outcome;
        let picture = picture.expect("a picture was made");
        let output = &self.args().output;
        let sample_type = output
            .depth_of_output
            .unwrap_or(match loaded.color_is_half {
                true => OutputType::Half,
                false => OutputType::Float,
            });
        let (layer, alpha) = (output.color_layer(loaded), loaded.frame.alpha.as_ref());
        color_channels(layer, &picture.color, alpha, sample_type)
    }

    /// The lines that were made, if they are written as such.
    fn lines<'a>(&self, _frame: &Frame, _outcome: &'a Outcome) -> Option<svg::LinePage<'a>> {
        None
    }
}

impl WorkArgs {
    /// Refuses what does not go with a single picture.
    fn check_one_picture(&self) -> Result<()> {
        self.output.kind()?;
        self.output.refuse_numbers()?;
        self.flags.refuse_more_scales()
    }
}

impl Command {
    /// The command that makes something of a frame.
    ///
    /// # Panics
    /// If it is none of those of recipes.
    pub(crate) fn work(&self) -> &dyn FrameWork {
        match self {
            Self::Shape(args) => args,
            Self::Enhance(args) => args,
            Self::Relight(args) => &**args,
            Self::Hatch(args) => &**args,
            Self::Map(args) | Self::Normals(args) => args,
            _ => unreachable!("it is one of the commands of recipes"),
        }
    }

    /// The same, to be changed.
    pub(crate) fn work_mut(&mut self) -> &mut dyn FrameWork {
        match self {
            Self::Shape(args) => args,
            Self::Enhance(args) => args,
            Self::Relight(args) => &mut **args,
            Self::Hatch(args) => &mut **args,
            Self::Map(args) | Self::Normals(args) => args,
            _ => unreachable!("it is one of the commands of recipes"),
        }
    }

    /// The command for one frame of a sequence, or for a single picture.
    pub(crate) fn of_frame(&self, frame: Option<i32>) -> Self {
        let mut one = self.clone();
        if let Some(frame) = frame {
            let names = one.work_mut().names();
            names.into_iter().for_each(|name| name.number(frame));
        }
        one
    }

    /// Every input that is a separate file.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let mut one = self.clone();
        let names = one.work_mut().names().into_iter();
        names.filter_map(Named::file).collect()
    }
}

/// The light of a command, with a lamp in place of none, and what is to be said of that.
pub(crate) fn light_of(work: &dyn FrameWork) -> Result<(Illumination, Option<String>)> {
    let mut light = work.light().map(relight::illumination).transpose()?;
    let light = light.get_or_insert_default();
    let said = work.add_lamp(light);
    Ok((std::mem::take(light), said))
}
