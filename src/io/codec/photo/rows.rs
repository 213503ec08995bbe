//! Pictures row by row, for those too large to hold.

use super::decoder::within_fence;
use super::faults::{damaged, image_error};
use super::header::PhotoHeader;
use crate::error::{Error, Result};
use crate::io::open::open_buffered;
use image::codecs::hdr::HdrDecoder;
use image::{ImageDecoder, ImageError, ImageFormat};
use std::io::{Cursor, Read};
use std::ops::Range;

/// Callback for the samples of a row, in native byte order, with the row's index.
type Take<'t> = dyn FnMut(usize, &[u8]) + 't;

/// Decodes the picture up to the end of `rows`, and passes these rows to `take`, because the whole picture exceeds
/// `most_bytes`.
///
/// # Errors
/// If the file is damaged, or of a kind that can only be decoded whole.
pub(super) fn each_row(
    photo: &PhotoHeader,
    rows: Range<usize>,
    most_bytes: u64,
    take: &mut Take,
) -> Result<()> {
    within_fence(&photo.path, || match photo.format {
        // Upright rows are not rows of the file.
        _ if photo.turned_from().is_some() => Err(photo.too_large(most_bytes)),
        ImageFormat::Png => png_rows(photo, rows, most_bytes, take),
        ImageFormat::Hdr => hdr_rows(photo, rows, take),
        _ => Err(photo.too_large(most_bytes)),
    })
}

fn png_rows(
    photo: &PhotoHeader,
    rows: Range<usize>,
    most_bytes: u64,
    take: &mut Take,
) -> Result<()> {
    let failed = |error| png_error(photo, error);
    let mut decoder = png::Decoder::new(open_buffered(&photo.path)?);
    // As in `image`: palettes and small depths become 8-bit samples.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(failed)?;
    if reader.info().interlaced {
        return Err(photo.too_large(most_bytes));
    }
    let length = photo.row_bytes();
    let mut native = Vec::new();
    for y in 0..rows.end {
        let row = reader.next_row().map_err(failed)?;
        let row = row.filter(|row| row.data().len() == length);
        let row = row.ok_or_else(|| photo.has_changed())?;
        if y < rows.start {
            continue;
        }
        native.clear();
        native.extend_from_slice(row.data());
        if photo.bits == 16 {
            for pair in native.as_chunks_mut::<2>().0 {
                *pair = u16::from_be_bytes(*pair).to_ne_bytes();
            }
        }
        take(y, &native);
    }
    Ok(())
}

/// Every row of an HDR is coded on its own: it is read as a picture of one row.
fn hdr_rows(photo: &PhotoHeader, rows: Range<usize>, take: &mut Take) -> Result<()> {
    let failed = image_error(&photo.path);
    let mut file = open_buffered(&photo.path)?;
    let header = HdrDecoder::new(&mut file).map_err(&failed)?;
    if header.dimensions() != (photo.width as u32, photo.height as u32) {
        return Err(photo.has_changed());
    }
    let one_row = format!("#?RADIANCE\n\n-Y 1 +X {}\n", photo.width);
    let mut bytes = vec![0; photo.row_bytes()];
    for y in 0..rows.end {
        let row = Cursor::new(&one_row).chain(&mut file);
        let decoder = HdrDecoder::new(row).map_err(&failed)?;
        decoder.read_image(&mut bytes).map_err(&failed)?;
        if y >= rows.start {
            take(y, &bytes);
        }
    }
    Ok(())
}

fn png_error(photo: &PhotoHeader, error: png::DecodingError) -> Error {
    let path = &photo.path;
    match error {
        png::DecodingError::IoError(error) => image_error(path)(ImageError::IoError(error)),
        other => damaged(path, &other),
    }
}
