//! `relievo hatch`: the layers it needs, and its plan.

use super::args::WorkArgs;
use super::line_args::HatchArgs;
use super::output::Kind;
use super::relight::needs;
use crate::engine::outcome::Drawing;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, SpecularScene, Window};
use crate::io::inputs::Inputs;
use crate::io::picture::{Picture, PictureFormat};
use crate::io::svg;
use crate::io::{self, Needs, picture_size};
use crate::light::lights::{DirectionalLight, Illumination, LAMP_DEG};
use crate::line::bilevel::bilevel;
use crate::line::contours::Contour;
use crate::line::fading::{faded, largest_around};
use crate::line::paper::on_paper;
use crate::line::stippling::cpu::most_dots_per_px;
use crate::line::streamlines::{Streamline, Tool};
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{
    Ink, LineParams, ObjectLines, RelightParams, ScalingParams, ShapeParams, SoftThreshold,
    StrokeParams, StrokeScale, Style, ToneSource,
};
use crate::plan::{Available, LightKinds, Plan, ToneFrom};
use std::path::Path;

/// Memory per pixel of an enlarged drawing, beside its strokes. Measured at 32 megapixels: 58 to 68, with few strokes.
const BYTES_PER_PIXEL: f64 = 110.0;

/// Memory per pixel of an enlarged drawing for what mirrors and lenses show. Measured with a lens before a wall at one
/// megapixel: 205 in all.
const TRACED_BYTES_PER_PIXEL: f64 = 100.0;

/// Memory per pixel of a drawing at the size of its frame, beyond that of a frame. Measured without depth: 17 at 2
/// megapixels, 33 at .8.
const DRAWN_BYTES_PER_PIXEL: f64 = 45.0;

/// Memory of a point of a stroke, and of a dot. Measured on black pictures of 8 megapixels, with 0.2 to 2.1 points and 0.3
/// to 4.5 dots in a pixel: 85 to 95, and 32.
const POINT_BYTES: f32 = 100.0;
const DOT_BYTES: f32 = 40.0;

/// Settings of a drawing, collected from the flags.
pub(crate) struct Looks {
    shape: ShapeParams,
    scaling: ScalingParams,
    light: RelightParams,
    pub(crate) line: LineParams,
}

/// Circumstances in which a frame is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drawn {
    /// Enlargement of the frame before drawing; 1 keeps its size.
    pub(crate) times: f64,
    /// Whether it belongs to a sequence, whose frames need consistent tones and lines.
    pub(crate) is_in_sequence: bool,
    /// Whether strokes move with the surface.
    pub(crate) moves: bool,
    /// Whether mirrors and lenses are traced in the frame.
    pub(crate) is_specular: bool,
}

impl HatchArgs {
    /// Settings of the drawing, checked for contradictions.
    pub(crate) fn looks(&self) -> Result<Looks> {
        let relight = &self.relight;
        let work = &relight.work;
        work.flags.refuse_more_scales()?;
        let mut line = self.params();
        if is_svg(work) {
            in_lines(&mut line.strokes)?;
            if work.flags.params.mix < 1.0 {
                return Err(Error::BadParameter {
                    name: "--mix",
                    found: "takes a share of ink, and the lines of an SVG are there or not".into(),
                    remedy: "leave it out, or write a .png".into(),
                });
            }
        } else {
            refuse_grey(work.output.kind()?, line.strokes.ink)?;
        }
        Ok(Looks {
            shape: work.flags.params.shape,
            scaling: work.flags.params.scaling,
            light: relight.params(),
            line,
        })
    }

    /// The stroke texture, if it comes from pictures.
    pub(crate) fn art_map(&self, looks: &Looks) -> Result<Option<TonalArtMap>> {
        let map = self.pictures();
        let most = self.relight.work.run.max_memory.for_light();
        map.map(|path| own_map(path, &looks.line.strokes, most))
            .transpose()
    }

    /// Inputs and layers to read for a frame.
    pub(crate) fn reading(
        &self,
        looks: &Looks,
        illumination: &Illumination,
        frame: Option<i32>,
    ) -> (Inputs, Needs) {
        let mut needs = needs(&looks.light, illumination);
        // Lines of an SVG are either there or not, so the mask is read as coverage.
        needs.strength = !is_svg(&self.relight.work);
        needs.confidence_if_any = false;
        let contours = looks.line.contours.as_ref();
        needs.objects = contours.is_some_and(|c| c.object_lines == ObjectLines::Auto);
        needs.color |= matches!(self.tone(), ToneSource::Enhance | ToneSource::Picture);
        if looks
            .line
            .interior
            .is_some_and(|interior| interior.has_shadows())
        {
            (needs.color, needs.albedo) = (true, true);
        }
        let inputs = Inputs {
            object_angles: self.object_angles.clone(),
            ..self.relight.inputs(frame)
        };
        (inputs, needs)
    }

    /// The enlargement of a frame for its drawing.
    pub(crate) fn times(&self, frame: &Frame) -> Result<f64> {
        self.times_of(frame.display_window, frame.pixel_aspect)
    }

    fn times_of(&self, window: Window, pixel_aspect: f32) -> Result<f64> {
        let params = &self.relight.work.flags.params;
        let (width, height) = (window.width(), window.height());
        match params.size {
            Some(paper) => paper.factor([width, height], pixel_aspect, self.dpi()),
            None => {
                let size_px = ((width * height) as f32).sqrt();
                Ok(params.enlarge.times(size_px) as f64)
            }
        }
    }

    /// Refuses a `picture` over the memory limit, by its header.
    pub(crate) fn refuse_too_large(&self, picture: &Path) -> Result<()> {
        let work = &self.relight.work;
        let Some(size) = picture_size(picture) else {
            return work.refuse_too_large(picture);
        };
        let times = self.times_of(size.display_window, size.pixel_aspect)?;
        let [width, height] = enlarged_size(size.display_window, times);
        let why = match times > 1.0 {
            true => format!("draws it in {width:.0}x{height:.0} pixels"),
            false => "draws the picture whole".into(),
        };
        let beside = self.drawing_bytes(size.display_window, size.pixels, times)?;
        work.refuse_above(picture, beside, &why)
    }

    /// Refuses to enlarge frames, with what their mirrors and lenses show, beyond the memory limit.
    pub(crate) fn refuse_enlarged(
        &self,
        frame: &Frame,
        times: f64,
        scene: Option<&SpecularScene>,
    ) -> Result<()> {
        let work = &self.relight.work;
        let pixels = frame.mask.plane().samples().len() as u64;
        let shown = scene.map_or(0.0, |_| {
            pixels as f64 * times * times * TRACED_BYTES_PER_PIXEL
        });
        let bytes = self.drawing_bytes(frame.display_window, pixels, times)? + shown as u64;
        if bytes <= work.run.max_memory.most() {
            return Ok(());
        }
        let [width, height] = enlarged_size(frame.display_window, times);
        let found = format!(
            "makes a drawing of {width:.0}x{height:.0} pixels, and memory for it is not allowed"
        );
        let less = match work.flags.params.size {
            Some(_) => "give a lower --dpi",
            None => "give a lower one",
        };
        Err(self.cannot_enlarge(found, format!("{less}, or raise --max-memory")))
    }

    /// Memory that a drawing of so many pixels of a picture takes beside these, at worst, which is where all of it is
    /// black: an enlarged frame, and strokes that are laid one by one.
    fn drawing_bytes(&self, display_window: Window, pixels: u64, times: f64) -> Result<u64> {
        let work = &self.relight.work;
        let mut strokes = self.params().strokes;
        if is_svg(work) {
            in_lines(&mut strokes)?;
        }
        let [width, height] = enlarged_size(display_window, times);
        let reference = work.flags.params.shape.reference_height;
        let reference = reference.map_or(display_window.height() as f64, f64::from);
        let factor = (height / reference) as f32;
        strokes.fit((width * height).sqrt() as f32, factor);
        let drawn = match times > 1.0 {
            true => BYTES_PER_PIXEL,
            false => DRAWN_BYTES_PER_PIXEL,
        };
        let per_pixel = drawn + f64::from(stroke_bytes_per_px(&strokes, factor));
        Ok((pixels as f64 * times * times * per_pixel) as u64)
    }

    /// Error for an enlargement that is not possible.
    pub(crate) fn cannot_enlarge(&self, found: String, remedy: String) -> Error {
        let name = match self.relight.work.flags.params.size {
            Some(_) => "--size",
            None => "--enlarge",
        };
        Error::BadParameter {
            name,
            found,
            remedy,
        }
    }

    /// Pixels per inch that give the print's height.
    pub(crate) fn dpi(&self) -> f32 {
        self.params().strokes.print_dpi()
    }

    /// Mixes in only the requested share of ink, overall and per pixel. Where the mask selects lines along edges, they
    /// are kept whole as far as they reach.
    pub(crate) fn mix(&self, drawing: &mut Drawing, frame: &Frame, times: f64) {
        let share = self.relight.work.flags.params.mix;
        let strength = frame.strength.as_ref();
        let width_px = self.params().contours.map_or(0.0, |lines| lines.width_px);
        let reach = (0.5 * f64::from(width_px) * times).ceil() as usize + 1;
        let around = strength.map(|strength| largest_around(strength, reach));
        faded(&mut drawing.hatching, strength, share);
        let within = drawing.interior.iter_mut().chain(&mut drawing.asked);
        within.for_each(|ink| faded(ink, strength, share));
        let along_edges = drawing.contours.iter_mut();
        along_edges.for_each(|ink| faded(ink, around.as_ref(), share));
    }

    /// A drawing on its paper, as a picture shows it.
    pub(crate) fn printed(&self, drawing: &Drawing) -> ColorPlanes {
        let color = inked(drawing);
        match self.params().strokes.ink {
            Ink::Antialiased => color,
            Ink::Bilevel => {
                let light = bilevel(&color.r);
                ColorPlanes {
                    r: light.clone(),
                    g: light.clone(),
                    b: light,
                }
            }
        }
    }

    /// A drawing on its paper as a picture, of pixels `pixel_aspect` times as wide as high.
    pub(crate) fn on_a_page<'a>(&self, color: &'a ColorPlanes, pixel_aspect: f32) -> Picture<'a> {
        let work = &self.relight.work;
        let is_bilevel = self.params().strokes.ink == Ink::Bilevel;
        let has_size = work.flags.params.size.is_some() || self.params().strokes.dpi.is_some();
        let is_for_print = is_bilevel || has_size;
        Picture {
            grey: true,
            bits: if is_bilevel { 1 } else { 8 },
            dpi: is_for_print.then_some([self.dpi() / pixel_aspect, self.dpi()]),
            ..Picture::of(color, work.output.view_transform.transform())
        }
    }

    /// The plan for a frame and its light, with a default lamp where tones need light and none is given.
    pub(crate) fn plan(
        &self,
        looks: &Looks,
        mut illumination: Illumination,
        frame: &Frame,
        drawn: Drawn,
    ) -> Result<(Plan, Illumination)> {
        let is_specular = drawn.is_specular;
        let specular = self
            .relight
            .specular
            .params(&self.relight.work.flags.params);
        let available = Available {
            moving: drawn.moves,
            in_sequence: drawn.is_in_sequence,
            specular: is_specular.then_some(specular),
            ..Available::in_frame(frame)
        };
        let is_lit = LightKinds::in_light(&illumination) != LightKinds::default();
        // A surface seen in mirrors has no tone but that of its light.
        let shows_shape = self.tone() == ToneSource::Auto && !is_specular;
        let relit = match self.tone() {
            ToneSource::Relight => true,
            ToneSource::Auto if shows_shape => is_lit,
            ToneSource::Auto => is_lit || !available.color,
            ToneSource::Enhance | ToneSource::Picture => false,
        };
        let is_mirror = looks.light.material.material.shows_surroundings();
        if relit && !is_lit && !(is_mirror && is_specular) {
            illumination
                .directional
                .push(DirectionalLight::white(LAMP_DEG));
        }
        let kinds = LightKinds::in_light(&illumination);
        let tone = match self.tone() {
            _ if shows_shape => ToneFrom::Shape(relit.then_some((looks.light, kinds))),
            _ if relit => ToneFrom::Relit(looks.light, kinds),
            ToneSource::Picture => ToneFrom::Picture,
            _ => ToneFrom::Enhanced,
        };
        let shape = enlarged(looks.shape, drawn.times, frame);
        let line = LineParams {
            contours: looks
                .line
                .contours
                .map(|contours| contours.enlarged(drawn.times as f32)),
            ..looks.line
        };
        let plan = Plan::hatch(available, shape, looks.scaling, tone, line)?;
        Ok((plan, illumination))
    }
}

/// Shape parameters for a frame enlarged by `times`, measured in pixels of the original.
fn enlarged(shape: ShapeParams, times: f64, frame: &Frame) -> ShapeParams {
    if times == 1.0 {
        return shape;
    }
    let height = (frame.display_window.height() as f64 / times)
        .round()
        .max(1.0) as u32;
    let SoftThreshold { lo, hi } = shape.crease;
    ShapeParams {
        reference_height: shape.reference_height.or(Some(height)),
        // Interpolated normals turn `times` less from pixel to pixel.
        crease: SoftThreshold {
            lo: lo / times as f32,
            hi: hi / times as f32,
        },
        ..shape
    }
}

/// Columns and rows of a window that is enlarged.
fn enlarged_size(window: Window, times: f64) -> [f64; 2] {
    [window.width(), window.height()].map(|side| side as f64 * times)
}

/// Memory of strokes in a black pixel, with `factor` as in [`StrokeParams::factor`].
fn stroke_bytes_per_px(strokes: &StrokeParams, factor: f32) -> f32 {
    let stroke = strokes.stroke(factor);
    match strokes.style {
        Style::Lines | Style::Engraving => {
            POINT_BYTES * Tool::of(&stroke, strokes.style).most_points_per_px()
        }
        Style::Stipple => DOT_BYTES * most_dots_per_px(&stroke),
        Style::Pen | Style::Pencil | Style::Pictures => 0.0,
    }
}

/// The lines of a drawing on a page.
pub(crate) fn page<'a>(
    frame: &Frame,
    drawing: &'a Drawing,
    strokes: &StrokeParams,
) -> svg::Drawing<'a> {
    let is_plotted = strokes.plotter.is_on(strokes.style);
    // Lines that cross others are a layer of their own for a plotter.
    let laid = |wanted: &dyn Fn(&Streamline) -> bool| {
        let lines = drawing.lines.iter().filter(|line| wanted(line));
        lines
            .map(|line| (&line.points[..], &line.widths[..]))
            .collect::<Vec<svg::Line>>()
    };
    let along = |lines: &'a [Contour]| {
        let lines = lines.iter();
        lines
            .map(|line| (&line.points[..], &line.widths[..]))
            .collect()
    };
    let mut layers = match is_plotted {
        true => vec![
            ("strokes", laid(&|line| !line.crosses)),
            ("crossing", laid(&|line| line.crosses)),
        ],
        false => vec![("strokes", laid(&|_| true))],
    };
    layers.push(("contours", along(&drawing.contour_lines)));
    if drawing.interior.is_some() {
        layers.push(("interior", along(&drawing.interior_lines)));
    }
    svg::Drawing {
        display_window: frame.display_window,
        data_window: frame.data_window,
        pixel_aspect: frame.pixel_aspect,
        dpi: strokes.print_dpi(),
        dots: drawing
            .dots
            .iter()
            .map(|dot| (dot.at, dot.radius))
            .collect(),
        layers,
        is_plotted,
    }
}

/// Refuses bilevel ink for file types without it; EXR layers hold coverage.
fn refuse_grey(kind: Kind, ink: Ink) -> Result<()> {
    let is_grey = matches!(
        kind,
        Kind::Picture(PictureFormat::Jpeg | PictureFormat::Hdr)
    );
    match is_grey && ink == Ink::Bilevel {
        false => Ok(()),
        true => Err(Error::BadParameter {
            name: "--ink",
            found: "is bilevel, and the output is of a kind that cannot be".into(),
            remedy: "write a .png or .tif".into(),
        }),
    }
}

/// Turns pen strokes into lines for an SVG, and refuses textures.
fn in_lines(strokes: &mut StrokeParams) -> Result<()> {
    match strokes.style {
        Style::Pen => strokes.style = Style::Lines,
        Style::Lines | Style::Engraving | Style::Stipple => {}
        Style::Pencil | Style::Pictures => {
            return Err(Error::BadParameter {
                name: "--style",
                found: "is a texture, and an SVG holds lines".into(),
                remedy: "leave it out, or write a .png".into(),
            });
        }
    }
    Ok(())
}

/// The stroke texture read from a folder of pictures.
fn own_map(path: &Path, strokes: &StrokeParams, most_bytes: u64) -> Result<TonalArtMap> {
    let factor = match strokes.scale {
        StrokeScale::Auto => 1.0,
        StrokeScale::Factor(factor) => factor,
        StrokeScale::Millimetres(_) => {
            return Err(Error::BadParameter {
                name: "--stroke-scale",
                found: "is in millimetres, but how wide the strokes of pictures are is not known"
                    .into(),
                remedy: "give a factor".into(),
            });
        }
    };
    Ok(TonalArtMap::of_pictures(
        &io::read_art_map(path, most_bytes)?,
        factor.recip(),
    ))
}

/// Whether the drawing is written as SVG lines.
pub(crate) fn is_svg(work: &WorkArgs) -> bool {
    let extension = work.output.output.as_deref().and_then(Path::extension);
    extension.is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

/// Colour of the ink on its paper.
pub(crate) fn inked(drawing: &Drawing) -> ColorPlanes {
    on_paper(&drawing.layers())
}
