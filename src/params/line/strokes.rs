//! Strokes: how each is drawn, and how directions are cut into partitions.

use crate::error::{Error, Result};
use crate::params::in_range;
use serde::Serialize;

/// What strokes are drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Style {
    /// Ink: black, sharp, swelling with pressure.
    Pen,
    /// Graphite: soft, grey, caught by the grain of the paper.
    Pencil,
    /// Pictures of one's own at several tones; sizes are factors of theirs.
    Pictures,
    /// Ink, every stroke a line of its own that runs as long as it can: for plotters, and to be edited.
    Lines,
}

/// How large strokes are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StrokeScale {
    /// The style's own sizes times this factor, in output pixels.
    Factor(f32),
    /// As large as makes strokes this wide, in millimetres, on paper.
    Millimetres(f32),
}

impl std::fmt::Display for StrokeScale {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Factor(factor) => write!(f, "{factor}"),
            Self::Millimetres(width) => write!(f, "{width}mm"),
        }
    }
}

impl std::str::FromStr for StrokeScale {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (number, scale): (&str, fn(f32) -> Self) = match text.strip_suffix("mm") {
            Some(number) => (number, Self::Millimetres),
            None => (text, Self::Factor),
        };
        let number = number.trim().parse().ok().filter(|v: &f32| v.is_finite());
        let expected = "expected a factor as in 1.5, or the width of a stroke as in 0.3mm";
        number.map(scale).ok_or(expected.into())
    }
}

/// The strokes of a hatching.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StrokeParams {
    /// What they are drawn with.
    pub style: Style,
    /// Size of everything about strokes. Small strokes melt into grey; large ones no longer follow the form.
    pub scale: StrokeScale,
    /// Pixels per inch of the printed drawing, 1 to 10000: what millimetres are told in.
    pub dpi: f32,
    /// Width of a stroke pressed hard, in pixels at scale 1, 0.05 to 100; the style's own where `None`.
    pub width_px: Option<f32>,
    /// Length of a stroke likewise, 1 to 10000. Long strokes are calm; short ones follow tight curves.
    pub length_px: Option<f32>,
    /// Distance between strokes in a light tone, likewise, 0.5 to 1000. Wide spacing makes darker strokes
    /// stand alone; narrow spacing thins them.
    pub spacing_px: Option<f32>,
    /// How far strokes stray from straight, 0 to 1: 0 is ruled, 1 is a trembling hand.
    pub wobble: Option<f32>,
    /// How much a stroke swells with tone, 0 to 1: at 0 tone is told by the number of strokes alone.
    pub pressure: Option<f32>,
    /// Chooses one drawing of many.
    pub seed: u64,
    /// Levels that directions are quantised to over half a turn, 1 to [`MAX_LEVELS`]; [LA] takes 12 to
    /// 24. Few make long strokes that turn in jumps; many follow the form with short ones.
    pub levels: u32,
    /// Sets of levels laid over one another, each offset by its share of a level, 1 to 8: more hide the
    /// borders between levels, and take as much longer.
    pub sets: u32,
}

/// Past this a level turns by less than strokes tremble.
pub const MAX_LEVELS: u32 = 360;

impl Default for StrokeParams {
    fn default() -> Self {
        Self {
            style: Style::Pen,
            scale: StrokeScale::Factor(1.0),
            dpi: 300.0,
            width_px: None,
            length_px: None,
            spacing_px: None,
            wobble: None,
            pressure: None,
            seed: 1,
            levels: 16,
            sets: 1,
        }
    }
}

/// Sizes and habits of a stroke, in output pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stroke {
    /// Width pressed hard.
    pub width_px: f32,
    /// Length.
    pub length_px: f32,
    /// Distance between strokes in a light tone.
    pub spacing_px: f32,
    /// See [`StrokeParams::wobble`].
    pub wobble: f32,
    /// See [`StrokeParams::pressure`].
    pub pressure: f32,
}

impl Style {
    /// How the style draws where nothing else is said, at scale 1.
    pub fn stroke(self) -> Stroke {
        match self {
            Self::Pen | Self::Pictures => Stroke {
                width_px: 1.7,
                length_px: 60.0,
                spacing_px: 6.0,
                wobble: 0.3,
                pressure: 0.3,
            },
            Self::Lines => Stroke {
                width_px: 1.2,
                length_px: 10_000.0,
                spacing_px: 6.0,
                wobble: 0.0,
                pressure: 0.5,
            },
            Self::Pencil => Stroke {
                width_px: 2.4,
                length_px: 50.0,
                spacing_px: 4.5,
                wobble: 0.4,
                pressure: 0.7,
            },
        }
    }
}

impl StrokeParams {
    /// Output pixels for one at scale 1, in a picture of which `resolution_factor` pixels stand for one of
    /// the reference.
    pub fn factor(&self, resolution_factor: f32) -> f32 {
        let width = self.width_px.unwrap_or(self.style.stroke().width_px);
        match self.scale {
            StrokeScale::Factor(factor) => factor * resolution_factor,
            StrokeScale::Millimetres(mm) => mm / MM_PER_INCH * self.dpi / width,
        }
    }

    /// The strokes in such a picture.
    pub fn stroke(&self, resolution_factor: f32) -> Stroke {
        let own = self.style.stroke();
        let scale = self.factor(resolution_factor);
        Stroke {
            width_px: scale * self.width_px.unwrap_or(own.width_px),
            length_px: scale * self.length_px.unwrap_or(own.length_px),
            spacing_px: scale * self.spacing_px.unwrap_or(own.spacing_px),
            wobble: self.wobble.unwrap_or(own.wobble),
            pressure: self.pressure.unwrap_or(own.pressure),
        }
    }

    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        match self.scale {
            StrokeScale::Factor(factor) => in_range("--stroke-scale", factor, 0.05..=1000.0)?,
            StrokeScale::Millimetres(mm) => in_range("--stroke-scale", mm, 0.01..=100.0)?,
        }
        in_range("--dpi", self.dpi, 1.0..=10_000.0)?;
        let optional = [
            ("--stroke-width", self.width_px, 0.05..=100.0),
            ("--stroke-length", self.length_px, 1.0..=10_000.0),
            ("--stroke-spacing", self.spacing_px, 0.5..=1000.0),
            ("--wobble", self.wobble, 0.0..=1.0),
            ("--pressure", self.pressure, 0.0..=1.0),
        ];
        for (name, value, range) in optional {
            value.map_or(Ok(()), |value| in_range(name, value, range))?;
        }
        in_count("--levels", self.levels, MAX_LEVELS)?;
        in_count("--sets", self.sets, 8)
    }
}

fn in_count(name: &'static str, value: u32, most: u32) -> Result<()> {
    if (1..=most).contains(&value) {
        return Ok(());
    }
    Err(Error::BadParameter {
        name,
        found: format!("is {value}"),
        remedy: format!("give 1 to {most}"),
    })
}

const MM_PER_INCH: f32 = 25.4;
