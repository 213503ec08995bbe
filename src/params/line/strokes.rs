//! Strokes: style, size, and quantisation of directions.

use crate::error::{Error, Result, bad};
use crate::params::range::in_range;
use crate::params::table::{Choice, Kind, Unit, even};
use crate::params::value::{Value, finite};
use crate::params::{Group, Param};
use serde::Serialize;

/// Drawing tool and technique.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Style {
    /// The one that suits the picture: see [`Available::style`](crate::plan::Available::style).
    Auto,
    /// Ink: black and sharp, wider under pressure.
    Pen,
    /// Graphite: soft and grey, with paper grain.
    Pencil,
    /// Custom stroke pictures at several tones; sizes are factors of theirs.
    Pictures,
    /// Ink, each stroke a separate line as long as possible: for plotters, and for editing.
    Lines,
    /// Ink, evenly spaced lines that swell with tone and end in points, cross-hatched in the dark, as in copper
    /// engraving.
    Engraving,
    /// Ink, dots of about one size, dense in the dark and sparse in the light.
    Stipple,
}

impl Style {
    /// The styles with a name.
    const NAMED: [(Self, Choice); 6] = [
        (
            Self::Auto,
            Choice {
                name: "auto",
                doc: &["Engraving of one picture with depth whose surface bends, else pen"],
            },
        ),
        (
            Self::Pen,
            Choice {
                name: "pen",
                doc: &["Ink"],
            },
        ),
        (
            Self::Pencil,
            Choice {
                name: "pencil",
                doc: &["Graphite"],
            },
        ),
        (
            Self::Lines,
            Choice {
                name: "lines",
                doc: &["Strokes as long as they can be, one by one"],
            },
        ),
        (
            Self::Engraving,
            Choice {
                name: "engraving",
                doc: &["Lines evenly apart that swell with tone"],
            },
        ),
        (
            Self::Stipple,
            Choice {
                name: "stipple",
                doc: &["Dots"],
            },
        ),
    ];
}

impl Value for Style {
    const KIND: Kind = Kind::ChoiceOrFolder(&{
        let [
            (_, auto),
            (_, pen),
            (_, pencil),
            (_, lines),
            (_, engraving),
            (_, stipple),
        ] = Self::NAMED;
        [auto, pen, pencil, lines, engraving, stipple]
    });

    /// A text that is not a style name is a folder of pictures.
    fn parse(text: &str, _: &Param) -> std::result::Result<Self, String> {
        let named = Self::NAMED.iter().find(|(_, choice)| choice.name == text);
        Ok(named.map_or(Self::Pictures, |(style, _)| *style))
    }

    fn text(&self, _: &Param) -> Option<String> {
        let named = Self::NAMED.iter().find(|(style, _)| style == self);
        named.map(|(_, choice)| choice.name.into())
    }
}

choices! {
    /// When an SVG holds lines for a pen plotter.
    pub enum Plotter {
        /// For stipple, and where pens are counted.
        Auto = "auto",
        /// Always.
        On = "on",
        /// Never: every line is a filled outline.
        Off = "off",
    }
}

choices! {
    /// Where separately placed lines end at edges.
    pub enum AtEdges {
        /// On the edge, under the line along it.
        Meet = "meet",
        /// Before the edge, leaving a rim of paper.
        Stop = "stop",
    }
}

/// Size of strokes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StrokeScale {
    /// Fitted to the picture: spacing is a 220th of the root of its area.
    Auto,
    /// The style's own sizes times this factor, in output pixels.
    Factor(f32),
    /// The size that makes strokes this wide on paper, in millimetres.
    Millimetres(f32),
}

impl Value for StrokeScale {
    const KIND: Kind = Kind::Text;

    fn parse(text: &str, _: &Param) -> std::result::Result<Self, String> {
        if text == AUTO {
            return Ok(Self::Auto);
        }
        let (number, scale): (&str, fn(f32) -> Self) = match text.strip_suffix("mm") {
            Some(number) => (number, Self::Millimetres),
            None => (text, Self::Factor),
        };
        let expected = "expected auto, a factor as in 1.5, or the width of a stroke as in 0.3mm";
        finite(number).map(scale).ok_or(expected.into())
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(match self {
            Self::Auto => AUTO.into(),
            Self::Factor(factor) => factor.to_string(),
            Self::Millimetres(width) => format!("{width}mm"),
        })
    }

    /// The range applies to factors only.
    fn outside(&self, row: &Param) -> Option<String> {
        match self {
            Self::Factor(factor) => factor.outside(row),
            Self::Auto | Self::Millimetres(_) => None,
        }
    }
}

/// Word for a scale fitted to the picture.
const AUTO: &str = "auto";

/// Picture size, the root of its area, at which strokes of scale 1 carry its forms, and the range of fitted scales.
const SIZE_AT_SCALE_1_PX: f32 = 1320.0;
const FIT_SCALES: [f32; 2] = [0.35, 4.0];

/// Picture size at which lines along edges have their nominal width.
const SIZE_OF_LINES_PX: f32 = 554.0;

number_or_word! {
    /// Enlargement of the picture before drawing.
    #[derive(Eq)]
    pub enum Enlargement {
        /// Enough for strokes to carry the forms of a small picture, which has too few pixels for them.
        Auto = "auto",
        /// A given factor.
        Times(u32),
    }
    whole: true,
    numbers: |times| (1..=MAX_TIMES).contains(times),
    expected: format!("expected auto or a whole number, 1 to {MAX_TIMES}"),
}

/// Maximum enlargement of a drawing.
pub(super) const MAX_TIMES: u32 = 16;

impl Enlargement {
    /// Enlargement for a picture of this size, the root of its area in pixels.
    pub fn times(self, size_px: f32) -> usize {
        match self {
            Self::Auto => ((SIZE_AT_SCALE_1_PX / size_px.max(1.0)).ceil() as usize)
                .clamp(1, MAX_TIMES as usize),
            Self::Times(times) => times as usize,
        }
    }
}

choices! {
    /// Pixel values of a drawing.
    pub enum Ink {
        /// Grey levels: strokes have smooth edges.
        Antialiased = "antialiased",
        /// Black or white only, with the tone preserved: for a press or a laser printer.
        Bilevel = "bilevel",
    }
}

params! {
    /// The strokes of a hatching.
    pub struct StrokeParams in Strokes {
        /// Drawing tool: auto chooses engraving, enlarged, where a single picture has depth and its surface bends, else
        /// pen, as in photos, streets and sequences; lines draws long separate strokes, as in an SVG; engraving makes them swell with tone; stipple
        /// uses dots; a folder holds pictures of horizontal strokes, one per tone.
        style: Style = Style::Auto, flag: "--style", common: true, form: "auto|pen|pencil|lines|engraving|stipple|DIR";
        /// Pixels of a PNG or TIFF: grey levels, or bilevel for black and white only, for print.
        ///
        /// Layers of an EXR always hold coverage.
        ink: Ink = Ink::Antialiased, flag: "--ink", common: true, form: "KIND";
        /// Size of strokes: auto fits the picture; a number is a factor of the style's own size in pixels; a length
        /// such as 0.3mm is the stroke width on paper.
        ///
        /// Small strokes blend into grey; large ones no longer follow the form.
        scale: StrokeScale = StrokeScale::Auto, flag: "--stroke-scale", common: true, form: "S|MMmm|auto", valid: 0.05..=1000.0;
        /// Pixels per inch of the print, also stored in PNG, JPEG and TIFF; by default 300 for drawings, and the value
        /// stored in the photo for other pictures.
        dpi: Option<f32> = None,
            flag: "--dpi", common: true, form: "PPI", unit: Unit::PerInch, valid: 1.0..=10_000.0, group: Group::Print;
        /// Width of a stroke at full pressure, in pixels at scale 1; by default that of the style.
        width_px: Option<f32> = None,
            flag: "--stroke-width", form: "PX", unit: Unit::Pixels, valid: 0.05..=100.0, useful: even(0.2, 10.0);
        /// Length of a stroke, in pixels at scale 1; by default that of the style.
        ///
        /// Long strokes look calm; short ones follow tight curves.
        length_px: Option<f32> = None,
            flag: "--stroke-length", form: "PX", unit: Unit::Pixels, valid: 1.0..=10_000.0;
        /// Distance between strokes in light tones, in pixels at scale 1; by default that of the style.
        ///
        /// Wide spacing isolates darker strokes; narrow spacing thins them.
        spacing_px: Option<f32> = None,
            flag: "--stroke-spacing", form: "PX", unit: Unit::Pixels, valid: 0.5..=1000.0, useful: even(1.0, 40.0);
        /// Deviation of strokes from straight, 0 to 1; by default that of the style.
        ///
        /// 0 is ruled, 1 a trembling hand.
        wobble: Option<f32> = None, flag: "--wobble", form: "W", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// How much strokes widen with tone, 0 to 1; by default that of the style.
        ///
        /// At 0 tone comes from the number of strokes alone.
        pressure: Option<f32> = None, flag: "--pressure", form: "P", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// Where separately placed lines end at silhouettes and creases.
        at_edges: AtEdges = AtEdges::Meet, flag: "--at-edges", form: "HOW";
        /// Random seed: each gives another drawing.
        seed: u64 = 1, flag: "--seed", form: "N";
        /// When an SVG is for a pen plotter: each line is one path along its middle, followed by the nearest one, from
        /// its nearer end, and the SVG states the distance travelled with the pen up. Otherwise each line is the
        /// outline of its ink.
        plotter: Plotter = Plotter::Auto, flag: "--plotter", form: "WHEN";
        /// Most widths of a plotter's lines, 1 by default: each line has one width, and each width of each kind of line
        /// is a layer.
        pens: Option<u32> = None, flag: "--pens", form: "N", valid: 1.0..=16.0;
        /// Quantisation levels of stroke directions: more levels follow the form better, with shorter strokes.
        ///
        /// They divide half a turn; [LA] uses 12 to 24. Few levels give long strokes that turn in jumps.
        levels: u32 = 16, flag: "--levels", form: "N", valid: 1.0..=MAX_LEVELS as f32, useful: even(2.0, 64.0);
        /// Overlaid sets of levels: more hide the borders between levels.
        ///
        /// Each is offset by an equal fraction of a level. Run time grows with their number.
        sets: u32 = 1, flag: "--sets", form: "N", valid: 1.0..=8.0;
    }
    relations StrokeParams::relations;
}

/// Beyond this a level turns by less than strokes wobble.
pub(crate) const MAX_LEVELS: u32 = 360;

/// Sizes and character of a stroke, in output pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stroke {
    /// Width at full pressure.
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
    /// Whether strokes are placed one by one rather than cut from a texture.
    pub fn is_laid(self) -> bool {
        matches!(self, Self::Lines | Self::Engraving | Self::Stipple)
    }

    /// The style's default stroke at scale 1.
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
            Self::Auto | Self::Engraving => Stroke {
                width_px: 5.5,
                length_px: 10_000.0,
                spacing_px: 5.0,
                wobble: 0.0,
                pressure: 0.93,
            },
            // Dots are as wide as strokes; their number follows tone.
            Self::Stipple => Stroke {
                width_px: 2.2,
                length_px: 2.2,
                spacing_px: 6.0,
                wobble: 0.0,
                pressure: 0.0,
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
    /// Replaces [`StrokeScale::Auto`] by the factor fitted to a picture of this size, the root of its area, with
    /// `resolution_factor` as in [`StrokeParams::factor`]. Returns the factor for lines along edges. It equals that of
    /// strokes unless fitted: strokes shrink to show small forms, but lines must stay visible.
    pub(crate) fn fit(&mut self, size_px: f32, resolution_factor: f32) -> f32 {
        if self.scale != StrokeScale::Auto {
            return self.factor(resolution_factor);
        }
        let [least, most] = FIT_SCALES;
        let factor = match self.style {
            Style::Pictures => 1.0,
            _ => (size_px / SIZE_AT_SCALE_1_PX).clamp(least, most),
        };
        self.scale = StrokeScale::Factor(factor / resolution_factor);
        size_px / SIZE_OF_LINES_PX
    }

    /// The number of pens that an SVG is for, if it is for a plotter.
    pub fn plotter_pens(&self) -> Option<u32> {
        let is_plotted = match self.plotter {
            Plotter::Auto => self.style == Style::Stipple || self.pens.is_some(),
            Plotter::On => true,
            Plotter::Off => false,
        };
        is_plotted.then(|| self.pens.unwrap_or(1))
    }

    /// Resolution of the drawing on paper, in pixels per inch.
    pub fn print_dpi(&self) -> f32 {
        self.dpi.unwrap_or(DPI)
    }

    /// Output pixels per pixel at scale 1, in a picture where `resolution_factor` pixels correspond to one of the
    /// reference.
    pub fn factor(&self, resolution_factor: f32) -> f32 {
        let width = self.width_px.unwrap_or(self.style.stroke().width_px);
        match self.scale {
            StrokeScale::Auto => 1.0,
            StrokeScale::Factor(factor) => factor * resolution_factor,
            StrokeScale::Millimetres(mm) => mm / MM_PER_INCH * self.print_dpi() / width,
        }
    }

    /// Stroke sizes in output pixels, with `resolution_factor` as in [`StrokeParams::factor`].
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

    fn relations(&self) -> Result<()> {
        if self.ink == Ink::Bilevel && matches!(self.style, Style::Pencil | Style::Pictures) {
            return Err(Error::BadParameter {
                name: "--ink",
                found: "is bilevel, and the style is grey".into(),
                remedy: "give --style pen or lines, or --ink antialiased".into(),
            });
        }
        if self.plotter == Plotter::Off && self.pens.is_some() {
            return Err(bad(
                "--pens",
                "counts the pens of a plotter, and --plotter is off",
                "leave one out",
            ));
        }
        match self.scale {
            StrokeScale::Auto | StrokeScale::Factor(_) => Ok(()),
            StrokeScale::Millimetres(mm) => in_range("--stroke-scale", mm, 0.01..=100.0),
        }
    }
}

pub(crate) const MM_PER_INCH: f32 = 25.4;

/// Default resolution of drawings, in pixels per inch.
const DPI: f32 = 300.0;
