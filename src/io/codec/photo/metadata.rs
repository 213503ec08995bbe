//! Metadata that a picture made from a photo keeps: colour profile, camera data, resolution.

use super::decoder::with_decoder;
use super::header::{PhotoHeader, turned};
use super::npz::is_inside;
use crate::error::Result;
use crate::io::codec::exif::{Exif, SOUND_DPI};
use crate::io::open::open_buffered;
use crate::params::MM_PER_INCH;
use image::{ImageDecoder, ImageFormat};
use std::io::Read;
use std::path::Path;
use tiff::tags::Tag;

/// Metadata that a picture made from a photo keeps.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PhotoMetadata {
    /// Columns of the photo.
    pub width: usize,
    /// Its ICC profile.
    pub profile: Option<Vec<u8>>,
    /// Its EXIF block, which may name another orientation than that of the pixels, upright.
    pub exif: Option<Vec<u8>>,
    /// Pixels per inch, across and down.
    pub dpi: Option<[f32; 2]>,
}

/// Longest colour profile that is kept, in bytes.
const MAX_PROFILE: usize = 1 << 24;

impl PhotoMetadata {
    /// Metadata of the photo with this header. Unreadable items are left out.
    ///
    /// # Errors
    /// Those of opening the file.
    pub(super) fn of(photo: &PhotoHeader) -> Result<Self> {
        let (profile, exif) = with_decoder(&photo.path, |mut decoder, _| {
            let profile = decoder.icc_profile().unwrap_or_default();
            let profile = profile.filter(|profile| profile.len() <= MAX_PROFILE);
            Ok((profile, decoder.exif_metadata().unwrap_or_default()))
        })?;
        let said = || Exif::read(exif.as_ref()?)?.dpi();
        let dpi = match photo.format {
            ImageFormat::Jpeg => jfif_dpi(&photo.path)?,
            ImageFormat::Png => png_dpi(&photo.path)?,
            ImageFormat::Tiff if !is_inside(&photo.path) => tiff_dpi(&photo.path)?,
            _ => None,
        };
        let is_sound = |dpi: &[f32; 2]| dpi.iter().all(|dpi| SOUND_DPI.contains(dpi));
        let dpi = dpi.or_else(said).filter(is_sound);
        Ok(Self {
            width: photo.width,
            profile,
            exif,
            dpi: dpi.map(|dpi| turned(photo.orientation, dpi.into()).into()),
        })
    }
}

/// The density in the first segment of a JPEG: after its marker and length `JFIF\0`, a version in two bytes, the unit (1
/// inches, 2 centimetres), and numbers of two bytes across and down.
fn jfif_dpi(path: &Path) -> Result<Option<[f32; 2]>> {
    let mut start = [0; 18];
    if open_buffered(path)?.read_exact(&mut start).is_err() || &start[6..11] != b"JFIF\0" {
        return Ok(None);
    }
    let per_inch = match start[13] {
        1 => 1.0,
        2 => MM_PER_INCH / 10.0,
        _ => return Ok(None),
    };
    let dpi = [14, 16].map(|at| u16::from_be_bytes([start[at], start[at + 1]]));
    Ok(Some(dpi.map(|dpi| f32::from(dpi) * per_inch)))
}

fn png_dpi(path: &Path) -> Result<Option<[f32; 2]>> {
    let Ok(reader) = png::Decoder::new(open_buffered(path)?).read_info() else {
        return Ok(None);
    };
    let dims = reader.info().pixel_dims;
    let dims = dims.filter(|dims| dims.unit == png::Unit::Meter);
    Ok(dims.map(|dims| [dims.xppu, dims.yppu].map(|dpm| dpm as f32 * MM_PER_INCH / 1000.0)))
}

fn tiff_dpi(path: &Path) -> Result<Option<[f32; 2]>> {
    let Ok(mut decoder) = tiff::decoder::Decoder::new(open_buffered(path)?) else {
        return Ok(None);
    };
    let mut value = |tag| decoder.find_tag(tag).ok().flatten();
    let unit = value(Tag::ResolutionUnit).and_then(|unit| unit.into_u16().ok());
    let per_inch = match unit {
        None | Some(2) => 1.0,
        Some(3) => MM_PER_INCH / 10.0,
        Some(_) => return Ok(None),
    };
    let mut dpi = |tag| match value(tag)? {
        tiff::decoder::ifd::Value::Rational(n, d) => Some(n as f32 / d as f32 * per_inch),
        _ => None,
    };
    Ok(dpi(Tag::XResolution)
        .zip(dpi(Tag::YResolution))
        .map(<[f32; 2]>::from))
}
