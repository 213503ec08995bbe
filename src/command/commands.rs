//! The commands and their arguments. Flags of parameters come from their table.

use super::args::{ComputeArgs, MOST_THREADS, WorkArgs};
use super::flags::{Flags, Section, SumFlag};
use super::light_layers::LightLayerFlags;
use super::line_args::HatchArgs;
use super::map::MapArgs;
use super::motion_arg::MotionArg;
use super::recipe;
use super::relight_args::RelightArgs;
use super::role_args::RoleArgs;
use super::sequence::FramesArg;
use crate::params::Group;
use crate::params::table::rows;
use clap::parser::ValueSource;
use clap::{ArgAction, ArgMatches, Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Brings out the shape of surfaces in pictures, from their normals and depth.
#[derive(Debug, Parser)]
#[command(
    name = "relievo",
    version,
    arg_required_else_help = true,
    args_override_self = true,
    disable_help_flag = true
)]
pub(crate) struct Cli {
    /// Print help: what most users need.
    #[arg(short, long, global = true, action = ArgAction::HelpShort)]
    help: Option<bool>,
    /// Print help on all options.
    #[arg(long = ALL_OPTIONS, global = true)]
    help_all: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// Commands that make something of a frame, which recipes can run.
pub(crate) const COMMANDS: [&str; 6] = ["shape", "enhance", "relight", "hatch", "map", "normals"];

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum Command {
    /// Describe files: the role and space of each layer, and the evidence.
    #[command(after_help = examples("inspect"))]
    Inspect(InspectArgs),
    /// Write the shape descriptor: layers to an EXR, or the coloured curvature display to a picture.
    #[command(after_help = examples("shape"))]
    Shape(ShapeArgs),
    /// Bring out the shape in the shading that a picture already has.
    #[command(after_help = examples("enhance"))]
    Enhance(EnhanceArgs),
    /// Relight the surface: lights, an environment or a lit sphere, bent and scaled by curvature.
    #[command(after_help = examples("relight"))]
    Relight(Box<RelightArgs>),
    /// Draw the surface: pen or pencil strokes along its curvature, lines along its edges.
    #[command(after_help = examples("hatch"), mut_arg("sum", |sum| sum.hide(true)))]
    Hatch(Box<HatchArgs>),
    /// Make maps for textures: curvature, its convex and concave parts, edges, height, occlusion, normals.
    #[command(after_help = examples("map"))]
    Map(MapArgs),
    /// Write the normals that all commands use: those of the input, or of its depth, heights or positions.
    #[command(
        after_help = examples("normals"),
        mut_arg("maps", |maps| maps.default_value("normals").hide(true)),
        mut_arg("sum", |sum| sum.hide(true))
    )]
    Normals(MapArgs),
    /// Run a recipe: a command with its settings, as --save-recipe writes one from any command line.
    #[command(after_help = run_examples())]
    Run(RecipeArgs),
    /// Print the JSON schema of recipes.
    Schema,
    /// Print what makes a shell complete commands, options and the layers of a file.
    #[command(after_help = examples("completions"))]
    Completions(CompletionsArgs),
    /// Print a manual page: of the program, or of a command.
    #[command(after_help = examples("man"))]
    Man(ManArgs),
    /// Open a window in which a look is tuned and saved as a recipe.
    #[command(after_help = examples("view"))]
    View(ViewArgs),
    /// Measure a command on a frame: error against run time, and what it can leave out.
    #[command(after_help = examples("report"))]
    Report(ReportArgs),
}

/// The examples of a command, from the text that has those of all.
fn examples(command: &str) -> &'static str {
    let all = include_str!("examples.txt").split("\n\n");
    let mut named = all.filter_map(|one| one.split_once('\n'));
    let own = named.find(|(name, _)| *name == command);
    own.expect("every command has its examples").1.trim_end()
}

fn run_examples() -> String {
    format!(
        "{}\n\nPresets, for drawings: {}.",
        examples("run"),
        recipe::presets()
    )
}

#[derive(Debug, Clone, Args)]
pub(crate) struct CompletionsArgs {
    /// The shell.
    #[arg(value_name = "SHELL")]
    pub(crate) shell: Shell,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ManArgs {
    /// A command; all in short if left out.
    #[arg(value_name = "COMMAND")]
    pub(crate) command: Option<String>,
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct InspectArgs {
        /// Files to look into.
        pub(crate) files: Vec<PathBuf> = [required = true, value_name = "FILE"];
        pub(crate) roles: RoleArgs as flatten;
        /// Planned scaling magnitude: warn where it is too high.
        pub(crate) scaling: Option<f32> = [long, value_name = "G", allow_negative_numbers = true];
        /// Planned invariant point, for the same warning.
        pub(crate) invariant_point: Option<f32> = [long, value_name = "A", allow_negative_numbers = true];
        /// Print one JSON array instead of text.
        pub(crate) json: bool = [long];
    }
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct RecipeArgs {
        /// The recipe: a TOML file, or the name of a preset.
        pub(crate) recipe: PathBuf = [value_name = "RECIPE"];
        /// IN, -o OUT and other arguments of the recipe's command; they go before its settings. --keep-levels applies the
        /// recipe's automatic choices to other frames too.
        pub(crate) rest: Vec<OsString> =
            [value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true];
    }
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct ViewArgs {
        /// The render or photo; one can also be opened in the window.
        pub(crate) input: Option<PathBuf> = [value_name = "IN"];
        /// Recipe to begin with.
        pub(crate) recipe: Option<PathBuf> = [long, value_name = "FILE.toml", help_heading = "Run"];
        pub(crate) roles: RoleArgs as flatten;
        pub(crate) frames: FramesArg as flatten;
        pub(crate) compute: ComputeArgs as flatten;
    }
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct ShapeArgs {
        pub(crate) work: WorkArgs as flatten;
        _relief: Section<{ Group::Relief as u8 }> as flatten;
    }
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct EnhanceArgs {
        pub(crate) work: WorkArgs as flatten;
        _lobes: Section<{ Group::LightLayers as u8 }> as flatten;
        pub(crate) light: LightLayerFlags as flatten;
        _sum: SumFlag as flatten;
        _scaling: Section<{ Group::Scaling as u8 }> as flatten;
        _white_levels: Section<{ Group::WhiteLevels as u8 }> as flatten;
        _display: Section<{ Group::Display as u8 }> as flatten;
    }
}

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct ReportArgs {
        /// The render or photo, or a folder as estimators of normals and depth write one.
        pub(crate) input: PathBuf =
            [value_name = "IN", required_unless_present = "cases", default_value = ".", hide_default_value = true];
        /// The command to report on, with its flags, without IN and -o: enhance by default.
        pub(crate) command: Option<String> = [long = "for", value_name = "COMMAND", help_heading = "Run"];
        /// The same from a recipe, or a preset.
        pub(crate) recipe: Option<PathBuf> =
            [long, value_name = "FILE.toml", help_heading = "Run", conflicts_with = "command"];
        pub(crate) roles: RoleArgs as flatten;
        _flags: Flags as flatten;
        _shape: Section<{ Group::Shape as u8 }> as flatten;
        pub(crate) frames: FramesArg as flatten;
        motion: MotionArg as flatten;
        /// Directory for report.html, one page that loads nothing, and report.json with every number; created if missing, older
        /// files replaced. Without it the report is printed.
        pub(crate) output: Option<PathBuf> = [short = 'o', long, value_name = "DIR", help_heading = "Output"];
        /// Time it may take in seconds: 15 by default, 45 in the light of an environment.
        pub(crate) budget: Option<u16> =
            [long, value_name = "S", help_heading = "Run", value_parser = clap::value_parser!(u16).range(1..=3600)];
        /// Check this program instead of a frame: cases whose answers are known.
        pub(crate) cases: bool = [long, help_heading = "Run"];
        /// Without effect: a report is on one command.
        pub(crate) full: bool = [long, hide = true];
        /// Without effect: a report is quick.
        pub(crate) quick: bool = [long, hide = true];
        /// Threads; all cores by default.
        pub(crate) threads: Option<u16> =
            [long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()), help_heading = "Run"];
        /// Say nothing but errors; the report still goes to stdout.
        pub(crate) quiet: bool = [short, long, help_heading = "Run"];
    }
}

/// The program in clap's form.
pub(crate) fn program() -> &'static clap::Command {
    static PROGRAM: LazyLock<clap::Command> = LazyLock::new(Cli::command);
    &PROGRAM
}

/// The flag for help on all options.
const ALL_OPTIONS: &str = "help-all";

/// Help on all options of the command that `words` name, if they ask for it.
pub(crate) fn help_on_all(words: &[OsString]) -> Option<String> {
    let asks =
        |word: &OsString| word.to_str().and_then(|w| w.strip_prefix("--")) == Some(ALL_OPTIONS);
    let typed = words.iter().take_while(|word| *word != "--");
    typed.clone().find(|word| asks(word))?;
    let mut program = program().clone();
    program.build();
    let names = typed.filter_map(|word| word.to_str());
    let mut named = names.filter_map(|name| program.find_subcommand(name));
    let command = named.next().unwrap_or(&program).clone();
    let mut command = command.mut_args(|arg| arg.hide_short_help(false));
    Some(command.render_help().to_string())
}

/// The clap subcommand of that name; the whole program if there is none.
pub(crate) fn command_named(name: &str) -> clap::Command {
    let program = program();
    program.find_subcommand(name).unwrap_or(program).clone()
}

/// The long names of an argument, without dashes.
pub(super) fn names_of(arg: &clap::Arg) -> impl Iterator<Item = &str> {
    let aliases = arg.get_visible_aliases().unwrap_or_default();
    arg.get_long().into_iter().chain(aliases)
}

/// The argument spelled `--name`.
pub(crate) fn long<'a>(command: &'a clap::Command, name: &str) -> Option<&'a clap::Arg> {
    command
        .get_arguments()
        .find(|arg| names_of(arg).any(|known| known == name))
}

/// The ids of all arguments given on the command line.
pub(super) fn typed_ids(matches: &ArgMatches) -> impl Iterator<Item = &str> {
    let ids = matches.ids().map(clap::Id::as_str);
    ids.filter(|id| {
        // Flattened groups of arguments have ids but no values.
        matches.try_get_raw(id).is_ok()
            && matches.value_source(id) == Some(ValueSource::CommandLine)
    })
}
