//! Reading pictures of the everyday kinds: PNG, JPEG, TIFF and Radiance HDR.
//!
//! A picture is read as its stored values, and made linear only when asked: a photograph is, a normal
//! map or a mask is not. The orientation tag that cameras write is not obeyed, so that a photograph
//! and the normal map made from it, which has no such tag, keep the same pixels. Colour profiles are
//! not read either: integer pictures are taken as sRGB, floating-point ones as linear.
//!
//! Opening a picture reads its header alone. Its pixels are decoded when they are first asked for, and
//! held as they are stored, a byte for a sample of 8 bits.

mod decoder;
mod rows;
mod stored;

pub(super) use decoder::{max_code, one_line, unsupported};
pub(super) use stored::{Meaning, StoredPhoto};

use crate::error::Result;
use crate::frame::Plane;
use std::path::Path;

/// A picture as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Bits per sample: 8, 16 or 32.
    pub bits: u8,
    /// Whether samples are floating point: then they are linear, else sRGB-encoded and 0..1.
    pub is_float: bool,
    /// One plane of grey, or three of red, green and blue; not multiplied by alpha.
    pub channels: Vec<Plane>,
    /// Coverage, 0..1.
    pub alpha: Option<Plane>,
}

impl Photo {
    /// Reads the picture at `path`; its kind is recognised by content, not by name.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] for a picture that is too large, holds no pixels or is of no kind that is read;
    /// [`crate::Error::Damaged`] and [`crate::Error::Io`].
    pub fn read(path: &Path) -> Result<Photo> {
        let stored = StoredPhoto::open(path, u64::MAX)?;
        let mut channels = stored.planes(0..stored.height, Meaning::Stored)?;
        let alpha = if stored.has_alpha() {
            channels.pop()
        } else {
            None
        };
        Ok(Photo {
            width: stored.width,
            height: stored.height,
            bits: stored.bits,
            is_float: stored.is_float,
            channels,
            alpha,
        })
    }

    /// The grey or colour planes in linear light, not multiplied by alpha.
    pub fn to_linear(&self) -> Vec<Plane> {
        if self.is_float {
            return self.channels.clone();
        }
        let linear = stored::values(self.bits, Meaning::Linear);
        let max = max_code(self.bits) as f32;
        let lookup = |v: f32| linear[(v * max).round() as usize];
        let channels = self.channels.iter();
        channels.map(|plane| plane.map(lookup)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::ColorPlanes;
    use crate::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
    use std::io::Cursor;

    #[test]
    fn damaged_pictures_are_errors_of_one_line() {
        let plane = Plane::filled(16, 16, 0.25);
        let color = ColorPlanes {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        };
        let picture = Picture {
            color: &color,
            alpha: None,
            grey: false,
            bits: 8,
            transform: ViewTransform::Srgb,
        };
        let directory = tempfile::tempdir().unwrap();
        for format in [
            PictureFormat::Png,
            PictureFormat::Jpeg,
            PictureFormat::Tiff,
            PictureFormat::Hdr,
        ] {
            let mut file = Cursor::new(Vec::new());
            write_picture(&mut file, Path::new("test"), format, &picture).unwrap();
            let bytes = file.into_inner();
            let path = directory.path().join("picture");
            for end in (0..bytes.len()).step_by(7) {
                std::fs::write(&path, &bytes[..end]).unwrap();
                if let Err(error) = Photo::read(&path) {
                    let message = error.to_string();
                    assert!(
                        message.contains("picture") && !message.contains('\n'),
                        "{message}"
                    );
                }
            }
        }
    }
}
