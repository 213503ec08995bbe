//! `relievo hatch`: line art.

use super::relight::needs;
use super::{FrameSeen, FrameWork};
use crate::command::args::WorkArgs;
use crate::command::line_args::HatchArgs;
use crate::command::motion_arg::MotionArg;
use crate::command::named::Named;
use crate::command::relight_args::RelightArgs;
use crate::engine::request::Request;
use crate::error::{Error, Result, bad};
use crate::frame::{Frame, Window};
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::inputs::Inputs;
use crate::io::output::OutputKind;
use crate::io::output::layers::{color_channels, stroke_channels};
use crate::io::output::page::page;
use crate::io::output::picture::MadePicture;
use crate::io::picture::PictureFormat;
use crate::io::svg;
use crate::io::{self, Loaded, Needs, picture_size};
use crate::light::lights::Illumination;
use crate::line::stippling::cpu::most_dots_per_px;
use crate::line::streamlines::Tool;
use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{
    Enlargement, Ink, LineParams, ObjectLines, StrokeParams, StrokeScale, Style, ToneSource,
};
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Plan};
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

impl FrameWork for HatchArgs {
    fn args(&self) -> &WorkArgs {
        &self.relight.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.relight.work
    }

    fn names(&mut self) -> Vec<Named<'_>> {
        let mut all = self.relight.names();
        all.extend(self.motion.names());
        all
    }

    fn folder(&self) -> Option<&Path> {
        self.pictures()
    }

    fn light(&self) -> Option<&RelightArgs> {
        Some(&self.relight)
    }

    fn motion(&self) -> Option<&MotionArg> {
        Some(&self.motion).filter(|motion| motion.moves())
    }

    fn check(&self) -> Result<()> {
        self.args().output.refuse_numbers()?;
        self.line().map(drop)
    }

    fn art_map(&self) -> Result<Option<TonalArtMap>> {
        let most = self.args().run.max_memory.for_light();
        let map = self.pictures();
        map.map(|path| own_map(path, &self.line()?.strokes, most))
            .transpose()
    }

    fn reading(&self, light: &Illumination) -> Result<(Inputs, Needs)> {
        let mut needs = needs(&self.relight.params(), light);
        // Lines of an SVG are either there or not, so the mask is read as coverage.
        needs.strength = !self.args().output.is_svg();
        needs.confidence_if_any = false;
        let LineParams {
            contours, interior, ..
        } = self.params();
        needs.objects = contours.is_some_and(|c| c.object_lines == ObjectLines::Auto);
        needs.color |= matches!(self.tone(), ToneSource::Enhance | ToneSource::Picture);
        if interior.is_some_and(|interior| interior.has_shadows()) {
            (needs.color, needs.albedo) = (true, true);
        }
        let inputs = Inputs {
            object_angles: self.object_angles.clone(),
            ..self.relight.inputs()
        };
        Ok((inputs, needs))
    }

    fn takes_whole(&self) -> bool {
        true
    }

    fn refuse_too_large(&self, picture: &Path) -> Result<()> {
        let work = self.args();
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

    fn times(&self, frame: &Frame, is_specular: bool, is_alone: bool) -> Result<f64> {
        let times = self.times_of(frame.display_window, frame.pixel_aspect)?;
        if times != 1.0 {
            self.refuse_enlarged(frame, times, is_specular)?;
        }
        if !is_alone || !self.enlarges_by_itself(frame) {
            return Ok(times);
        }
        let times = Enlargement::Auto.times(frame.display_window.size_px()) as f64;
        let fits = self.refuse_enlarged(frame, times, is_specular).is_ok();
        Ok(if fits { times } else { 1.0 })
    }

    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>> {
        let mut params = self.args().flags.params;
        params.relight = self.relight.params();
        let available = Available {
            moving: seen.moves,
            in_sequence: seen.is_in_sequence,
            specular: (seen.is_specular).then(|| self.relight.tracing(&params)),
            ..Available::in_frame(seen.frame).lit_by(&seen.light)
        };
        params.line.strokes.style = available.style(params.line.strokes.style);
        params.line = self.checked(params.line)?;
        let request = Request::hatch(params).fitted(seen.frame, seen.times);
        if let Some(lamp) = request.lamp(available) {
            seen.light.to_mut().directional.push(lamp);
        }
        let mut plan = request.plan(available)?;
        plan.inks_strokes = !self.args().output.is_svg();
        plan.keeps_tone = plan.inks_strokes && self.args().output.kind()? == OutputKind::Exr;
        Ok(vec![plan])
    }

    fn picture<'a>(&self, frame: &'a Frame, outcome: &'a Outcome) -> Option<MadePicture<'a>> {
        let params = &self.args().flags.params;
        let is_picture = !self.args().output.is_svg();
        is_picture.then(|| MadePicture::drawn(outcome, params, frame.pixel_aspect))?
    }

    fn channels<'a>(
        &self,
        loaded: &'a Loaded,
        outcome: &'a Outcome,
        picture: Option<&'a MadePicture>,
    ) -> Vec<OutputChannel<'a>> {
        let output = &self.args().output;
        let sample_type = output.depth_of_output.unwrap_or(OutputType::Half);
        let color = picture.map(|picture| &*picture.color);
        let color = color.expect("a drawing was made");
        let mut channels = color_channels(output.color_layer(loaded), color, None, sample_type);
        channels.extend(stroke_channels(outcome, sample_type));
        channels
    }

    fn lines<'a>(&self, frame: &Frame, outcome: &'a Outcome) -> Option<svg::LinePage<'a>> {
        let drawing = outcome
            .drawing
            .as_ref()
            .filter(|_| self.args().output.is_svg())?;
        Some(page(drawing, &self.args().flags.params, &frame.into()))
    }
}

impl HatchArgs {
    /// Settings of the lines, checked for contradictions.
    fn line(&self) -> Result<LineParams> {
        self.checked(self.params())
    }

    /// These settings, as lines if the output takes no others.
    fn checked(&self, mut line: LineParams) -> Result<LineParams> {
        let work = self.args();
        work.flags.refuse_more_scales()?;
        if !work.output.is_svg() {
            refuse_grey(work.output.kind()?, line.strokes.ink)?;
            return Ok(line);
        }
        in_lines(&mut line.strokes)?;
        match work.flags.params.mix < 1.0 {
            false => Ok(line),
            true => Err(bad(
                "--mix",
                "takes a share of ink, and the lines of an SVG are there or not",
                "leave it out, or write a .png",
            )),
        }
    }

    fn times_of(&self, window: Window, pixel_aspect: f32) -> Result<f64> {
        let size = [window.width(), window.height()];
        self.args().flags.params.times(size, pixel_aspect)
    }

    /// Whether a frame that stands alone is enlarged although nothing asks for it: an engraving that nobody chose, in a file
    /// of any size.
    fn enlarges_by_itself(&self, frame: &Frame) -> bool {
        let params = &self.relight.work.flags.params;
        let is_asked = params.enlarge.is_some() || params.size.is_some();
        let output = &self.relight.work.output;
        let has_size = match output.output {
            Some(_) => !output.is_svg() && !matches!(output.kind(), Ok(OutputKind::Picture(_))),
            None => true,
        };
        let style = self.params().strokes.style;
        style == Style::Auto
            && !is_asked
            && !has_size
            && Available::in_frame(frame).style(style) == Style::Engraving
    }

    /// Refuses to enlarge frames, with what their mirrors and lenses show, beyond the memory limit.
    fn refuse_enlarged(&self, frame: &Frame, times: f64, is_specular: bool) -> Result<()> {
        let work = &self.relight.work;
        let pixels = frame.mask.plane().samples().len() as u64;
        let shown = match is_specular {
            true => pixels as f64 * times * times * TRACED_BYTES_PER_PIXEL,
            false => 0.0,
        };
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
        Err(work.cannot_enlarge(found, format!("{less}, or raise --max-memory")))
    }

    /// Memory that a drawing of so many pixels of a picture takes beside these, at worst, which is where all of it is
    /// black: an enlarged frame, and strokes that are laid one by one.
    fn drawing_bytes(&self, display_window: Window, pixels: u64, times: f64) -> Result<u64> {
        let work = &self.relight.work;
        let mut params = work.flags.params;
        if work.output.is_svg() {
            in_lines(&mut params.line.strokes)?;
        }
        let [width, height] = enlarged_size(display_window, times);
        let mut strokes = params.strokes_on_page([width, height], 1.0);
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
}

/// Columns and rows of a window that is enlarged.
fn enlarged_size(window: Window, times: f64) -> [f64; 2] {
    [window.width(), window.height()].map(|side| side as f64 * times)
}

/// Memory of strokes in a black pixel, with `factor` as in [`StrokeParams::factor`].
fn stroke_bytes_per_px(strokes: &StrokeParams, factor: f32) -> f32 {
    let stroke = strokes.stroke(factor);
    match strokes.style {
        Style::Lines | Style::Engraving | Style::Auto => {
            POINT_BYTES * Tool::of(&stroke, strokes.style).most_points_per_px()
        }
        Style::Stipple => DOT_BYTES * most_dots_per_px(&stroke),
        Style::Pen | Style::Pencil | Style::Pictures => 0.0,
    }
}

/// Refuses bilevel ink for file types without it; EXR layers hold coverage.
fn refuse_grey(kind: OutputKind, ink: Ink) -> Result<()> {
    let is_grey = matches!(
        kind,
        OutputKind::Picture(PictureFormat::Jpeg | PictureFormat::Hdr)
    );
    match is_grey && ink == Ink::Bilevel {
        false => Ok(()),
        true => Err(bad(
            "--ink",
            "is bilevel, and the output is of a kind that cannot be",
            "write a .png or .tif",
        )),
    }
}

/// Turns pen strokes into lines for an SVG, and refuses textures.
fn in_lines(strokes: &mut StrokeParams) -> Result<()> {
    match strokes.style {
        Style::Pen => strokes.style = Style::Lines,
        Style::Lines | Style::Engraving | Style::Stipple | Style::Auto => {}
        Style::Pencil | Style::Pictures => {
            return Err(bad(
                "--style",
                "is a texture, and an SVG holds lines",
                "leave it out, or write a .png",
            ));
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
            return Err(bad(
                "--stroke-scale",
                "is in millimetres, but how wide the strokes of pictures are is not known",
                "give a factor",
            ));
        }
    };
    Ok(TonalArtMap::of_pictures(
        &io::read_art_map(path, most_bytes)?,
        factor.recip(),
    ))
}

impl WorkArgs {
    /// Error for an enlargement that is not possible.
    pub(crate) fn cannot_enlarge(&self, found: String, remedy: String) -> Error {
        let name = match self.flags.params.size {
            Some(_) => "--size",
            None => "--enlarge",
        };
        bad(name, found, remedy)
    }
}
