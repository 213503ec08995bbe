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
use crate::params::table::rows;
use crate::params::words::one_of;
use crate::untrusted::shown;
use clap::ValueEnum;
use std::path::{Path, PathBuf};

/// Upper limit of --threads; no machine has more cores.
pub(crate) const MOST_THREADS: u16 = 512;

rows! {
    /// Arguments shared by all commands that make a picture.
    #[derive(Debug, Clone)]
    pub(crate) struct WorkArgs {
        /// The render or photo, or a folder as estimators of normals and depth write one.
        pub(crate) input: PathBuf = [value_name = "IN"];
        /// More inputs, each processed on its own, to the folder named by -o or to a name with {name}: there, and in the
        /// names of all files written beside it, {name} stands for each input's name.
        pub(crate) more: Vec<PathBuf> = [value_name = "MORE"];
        pub(crate) roles: RoleArgs as flatten;
        pub(crate) flags: Flags as flatten;
        _shape: Section<{ Group::Shape as u8 }> as flatten;
        pub(crate) output: OutputArgs as flatten;
        _print: Section<{ Group::Print as u8 }> as flatten;
        pub(crate) sequence: SequenceArgs as flatten;
        pub(crate) run: RunArgs as flatten;
    }
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
        let pixel = self.flags.params.pixel_size;
        Inputs {
            height_unit_px: pixel.map(|pixel| pixel.unit_mm / pixel.mm),
            ..self.roles.inputs(&self.input)
        }
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

rows! {
    /// Where results go.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Output")]
    pub(crate) struct OutputArgs {
        /// File to write; its ending tells the kind, as in .exr .png .jpg .npy; or a folder for a PNG of each input. Without it
        /// --save-recipe writes what would be done.
        pub(crate) output: Option<PathBuf> =
            [short = 'o', long, value_name = "FILE", required_unless_present = "save_recipe"];
        /// What {map} in its name stands for, each in a file of its own.
        pub(crate) parts: Vec<String> = [skip];
        /// Whether a TIFF holds numbers as they are, rather than a picture.
        pub(crate) tiff_holds_numbers: bool = [skip];
        /// Its name as given, and what {name} in it stands for, where it has a place for that.
        pub(crate) named: Option<(PathBuf, String)> = [skip];
        /// EXR: keep the input's bytes and append a part; write channels into its re-encoded first part, for readers that
        /// see no other; or write the results only.
        pub(crate) layers: LayersArg = [long, value_name = "WHAT", default_value = "keep"];
        /// EXR: names of our layers: full, shown by Blender and others, as in relievo.CurvatureKappa.V, or short, as in
        /// curvature.kappa.
        pub(crate) layer_names: LayerNames =
            [hide_short_help = true, long, value_name = "WHICH", default_value = "full"];
        /// EXR: write only these of our layers or channels, as in kappa,curvature.mean; * and ? match any letters. All by
        /// default. Of shape .npy and .tif hold up to four, as floats.
        pub(crate) write: Vec<String> = [long, value_name = "NAMES", value_delimiter = ','];
        /// EXR: compression of the written part; auto is zip, in the way that suits the samples. --layers channels keeps that of
        /// the input.
        pub(crate) compression: OutputCompression =
            [hide_short_help = true, long, value_name = "HOW", default_value = "auto", value_parser = one_of(compressions())];
        /// EXR: sample type; by default pictures keep that of the input (float for a photo), and layers are half.
        pub(crate) depth_of_output: Option<OutputType> =
            [hide_short_help = true, long, visible_alias = "sample-type", value_name = "TYPE", value_parser = one_of(OUTPUT_TYPES)];
        /// JPEG: quality, 1 to 100; 95 by default.
        pub(crate) quality: Option<u8> =
            [long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100)];
        /// Refuse to replace a file.
        pub(crate) no_clobber: bool = [hide_short_help = true, long, conflicts_with = "force"];
        /// Replace write-protected files too.
        pub(crate) force: bool = [hide_short_help = true, long];
    }
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

rows! {
    /// Backend and threads.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Run")]
    pub(crate) struct ComputeArgs {
        /// Backend: auto uses a GPU where the build supports it and one is available, and the CPU for stages without
        /// kernels.
        pub(crate) backend: BackendArg =
            [hide_short_help = true, long, value_name = "WHAT", value_enum, default_value_t = BackendArg::Auto];
        /// Threads; all cores by default.
        pub(crate) threads: Option<u16> =
            [long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into())];
    }
}

rows! {
    /// How the work is run and reported.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Run")]
    pub(crate) struct RunArgs {
        pub(crate) compute: ComputeArgs as flatten;
        /// Memory limit: 2G, 500M, or auto for six tenths of what is free; photos are then processed in strips from 1.5G on.
        pub(crate) max_memory: MaxMemory =
            [hide_short_help = true, long, value_name = "SIZE|auto", default_value_t = MaxMemory::Auto];
        /// Write the settings of this command line, and the automatic choices, as a recipe.
        pub(crate) save_recipe: Option<PathBuf> = [long, value_name = "FILE.toml"];
        /// How to show how far a sequence has come: a bar, a line or a JSON object per frame; auto is a bar on a
        /// terminal, else plain.
        pub(crate) progress: ProgressArg =
            [hide_short_help = true, long, value_name = "HOW", value_enum, default_value_t = ProgressArg::Auto];
        /// Print what ran, how long it took and why, once it has run; with -v what was not made, too.
        pub(crate) explain: bool = [hide_short_help = true, long];
        /// Write how long each stage took, as JSON.
        pub(crate) timings: Option<PathBuf> = [hide_short_help = true, long, value_name = "FILE.json"];
        /// Report how the inputs were read.
        pub(crate) verbose: bool = [short, long, conflicts_with = "quiet"];
        /// Print errors only.
        pub(crate) quiet: bool = [short, long];
    }
}
