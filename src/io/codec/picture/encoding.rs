//! Encoding of a picture's file, and the metadata beside its pixels.

use crate::io::codec::exif::{DESCRIPTION, Exif, SOFTWARE, SOUND_DPI};
use crate::io::photo::PhotoMetadata;
use crate::params::{MM_PER_INCH, ScaleBar};

/// Encoding of a picture's file, and the metadata beside its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoding {
    /// Quality of a JPEG, 1 to 100.
    pub quality: u8,
    /// The program that made it.
    pub software: Option<String>,
    /// Settings used for the picture. PNG, JPEG and TIFF store them as their description.
    pub settings: Option<String>,
    /// Width of a pixel on the depicted object, in millimetres, if known.
    pub pixel_mm: Option<f64>,
    /// Placement of the scale bar, drawn if the size of a pixel is known.
    pub scale_bar: ScaleBar,
    /// Metadata of the original photo: PNG and JPEG keep all of it, TIFF all but the camera data.
    pub metadata: PhotoMetadata,
}

impl Default for Encoding {
    fn default() -> Self {
        Self {
            quality: 95,
            software: None,
            settings: None,
            pixel_mm: None,
            scale_bar: ScaleBar::Off,
            metadata: PhotoMetadata::default(),
        }
    }
}

/// Longest EXIF block of a JPEG: a segment of 65,535 bytes, less its length and name.
const LONGEST_IN_JPEG: usize = 65_535 - 8;

impl Encoding {
    /// Resolution of a picture with `width` columns, in pixels per inch: printed at the size of the depicted object, if
    /// that is known and printable, otherwise as the photo.
    pub(super) fn dpi(&self, width: usize) -> Option<[f32; 2]> {
        let of_pixels = self.pixel_mm.map(|mm| (f64::from(MM_PER_INCH) / mm) as f32);
        if let Some(dpi) = of_pixels.filter(|dpi| SOUND_DPI.contains(dpi)) {
            return Some([dpi; 2]);
        }
        let times = width as f32 / self.metadata.width.max(1) as f32;
        Some(self.metadata.dpi?.map(|dpi| dpi * times))
    }

    /// The photo's colour profile, if it is an RGB one.
    pub(super) fn profile(&self) -> Option<&[u8]> {
        // The space of its colours is named after 16 bytes.
        let profile = self.metadata.profile.as_deref()?;
        (profile.get(16..20)? == b"RGB ").then_some(profile)
    }

    /// The EXIF block of a JPEG, including its settings; the camera data are dropped, then the settings, if it would be
    /// too long.
    pub(super) fn exif_of_jpeg(&self, dpi: Option<[f32; 2]>) -> Option<Vec<u8>> {
        if (&self.software, &self.settings, &self.metadata.exif) == (&None, &None, &None) {
            return None;
        }
        let fresh = Exif::default;
        let settings = self.settings.as_deref();
        let tries = [
            (self.kept_exif().unwrap_or_else(fresh), settings),
            (fresh(), settings),
            (fresh(), None),
        ];
        let mut blocks = tries.into_iter().map(|(mut exif, settings)| {
            let described = [exif.description(), settings.map(ascii)];
            let described: Vec<_> = described.into_iter().flatten().collect();
            if settings.is_some() {
                exif.set_text(DESCRIPTION, &described.join("\n\n"));
            }
            self.said(exif, dpi)
        });
        blocks.find(|block| block.len() <= LONGEST_IN_JPEG)
    }

    /// The EXIF block of a PNG: that of the photo, if it has one.
    pub(super) fn exif_of_png(&self, dpi: Option<[f32; 2]>) -> Option<Vec<u8>> {
        self.kept_exif().map(|exif| self.said(exif, dpi))
    }

    fn kept_exif(&self) -> Option<Exif> {
        Exif::read(self.metadata.exif.as_deref()?)
    }

    /// The block updated for this picture.
    fn said(&self, mut exif: Exif, dpi: Option<[f32; 2]>) -> Vec<u8> {
        exif.set_upright();
        exif.set_dpi(dpi);
        if let Some(software) = &self.software {
            exif.set_text(SOFTWARE, &ascii(software));
        }
        exif.into_bytes()
    }
}

/// A text for all formats: non-ASCII letters are escaped as in TOML.
pub(super) fn ascii(text: &str) -> String {
    let spelled = |c: char| match c {
        '\0' => String::new(),
        _ if c.is_ascii() => c.into(),
        _ => format!("\\U{:08X}", u32::from(c)),
    };
    text.chars().map(spelled).collect()
}
