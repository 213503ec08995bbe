//! The names of `hatch`. Every default is read from `params`.

use super::relight_args::RelightArgs;
use crate::params::{Adaptive, LineParams, StrokeParams, StrokeScale, Style, ToneParams};
use clap::{Args, ValueEnum};
use std::sync::LazyLock;

static LINE: LazyLock<LineParams> = LazyLock::new(LineParams::default);

#[derive(Debug, Args)]
pub(super) struct HatchArgs {
    #[command(flatten)]
    pub(super) relight: RelightArgs,
    #[command(flatten)]
    pub(super) tone: ToneFlags,
    #[command(flatten)]
    strokes: StrokeFlags,
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

/// How strokes are drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Strokes")]
struct StrokeFlags {
    /// What strokes are drawn with.
    #[arg(long, value_name = "STYLE", value_enum, default_value_t = StyleArg::from(LINE.strokes.style))]
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

#[derive(Debug, Clone, Copy, ValueEnum)]
enum StyleArg {
    Pen,
    Pencil,
}

impl From<Style> for StyleArg {
    fn from(style: Style) -> Self {
        match style {
            Style::Pen => Self::Pen,
            Style::Pencil => Self::Pencil,
        }
    }
}

impl From<StyleArg> for Style {
    fn from(arg: StyleArg) -> Self {
        match arg {
            StyleArg::Pen => Self::Pen,
            StyleArg::Pencil => Self::Pencil,
        }
    }
}

impl HatchArgs {
    pub(super) fn params(&self) -> LineParams {
        let Self { tone, strokes, .. } = self;
        LineParams {
            strokes: StrokeParams {
                style: strokes.style.into(),
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
            contours: LINE.contours,
        }
    }
}
