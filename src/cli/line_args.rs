//! The names of `hatch`. Every default is read from `params`.

use super::motion::MotionArg;
use super::relight_args::{RelightArgs, mirrored};
use crate::params::{
    Adaptive, ContourParams, Fallback, FieldParams, LineParams, StrokeDirections, StrokeParams,
    StrokeScale, Style, ToneParams,
};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

static LINE: LazyLock<LineParams> = LazyLock::new(LineParams::default);

#[derive(Debug, Args)]
pub(super) struct HatchArgs {
    #[command(flatten)]
    pub(super) relight: RelightArgs,
    #[command(flatten)]
    pub(super) tone: ToneFlags,
    #[command(flatten)]
    field: FieldFlags,
    #[command(flatten)]
    strokes: StrokeFlags,
    #[command(flatten)]
    contours: ContourFlags,
    #[command(flatten)]
    pub(super) motion: MotionArg,
}

/// What becomes light and dark.
#[derive(Debug, Args)]
#[command(next_help_heading = "Tone")]
pub(super) struct ToneFlags {
    /// Where tone comes from: the picture by radiance scaling, the picture as it is, or new light; auto
    /// takes new light where any is given or there is no picture.
    #[arg(long, value_name = "SOURCE", value_enum, default_value_t = ToneArg::Auto)]
    pub(super) tone: ToneArg,
    /// Luminance from which on paper stays white, or auto to fit the picture.
    #[arg(long, value_name = "L|auto", default_value_t = LINE.tone.white_point, allow_negative_numbers = true)]
    white_point: Adaptive,
    /// Share of the white point up to which all is black.
    #[arg(long, value_name = "B", default_value_t = LINE.tone.black_point, allow_negative_numbers = true)]
    black_point: f32,
    /// Tone curve: at 1 the drawing is as bright as the picture from afar; more lightens it.
    #[arg(long, value_name = "G", default_value_t = LINE.tone.gamma, allow_negative_numbers = true)]
    tone_gamma: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ToneArg {
    Auto,
    Enhance,
    Picture,
    Relight,
}

/// Where strokes go.
#[derive(Debug, Args)]
#[command(next_help_heading = "Directions")]
struct FieldFlags {
    /// Directions of curvature that strokes follow: of the larger, around a cylinder; of the lesser, along
    /// it; both, the dark crossed by a second hatching.
    #[arg(long, value_name = "WHICH", value_enum, default_value_t = DirectionsArg::from(LINE.directions))]
    directions: DirectionsArg,
    /// Where strokes go that curvature does not lead, on planes and balls: degrees in the picture, or
    /// surface for an upright direction on it.
    #[arg(long, value_name = "DEG|surface", default_value_t = LINE.field.fallback, allow_negative_numbers = true)]
    fallback: Fallback,
    /// How often directions are averaged with those around them: more make calmer strokes.
    #[arg(long, value_name = "N", default_value_t = LINE.field.passes)]
    passes: u32,
    /// How far around, in pixels of a quarter of the picture's size.
    #[arg(long, value_name = "PX", default_value_t = LINE.field.radius_px, allow_negative_numbers = true)]
    smoothing: f32,
}

mirrored!(DirectionsArg, StrokeDirections { Max, Min, Both });

/// How strokes are drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Strokes")]
struct StrokeFlags {
    /// What strokes are drawn with; lines are strokes as long as they can be, one by one, as an SVG has them; a
    /// folder holds pictures of strokes along the horizontal, one per tone.
    #[arg(long, value_name = "pen|pencil|lines|DIR", default_value_t = StyleArg::Known(LINE.strokes.style))]
    style: StyleArg,
    /// Size of strokes: a factor of the style's own pixels, or the width of a stroke on paper as in 0.3mm.
    #[arg(long, value_name = "S|MMmm", default_value_t = LINE.strokes.scale, allow_negative_numbers = true)]
    stroke_scale: StrokeScale,
    /// Pixels per inch of the printed drawing, for sizes in millimetres.
    #[arg(long, value_name = "PPI", default_value_t = LINE.strokes.dpi, allow_negative_numbers = true)]
    dpi: f32,
    /// Width of a stroke pressed hard, in pixels at scale 1; the style's own where not given.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    stroke_width: Option<f32>,
    /// Length of a stroke, likewise.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    stroke_length: Option<f32>,
    /// Distance between strokes in light tones, likewise.
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    stroke_spacing: Option<f32>,
    /// How far strokes stray from straight, 0 to 1; the style's own where not given.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    wobble: Option<f32>,
    /// How much strokes swell with tone, 0 to 1, likewise.
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    pressure: Option<f32>,
    /// Chooses one drawing of many.
    #[arg(long, value_name = "N", default_value_t = LINE.strokes.seed)]
    seed: u64,
    /// Levels that directions are quantised to: more follow the form with shorter strokes.
    #[arg(long, value_name = "N", default_value_t = LINE.strokes.levels)]
    levels: u32,
    /// Sets of levels laid over one another: more hide the borders between levels.
    #[arg(long, value_name = "N", default_value_t = LINE.strokes.sets)]
    sets: u32,
}

static CONTOURS: LazyLock<ContourParams> = LazyLock::new(ContourParams::default);

/// How lines along edges are drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Contours")]
struct ContourFlags {
    /// Lines along silhouettes and creases, over the strokes.
    #[arg(long, value_name = "on|off", value_enum, default_value_t = ContoursArg::On)]
    contours: ContoursArg,
    /// Width of the line around the nearest thing, in pixels at scale 1.
    #[arg(long, value_name = "PX", default_value_t = CONTOURS.width_px, allow_negative_numbers = true)]
    contour_width: f32,
    /// Width of creases as a share of that; 0 draws none.
    #[arg(long, value_name = "SHARE", default_value_t = CONTOURS.crease_share, allow_negative_numbers = true)]
    crease_width: f32,
    /// Share of its width that the line around the farthest thing loses.
    #[arg(long, value_name = "SHARE", default_value_t = CONTOURS.depth_emphasis, allow_negative_numbers = true)]
    depth_emphasis: f32,
    /// Share of its width that a line across the faintest jump of depth, or along the bluntest crease, loses.
    #[arg(long, value_name = "SHARE", default_value_t = CONTOURS.jump_emphasis, allow_negative_numbers = true)]
    jump_emphasis: f32,
    /// Lines that are shorter with all they are joined to are left out, in pixels; creases twice that.
    #[arg(long, value_name = "PX", default_value_t = CONTOURS.shortest_px, allow_negative_numbers = true)]
    shortest_contour: f32,
    /// Pixels over which the open end of a line runs thin.
    #[arg(long, value_name = "PX", default_value_t = CONTOURS.taper_px, allow_negative_numbers = true)]
    contour_taper: f32,
    /// Pixels to either side along a line over which the steps between pixels are evened out.
    #[arg(long, value_name = "PX", default_value_t = CONTOURS.smoothing_px, allow_negative_numbers = true)]
    contour_smoothing: f32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ContoursArg {
    On,
    Off,
}

impl ContourFlags {
    fn params(&self) -> Option<ContourParams> {
        let params = ContourParams {
            width_px: self.contour_width,
            crease_share: self.crease_width,
            depth_emphasis: self.depth_emphasis,
            jump_emphasis: self.jump_emphasis,
            shortest_px: self.shortest_contour,
            taper_px: self.contour_taper,
            smoothing_px: self.contour_smoothing,
        };
        (self.contours == ContoursArg::On).then_some(params)
    }
}

/// A style by its name, or a folder of pictures.
#[derive(Debug, Clone, PartialEq)]
enum StyleArg {
    Known(Style),
    Folder(PathBuf),
}

/// The styles that have a name.
const STYLES: [(&str, Style); 3] = [
    ("pen", Style::Pen),
    ("pencil", Style::Pencil),
    ("lines", Style::Lines),
];

impl std::fmt::Display for StyleArg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = |known| STYLES.iter().find(|(_, style)| *style == known);
        match self {
            Self::Known(known) => f.write_str(name(*known).map_or("", |(name, _)| name)),
            Self::Folder(path) => write!(f, "{}", path.display()),
        }
    }
}

impl std::str::FromStr for StyleArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = STYLES.iter().find(|(name, _)| *name == text);
        match known {
            Some((_, style)) => Ok(Self::Known(*style)),
            None if Path::new(text).is_dir() => Ok(Self::Folder(text.into())),
            None => Err("expected pen, pencil, lines or a folder of pictures of strokes".into()),
        }
    }
}

impl HatchArgs {
    /// The folder of pictures that strokes are taken from, if any.
    pub(super) fn pictures(&self) -> Option<&Path> {
        match &self.strokes.style {
            StyleArg::Known(_) => None,
            StyleArg::Folder(path) => Some(path),
        }
    }

    pub(super) fn params(&self) -> LineParams {
        let Self {
            tone,
            strokes,
            field,
            contours,
            ..
        } = self;
        LineParams {
            directions: field.directions.into(),
            field: FieldParams {
                passes: field.passes,
                radius_px: field.smoothing,
                fallback: field.fallback,
                ..LINE.field
            },
            strokes: StrokeParams {
                style: match &strokes.style {
                    StyleArg::Known(style) => *style,
                    StyleArg::Folder(_) => Style::Pictures,
                },
                scale: strokes.stroke_scale,
                dpi: strokes.dpi,
                width_px: strokes.stroke_width,
                length_px: strokes.stroke_length,
                spacing_px: strokes.stroke_spacing,
                wobble: strokes.wobble,
                pressure: strokes.pressure,
                seed: strokes.seed,
                levels: strokes.levels,
                sets: strokes.sets,
            },
            tone: ToneParams {
                white_point: tone.white_point,
                black_point: tone.black_point,
                gamma: tone.tone_gamma,
            },
            contours: contours.params(),
        }
    }
}
