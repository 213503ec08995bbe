//! Opening a picture: reads its header, and refuses unsupported files.

use super::faults::{MAX_BYTES, image_error, unsupported};
use super::numbers::{Numbers, is_tiff_of_numbers};
use crate::error::{Error, Result};
use crate::io::fence::fenced;
use crate::io::open::open_buffered;
use image::{ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Longest side that is read, in pixels.
const MAX_SIDE: u32 = 1 << 16;
/// Most bytes for the profile of a PNG, which is inflated as its header is read, and all else beside its samples.
const MAX_PNG_METADATA: u64 = 1 << 26;

/// Calls `read` with a decoder of the picture at `path`, whose header has been read, and its format.
///
/// # Errors
/// For a picture that is damaged, has no pixels or too many, or has an unsupported format; those of `read`.
pub(super) fn with_decoder<T>(
    path: &Path,
    read: impl FnOnce(Box<dyn ImageDecoder + '_>, ImageFormat) -> Result<T>,
) -> Result<T> {
    let decode = || {
        if let Some(numbers) = Numbers::read(path)? {
            return read(Box::new(numbers), ImageFormat::Tiff);
        }
        let (reader, format) = open(path)?;
        if format == ImageFormat::Tiff && is_tiff_of_numbers(path)? {
            return read(Box::new(Numbers::tiff(path)?), format);
        }
        match reader.into_decoder() {
            Ok(decoder) => {
                check_size(path, &decoder)?;
                read(Box::new(decoder), format)
            }
            Err(ImageError::Unsupported(_)) if format == ImageFormat::Tiff => {
                read(Box::new(Numbers::tiff(path)?), format)
            }
            Err(error) => Err(image_error(path)(error)),
        }
    };
    within_fence(path, decode)
}

/// The result of `decode`, which may panic on a malformed picture.
pub(super) fn within_fence<T>(path: &Path, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    fenced(decode).unwrap_or_else(|| {
        Err(Error::Damaged {
            path: path.to_path_buf(),
            found: "the picture contradicts itself".into(),
        })
    })
}

fn open(path: &Path) -> Result<(ImageReader<BufReader<File>>, ImageFormat)> {
    let failed = |error| Error::io(path, "read")(error);
    let mut file = open_buffered(path)?;
    let start = file.fill_buf().map_err(failed)?;
    refuse_textures(path, start)?;
    let is_big_tiff = start.starts_with(b"II\x2b\0") || start.starts_with(b"MM\0\x2b");
    let mut reader = ImageReader::new(file)
        .with_guessed_format()
        .map_err(failed)?;
    if is_big_tiff {
        reader.set_format(ImageFormat::Tiff);
    }
    let by_name = || {
        // TGA has no mark.
        let named = ImageFormat::from_path(path).ok();
        named.filter(|format| *format == ImageFormat::Tga)
    };
    let format = reader.format().or_else(by_name).unwrap_or(ImageFormat::Png);
    reader.set_format(format);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(match format {
        ImageFormat::Png => MAX_PNG_METADATA,
        _ => MAX_BYTES,
    });
    reader.limits(limits);
    Ok((reader, format))
}

/// Refuses files of textures for graphics devices, which have compressions of their own.
fn refuse_textures(path: &Path, start: &[u8]) -> Result<()> {
    let kinds: [(&[u8], &str, &str); 3] = [
        (
            b"DDS ",
            "a DDS texture",
            "texconv -ft png, or magick IN.dds OUT.png",
        ),
        (
            b"\xabKTX 20\xbb",
            "a KTX2 texture",
            "ktx extract IN.ktx2 OUT.png",
        ),
        (
            b"\xabKTX 11\xbb",
            "a KTX texture",
            "ktx2ktx2 IN.ktx, then ktx extract IN.ktx2 OUT.png",
        ),
    ];
    let found = kinds.into_iter().find(|(mark, ..)| start.starts_with(mark));
    found.map_or(Ok(()), |(_, kind, converter)| {
        Err(Error::Unsupported {
            path: path.to_path_buf(),
            found: format!("is {kind}, which is not read"),
            remedy: format!("convert it to PNG, as with {converter}"),
        })
    })
}

fn check_size(path: &Path, decoder: &impl ImageDecoder) -> Result<()> {
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(Error::Damaged {
            path: path.to_path_buf(),
            found: format!("is {width}x{height} and holds no pixels"),
        });
    }
    match decoder.total_bytes() > MAX_BYTES {
        true => Err(unsupported(
            path,
            &format!("is {width}x{height}, too large"),
        )),
        false => Ok(()),
    }
}

pub(in crate::io) fn max_code(bits: u8) -> u32 {
    u32::MAX >> (32 - bits)
}
