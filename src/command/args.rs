//! Arguments that commands on frames share: outputs and run options.

use super::flags::{Flags, Section};
use super::memory::MaxMemory;
use super::named::Named;
use super::role_args::RoleArgs;
use super::sequence::SequenceArgs;
use crate::engine::Engine;
use crate::error::{Error, Result, bad};
use crate::io::exr::{OutputCompression, OutputType};
use crate::io::inputs::{Inputs, Wrap};
use crate::io::output::full_name;
use crate::io::sequence::path_of_frame;
use crate::io::{frame_bytes, program_bytes};
use crate::params::Group;
use crate::params::words::one_of;
use crate::untrusted::shown;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// Upper limit of --threads; no machine has more cores.
pub(crate) const MOST_THREADS: u16 = 512;

/// Arguments shared by all commands that make a picture.
#[derive(Debug, Clone, Args)]
pub(crate) struct WorkArgs {
    /// The render or photo, or a folder as estimators of normals and depth write one.
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// More inputs, each processed on its own, to the folder named by -o or to a name with {name}: there, and in the
    /// names of all files written beside it, {name} stands for each input's name.
    #[arg(value_name = "MORE")]
    pub(crate) more: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArgs,
    #[command(flatten)]
    pub(crate) flags: Flags,
    #[command(flatten)]
    _shape: Section<{ Group::Shape as u8 }>,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    _print: Section<{ Group::Print as u8 }>,
    #[command(flatten)]
    pub(crate) sequence: SequenceArgs,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

impl WorkArgs {
    /// The frames of a sequence; `None` for a single picture.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for frames and names that do not match, and for a single timings file for a sequence.
    pub(crate) fn frames(&self) -> Result<Option<&[i32]>> {
        let frames = self
            .sequence
            .frames
            .of(&self.input, self.output.output.as_deref())?;
        match &self.run.timings {
            Some(path) if frames.is_some() && path_of_frame(path, 0).is_none() => Err(bad(
                "--timings",
                format!("{} is one file for all frames", shown(path)),
                "put #### where their numbers go",
            )),
            _ => Ok(frames),
        }
    }

    /// The layers and files that are named.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        let mut all = vec![Named::Input(&mut self.input)];
        all.extend(self.roles.names());
        let written = [&mut self.output.output, &mut self.run.timings];
        all.extend(written.into_iter().flatten().map(Named::Output));
        all
    }

    /// Files and layers to read.
    pub(crate) fn inputs(&self) -> Inputs {
        self.roles.inputs(&self.input)
    }

    /// Estimated memory, in bytes, for processing `picture`.
    pub(crate) fn frame_bytes(&self, picture: &Path) -> u64 {
        let may_wrap = self.roles.named.wrap != Wrap::None;
        frame_bytes(picture, self.flags.more_scales().len(), may_wrap)
    }

    /// Refuses a `picture` over the memory limit, for commands that need the whole of it.
    pub(crate) fn refuse_too_large(&self, picture: &Path) -> Result<()> {
        self.refuse_above(picture, 0, "needs the picture whole")
    }

    /// Refuses a `picture` that takes more than the memory limit together with so many bytes `beside` it, and says `why`.
    pub(crate) fn refuse_above(&self, picture: &Path, beside: u64, why: &str) -> Result<()> {
        let bytes = program_bytes() + self.frame_bytes(picture).saturating_add(beside);
        match bytes > self.run.max_memory.most() {
            true => Err(self.too_large(picture, why, bytes)),
            false => Ok(()),
        }
    }

    /// Error for a picture that needs at least `least` bytes.
    pub(crate) fn too_large(&self, picture: &Path, why: &str, least: u64) -> Error {
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        Error::Unsupported {
            path: picture.to_path_buf(),
            found: format!(
                "takes about {} MiB, and {} are allowed; this {why}",
                mib(self.frame_bytes(picture).max(least)),
                mib(self.run.max_memory.most()),
            ),
            remedy: format!("give --max-memory {}M or more, or crop it", mib(least)),
        }
    }
}

/// Where results go.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// File to write: .exr .png .jpg .tif .hdr .npy, or a folder for a PNG of each input. Without it --save-recipe writes what would be done.
    #[arg(
        short = 'o',
        long,
        value_name = "FILE",
        required_unless_present = "save_recipe"
    )]
    pub(crate) output: Option<PathBuf>,
    /// What {map} in its name stands for, each in a file of its own.
    #[arg(skip)]
    pub(crate) parts: Vec<String>,
    /// Whether a TIFF holds numbers as they are, rather than a picture.
    #[arg(skip)]
    pub(crate) tiff_holds_numbers: bool,
    /// Its name as given, and what {name} in it stands for, where it has a place for that.
    #[arg(skip)]
    pub(crate) named: Option<(PathBuf, String)>,
    /// EXR: keep the input's bytes and append a part; write channels into its re-encoded first part, for readers that
    /// see no other; or write the results only.
    #[arg(long, value_name = "WHAT", default_value = "keep")]
    pub(crate) layers: LayersArg,
    /// EXR: names of our layers: full, shown by Blender and others, as in relievo.CurvatureKappa.V, or short, as in
    /// curvature.kappa.
    #[arg(
        hide_short_help = true,
        long,
        value_name = "WHICH",
        default_value = "full"
    )]
    pub(crate) layer_names: LayerNames,
    /// EXR: write only these of our layers or channels, as in kappa,curvature.mean; * and ? match any letters. All by
    /// default. Of shape .npy and .tif hold up to four, as floats.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) write: Vec<String>,
    /// EXR: compression of the written part; auto is zip, in the way that suits the samples. --layers channels keeps that of
    /// the input.
    #[arg(hide_short_help = true, long, value_name = "HOW", default_value = "auto", value_parser = one_of(compressions()))]
    pub(crate) compression: OutputCompression,
    /// EXR: sample type; by default pictures keep that of the input (float for a photo), and layers are half.
    #[arg(hide_short_help = true, long, visible_alias = "sample-type", value_name = "TYPE", value_parser = one_of(OUTPUT_TYPES))]
    pub(crate) depth_of_output: Option<OutputType>,
    /// JPEG: quality, 1 to 100; 95 by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) quality: Option<u8>,
    /// Refuse to replace a file.
    #[arg(hide_short_help = true, long, conflicts_with = "force")]
    pub(crate) no_clobber: bool,
    /// Replace write-protected files too.
    #[arg(hide_short_help = true, long)]
    pub(crate) force: bool,
}

/// Compressions by name.
fn compressions() -> impl Iterator<Item = (OutputCompression, &'static str)> {
    let named = OutputCompression::ALL.map(|kind| (kind, kind.name()));
    [(OutputCompression::default(), "auto")]
        .into_iter()
        .chain(named)
}

/// Names of sample types.
const OUTPUT_TYPES: [(OutputType, &str); 2] =
    [(OutputType::Half, "half"), (OutputType::Float, "float")];

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayersArg {
    Keep,
    Channels,
    Results,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LayerNames {
    Full,
    Short,
}

impl LayerNames {
    /// The channel name for the `short` name in our tables.
    pub(crate) fn of(self, short: &str) -> String {
        match self {
            Self::Full => full_name(short),
            Self::Short => short.into(),
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendArg {
    Auto,
    Cpu,
    Gpu,
}

impl BackendArg {
    /// The engine of this backend.
    ///
    /// # Errors
    /// [`crate::Error::NoGpu`] where a device is required and none is available.
    pub(crate) fn engine(self) -> Result<Engine> {
        match self {
            Self::Auto => Ok(Engine::auto()),
            Self::Cpu => Ok(Engine::cpu()),
            Self::Gpu => Engine::gpu(),
        }
    }
}

/// How the progress of a sequence is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressArg {
    Auto,
    Bar,
    Plain,
    Json,
    None,
}

/// Backend and threads.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub(crate) struct ComputeArgs {
    /// Backend: auto uses a GPU where the build supports it and one is available, and the CPU for stages without
    /// kernels.
    #[arg(hide_short_help = true, long, value_name = "WHAT", value_enum, default_value_t = BackendArg::Auto)]
    pub(crate) backend: BackendArg,
    /// Threads; all cores by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()))]
    pub(crate) threads: Option<u16>,
}

/// How the work is run and reported.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunArgs {
    #[command(flatten)]
    pub(crate) compute: ComputeArgs,
    /// Memory limit: 2G, 500M, or auto for six tenths of what is free; photos are then processed in strips from 1.5G on.
    #[arg(hide_short_help = true, long, value_name = "SIZE|auto", default_value_t = MaxMemory::Auto)]
    pub(crate) max_memory: MaxMemory,
    /// Write the settings of this command line, and the automatic choices, as a recipe.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) save_recipe: Option<PathBuf>,
    /// How to show how far a sequence has come: a bar, a line or a JSON object per frame; auto is a bar on a
    /// terminal, else plain.
    #[arg(hide_short_help = true, long, value_name = "HOW", value_enum, default_value_t = ProgressArg::Auto)]
    pub(crate) progress: ProgressArg,
    /// Print what ran, how long it took and why, once it has run; with -v what was not made, too.
    #[arg(hide_short_help = true, long)]
    pub(crate) explain: bool,
    /// Write how long each stage took, as JSON.
    #[arg(hide_short_help = true, long, value_name = "FILE.json")]
    pub(crate) timings: Option<PathBuf>,
    /// Report how the inputs were read.
    #[arg(short, long, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
    /// Print errors only.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
