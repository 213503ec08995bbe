//! PNG and TIFF with resolution and other metadata, and with one bit per pixel: `image` supports neither.

use super::encoding::{Encoding, ascii};
use crate::error::Error;
use crate::io::codec::exif::thousandths;
use crate::io::photo::unsupported;
use crate::io::text::one_line;
use crate::params::MM_PER_INCH;
use fax::encoder::Encoder;
use fax::{Color, VecWriter};
use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::{JpegEncoder, PixelDensity, PixelDensityUnit};
use image::error::{EncodingError, ImageFormatHint};
use image::{ExtendedColorType, ImageEncoder, ImageError, ImageFormat, ImageResult};
use std::borrow::Cow;
use std::io::{Seek, Write};
use std::path::Path;
use tiff::encoder::{DirectoryEncoder, Rational, TiffEncoder, TiffKindStandard};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, ResolutionUnit, SampleFormat, Tag};
use tiff::{TiffError, TiffResult};

/// A picture ready to be stored.
pub(super) struct Storable<'a> {
    /// Columns and rows.
    pub(super) size: [u32; 2],
    /// Samples of a pixel: 1, 3, or 4 with alpha; of floats 2 too, and 4 of any meaning.
    pub(super) channels: usize,
    /// Bits of a sample: 1, 8 or 16, or 32 of a float, in TIFF.
    pub(super) bits: u8,
    /// Pixels per inch, across and down.
    pub(super) dpi: Option<[f32; 2]>,
    /// The ICC profile of its colours.
    pub(super) profile: Option<&'a [u8]>,
    /// Samples: those of several bytes in native byte order, 1-bit ones a byte each, with 1 as white.
    pub(super) samples: &'a [u8],
}

/// Writes a PNG.
pub(super) fn write_png(
    w: &mut impl Write,
    picture: &Storable,
    encoding: &Encoding,
) -> ImageResult<()> {
    let [width, height] = picture.size;
    let mut info = png::Info::with_size(width, height);
    info.icc_profile = picture.profile.map(Cow::Borrowed);
    info.exif_metadata = encoding.exif_of_png(picture.dpi).map(Cow::Owned);
    let mut encoder = png::Encoder::with_info(w, info).map_err(png_error)?;
    for (keyword, text) in texts(encoding) {
        let added = encoder.add_text_chunk(keyword.into(), text);
        added.map_err(png_error)?;
    }
    encoder.set_color(match picture.channels {
        1 => png::ColorType::Grayscale,
        4 => png::ColorType::Rgba,
        _ => png::ColorType::Rgb,
    });
    encoder.set_depth(match picture.bits {
        1 => png::BitDepth::One,
        8 => png::BitDepth::Eight,
        _ => png::BitDepth::Sixteen,
    });
    encoder.set_pixel_dims(picture.dpi.map(|dpi| {
        let [xppu, yppu] = dpi.map(|dpi| (1000.0 * dpi / MM_PER_INCH).round() as u32);
        let unit = png::Unit::Meter;
        png::PixelDimensions { xppu, yppu, unit }
    }));
    match picture.bits {
        // Differences of bytes of eight pixels are no easier to compress.
        1 => encoder.set_filter(png::Filter::NoFilter),
        _ => encoder.set_compression(png::Compression::Fast),
    }
    let mut writer = encoder.write_header().map_err(png_error)?;
    let written = match picture.bits {
        1 => writer.write_image_data(&packed(picture)),
        8 => writer.write_image_data(picture.samples),
        _ => {
            let samples = picture.samples.as_chunks::<2>().0.iter();
            let samples = samples.flat_map(|&code| u16::from_ne_bytes(code).to_be_bytes());
            writer.write_image_data(&samples.collect::<Vec<_>>())
        }
    };
    written.and_then(|()| writer.finish()).map_err(png_error)
}

/// Text chunks of a PNG, by keyword.
fn texts(encoding: &Encoding) -> impl Iterator<Item = (&'static str, String)> {
    let texts = [
        ("Software", &encoding.software),
        ("Description", &encoding.settings),
    ];
    let texts = texts.into_iter();
    texts.filter_map(|(keyword, text)| Some((keyword, ascii(text.as_deref()?))))
}

/// Eight pixels to a byte, the first the highest bit; every row begins with a byte of its own.
fn packed(picture: &Storable) -> Vec<u8> {
    let width = picture.size[0].max(1) as usize;
    let byte = |pixels: &[u8]| {
        let bits = pixels.iter().enumerate();
        bits.fold(0, |byte, (i, &white)| byte | white << (7 - i))
    };
    let rows = picture.samples.chunks(width);
    rows.flat_map(|row| row.chunks(8).map(byte)).collect()
}

/// Writes a TIFF: one-bit pictures by CCITT Group 4, others uncompressed.
pub(super) fn write_tiff(
    w: &mut (impl Write + Seek),
    picture: &Storable,
    encoding: &Encoding,
) -> ImageResult<()> {
    let [width, height] = picture.size;
    let group_4 = match picture.bits {
        1 => Some(group_4(picture)?),
        _ => None,
    };
    let write = || {
        let mut encoder = TiffEncoder::new(w)?;
        let mut file = encoder.image_directory()?;
        let (samples, compression, rows) = match &group_4 {
            Some(samples) => (&samples[..], CompressionMethod::Fax4, height),
            None => {
                let samples = picture.samples;
                let rows = rows_per_strip(samples.len(), height);
                (samples, CompressionMethod::None, rows)
            }
        };
        let meaning = match (picture.bits, picture.channels) {
            (1, _) => PhotometricInterpretation::WhiteIsZero,
            (_, 1 | 2) => PhotometricInterpretation::BlackIsZero,
            _ => PhotometricInterpretation::RGB,
        };
        let strip = match rows == height {
            true => samples.len(),
            false => samples.len() / height as usize * rows as usize,
        };
        let strips: Vec<_> = samples.chunks(strip.max(1)).collect();
        let mut offsets = Vec::new();
        for strip in &strips {
            offsets.push(u32::try_from(file.write_data(*strip)?)?);
        }
        let lengths: Vec<_> = strips.iter().map(|strip| strip.len() as u32).collect();
        file.write_tag(Tag::ImageWidth, width)?;
        file.write_tag(Tag::ImageLength, height)?;
        let bits = vec![u16::from(picture.bits); picture.channels];
        file.write_tag(Tag::BitsPerSample, &bits[..])?;
        file.write_tag(Tag::Compression, compression.to_u16())?;
        file.write_tag(Tag::PhotometricInterpretation, meaning.to_u16())?;
        file.write_tag(Tag::StripOffsets, &offsets[..])?;
        file.write_tag(Tag::SamplesPerPixel, picture.channels as u16)?;
        file.write_tag(Tag::RowsPerStrip, rows)?;
        file.write_tag(Tag::StripByteCounts, &lengths[..])?;
        if picture.bits == 32 {
            let floats = vec![SampleFormat::IEEEFP.to_u16(); picture.channels];
            file.write_tag(Tag::SampleFormat, &floats[..])?;
        }
        match (picture.bits, picture.channels) {
            (32, 2 | 4) => file.write_tag(Tag::ExtraSamples, UNSPECIFIED)?,
            (_, 4) => file.write_tag(Tag::ExtraSamples, STRAIGHT_ALPHA)?,
            _ => {}
        }
        write_tags(&mut file, picture, encoding)?;
        file.finish()
    };
    write().map_err(tiff_error)
}

/// Rows of a strip of about [`STRIP_BYTES`], for a picture of this many bytes and rows.
fn rows_per_strip(bytes: usize, height: u32) -> u32 {
    let row = (bytes / height.max(1) as usize).max(1);
    ((STRIP_BYTES / row) as u32).clamp(1, height.max(1))
}

/// Bytes of a strip, which readers hold at once.
const STRIP_BYTES: usize = 1 << 20;

/// Tags of a TIFF for metadata.
fn write_tags<W: Write + Seek>(
    file: &mut DirectoryEncoder<W, TiffKindStandard>,
    picture: &Storable,
    encoding: &Encoding,
) -> TiffResult<()> {
    if let Some([across, down]) = picture.dpi {
        file.write_tag(Tag::XResolution, rational(across))?;
        file.write_tag(Tag::YResolution, rational(down))?;
        file.write_tag(Tag::ResolutionUnit, ResolutionUnit::Inch.to_u16())?;
    }
    let texts = [
        (Tag::Software, &encoding.software),
        (Tag::ImageDescription, &encoding.settings),
    ];
    for (tag, text) in texts {
        if let Some(text) = text {
            file.write_tag(tag, ascii(text).as_str())?;
        }
    }
    if let Some(profile) = picture.profile {
        file.write_tag(Tag::IccProfile, profile)?;
    }
    Ok(())
}

/// The tag's word for a further sample of any meaning.
const UNSPECIFIED: u16 = 0;
/// The tag's word for alpha that colour is not multiplied by.
const STRAIGHT_ALPHA: u16 = 2;

fn rational(dpi: f32) -> Rational {
    let [n, d] = thousandths(dpi);
    Rational { n, d }
}

/// Wider rows overflow the encoder's numbers.
const WIDEST: u32 = i16::MAX as u32;

/// Black and white as CCITT Group 4 (ITU-T T.6) has them.
fn group_4(picture: &Storable) -> ImageResult<Vec<u8>> {
    let width = picture.size[0];
    if width > WIDEST {
        let reason = format!("a bilevel TIFF is up to {WIDEST} pixels wide; write a .png");
        return Err(refused(ImageFormat::Tiff, reason));
    }
    let mut encoder = Encoder::new(VecWriter::new());
    let of_code = |&code: &u8| match code {
        0 => Color::Black,
        _ => Color::White,
    };
    for row in picture.samples.chunks(width.max(1) as usize) {
        let Ok(()) = encoder.encode_line(row.iter().map(of_code), width as u16);
    }
    let Ok(writer) = encoder.finish();
    Ok(writer.finish())
}

/// The error of a picture that cannot be written.
pub(super) fn unwritten(target: &Path) -> impl Fn(ImageError) -> Error {
    move |error| match error {
        ImageError::IoError(source) => Error::io(target, "write")(source),
        other => {
            let found = format!("cannot be written ({})", one_line(&other.to_string()));
            unsupported(target, &found)
        }
    }
}

fn png_error(error: png::EncodingError) -> ImageError {
    match error {
        png::EncodingError::IoError(source) => ImageError::IoError(source),
        other => refused(ImageFormat::Png, other),
    }
}

fn tiff_error(error: TiffError) -> ImageError {
    match error {
        TiffError::IoError(source) => ImageError::IoError(source),
        other => refused(ImageFormat::Tiff, other),
    }
}

fn refused(
    format: ImageFormat,
    reason: impl Into<Box<dyn std::error::Error + Send + Sync>>,
) -> ImageError {
    ImageError::Encoding(EncodingError::new(ImageFormatHint::Exact(format), reason))
}

pub(super) fn write_hdr(w: &mut impl Write, picture: &Storable) -> ImageResult<()> {
    let (floats, _) = picture.samples.as_chunks::<4>();
    let floats: Vec<f32> = floats.iter().map(|&v| f32::from_ne_bytes(v)).collect();
    let (pixels, _) = floats.as_chunks::<3>();
    let pixels: Vec<_> = pixels.iter().map(|&rgb| image::Rgb(rgb)).collect();
    let [width, height] = picture.size.map(|side| side as usize);
    HdrEncoder::new(w).encode(&pixels, width, height)
}

pub(super) fn write_jpeg(
    w: &mut impl Write,
    picture: &Storable,
    encoding: &Encoding,
) -> ImageResult<()> {
    let [width, height] = picture.size;
    let mut encoder = JpegEncoder::new_with_quality(w, encoding.quality);
    if let Some(dpi) = picture.dpi {
        encoder.set_pixel_density(density(dpi));
    }
    if let Some(profile) = picture.profile {
        let set = encoder.set_icc_profile(profile.to_vec());
        set.map_err(ImageError::Unsupported)?;
    }
    if let Some(exif) = encoding.exif_of_jpeg(picture.dpi) {
        let set = encoder.set_exif_metadata(exif);
        set.map_err(ImageError::Unsupported)?;
    }
    let kind = match picture.channels {
        1 => ExtendedColorType::L8,
        _ => ExtendedColorType::Rgb8,
    };
    encoder.write_image(picture.samples, width, height, kind)
}

/// Pixels per inch as a JPEG has them.
fn density(dpi: [f32; 2]) -> PixelDensity {
    let [across, down] = dpi.map(|dpi| dpi.round() as u16);
    PixelDensity {
        density: (across, down),
        unit: PixelDensityUnit::Inches,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{ColorPlanes, Plane};
    use crate::io::photo::Photo;
    use crate::io::picture::{Picture, PictureFormat, ViewTransform, write_picture};
    use std::io::Cursor;
    use std::path::Path;

    /// Runs of all lengths up to `width`, black and white, some beside those above and some not.
    fn runs(width: usize) -> Plane {
        Plane::from_fn(width, 31, |x, y| {
            let is_white = match y {
                0 => true,
                1 => false,
                2..20 => (x + y / 3) / (1 << (y % 12)) % 2 == 0,
                _ => (x * x / 7 + y * x / 3) % 5 < 3,
            };
            f32::from(u8::from(is_white))
        })
    }

    fn written(format: PictureFormat, light: &Plane, bits: u8, dpi: Option<[f32; 2]>) -> Vec<u8> {
        let color = ColorPlanes {
            r: light.clone(),
            g: light.clone(),
            b: light.clone(),
        };
        let picture = Picture {
            grey: true,
            bits,
            dpi,
            ..Picture::of(&color, ViewTransform::Srgb)
        };
        encoded(format, &picture)
    }

    fn encoded(format: PictureFormat, picture: &Picture) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        write_picture(&mut file, Path::new("test"), format, picture).unwrap();
        file.into_inner()
    }

    fn read(file: &[u8]) -> Photo {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture");
        std::fs::write(&path, file).unwrap();
        Photo::read(&path).unwrap()
    }

    #[test]
    fn pictures_of_one_bit_are_read_back() {
        // Widths of whole bytes and not, and runs past 2560, the longest that Group 4 has a word for.
        for width in [1, 7, 8, 63, 64, 65, 1000, 6001] {
            let light = runs(width);
            for format in [PictureFormat::Png, PictureFormat::Tiff] {
                let photo = read(&written(format, &light, 1, None));
                assert_eq!((photo.width, photo.height), (width, 31));
                assert_eq!(photo.channels.len(), 1);
                assert_eq!(photo.channels[0], light, "{format:?} {width}");
            }
        }
    }

    #[test]
    fn files_say_their_bits_and_their_resolution() {
        let png = written(PictureFormat::Png, &runs(40), 1, Some([300.0, 600.0]));
        let png = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
        assert_eq!(png.info().bit_depth, png::BitDepth::One);
        // 300 / .0254 and twice that.
        let pixels = png.info().pixel_dims.unwrap();
        assert_eq!((pixels.xppu, pixels.yppu), (11811, 23622));
        for (bits, compression) in [(1, 4), (8, 1), (16, 1)] {
            let tiff = written(PictureFormat::Tiff, &runs(40), bits, Some([72.5, 600.0]));
            assert_eq!(read(&tiff).channels, [runs(40)], "{bits}");
            let mut tiff = tiff::decoder::Decoder::new(Cursor::new(tiff)).unwrap();
            let mut number = |tag| tiff.get_tag(tag).unwrap();
            assert_eq!(number(Tag::Compression).into_u16().unwrap(), compression);
            let of_inch = ResolutionUnit::Inch.to_u16();
            assert_eq!(number(Tag::ResolutionUnit).into_u16().unwrap(), of_inch);
            let mut dpi = |tag| match number(tag) {
                tiff::decoder::ifd::Value::Rational(n, d) => f64::from(n) / f64::from(d),
                other => panic!("{other:?}"),
            };
            assert_eq!(
                [dpi(Tag::XResolution), dpi(Tag::YResolution)],
                [72.5, 600.0]
            );
        }
        let jpeg = written(PictureFormat::Jpeg, &runs(40), 8, Some([300.0, 600.0]));
        // After the name of the segment and its version: inches, and 300 and 600 in two bytes each.
        let at = jpeg.windows(5).position(|w| w == b"JFIF\0").unwrap();
        assert_eq!(jpeg[at + 7..at + 12], [1, 1, 44, 2, 88]);
    }

    #[test]
    fn colour_and_alpha_keep_their_samples_beside_a_resolution() {
        let plane = |at: usize| Plane::from_fn(5, 7, |x, y| (3 * (5 * y + x) + at) as f32 / 110.0);
        let color = ColorPlanes {
            r: plane(0),
            g: plane(1),
            b: plane(2),
        };
        let alpha = Plane::from_fn(5, 7, |x, _| (x + 1) as f32 / 5.0);
        for format in [PictureFormat::Png, PictureFormat::Tiff] {
            for (bits, alpha) in [(8, None), (16, None), (8, Some(&alpha)), (16, Some(&alpha))] {
                let of = |dpi| {
                    let picture = Picture {
                        alpha,
                        bits,
                        dpi,
                        ..Picture::of(&color, ViewTransform::Srgb)
                    };
                    read(&encoded(format, &picture))
                };
                assert_eq!(of(Some([300.0; 2])), of(None), "{format:?} {bits}");
            }
        }
    }

    #[test]
    fn what_group_4_does_not_hold_is_refused() {
        let samples = vec![1; WIDEST as usize + 1];
        let picture = Storable {
            size: [WIDEST + 1, 1],
            channels: 1,
            bits: 1,
            dpi: None,
            profile: None,
            samples: &samples,
        };
        let refused =
            write_tiff(&mut Cursor::new(Vec::new()), &picture, &Encoding::default()).unwrap_err();
        assert!(refused.to_string().contains("write a .png"), "{refused}");
    }
}
