//! Output pictures: content, format, and encoding of values.

use super::display::{Display, DisplayMapping};
use super::encoding::Encoding;
use super::stored::{Storable, write_hdr, write_jpeg, write_png, write_tiff};
use crate::frame::{ColorPlanes, Plane};
use image::ImageResult;
use std::io::{Seek, Write};
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
    /// All kinds, with the endings of their names and, where their files have one, the end of a whole file.
    const ALL: [(Self, &[&str], &[u8]); 4] = [
        (Self::Png, &["png"], b"IEND\xae\x42\x60\x82"),
        (Self::Jpeg, &["jpg", "jpeg"], &[0xff, 0xd9]),
        (Self::Tiff, &["tif", "tiff"], &[]),
        (Self::Hdr, &["hdr"], &[]),
    ];

    /// The format for the extension of `path`.
    pub fn of_path(path: &Path) -> Option<PictureFormat> {
        let extension = path.extension()?;
        let is_own = |name: &&str| extension.eq_ignore_ascii_case(name);
        let mut all = Self::ALL.into_iter();
        all.find_map(|(format, names, _)| names.iter().any(is_own).then_some(format))
    }

    /// The usual ending of each kind.
    pub(crate) fn endings() -> impl Iterator<Item = &'static str> {
        Self::ALL.into_iter().map(|(_, names, _)| names[0])
    }

    /// The last bytes of a whole file; none where they tell nothing.
    pub(crate) fn last_bytes(self) -> &'static [u8] {
        Self::ALL[self as usize].2
    }

    pub(super) fn holds_alpha(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::Tiff)
    }

    /// Bits of a stored sample of a picture of so many, 32 of floats.
    pub(super) fn bits(self, wanted: u8) -> u8 {
        match self {
            PictureFormat::Jpeg => 8,
            PictureFormat::Hdr => 32,
            PictureFormat::Png | PictureFormat::Tiff => wanted,
        }
    }

    /// Writes a picture of this kind.
    pub(super) fn write(
        self,
        w: &mut (impl Write + Seek),
        stored: &Storable,
        encoding: &Encoding,
    ) -> ImageResult<()> {
        match self {
            PictureFormat::Png => write_png(w, stored, encoding),
            PictureFormat::Jpeg => write_jpeg(w, stored, encoding),
            PictureFormat::Tiff => write_tiff(w, stored, encoding),
            PictureFormat::Hdr => write_hdr(w, stored),
        }
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

    /// The mapping of light, if this picture is for a display.
    pub(super) fn mapping(&self) -> Option<DisplayMapping<'a>> {
        (self.transform == ViewTransform::Srgb).then(|| self.display.mapping())
    }
}
