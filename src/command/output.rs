//! The kind of output that a path names, and the picture for a display.

use super::args::{OutputArgs, View, WorkArgs};
use super::rec709::{converted, rec709_from};
use crate::engine::outcome::Outcome;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::io::colorspace::Chromaticities;
use crate::io::picture::{ArrayFormat, Bright, Brightness, Display, Picture, PictureFormat};
use crate::light::mixing::mix;
use crate::params::{DisplayParams, Exposure, Highlights};
use crate::untrusted::shown;
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Placeholder in file names for the input's name without folder and extension.
pub(crate) const NAME: &str = "{name}";

/// Placeholder in the output's name for the map.
const MAP: &str = "{map}";

/// The kind of file that an output path names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Exr,
    Picture(PictureFormat),
    /// Planes as numbers.
    Numbers(ArrayFormat),
}

impl Kind {
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let ends_in = |extension: &str| {
            let own = path.extension();
            own.is_some_and(|own| own.eq_ignore_ascii_case(extension))
        };
        match PictureFormat::of_path(path) {
            _ if ends_in("exr") => Ok(Self::Exr),
            _ if ends_in("npy") => Ok(Self::Numbers(ArrayFormat::Npy)),
            Some(format) => Ok(Self::Picture(format)),
            None => Err(Error::BadParameter {
                name: "-o",
                found: format!("{} has no known extension", shown(path)),
                remedy: "end it in .exr, .png, .jpg, .tif, .hdr or .npy".into(),
            }),
        }
    }
}

/// A result picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MadePicture<'a> {
    pub(crate) color: &'a ColorPlanes,
    /// The picture it was derived from; `None` where it was lit anew.
    pub(crate) before: Option<&'a ColorPlanes>,
    /// The picture that it is to be as bright as, where its surface was lit anew.
    pub(crate) like: Option<&'a ColorPlanes>,
}

impl MadePicture<'_> {
    /// Whether the exposure is still to be chosen: AgX has room for bright light, and linear numbers stay.
    pub(crate) fn leaves_exposure(&self, work: &WorkArgs) -> bool {
        work.flags.params.display.exposure == Exposure::Auto
            && work.output.view_transform == View::Standard
            && self.before.is_none()
    }

    /// Automatic exposure in stops for this surface; `None` where it is given.
    pub(crate) fn exposure(&self, work: &WorkArgs, mask: &Mask) -> Option<f32> {
        self.leaves_exposure(work).then(|| {
            let mut brightness = Brightness::default();
            brightness.add(self.color, self.like, mask, 0..mask.height());
            brightness.exposure()
        })
    }
}

/// A picture as sent to a display, in Rec. 709 primaries.
pub(crate) struct Displayed<'a> {
    color: Cow<'a, ColorPlanes>,
    before: Option<Cow<'a, ColorPlanes>>,
    alpha: Option<&'a Plane>,
    pub(crate) bits: u8,
    dpi: Option<[f32; 2]>,
    view: View,
    exposure: f32,
    highlights: Highlights,
}

impl Displayed<'_> {
    /// The picture that it was derived from.
    pub(crate) fn before(&self) -> Option<&ColorPlanes> {
        self.before.as_deref()
    }

    pub(crate) fn picture(&self) -> Picture<'_> {
        let bright = match (self.view, self.highlights, &self.before) {
            (View::Agx, ..) => Bright::Agx,
            (_, Highlights::Clip, _) => Bright::Clipped,
            (_, Highlights::Compress, None) => Bright::Compressed,
            (_, Highlights::Compress, Some(before)) => Bright::ChangedFrom(before),
        };
        Picture {
            color: &self.color,
            alpha: self.alpha,
            grey: false,
            bits: self.bits,
            dpi: self.dpi,
            transform: self.view.transform(),
            display: Display {
                exposure: self.exposure,
                bright,
            },
        }
    }
}

impl OutputArgs {
    /// The kind of the output; a picture if no output is given. A TIFF of maps or of chosen layers holds their numbers.
    pub(crate) fn kind(&self) -> Result<Kind> {
        let is_of_numbers = self.tiff_holds_numbers || !self.write.is_empty();
        match self.output.as_deref().map(Kind::of).transpose()? {
            Some(Kind::Picture(PictureFormat::Tiff)) if is_of_numbers => {
                Ok(Kind::Numbers(ArrayFormat::Tiff))
            }
            Some(kind) => Ok(kind),
            None => Ok(Kind::Picture(PictureFormat::Png)),
        }
    }

    /// Refuses a file of numbers for a command that makes a picture.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the output.
    pub(crate) fn refuse_numbers(&self) -> Result<()> {
        let (Ok(Kind::Numbers(_)), Some(path)) = (self.kind(), &self.output) else {
            return Ok(());
        };
        Err(Error::BadParameter {
            name: "-o",
            found: format!(
                "{} is to hold planes of numbers, and this command makes a picture",
                shown(path)
            ),
            remedy: "write an .exr; normals, map and shape write numbers".into(),
        })
    }

    /// The files it names: one, or one for each map.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let Some(output) = &self.output else {
            return Vec::new();
        };
        match self.pattern().and_then(Path::to_str) {
            Some(pattern) if pattern.contains(MAP) && !self.parts.is_empty() => {
                let name = self.named.as_ref().map_or(NAME, |(_, name)| name);
                let parts = self.parts.iter();
                let file = |part: &String| filled(pattern, &[(NAME, name), (MAP, part)]).into();
                parts.map(file).collect()
            }
            _ => vec![output.clone()],
        }
    }

    /// Whether its name has a place for the map.
    pub(crate) fn is_per_map(&self) -> bool {
        let pattern = self.pattern().map(Path::to_string_lossy);
        pattern.is_some_and(|pattern| pattern.contains(MAP))
    }

    /// Its name as given.
    fn pattern(&self) -> Option<&Path> {
        let named = self.named.as_ref().map(|(pattern, _)| pattern.as_path());
        named.or(self.output.as_deref())
    }

    /// Refuses --quality for files that are not JPEG, and a choice of channels for pictures.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the output.
    pub(crate) fn refuse_idle(&self) -> Result<()> {
        let Some(path) = &self.output else {
            return Ok(());
        };
        let is_jpeg = PictureFormat::of_path(path) == Some(PictureFormat::Jpeg);
        let holds_layers = matches!(self.kind(), Ok(Kind::Exr | Kind::Numbers(_)));
        let of = |name, format: &str, extension: &str| {
            Err(Error::BadParameter {
                name,
                found: format!("is of {format} alone, and {} is none", shown(path)),
                remedy: format!("write a {extension} or leave it out"),
            })
        };
        if self.quality.is_some() && !is_jpeg {
            return of("--quality", "JPEG", ".jpg");
        }
        if !self.write.is_empty() && !holds_layers {
            return of("--write", "EXR, NPY and TIFF", ".exr");
        }
        Ok(())
    }
}

impl WorkArgs {
    /// Blends the result of `frame` with the original by the requested share, overall and per pixel.
    pub(crate) fn mix(&self, frame: &Frame, outcome: &mut Outcome) {
        if let Some(made) = &mut outcome.color {
            let params = &self.flags.params;
            let before = frame.color.as_ref();
            mix(made, before, frame.strength.as_ref(), params.mix);
            if let Some(confidence) = &frame.confidence {
                let kept = confidence.map(|confidence| 1.0 - params.blur_fade * (1.0 - confidence));
                mix(made, before, Some(&kept), 1.0);
            }
        }
    }

    /// Pixels per inch as given, across and down.
    pub(crate) fn dpi(&self, frame: &Frame) -> Option<[f32; 2]> {
        let dpi = self.flags.params.line.strokes.dpi?;
        Some([dpi / frame.pixel_aspect, dpi])
    }

    /// The result for a display, in 8 bits, converted from the file's primaries; `chosen` is the exposure where none
    /// was given.
    pub(crate) fn displayed<'a>(
        &self,
        frame: &'a Frame,
        primaries: Option<Chromaticities>,
        made: MadePicture<'a>,
        chosen: Option<f32>,
    ) -> Displayed<'a> {
        let view = self.output.view_transform;
        let turn = primaries.and_then(rec709_from);
        let turn = turn.filter(|_| view != View::None);
        let turned = |color| match turn {
            Some(matrix) => Cow::Owned(converted(color, matrix)),
            None => Cow::Borrowed(color),
        };
        let DisplayParams {
            exposure,
            highlights,
        } = self.flags.params.display;
        let exposure = match exposure {
            Exposure::Auto => chosen.unwrap_or(0.0),
            Exposure::Stops(stops) => stops,
        };
        Displayed {
            color: turned(made.color),
            before: made.before.map(turned),
            alpha: frame.alpha.as_ref(),
            bits: 8,
            dpi: self.dpi(frame),
            view,
            exposure,
            highlights,
        }
    }
}

/// Most planes in a file of numbers, which are read again as a picture's channels.
pub(crate) const MOST_PLANES: usize = 4;

/// `pattern` with each placeholder replaced by its text, which may look like another one.
fn filled(pattern: &str, texts: &[(&str, &str)]) -> String {
    let mut made = String::new();
    let mut rest = pattern;
    while let Some(next) = rest.chars().next() {
        let found = texts.iter().find(|(place, _)| rest.starts_with(place));
        let own = &rest[..next.len_utf8()];
        let &(place, text) = found.unwrap_or(&(own, own));
        made += text;
        rest = &rest[place.len()..];
    }
    made
}
