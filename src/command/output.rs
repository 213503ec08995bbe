//! What an output path stands for, and the picture that a display is given.

use super::args::OutputArgs;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane};
use crate::io::Loaded;
use crate::io::colorspace::{converted, rec709_from};
use crate::io::picture::{Picture, PictureFormat, ViewTransform};
use std::path::Path;

/// What kind of file an output path stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Exr,
    Picture(PictureFormat),
}

impl Kind {
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let is_exr = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match PictureFormat::of_path(path) {
            _ if is_exr => Ok(Self::Exr),
            Some(format) => Ok(Self::Picture(format)),
            None => Err(Error::BadParameter {
                name: "-o",
                found: format!("{} has no known extension", path.display()),
                remedy: "end it in .exr, .png, .jpg, .tif or .hdr".into(),
            }),
        }
    }
}

impl OutputArgs {
    /// The kind of the output; a picture where there is none.
    pub(crate) fn kind(&self) -> Result<Kind> {
        match &self.output {
            Some(path) => Kind::of(path),
            None => Ok(Kind::Picture(PictureFormat::Png)),
        }
    }

    /// `color` as a display has it, in Rec. 709 primaries, where it has others.
    pub(crate) fn turned(&self, loaded: &Loaded, color: &ColorPlanes) -> Option<ColorPlanes> {
        let turn = loaded.chromaticities.and_then(rec709_from);
        let turn = turn.filter(|_| self.view_transform == ViewTransform::Srgb);
        turn.map(|matrix| converted(color, matrix))
    }

    /// The picture of a display's colours.
    pub(crate) fn picture<'p>(
        &self,
        color: &'p ColorPlanes,
        alpha: Option<&'p Plane>,
        bits: u8,
    ) -> Picture<'p> {
        Picture {
            color,
            alpha,
            grey: false,
            bits,
            dpi: None,
            transform: self.view_transform,
        }
    }
}
