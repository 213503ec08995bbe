//! The header of a picture, and the samples of its rows.

use super::decoder::{max_code, with_decoder};
use super::faults::unsupported;
use super::numbers::PAIR;
use crate::error::{Error, Result};
use crate::frame::Window;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat};
use std::path::{Path, PathBuf};

/// The header of a picture.
#[derive(Clone)]
pub(in crate::io) struct PhotoHeader {
    pub(in crate::io) path: PathBuf,
    /// Upright columns and rows, after its orientation.
    pub(in crate::io) width: usize,
    pub(in crate::io) height: usize,
    /// Rotation of the stored pixels.
    pub(super) orientation: Orientation,
    /// Bits per sample: 8, 16 or 32.
    pub(in crate::io) bits: u8,
    /// Whether samples are floating point, hence linear.
    pub(in crate::io) is_float: bool,
    /// Whether it holds two channels of vectors, as red and green.
    pub(in crate::io) is_pair: bool,
    pub(super) format: ImageFormat,
    pub(super) color: ColorType,
}

/// Codes of 8 bits that JPEG moves a smooth picture by, about: it rounds luminance and colour apart, then waves of both,
/// and the result. Measured on gentle forms: 1 for 99 of 100 samples at qualities 95 and 90, 2 at 75, 3 at 50.
const JPEG_CODES: f32 = 2.0;

impl PhotoHeader {
    /// How far coding may have moved a sample, from 0 to 1; 0 for floats.
    pub(in crate::io) fn coding_error(&self) -> f32 {
        let codes = match self.format {
            _ if self.is_float => 0.0,
            ImageFormat::Jpeg => JPEG_CODES,
            _ => 0.5,
        };
        codes / max_code(self.bits) as f32
    }

    /// Reads the header of the picture at `path`; its kind is recognised by content, not by name.
    pub(super) fn read(path: &Path) -> Result<Self> {
        with_decoder(path, |mut decoder, format| {
            let color = decoder.color_type();
            // A tag that cannot be read is no reason to refuse the picture.
            let upright = Orientation::NoTransforms;
            let orientation = decoder.orientation().unwrap_or(upright);
            let (width, height) = turned(orientation, decoder.dimensions());
            let bits = 8 * (color.bytes_per_pixel() / color.channel_count());
            if ![8, 16, 32].contains(&bits) {
                return Err(unsupported(path, "has samples of an unknown kind"));
            }
            Ok(Self {
                path: path.to_path_buf(),
                width: width as usize,
                height: height as usize,
                orientation,
                bits,
                is_float: bits == 32,
                is_pair: decoder.original_color_type() == PAIR,
                format,
                color,
            })
        })
    }

    /// Its pixels.
    pub(in crate::io) fn window(&self) -> Window {
        Window::from_size(self.width, self.height)
    }

    /// Whether its colours may be vectors in codes of integers.
    pub(in crate::io) fn may_hold_coded_vectors(&self) -> bool {
        !self.is_float && self.color_channels() == 3
    }

    pub(in crate::io) fn has_alpha(&self) -> bool {
        self.color.has_alpha()
    }

    /// Channels without alpha: 1 or 3.
    pub(in crate::io) fn color_channels(&self) -> usize {
        self.channels() - usize::from(self.has_alpha())
    }

    pub(in crate::io) fn channels(&self) -> usize {
        usize::from(self.color.channel_count())
    }

    /// Stored columns and rows, and the EXIF number of the orientation, if it rotates the pixels.
    pub(in crate::io) fn turned_from(&self) -> Option<([usize; 2], u8)> {
        let (width, height) = turned(self.orientation, (self.width, self.height));
        let is_turned = self.orientation != Orientation::NoTransforms;
        is_turned.then(|| ([width, height], self.orientation.to_exif()))
    }

    /// Bytes of all samples.
    pub(in crate::io) fn bytes(&self) -> u64 {
        (self.row_bytes() as u64).saturating_mul(self.height as u64)
    }

    /// Bytes of the samples of a row.
    pub(super) fn row_bytes(&self) -> usize {
        self.width * usize::from(self.color.bytes_per_pixel())
    }

    /// The refusal of a picture whose samples can only be decoded whole.
    pub(super) fn too_large(&self, most_bytes: u64) -> Error {
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let (kind, remedy) = match self.turned_from() {
            Some(_) => ("one that its orientation turns", "save it upright as PNG"),
            None => (
                "a picture of this kind",
                "save it as PNG without interlacing",
            ),
        };
        Error::Unsupported {
            path: self.path.clone(),
            found: format!(
                "is {}x{} and takes {} MiB, of which {} may be held; {kind} is decoded whole",
                self.width,
                self.height,
                mib(self.bytes()),
                most_bytes >> 20,
            ),
            remedy: format!("allow more memory, make it smaller, or {remedy} or OpenEXR"),
        }
    }

    pub(super) fn has_changed(&self) -> Error {
        Error::Damaged {
            path: self.path.clone(),
            found: "has changed while it was read".into(),
        }
    }
}

/// Columns and rows after the rotation, or before: the sides swap both ways.
pub(super) fn turned<T>(orientation: Orientation, (width, height): (T, T)) -> (T, T) {
    match orientation {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => (height, width),
        _ => (width, height),
    }
}
