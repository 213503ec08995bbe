//! Reading pictures of the everyday kinds: PNG, JPEG, TIFF and Radiance HDR.
//!
//! A picture is read as its stored values, and made linear only when asked: a photograph is, a normal
//! map or a mask is not. The orientation tag that cameras write is not obeyed, so that a photograph
//! and the normal map made from it, which has no such tag, keep the same pixels. Colour profiles are
//! not read either: integer pictures are taken as sRGB, floating-point ones as linear.

use crate::error::{Error, Result};
use crate::frame::Plane;
use crate::io::fence::fenced;
use crate::io::open::open_input;
use crate::io::srgb;
use image::{DynamicImage, ImageDecoder, ImageError, ImageReader};
use std::io::BufReader;
use std::path::Path;

/// Longest side that is read, in pixels.
const MAX_SIDE: u32 = 1 << 16;
/// Most bytes that a decoder may use.
const MAX_BYTES: u64 = 1 << 30;

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
    pub fn read(path: &Path) -> Result<Photo> {
        let picture = fenced(|| decoded(path)).unwrap_or_else(|| {
            Err(Error::Damaged {
                path: path.to_path_buf(),
                found: "the picture contradicts itself".into(),
            })
        })?;
        Photo::of_image(picture).ok_or_else(|| unsupported(path, "has samples of an unknown kind"))
    }

    /// The grey or colour planes in linear light, not multiplied by alpha.
    pub fn to_linear(&self) -> Vec<Plane> {
        if self.is_float {
            return self.channels.clone();
        }
        let max = max_code(self.bits);
        let linear: Vec<f32> = (0..=max)
            .map(|code| srgb::decoded(f64::from(code) / f64::from(max)) as f32)
            .collect();
        let lookup = |v: f32| linear[(v * max as f32).round() as usize];
        self.channels
            .iter()
            .map(|plane| plane.map(lookup))
            .collect()
    }

    fn of_image(image: DynamicImage) -> Option<Photo> {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let (count, has_alpha) = (image.color().channel_count(), image.color().has_alpha());
        let (bits, planes) = match &image {
            DynamicImage::ImageLuma8(i) => (8, planes(i.as_raw(), count, from_code8)),
            DynamicImage::ImageLumaA8(i) => (8, planes(i.as_raw(), count, from_code8)),
            DynamicImage::ImageRgb8(i) => (8, planes(i.as_raw(), count, from_code8)),
            DynamicImage::ImageRgba8(i) => (8, planes(i.as_raw(), count, from_code8)),
            DynamicImage::ImageLuma16(i) => (16, planes(i.as_raw(), count, from_code16)),
            DynamicImage::ImageLumaA16(i) => (16, planes(i.as_raw(), count, from_code16)),
            DynamicImage::ImageRgb16(i) => (16, planes(i.as_raw(), count, from_code16)),
            DynamicImage::ImageRgba16(i) => (16, planes(i.as_raw(), count, from_code16)),
            DynamicImage::ImageRgb32F(i) => (32, planes(i.as_raw(), count, |v| v)),
            DynamicImage::ImageRgba32F(i) => (32, planes(i.as_raw(), count, |v| v)),
            _ => return None,
        };
        let mut channels: Vec<Plane> = planes
            .into_iter()
            .map(|samples| Plane::from_samples(width, height, samples))
            .collect();
        let alpha = if has_alpha { channels.pop() } else { None };
        Some(Photo {
            width,
            height,
            bits,
            is_float: bits == 32,
            channels,
            alpha,
        })
    }
}

fn decoded(path: &Path) -> Result<DynamicImage> {
    let mut reader = open_input(path)
        .and_then(|file| ImageReader::new(BufReader::new(file)).with_guessed_format())
        .map_err(Error::io(path, "read"))?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let failed = |error| image_error(path, error);
    let decoder = reader.into_decoder().map_err(failed)?;
    if decoder.total_bytes() > MAX_BYTES {
        let (width, height) = decoder.dimensions();
        return Err(unsupported(
            path,
            &format!("is {width}x{height}, too large"),
        ));
    }
    DynamicImage::from_decoder(decoder).map_err(failed)
}

pub(super) fn unsupported(path: &Path, found: &str) -> Error {
    Error::Unsupported {
        path: path.to_path_buf(),
        found: found.into(),
        remedy: "save it as PNG or OpenEXR".into(),
    }
}

fn image_error(path: &Path, error: ImageError) -> Error {
    let damaged = |found: String| Error::Damaged {
        path: path.to_path_buf(),
        found,
    };
    match error {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            damaged("the file ends too early".into())
        }
        ImageError::IoError(source) => Error::io(path, "read")(source),
        ImageError::Decoding(e) => damaged(format!("is damaged ({})", one_line(&e.to_string()))),
        ImageError::Limits(_) => unsupported(path, "is too large"),
        other => unsupported(
            path,
            &format!("cannot be read ({})", one_line(&other.to_string())),
        ),
    }
}

pub(super) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

pub(super) fn max_code(bits: u8) -> u32 {
    (1 << bits) - 1
}

fn from_code8(code: u8) -> f32 {
    f32::from(code) / 255.0
}

fn from_code16(code: u16) -> f32 {
    f32::from(code) / 65535.0
}

/// Interleaved samples as one plane of values per channel.
fn planes<T: Copy>(samples: &[T], channels: u8, value: impl Fn(T) -> f32) -> Vec<Vec<f32>> {
    let count = usize::from(channels);
    (0..count)
        .map(|c| {
            samples
                .iter()
                .skip(c)
                .step_by(count)
                .map(|&s| value(s))
                .collect()
        })
        .collect()
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
