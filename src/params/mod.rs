//! All tunable parameters in one table: meaning, unit, range and default. Defaults are stated nowhere else.
//!
//! The table describes each parameter for any user interface, and [`Params`] accepts values by name:
//!
//! ```
//! use relievo::params::{Group, Param, Parameters, Params};
//!
//! let scaling = Param::named("scaling").unwrap();
//! assert_eq!((scaling.group, scaling.valid.clone()), (Group::Scaling, 0.0..=1e6));
//! assert_eq!((scaling.default)().as_deref(), Some("1"));
//!
//! let mut params = Params::default();
//! params.set("scaling", "1.5").unwrap();
//! assert_eq!(params.scaling.scaling, 1.5);
//! assert!(Param::all().iter().any(|row| row.unit.suffix() == "px"));
//! ```

use std::sync::LazyLock;

#[macro_use]
pub(crate) mod table;
#[macro_use]
pub(crate) mod value;
mod display;
mod light;
mod line;
mod range;
mod relight;
mod run;
mod scale_bar;
mod shape;
mod specular;
#[cfg(feature = "cli")]
pub(crate) mod words;

pub use display::{DisplayParams, DisplayView, Exposure, Highlights};
pub use light::{Adaptive, Magnitude, Magnitudes, ScalingParams, TermWhiteLevels};
pub(crate) use line::MM_PER_INCH;
pub use line::{
    AtEdges, Background, ContourParams, Enlargement, Fallback, FieldParams, Ink, InteriorParams,
    Landscape, Levels, LineLevels, LineParams, ObjectAngle, ObjectLines, PaperSize, Plotter,
    Stroke, StrokeDirections, StrokeParams, StrokeScale, Style, ToneLevels, ToneParams, ToneSource,
};
pub(crate) use range::in_range;
pub(crate) use relight::AUTO_SAMPLES;
#[cfg(feature = "cli")]
pub(crate) use relight::MAX_LIGHTS;
pub use relight::{
    AlbedoSource, Material, MaterialParams, Method, Quantisation, Raking, RelightParams,
    SampleCount, Shadows, Tangent, WarpBy, WarpingParams,
};
pub use run::{RunOptions, TileSize};
pub use scale_bar::{PixelSize, ScaleBar};
pub(crate) use shape::check_scales;
pub(crate) use shape::{COARSE_ROUNDING, MAX_MIXED, MAX_SIGMA_PX};
pub use shape::{Scale, ShapeParams, SoftThreshold, Solver};
pub use specular::{Bend, SearchParams, SpecularParams};
pub use table::{Choice, Group, Kind, Many, Param, Parameters, Unit, Useful};

choices! {
    /// Which opposite borders continue each other, in a picture that is a tile.
    #[derive(Default)]
    pub enum Wrap {
        /// None.
        None = "none" [default],
        /// Left and right.
        X = "x",
        /// Top and bottom.
        Y = "y",
        /// Both.
        Xy = "xy",
        /// Those across which normals change no more than beside them.
        Auto = "auto",
    }
}

choices! {
    /// Whether the lobes of light are scaled separately.
    #[derive(Default)]
    pub enum LobeChoice {
        /// If the input separates them and no layer was named to be scaled as a whole.
        Auto = "auto" [default],
        /// Always; the input must separate them.
        On = "on",
        /// Never.
        Off = "off",
    }
}

params! {
    /// All parameters of a picture.
    pub struct Params in Light {
        /// Shape analysis.
        shape: ShapeParams;
        /// Radiance scaling.
        scaling: ScalingParams;
        /// Scale each lobe of the light separately, where the file has light passes: diffuse, specular and others. auto
        /// does so unless --color names the layer to scale.
        lobes: LobeChoice = LobeChoice::Auto, flag: "--lobes", form: "WHEN", group: Group::LightLayers;
        /// Rotates the environment about the vertical axis.
        environment_rotate_deg: f32 = 0.0,
            flag: "--environment-rotate", form: "DEG", unit: Unit::Degrees,
            valid: range::ANGLES_DEG, useful: table::even(-180.0, 180.0);
        /// Relighting.
        relight: RelightParams;
        /// Blend between the original picture, 0, and the full change, 1.
        mix: f32 = 1.0,
            flag: "--mix", common: true, form: "SHARE", valid: 0.0..=1.0, useful: table::even(0.0, 1.0), group: Group::Display;
        /// How much the change fades where pixels blend several surfaces: defocus, motion blur, fur and fog. 0 treats
        /// them like all others.
        blur_fade: f32 = 1.0,
            flag: "--blur-fade", form: "SHARE", valid: 0.0..=1.0, useful: table::even(0.0, 1.0), group: Group::Display;
        /// Mapping to a display.
        display: DisplayParams;
        /// Search for what mirrors and lenses show.
        search: SearchParams;
        /// Source of tone: the picture after radiance scaling, the picture unchanged, or new light; auto shows the
        /// shape, with a key light and the picture, or new light where any is given.
        tone: ToneSource = ToneSource::Auto, flag: "--tone", common: true, form: "SOURCE", group: Group::Tone;
        /// Enlargement of the picture before drawing; auto makes small pictures large enough for strokes. Without it
        /// --style auto does so where it engraves a picture or SVG; 1 draws that, too, as large as the frame.
        enlarge: Option<Enlargement> = None, flag: "--enlarge", common: true, form: "N|auto", valid: 1.0..=16.0, group: Group::Strokes;
        /// Paper to fit, as in 210x297mm, 21x29.7cm or 8.5x11in: the drawing is enlarged to that size at --dpi.
        size: Option<PaperSize> = None, flag: "--size", common: true, form: "WxHmm", group: Group::Strokes, rival: Some("enlarge");
        /// Page of an SVG: A3, A4, or a size as in 210x297mm. The drawing is scaled to fit inside its margin, centred,
        /// and cut at the picture's border.
        page: Option<PaperSize> = None, flag: "--page", form: "A4|A3|WxHmm", group: Group::Strokes, rival: Some("size");
        /// Margin of the page on all sides.
        margin_mm: f32 = 12.0, flag: "--margin", form: "MM", unit: Unit::Millimetres, valid: 0.0..=1000.0, group: Group::Strokes;
        /// Whether the page's long side lies across.
        landscape: Landscape = Landscape::Auto, flag: "--landscape", form: "WHEN", group: Group::Strokes;
        /// Line art.
        line: LineParams;
        /// Width of an input pixel on the surface, as in 0.05mm, 12um, 0.4cm or 2m: pictures get the resolution of a
        /// life-size print, unless --dpi gives another.
        pixel_size: Option<PixelSize> = None, flag: "--pixel-size", common: true, form: "LENGTH", group: Group::Print;
        /// A scale bar of a round length by --pixel-size, about a fifth of the picture's width: on the picture in its
        /// quietest corner, or outside in a white strip below it.
        scale_bar: ScaleBar = ScaleBar::Off, flag: "--scale-bar", common: true, form: "WHERE", group: Group::Print;
    }
    relations Params::relations;
}

impl Params {
    /// These, and defaults for all others.
    pub fn of(shape: ShapeParams, scaling: ScalingParams) -> Self {
        Self {
            shape,
            scaling,
            ..Self::default()
        }
    }
}

impl Param {
    /// The whole table.
    pub fn all() -> &'static [&'static Self] {
        static TABLE: LazyLock<Vec<&'static Param>> = LazyLock::new(|| {
            let mut table = Vec::new();
            Params::rows(&mut table);
            table
        });
        &TABLE
    }

    /// The row of the parameter named `name` in recipes.
    pub fn named(name: &str) -> Option<&'static Self> {
        let is_it = |row: &&&Self| row.has_flag() && row.name() == name;
        Self::all().iter().find(is_it).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Default parameters with one set to `text`, if they pass validation.
    fn with(row: &Param, text: &str) -> std::result::Result<Params, String> {
        let mut params = Params::default();
        assert!(params.set(row.name(), text)?, "{} is not set", row.flag);
        match params.validate() {
            Ok(()) => Ok(params),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn rows_are_whole() {
        let names: BTreeSet<_> = Param::all().iter().map(|row| row.name()).collect();
        assert_eq!(names.len(), Param::all().len(), "a name stands twice");
        for row in Param::all() {
            let help = row.help();
            assert!(!help.is_empty() && !help.contains('\n'), "{}", row.flag);
            assert_eq!(
                row.has_flag() && row.kind != Kind::Switch,
                !row.form.is_empty(),
                "{}",
                row.flag
            );
            assert!(
                row.rival.is_none_or(|rival| names.contains(rival)),
                "{}",
                row.flag
            );
        }
        assert!(Param::named("stroke-width").is_some() && Param::named("min_nz").is_none());
    }

    #[test]
    fn defaults_are_read_back() {
        Params::default().validate().unwrap();
        for row in Param::all() {
            if let Some(text) = (row.default)() {
                assert_eq!(
                    with(row, &text),
                    Ok(Params::default()),
                    "{} {text}",
                    row.flag
                );
            }
        }
    }

    #[test]
    fn sliders_reach_no_farther_than_the_range() {
        for row in Param::all() {
            let Some(Useful {
                from,
                to,
                logarithmic,
            }) = row.useful
            else {
                continue;
            };
            assert!(from < to && (!logarithmic || from > 0.0), "{}", row.flag);
            let ends = [from, to].map(|end| end.to_string());
            for text in ends.iter().map(String::as_str).chain(row.word()) {
                with(row, text).unwrap_or_else(|error| panic!("{} {text}: {error}", row.flag));
            }
            if let Some(Ok(default)) = (row.default)().map(|text| text.parse::<f64>()) {
                assert!((from..=to).contains(&default), "{} is {default}", row.flag);
            }
        }
    }

    #[test]
    fn what_is_outside_a_range_is_refused() {
        for row in Param::all() {
            let number = |number: f32| match row.kind {
                Kind::Pair => format!("{number},{number}"),
                _ if row.flag == "--term-white-level" => format!("diffuse={number}"),
                _ => number.to_string(),
            };
            let (from, to) = (*row.valid.start(), *row.valid.end());
            if from.is_infinite() {
                continue;
            }
            for end in [from, to].into_iter().filter(|end| end.is_finite()) {
                with(row, &number(end))
                    .unwrap_or_else(|error| panic!("{} {end}: {error}", row.flag));
            }
            let below = if row.is_whole() {
                from - 1.0
            } else {
                from.next_down()
            };
            let above = if row.is_whole() {
                to + 1.0
            } else {
                to.next_up()
            };
            for outside in [below, above, f32::NAN, f32::INFINITY] {
                assert!(
                    with(row, &number(outside)).is_err(),
                    "{} {outside}",
                    row.flag
                );
            }
        }
        // Messages name the flag, the value and the range.
        let levels = Param::named("levels").unwrap();
        assert_eq!(
            with(levels, "361").unwrap_err(),
            "--levels is 361; give 1 to 360"
        );
        let step = Param::named("direction-step").unwrap();
        let remedy = "give a whole number from 1 to 64, or auto";
        assert_eq!(
            with(step, "1.5").unwrap_err(),
            format!("--direction-step is 1.5; {remedy}")
        );
    }
}
