//! Outcomes of requests to files, as the command line writes them.

use super::layers::{color_channels, shape_channels, stroke_channels};
use super::page::{page, text_of};
use super::picture::MadePicture;
use super::{OutputKind, Replace, software, write_atomically};
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use crate::io::picture::{Encoding, write_picture_as};
use crate::io::svg::{self, write_svg};
use crate::plan::outcome::{FileSheet, Outcome, Shows};
use crate::product::PART;
use std::borrow::Cow;
use std::path::Path;

impl Outcome {
    /// Writes what a request made of `frame` to a file of the kind that its name tells: the lines of a drawing to an
    /// `.svg`, a picture with all layers to an `.exr`, a picture for a display to others.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for another name; [`Error::Unfit`] for an outcome of a plan, which has no parameters of a
    /// file, and for a kind of file that does not hold what was made; [`Error::Io`].
    pub fn save(&self, path: impl AsRef<Path>, frame: &Frame) -> Result<()> {
        let (path, sheet) = (path.as_ref(), self.sheet()?);
        let kind = OutputKind::of(path)?;
        let frame =
            match frame.data_window == sheet.extent.data_window || sheet.shows == Shows::Drawing {
                true => Cow::Borrowed(frame),
                // A region of it was run.
                false => Cow::Owned(frame.crop(sheet.extent.data_window)),
            };
        let picture = self.made_picture(&frame, sheet);
        write_atomically(path, Replace::IfWritable, |w| match kind {
            OutputKind::Svg => write_svg(w, path, &self.page(sheet)?),
            OutputKind::Exr => write_results(w, path, &self.part(&frame, sheet, picture.as_ref())),
            OutputKind::Picture(format) => {
                let picture = picture.ok_or_else(|| unfit("has no picture", "write an .exr"))?;
                let FileSheet { params, extent, .. } = sheet;
                let exposure = picture.exposure(&params.display, &frame.mask);
                let shown = params.displayed(&frame, None, picture, 8, exposure);
                let times =
                    extent.display_window.width() as f64 / frame.display_window.width() as f64;
                let pixel_mm = params.pixel_size.map(|size| f64::from(size.mm) / times);
                let encoding = Encoding {
                    software: Some(software()),
                    pixel_mm,
                    scale_bar: params.scale_bar,
                    ..Encoding::default()
                };
                write_picture_as(w, path, format, &shown.picture(), &encoding)
            }
            #[cfg(feature = "cli")]
            OutputKind::Numbers(_) => Err(unfit("is more than numbers", "take its planes")),
        })
    }

    /// The drawing of a request as the text of an SVG.
    ///
    /// # Errors
    /// [`Error::Unfit`] where no lines were drawn.
    pub fn svg(&self) -> Result<String> {
        text_of(&self.page(self.sheet()?)?)
    }

    fn sheet(&self) -> Result<&FileSheet> {
        let none = || {
            unfit(
                "was made by a plan, which has no parameters of a file",
                "run a request",
            )
        };
        self.sheet.as_deref().ok_or_else(none)
    }

    fn page(&self, FileSheet { params, extent, .. }: &FileSheet) -> Result<svg::LinePage<'_>> {
        let drawing = self.drawing.as_ref();
        // Strokes that are not laid one by one are a texture.
        let lines = drawing.filter(|drawing| {
            drawing.lines.len() + drawing.dots.len() > 0 || params.line.lines_only
        });
        let lines = lines.ok_or_else(|| unfit("has no lines", "draw with Style::Lines"))?;
        Ok(page(lines, params, extent))
    }

    fn made_picture<'a>(&'a self, frame: &'a Frame, sheet: &FileSheet) -> Option<MadePicture<'a>> {
        let FileSheet {
            params,
            shows,
            extent,
        } = sheet;
        match shows {
            Shows::Layers => None,
            Shows::Curvature => MadePicture::curvature(frame, self, params),
            Shows::Enhanced => MadePicture::enhanced(frame, self),
            Shows::Relit => MadePicture::relit(frame, self, params),
            Shows::Drawing => MadePicture::drawn(self, params, extent.pixel_aspect),
        }
    }

    fn part<'a>(
        &'a self,
        frame: &'a Frame,
        sheet: &FileSheet,
        picture: Option<&'a MadePicture>,
    ) -> OutputPart<'a> {
        let half = OutputType::Half;
        let mut channels: Vec<OutputChannel> = match (picture, sheet.shows) {
            (None, _) => shape_channels(frame, self, half),
            (Some(picture), Shows::Drawing) => {
                let color = color_channels(None, &picture.color, None, half);
                color
                    .into_iter()
                    .chain(stroke_channels(self, half))
                    .collect()
            }
            (Some(picture), _) => color_channels(
                None,
                &picture.color,
                frame.alpha.as_ref(),
                OutputType::Float,
            ),
        };
        channels
            .iter_mut()
            .for_each(|channel| channel.name = super::full_name(&channel.name));
        OutputPart {
            name: PART.into(),
            data_window: sheet.extent.data_window,
            display_window: sheet.extent.display_window,
            pixel_aspect: sheet.extent.pixel_aspect,
            channels,
            attributes: vec![("software".into(), software())],
            chromaticities: None,
            compression: Default::default(),
        }
    }
}

fn unfit(found: &str, remedy: &'static str) -> Error {
    Error::Unfit {
        found: format!("the outcome {found}"),
        remedy,
    }
}
