//! Reading pictures of the everyday kinds: PNG, JPEG, TIFF, Radiance HDR, WebP, TGA, BMP and PNM; and numbers as NumPy arrays,
//! alone or in archives, and PFM.
//!
//! A picture is read as its stored values, and made linear on request: photographs are, normal maps and masks are not.
//! The orientation tag of cameras is obeyed: pixels are rotated while they are decoded, so everything else sees an
//! upright picture. Colour profiles are not applied: integer pictures are taken as sRGB, floating-point ones as linear.
//!
//! Opening a picture reads only its header. Its pixels are decoded on first use, and held as stored, a byte for an
//! 8-bit sample.

mod decoder;
mod faults;
mod header;
mod metadata;
mod npy;
mod npz;
mod numbers;
mod rows;
mod stored;

pub(in crate::io) use decoder::max_code;
pub(in crate::io) use faults::unsupported;
pub(in crate::io) use header::PhotoHeader;
pub use metadata::PhotoMetadata;
pub(in crate::io) use npz::{is_inside, pictures_in};
pub(in crate::io) use stored::{CodeMeaning, StoredPhoto};

use crate::error::Result;
use crate::frame::Plane;
use std::path::Path;

/// A picture as stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Bits per sample: 8, 16 or 32.
    pub bits: u8,
    /// Whether samples are floating point, hence linear; otherwise they are sRGB-encoded in 0..1.
    pub is_float: bool,
    /// One plane of grey, or three of red, green and blue; not multiplied by alpha.
    pub channels: Vec<Plane>,
    /// Coverage, 0..1.
    pub alpha: Option<Plane>,
}

impl Photo {
    /// Reads the picture at `path`; its format is recognised by content, not by name.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] for a picture that is too large, has no pixels or an unsupported format;
    /// [`crate::Error::Damaged`] and [`crate::Error::Io`].
    pub fn read(path: &Path) -> Result<Photo> {
        let stored = StoredPhoto::open(path, u64::MAX)?;
        let mut channels = stored.planes(0..stored.header.height, CodeMeaning::Stored)?;
        let alpha = if stored.header.has_alpha() {
            channels.pop()
        } else {
            None
        };
        Ok(Photo {
            width: stored.header.width,
            height: stored.header.height,
            bits: stored.header.bits,
            is_float: stored.header.is_float,
            channels,
            alpha,
        })
    }

    /// The grey or colour planes in linear light, not multiplied by alpha.
    pub fn to_linear(&self) -> Vec<Plane> {
        if self.is_float {
            return self.channels.clone();
        }
        let linear = stored::values(self.bits, CodeMeaning::Linear);
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

    /// A picture of 5 x 7 whose samples all differ, in one format.
    fn written(path: &Path, format: PictureFormat, bits: u8, with_alpha: bool) {
        let plane = |at: usize| Plane::from_fn(5, 7, |x, y| (3 * (5 * y + x) + at) as f32 / 110.0);
        let color = ColorPlanes {
            r: plane(0),
            g: plane(1),
            b: plane(2),
        };
        let alpha = Plane::from_fn(5, 7, |x, _| (x + 1) as f32 / 5.0);
        let picture = Picture {
            alpha: with_alpha.then_some(&alpha),
            bits,
            ..Picture::of(&color, ViewTransform::Srgb)
        };
        let mut file = Cursor::new(Vec::new());
        write_picture(&mut file, path, format, &picture).unwrap();
        std::fs::write(path, file.into_inner()).unwrap();
    }

    #[test]
    fn rows_are_those_of_the_whole_however_they_are_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture");
        for (format, bits, with_alpha) in [
            (PictureFormat::Png, 8, false),
            (PictureFormat::Png, 8, true),
            (PictureFormat::Png, 16, false),
            (PictureFormat::Png, 16, true),
            (PictureFormat::Hdr, 8, false),
        ] {
            written(&path, format, bits, with_alpha);
            for meaning in [CodeMeaning::Stored, CodeMeaning::Linear] {
                let whole = StoredPhoto::open(&path, u64::MAX).unwrap();
                let whole = whole.planes(0..7, meaning).unwrap();
                assert_eq!(whole.len(), 3 + usize::from(with_alpha));
                for most_bytes in [0, u64::MAX] {
                    let photo = StoredPhoto::open(&path, most_bytes).unwrap();
                    let rows = photo.planes(2..6, meaning).unwrap();
                    for (rows, whole) in rows.iter().zip(&whole) {
                        assert_eq!(
                            rows.samples(),
                            &whole.samples()[10..30],
                            "{format:?} {bits}"
                        );
                    }
                    let mut seen = Vec::new();
                    let mut take = |y: usize, row: Vec<Plane>| {
                        assert_eq!(row[0].samples(), whole[0].row(y), "{format:?} {bits}");
                        seen.push(y);
                    };
                    photo.each_row(2..6, meaning, &mut take).unwrap();
                    assert_eq!(seen, [2, 3, 4, 5]);
                }
            }
        }
    }

    #[test]
    fn what_is_only_decoded_whole_is_refused_where_it_does_not_fit() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture");
        written(&path, PictureFormat::Jpeg, 8, false);
        // 5 x 7 pixels of three bytes.
        let photo = StoredPhoto::open(&path, 5 * 7 * 3).unwrap();
        assert!(photo.planes(0..1, CodeMeaning::Linear).is_ok());
        let photo = StoredPhoto::open(&path, 5 * 7 * 3 - 1).unwrap();
        let refused = photo
            .planes(0..1, CodeMeaning::Linear)
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("decoded whole") && !refused.contains('\n'),
            "{refused}"
        );
    }

    #[test]
    fn pictures_of_no_pixels_are_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture.hdr");
        for size in ["-Y 0 +X 0", "-Y 4 +X 0", "-Y 0 +X 4"] {
            std::fs::write(
                &path,
                format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n"),
            )
            .unwrap();
            let refused = Photo::read(&path).unwrap_err().to_string();
            assert!(refused.contains("holds no pixels"), "{refused}");
        }
    }

    #[test]
    fn damaged_pictures_are_errors_of_one_line() {
        let plane = Plane::filled(16, 16, 0.25);
        let color = ColorPlanes {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        };
        let picture = Picture::of(&color, ViewTransform::Srgb);
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
