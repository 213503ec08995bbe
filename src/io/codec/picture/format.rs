//! Output pictures: content, format, and encoding of values.

use super::display::{Display, Shown};
use crate::frame::{ColorPlanes, Plane};
use std::path::Path;

/// The kinds of pictures that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// PNG, 8 or 16 bits, with alpha; or 1 bit.
    Png,
    /// JPEG, 8 bits, over black.
    Jpeg,
    /// TIFF, 8 or 16 bits, with alpha; or 1 bit, by CCITT Group 4.
    Tiff,
    /// Radiance HDR, linear, over black.
    Hdr,
}

impl PictureFormat {
    /// The format for the extension of `path`.
    pub fn of_path(path: &Path) -> Option<PictureFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(PictureFormat::Png),
            "jpg" | "jpeg" => Some(PictureFormat::Jpeg),
            "tif" | "tiff" => Some(PictureFormat::Tiff),
            "hdr" => Some(PictureFormat::Hdr),
            _ => None,
        }
    }

    pub(super) fn holds_alpha(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::Tiff)
    }
}

/// Whether a name has the extension of a readable picture.
pub(crate) fn is_picture_name(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    extension.eq_ignore_ascii_case("exr") || PictureFormat::of_path(path).is_some()
}

/// Encoding of linear values in integer formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ViewTransform {
    /// The sRGB curve: for pictures to be looked at.
    Srgb,
    /// None: for normals, masks and other data.
    None,
}

/// A picture to be written.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Linear colour, multiplied by alpha.
    pub color: &'a ColorPlanes,
    /// Coverage, 0..1.
    pub alpha: Option<&'a Plane>,
    /// Whether it is grey, of which red alone is read: without alpha PNG, JPEG and TIFF then hold one sample per pixel.
    pub grey: bool,
    /// Bits per sample: 8 or 16, or 1 for grey without alpha; JPEG always has 8, HDR its own.
    pub bits: u8,
    /// Print resolution in pixels per inch, horizontal and vertical, if the file is to state it; HDR does not.
    pub dpi: Option<[f32; 2]>,
    /// Encoding of values; HDR is always linear.
    pub transform: ViewTransform,
    /// Mapping of light to the range of a display, before values are encoded for one.
    pub display: Display<'a>,
}

impl<'a> Picture<'a> {
    /// A picture of colour alone, in 8 bits and as bright as it is.
    pub fn of(color: &'a ColorPlanes, transform: ViewTransform) -> Self {
        Self {
            color,
            alpha: None,
            grey: false,
            bits: 8,
            dpi: None,
            transform,
            display: Display::default(),
        }
    }

    /// Its planes: three of colour or one of grey, and alpha if it has one.
    pub fn planes(&self) -> Vec<&'a Plane> {
        let count = if self.grey { 1 } else { 3 };
        let color = self.primaries().into_iter().take(count);
        color.chain(self.alpha).collect()
    }

    /// Red, green and blue.
    pub(super) fn primaries(&self) -> [&'a Plane; 3] {
        let ColorPlanes { r, g, b } = self.color;
        if self.grey { [r; 3] } else { [r, g, b] }
    }

    /// The mapping of light, if this picture is for a display and the mapping changes it.
    pub(super) fn shown(&self) -> Option<Shown<'a>> {
        let is_shown = self.transform == ViewTransform::Srgb;
        self.display.shown().filter(|_| is_shown)
    }
}
