//! Strokes: how each is drawn, and how directions are cut into partitions.

use crate::error::{Error, Result};
use crate::params::range::in_range;
use crate::params::table::{Choice, Kind, Unit, even};
use crate::params::value::{Value, finite};
use crate::params::{Group, Param};
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
    /// Ink, lines evenly apart that swell with tone and run to points, the dark crossed: as engraved in copper.
    Engraving,
    /// Ink, in dots of about one size, many in the dark and few in the light.
    Stipple,
}

impl Style {
    /// Those that have a name.
    const NAMED: [(Self, Choice); 5] = [
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
            (_, pen),
            (_, pencil),
            (_, lines),
            (_, engraving),
            (_, stipple),
        ] = Self::NAMED;
        [pen, pencil, lines, engraving, stipple]
    });

    /// What is no name is a folder of pictures.
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
    /// When an SVG is made ready for a pen plotter.
    pub enum Plotter {
        /// Where strokes are engraved, or dots.
        Auto = "auto",
        /// Always.
        On = "on",
        /// Never: lines in the order they were laid in.
        Off = "off",
    }
}

impl Plotter {
    /// Whether an SVG of strokes of this style is made ready for one.
    pub fn is_on(self, style: Style) -> bool {
        match self {
            Self::Auto => matches!(style, Style::Engraving | Style::Stipple),
            Self::On => true,
            Self::Off => false,
        }
    }
}

choices! {
    /// Where lines that are laid one by one end at edges.
    pub enum AtEdges {
        /// On the edge, under the line along it.
        Meet = "meet",
        /// Before it, which leaves a rim of paper.
        Stop = "stop",
    }
}

/// How large strokes are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StrokeScale {
    /// As large as carries the forms of a picture of its size: spacing is a 220th of the root of its area.
    Auto,
    /// The style's own sizes times this factor, in output pixels.
    Factor(f32),
    /// As large as makes strokes this wide, in millimetres, on paper.
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

    /// A range is one of factors.
    fn outside(&self, row: &Param) -> Option<String> {
        match self {
            Self::Factor(factor) => factor.outside(row),
            Self::Auto | Self::Millimetres(_) => None,
        }
    }
}

/// The word for a scale that fits the picture.
const AUTO: &str = "auto";

/// The picture's size, the root of its area, in which strokes of scale 1 carry its forms, and the scales that are fit to any.
const SIZE_AT_SCALE_1_PX: f32 = 1320.0;
const FIT_SCALES: [f32; 2] = [0.35, 4.0];

/// The picture's size in which lines along edges have their own width.
const SIZE_OF_LINES_PX: f32 = 554.0;

number_or_word! {
    /// How many times larger than its picture a drawing is.
    #[derive(Eq)]
    pub enum Enlargement {
        /// So large that strokes carry its forms: a small picture has too few pixels for them.
        Auto = "auto",
        /// So many times.
        Times(u32),
    }
    whole: true,
    numbers: |times| (1..=MAX_TIMES).contains(times),
    expected: format!("expected auto or a whole number, 1 to {MAX_TIMES}"),
}

/// The most that a drawing is enlarged.
pub(super) const MAX_TIMES: u32 = 16;

impl Enlargement {
    /// How many times larger a drawing of a picture of this size, the root of its area in pixels, is.
    pub fn times(self, size_px: f32) -> usize {
        match self {
            Self::Auto => ((SIZE_AT_SCALE_1_PX / size_px.max(1.0)).ceil() as usize)
                .clamp(1, MAX_TIMES as usize),
            Self::Times(times) => times as usize,
        }
    }
}

choices! {
    /// What a pixel of a picture of a drawing can be.
    pub enum Ink {
        /// Any grey: the rims of strokes are smooth.
        Antialiased = "antialiased",
        /// Black or white alone, with the tone kept: what a press or a laser printer puts on paper.
        Bilevel = "bilevel",
    }
}

params! {
    /// The strokes of a hatching.
    pub struct StrokeParams in Strokes {
        /// What strokes are drawn with; lines are strokes as long as they can be, one by one, as an SVG has them, and an
        /// engraving's swell with tone; stipple is dots; a folder holds pictures of strokes along the horizontal, one per tone.
        style: Style = Style::Pen, flag: "--style", form: "pen|pencil|lines|engraving|stipple|DIR";
        /// What pixels of a PNG or TIFF are: any grey, or with bilevel black and white alone, for print.
        ///
        /// Layers of an EXR hold how much of a pixel is covered either way.
        ink: Ink = Ink::Antialiased, flag: "--ink", form: "KIND";
        /// Size of strokes: auto fits the picture; a factor of the style's own pixels; or the width of a stroke on paper as
        /// in 0.3mm.
        ///
        /// Small strokes melt into grey; large ones no longer follow the form.
        scale: StrokeScale = StrokeScale::Auto, flag: "--stroke-scale", form: "S|MMmm|auto", valid: 0.05..=1000.0;
        /// Pixels per inch of the print, which PNG, JPEG and TIFF say too: 300 for drawings where not given, and what the
        /// photo says for other pictures.
        dpi: Option<f32> = None,
            flag: "--dpi", form: "PPI", unit: Unit::PerInch, valid: 1.0..=10_000.0, group: Group::Print;
        /// Width of a stroke pressed hard, in pixels at scale 1; the style's own where not given.
        width_px: Option<f32> = None,
            flag: "--stroke-width", form: "PX", unit: Unit::Pixels, valid: 0.05..=100.0, useful: even(0.2, 10.0);
        /// Length of a stroke, likewise.
        ///
        /// Long strokes are calm; short ones follow tight curves.
        length_px: Option<f32> = None,
            flag: "--stroke-length", form: "PX", unit: Unit::Pixels, valid: 1.0..=10_000.0;
        /// Distance between strokes in light tones, likewise.
        ///
        /// Wide spacing makes darker strokes stand alone; narrow spacing thins them.
        spacing_px: Option<f32> = None,
            flag: "--stroke-spacing", form: "PX", unit: Unit::Pixels, valid: 0.5..=1000.0, useful: even(1.0, 40.0);
        /// How far strokes stray from straight, 0 to 1; the style's own where not given.
        ///
        /// 0 is ruled, 1 is a trembling hand.
        wobble: Option<f32> = None, flag: "--wobble", form: "W", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// How much strokes swell with tone, 0 to 1, likewise.
        ///
        /// At 0 the number of strokes alone makes the tone.
        pressure: Option<f32> = None, flag: "--pressure", form: "P", valid: 0.0..=1.0, useful: even(0.0, 1.0);
        /// Where lines that are laid one by one end at silhouettes and creases.
        at_edges: AtEdges = AtEdges::Meet, flag: "--at-edges", form: "HOW";
        /// Chooses one drawing of many.
        seed: u64 = 1, flag: "--seed", form: "N";
        /// Whether an SVG is made ready for a pen plotter: what is near is drawn next, from the nearer end, bends under a
        /// tenth of a pixel are left out, and every width of every kind of line is a layer; it says how far the pen goes
        /// in the air.
        plotter: Plotter = Plotter::Auto, flag: "--plotter", form: "WHEN";
        /// Levels that directions are quantised to: more follow the form with shorter strokes.
        ///
        /// They divide half a turn; [LA] takes 12 to 24. Few make long strokes that turn in jumps.
        levels: u32 = 16, flag: "--levels", form: "N", valid: 1.0..=MAX_LEVELS as f32, useful: even(2.0, 64.0);
        /// Sets of levels laid over one another: more hide the borders between levels.
        ///
        /// Each is offset by its share of a level. They take as much longer.
        sets: u32 = 1, flag: "--sets", form: "N", valid: 1.0..=8.0;
    }
    relations StrokeParams::relations;
}

/// Past this a level turns by less than strokes tremble.
pub(crate) const MAX_LEVELS: u32 = 360;

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
    /// Whether its strokes are laid one by one, in place of being cut from a texture.
    pub fn is_laid(self) -> bool {
        matches!(self, Self::Lines | Self::Engraving | Self::Stipple)
    }

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
            Self::Engraving => Stroke {
                width_px: 5.5,
                length_px: 10_000.0,
                spacing_px: 5.0,
                wobble: 0.0,
                pressure: 0.93,
            },
            // Dots are as wide, and as many as tone asks for.
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
    /// Puts the factor that fits a picture of this size, the root of its area, in the place of [`StrokeScale::Auto`], with
    /// `resolution_factor` as in [`StrokeParams::factor`]. Returns the factor of lines along edges: that of strokes, but
    /// for one that fits. Strokes shrink for the sake of small forms, lines have to be seen.
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

    /// Pixels per inch of the drawing on paper.
    pub fn print_dpi(&self) -> f32 {
        self.dpi.unwrap_or(DPI)
    }

    /// Output pixels for one at scale 1, in a picture of which `resolution_factor` pixels stand for one of
    /// the reference.
    pub fn factor(&self, resolution_factor: f32) -> f32 {
        let width = self.width_px.unwrap_or(self.style.stroke().width_px);
        match self.scale {
            StrokeScale::Auto => 1.0,
            StrokeScale::Factor(factor) => factor * resolution_factor,
            StrokeScale::Millimetres(mm) => mm / MM_PER_INCH * self.print_dpi() / width,
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

    fn relations(&self) -> Result<()> {
        if self.ink == Ink::Bilevel && matches!(self.style, Style::Pencil | Style::Pictures) {
            return Err(Error::BadParameter {
                name: "--ink",
                found: "is bilevel, and the style is grey".into(),
                remedy: "give --style pen or lines, or --ink antialiased".into(),
            });
        }
        match self.scale {
            StrokeScale::Auto | StrokeScale::Factor(_) => Ok(()),
            StrokeScale::Millimetres(mm) => in_range("--stroke-scale", mm, 0.01..=100.0),
        }
    }
}

pub(crate) const MM_PER_INCH: f32 = 25.4;

/// Pixels per inch of drawings for which none are given.
const DPI: f32 = 300.0;
