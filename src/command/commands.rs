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

#[derive(Debug, Clone, Subcommand)]
pub(crate) enum Command {
    /// Describe files: the role and space of each layer, and the evidence.
    #[command(after_help = INSPECT_EXAMPLES)]
    Inspect(InspectArgs),
    /// Write the shape descriptor: layers to an EXR, or the coloured curvature display to a picture.
    #[command(after_help = SHAPE_EXAMPLES)]
    Shape(ShapeArgs),
    /// Bring out the shape in the shading that a picture already has.
    #[command(after_help = ENHANCE_EXAMPLES)]
    Enhance(EnhanceArgs),
    /// Relight the surface: lights, an environment or a lit sphere, bent and scaled by curvature.
    #[command(after_help = RELIGHT_EXAMPLES)]
    Relight(Box<RelightArgs>),
    /// Draw the surface: pen or pencil strokes along its curvature, lines along its edges.
    #[command(after_help = HATCH_EXAMPLES, mut_arg("sum", |sum| sum.hide(true)))]
    Hatch(Box<HatchArgs>),
    /// Make maps for textures: curvature, its convex and concave parts, edges, height, occlusion, normals.
    #[command(after_help = MAP_EXAMPLES)]
    Map(MapArgs),
    /// Write the normals that all commands use: those of the input, or of its depth, heights or positions.
    #[command(
        after_help = NORMALS_EXAMPLES,
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
    #[command(after_help = COMPLETIONS_EXAMPLES)]
    Completions(CompletionsArgs),
    /// Print a manual page: of the program, or of a command.
    #[command(after_help = MAN_EXAMPLES)]
    Man(ManArgs),
    /// Open a window in which a look is tuned and saved as a recipe.
    #[command(after_help = VIEW_EXAMPLES)]
    View(ViewArgs),
    /// Measure a command on a frame: error against run time, and what it can leave out.
    #[command(after_help = REPORT_EXAMPLES)]
    Report(ReportArgs),
}

const INSPECT_EXAMPLES: &str = "\
Examples:
  relievo inspect render.exr
  relievo inspect --json shot.*.exr
  relievo inspect photo.jpg --normal normals.png";

const SHAPE_EXAMPLES: &str = "\
Examples:
  relievo shape render.exr -o curvature.png          a look at what is found
  relievo shape render.exr -o layers.exr             all layers beside those of the render
  relievo shape render.exr -o fine.png --iterations 0
  relievo shape render.exr -o scales.exr --scale 2,8,32
  relievo shape render.exr -o face.png --scale 8 --importance painted.png";

const ENHANCE_EXAMPLES: &str = "\
Examples:
  relievo enhance render.exr -o enhanced.png
  relievo enhance render.exr -o enhanced.exr --scaling 1.5 --iterations 50
  relievo enhance passes.exr -o enhanced.exr --scaling-diffuse 2 --scaling-specular 0.5
  relievo enhance passes.exr -o enhanced.exr --light-group key=135,40 --light-group fill=10,20
  relievo enhance photo.jpg --normal normals.png --normal-flip y -o enhanced.jpg
  relievo enhance shot.####.exr --frames 101-340 -o out/shot.####.exr --skip-existing
  relievo enhance hero.png --normal hero_n.png --grid 32x32 -o out.png        a sheet of sprites";

const NORMALS_EXAMPLES: &str = "\
Examples:
  relievo normals render.exr -o normals.exr          in view space: x right, y up, z toward the viewer
  relievo normals depth.exr -o normals.png           of a depth alone
  relievo normals scan.png --height scan.png --height-scale 40 -o normals.png
  relievo normals brick_gl.png -o brick_dx.png --as directx
  relievo normals moge_out -o normals.npy            a folder of an estimator; floats
  relievo normals tablet.png -o relief.png --flatten --detail scratches.png";

const RELIGHT_EXAMPLES: &str = "\
Examples:
  relievo relight photo.jpg --normal normals.png --light 75,10 --method warp -o raking.png
  relievo relight render.exr --light 135,40 --material phong --method scale -o lit.png
  relievo relight render.exr --environment sky.hdr --environment-rotate 90 -o outdoors.exr
  relievo relight render.exr --lit-sphere clay.png -o clay.png
  relievo relight render.exr --environment sky.hdr --material toon --contrast -0.5 -o cartoon.png
  relievo relight render.exr --specular-mask Mirror --surroundings around.exr --material mirror -o lit.png";

const HATCH_EXAMPLES: &str = "\
Examples:
  relievo hatch render.exr -o drawing.png
  relievo hatch render.exr -o pencil.png --style pencil --directions both
  relievo hatch render.exr --light 135,30 --method warp -o raking.png
  relievo hatch photo.jpg --normal normals.png -o print.png --stroke-scale 0.3mm --dpi 600
  relievo hatch render.exr -o plotter.svg --pens 1 --page A4    lines for one pen
  relievo hatch shot.####.exr --frames 1-240 -o drawn.####.png
  relievo hatch render.exr --specular-mask Mirror --surroundings around.exr -o mirror.png
  relievo hatch render.exr --specular-mask Lens --back back.exr --behind without.exr -o lens.png";

const MAP_EXAMPLES: &str = "\
Examples:
  relievo map brick_normal.png -o brick_curvature.png
  relievo map brick_normal.png -o brick_{map}.png --map convex,concave,edges
  relievo map brick_normal.png -o brick_{map}.png --scale 1,4,16        brick_curvature_1.png and so on
  relievo map brick_normal.png -o wear.png --scale 1,4,16 --sum 1,2,4
  relievo map brick_normal.png -o brick_{map}.png --map height,occlusion
  relievo map rock_directx.png -o rock.png --normal-flip y --bits 8
  relievo map render.exr -o maps.exr --map curvature,edges
  relievo map brick_normal.png -o brick_{map}.npy --map height,curvature    as floats";

const RUN_EXAMPLES: &str = "\
Examples:
  relievo enhance shot.0101.exr --scaling 1.5 --save-recipe look.toml         write one
  relievo run look.toml shot.0101.exr -o shot.png
  relievo run look.toml shot.0101.exr -o shot.png --scaling 2                 but for one setting
  relievo run look.toml shot.####.exr --frames 101-340 -o out/shot.####.exr
  relievo run portrait render.exr -o face.png                                 a preset
  relievo run inscription photo.jpg --normal normals.png -o letters.png --lines-only";

fn run_examples() -> String {
    format!(
        "{RUN_EXAMPLES}\n\nPresets, for drawings: {}.",
        recipe::presets()
    )
}

const REPORT_EXAMPLES: &str = "\
Examples:
  relievo report render.exr                         enhance: what trades quality for time, what can be left out
  relievo report render.exr --for 'enhance --scale 20'
  relievo report render.exr --for 'relight --environment sky.hdr --material ashikhmin-shirley' -o report
  relievo report render.exr --recipe look.toml -o report       report/report.html: one page
  relievo report --cases                            check this program: cases whose answers are known";

const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  source <(relievo completions bash)            in ~/.bashrc
  source <(relievo completions zsh)             in ~/.zshrc, after compinit
  relievo completions fish | source             in ~/.config/fish/config.fish
  relievo enhance render.exr --normal <TAB>     then lists the layers of render.exr";

const MAN_EXAMPLES: &str = "\
Examples:
  relievo man > relievo.1
  relievo man enhance | man -l -";

const VIEW_EXAMPLES: &str = "\
Examples:
  relievo view render.exr                        turn the light; save a recipe
  relievo view render.exr --recipe look.toml     go on from one
  relievo view photo.jpg --normal normals.png --normal-flip y
  relievo view shot.####.exr                     all frames that are there";

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

#[derive(Debug, Clone, Args)]
pub(crate) struct InspectArgs {
    /// Files to look into.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArgs,
    /// Planned scaling magnitude: warn where it is too high.
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub(crate) scaling: Option<f32>,
    /// Planned invariant point, for the same warning.
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub(crate) invariant_point: Option<f32>,
    /// Print one JSON array instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct RecipeArgs {
    /// The recipe: a TOML file, or the name of a preset.
    #[arg(value_name = "RECIPE")]
    pub(crate) recipe: PathBuf,
    /// IN, -o OUT and other arguments of the recipe's command; they go before its settings. --keep-levels applies the
    /// recipe's automatic choices to other frames too.
    #[arg(
        value_name = "ARGUMENT",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    pub(crate) rest: Vec<OsString>,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ViewArgs {
    /// The render or photo; one can also be opened in the window.
    #[arg(value_name = "IN")]
    pub(crate) input: Option<PathBuf>,
    /// Recipe to begin with.
    #[arg(long, value_name = "FILE.toml", help_heading = "Run")]
    pub(crate) recipe: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArgs,
    #[command(flatten)]
    pub(crate) frames: FramesArg,
    #[command(flatten)]
    pub(crate) compute: ComputeArgs,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ShapeArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    _relief: Section<{ Group::Relief as u8 }>,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct EnhanceArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    _lobes: Section<{ Group::LightLayers as u8 }>,
    #[command(flatten)]
    pub(crate) light: LightLayerFlags,
    #[command(flatten)]
    _sum: SumFlag,
    #[command(flatten)]
    _scaling: Section<{ Group::Scaling as u8 }>,
    #[command(flatten)]
    _white_levels: Section<{ Group::WhiteLevels as u8 }>,
    #[command(flatten)]
    _display: Section<{ Group::Display as u8 }>,
}

#[derive(Debug, Clone, Args)]
pub(crate) struct ReportArgs {
    /// The render or photo, or a folder as estimators of normals and depth write one.
    #[arg(
        value_name = "IN",
        required_unless_present = "cases",
        default_value = ".",
        hide_default_value = true
    )]
    pub(crate) input: PathBuf,
    /// The command to report on, with its flags, without IN and -o: enhance by default.
    #[arg(long = "for", value_name = "COMMAND", help_heading = "Run")]
    pub(crate) command: Option<String>,
    /// The same from a recipe, or a preset.
    #[arg(
        long,
        value_name = "FILE.toml",
        help_heading = "Run",
        conflicts_with = "command"
    )]
    pub(crate) recipe: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) roles: RoleArgs,
    #[command(flatten)]
    _flags: Flags,
    #[command(flatten)]
    _shape: Section<{ Group::Shape as u8 }>,
    #[command(flatten)]
    pub(crate) frames: FramesArg,
    #[command(flatten)]
    motion: MotionArg,
    /// Directory for report.html, one page that loads nothing, and report.json with every number; created if missing, older
    /// files replaced. Without it the report is printed.
    #[arg(short = 'o', long, value_name = "DIR", help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,
    /// Time it may take in seconds: 15 by default, 45 in the light of an environment.
    #[arg(long, value_name = "S", help_heading = "Run", value_parser = clap::value_parser!(u16).range(1..=3600))]
    pub(crate) budget: Option<u16>,
    /// Check this program instead of a frame: cases whose answers are known.
    #[arg(long, help_heading = "Run")]
    pub(crate) cases: bool,
    /// Without effect: a report is on one command.
    #[arg(long, hide = true)]
    pub(crate) full: bool,
    /// Without effect: a report is quick.
    #[arg(long, hide = true)]
    pub(crate) quick: bool,
    /// Threads; all cores by default.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS.into()), help_heading = "Run")]
    pub(crate) threads: Option<u16>,
    /// Say nothing but errors; the report still goes to stdout.
    #[arg(short, long, help_heading = "Run")]
    pub(crate) quiet: bool,
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
