//! Pictures of numbers, that decoders of pictures refuse: TIFF of further sample types, NumPy arrays and PFM. Their samples
//! are the numbers as stored; of several channels of unsigned integers of 8 and 16 bits they are codes. Grey is repeated,
//! since there is no grey of floats.

use super::faults::{MAX_BYTES, damaged, unsupported};
use super::npy::{NpyHeader, NumberFormat};
use super::npz;
use crate::error::{Error, Result};
use crate::io::open::open_buffered;
use crate::io::text::one_line;
use image::{ColorType, ExtendedColorType, ImageDecoder, ImageError, ImageResult};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// The type of two channels of vectors, which are read as red and green, and blue of 0.
pub(super) const PAIR: ExtendedColorType = ExtendedColorType::Unknown(64);

/// Where the samples are.
enum SamplesAt {
    /// Its codes may be those of luminance and of differences of colours.
    Tiff {
        decoder: Box<Decoder<BufReader<File>>>,
        is_ycbcr: bool,
    },
    /// Numbers one after another, by rows from the bottom or from the top.
    Raw {
        file: Box<dyn Read>,
        is_upward: bool,
    },
}

/// A picture of numbers whose header has been read.
pub(super) struct Numbers {
    size: [usize; 2],
    /// 1 to 4: grey or colour, with coverage or without.
    channels: usize,
    /// Whether two channels are those of vectors, rather than grey and coverage.
    is_pair: bool,
    /// How far apart neighbours along x, y and the channels are stored.
    strides: [usize; 3],
    number: NumberFormat,
    source: SamplesAt,
}

impl Numbers {
    /// The header of a NumPy array, of the array of an archive, or of a PFM; `None` for another file.
    pub(super) fn read(path: &Path) -> Result<Option<Self>> {
        if let Some((archive, name)) = npz::split(path) {
            let array = npz::open(archive, Some(name))?;
            return Self::npy(path, array)?.checked(path).map(Some);
        }
        let mut file = open_buffered(path)?;
        let start = file.fill_buf().map_err(Error::io(path, "read"))?;
        let found = match start {
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Self::npy(path, Box::new(file)),
            [b'P', b'K', 3, 4, ..] => Self::npy(path, npz::open(path, None)?),
            [b'P', b'F' | b'f', b'\n' | b' ' | b'\r', ..] => Self::pfm(path, file),
            _ => return Ok(None),
        };
        found?.checked(path).map(Some)
    }

    /// The header of a TIFF.
    pub(super) fn tiff(path: &Path) -> Result<Self> {
        let file = open_buffered(path)?;
        let failed = tiff_error(path);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_BYTES as usize;
        let decoder = Decoder::new(file).map_err(&failed)?;
        let mut decoder = decoder.with_limits(limits);
        let (width, height) = decoder.dimensions().map_err(&failed)?;
        let (width, height) = (width as usize, height as usize);
        let color = decoder.colortype().map_err(&failed)?;
        let is_ycbcr = color == tiff::ColorType::YCbCr(8);
        if matches!(
            color,
            tiff::ColorType::CMYK(_) | tiff::ColorType::CMYKA(_) | tiff::ColorType::YCbCr(_)
        ) && !is_ycbcr
        {
            return Err(unsupported(path, "holds CMYK or YCbCr of a rare kind"));
        }
        let channels = color.num_samples().into();
        let mut first = |tag| first_of(&mut decoder, tag).map_err(&failed);
        let is_planar = first(Tag::PlanarConfiguration)? == Some(2);
        let is_alpha = matches!(first(Tag::ExtraSamples)?, Some(1 | 2));
        let number = NumberFormat {
            kind: match first(Tag::SampleFormat)? {
                Some(2) => 'i',
                Some(3) => 'f',
                _ => 'u',
            },
            bytes: usize::from(color.bit_depth()).div_ceil(8),
            is_little: cfg!(target_endian = "little"),
        };
        let found = Self {
            size: [width, height],
            channels,
            is_pair: channels == 2 && !is_alpha,
            strides: match is_planar {
                true => [1, width, width.saturating_mul(height)],
                false => [channels, channels * width, 1],
            },
            number,
            source: SamplesAt::Tiff {
                decoder: Box::new(decoder),
                is_ycbcr,
            },
        };
        found.checked(path)
    }

    /// A NumPy array of so many bytes at most, as far as that is known.
    fn npy(path: &Path, mut file: Box<dyn Read>) -> Result<Self> {
        let header = NpyHeader::read(path, &mut file)?;
        let [rows, columns, channels] = header.picture().ok_or_else(|| header.no_picture(path))?;
        Ok(Self {
            size: [columns.0, rows.0],
            channels: channels.0,
            is_pair: channels.0 == 2,
            strides: [columns.1, rows.1, channels.1],
            number: header.number,
            source: SamplesAt::Raw {
                file,
                is_upward: false,
            },
        })
    }

    /// Three lines: `PF` or `Pf`, the size, and a scale whose sign tells the order of bytes.
    fn pfm(path: &Path, mut file: BufReader<File>) -> Result<Self> {
        let mut words = Vec::new();
        while words.len() < 4 {
            let mut word = Vec::new();
            let mut byte = [0];
            loop {
                file.read_exact(&mut byte)
                    .map_err(Error::io(path, "read"))?;
                match byte[0].is_ascii_whitespace() {
                    true if word.is_empty() => {}
                    true => break,
                    false if word.len() > 32 => return Err(damaged(path, &"its header is none")),
                    false => word.push(byte[0]),
                }
            }
            words.push(String::from_utf8_lossy(&word).into_owned());
        }
        let sizes = [&words[1], &words[2]].map(|word| word.parse().ok());
        let ([Some(width), Some(height)], Ok(scale)) = (sizes, words[3].parse::<f32>()) else {
            return Err(damaged(path, &"its header is none"));
        };
        let channels = if words[0] == "PF" { 3 } else { 1 };
        Ok(Self {
            size: [width, height],
            channels,
            is_pair: false,
            strides: [channels, channels * width, 1],
            number: NumberFormat {
                kind: 'f',
                bytes: 4,
                is_little: scale < 0.0,
            },
            source: SamplesAt::Raw {
                file: Box::new(file),
                is_upward: true,
            },
        })
    }

    /// It, unless it is too large or no picture.
    fn checked(self, path: &Path) -> Result<Self> {
        let [width, height] = self.size;
        let pixels = width
            .checked_mul(height)
            .filter(|&pixels| pixels as u64 <= MAX_BYTES / 16);
        match (pixels, self.channels) {
            (Some(0) | None, _) => Err(unsupported(path, &format!("is {width}x{height}"))),
            (_, 1..=4) => Ok(self),
            (_, channels) => Err(unsupported(path, &format!("has {channels} channels"))),
        }
    }

    /// All numbers, in their order.
    fn samples(&mut self) -> std::result::Result<Vec<f32>, String> {
        let count = self.size[0] * self.size[1] * self.channels;
        let said = |error: &dyn std::fmt::Display| one_line(&error.to_string());
        let number = self.number;
        let numbers = |row: &[u8]| -> Vec<f32> {
            let numbers = row.chunks_exact(number.bytes);
            numbers.map(|bytes| number.read(bytes)).collect()
        };
        let samples = match &mut self.source {
            SamplesAt::Tiff { decoder, is_ycbcr } => {
                let mut read = DecodingResult::U8(Vec::new());
                let whole = decoder.read_image_to_buffer(&mut read);
                whole.map_err(|e| said(&e))?;
                let mut samples = numbers(read.as_buffer(0).as_bytes());
                let [across, _, between] = self.strides;
                let pixels = if *is_ycbcr { count / 3 } else { 0 };
                for first in (0..pixels).map(|i| i * across) {
                    let places = [0, 1, 2].map(|channel| first + channel * between);
                    let color = rgb_of(places.map(|at| samples[at]));
                    for (at, code) in places.into_iter().zip(color) {
                        samples[at] = code;
                    }
                }
                samples
            }
            SamplesAt::Raw { file, is_upward } => {
                let stored = bytes_of(file, count * number.bytes).map_err(|e| said(&e))?;
                match is_upward {
                    true => {
                        let rows = stored.chunks_exact(number.bytes * self.strides[1]);
                        rows.rev().flat_map(numbers).collect()
                    }
                    false => numbers(&stored),
                }
            }
        };
        match samples.len() >= count {
            true => Ok(samples),
            false => Err("the file ends too early".into()),
        }
    }
}

impl ImageDecoder for Numbers {
    fn dimensions(&self) -> (u32, u32) {
        let [width, height] = self.size.map(|side| side as u32);
        (width, height)
    }

    fn color_type(&self) -> ColorType {
        let has_alpha = self.channels == 4 || (self.channels == 2 && !self.is_pair);
        // Several channels of unsigned integers are codes of a colour or a vector; one may hold heights.
        match (self.number.kind, self.number.bytes, has_alpha) {
            ('u', 1, false) if self.channels > 1 => ColorType::Rgb8,
            ('u', 2, false) if self.channels > 1 => ColorType::Rgb16,
            ('u', 1, true) => ColorType::Rgba8,
            ('u', 2, true) => ColorType::Rgba16,
            (_, _, false) => ColorType::Rgb32F,
            (_, _, true) => ColorType::Rgba32F,
        }
    }

    fn original_color_type(&self) -> ExtendedColorType {
        match self.is_pair {
            true => PAIR,
            false => self.color_type().into(),
        }
    }

    fn read_image(mut self, buffer: &mut [u8]) -> ImageResult<()> {
        let color = self.color_type();
        let sample = usize::from(color.bytes_per_pixel() / color.channel_count());
        let samples = self.samples().map_err(|found| {
            ImageError::IoError(std::io::Error::new(std::io::ErrorKind::InvalidData, found))
        })?;
        let ([width, height], [across, down, between]) = (self.size, self.strides);
        // Where a channel is read from; nowhere, it is 0.
        let order: &[Option<usize>] = match self.channels {
            1 => &[Some(0); 3],
            2 if self.is_pair => &[Some(0), Some(1), None],
            2 => &[Some(0), Some(0), Some(0), Some(1)],
            3 => &[Some(0), Some(1), Some(2)],
            _ => &[Some(0), Some(1), Some(2), Some(3)],
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| y * down + x * across));
        let numbers = pixels.flat_map(|at| {
            let place =
                move |channel: &Option<usize>| channel.map(|channel| at + channel * between);
            order.iter().map(place)
        });
        for (bytes, at) in buffer.chunks_exact_mut(sample).zip(numbers) {
            let sample = at.map_or(0.0, |at| samples[at]);
            match bytes {
                [code] => *code = sample as u8,
                [_, _] => bytes.copy_from_slice(&(sample as u16).to_ne_bytes()),
                _ => bytes.copy_from_slice(&sample.to_ne_bytes()),
            }
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, buffer: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(buffer)
    }
}

/// What makes a TIFF one that is read.
const DEFLATE: &str = "save it with Deflate, as with gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif, or tiffcp -c zip";
const RGB: &str = "make it RGB, as with magick IN.tif -colorspace sRGB -type TrueColor OUT.png";
const TOGETHER: &str =
    "put its channels together, as with gdal_translate -co INTERLEAVE=PIXEL IN.tif OUT.tif";

/// Refuses a TIFF of a kind that is not read, by its name. Decoders come to its compression with the samples alone. Whether
/// these fail on it otherwise: on channels in planes, and on long integers, which they take for floats.
pub(super) fn is_tiff_of_numbers(path: &Path) -> Result<bool> {
    let file = open_buffered(path)?;
    let failed = tiff_error(path);
    let mut decoder = Decoder::new(file).map_err(&failed)?;
    let mut first = |tag| first_of(&mut decoder, tag).map_err(&failed);
    let compression = first(Tag::Compression)?;
    // The decoder of JPEG makes as many samples of each.
    let is_subsampled = compression != Some(7) && first(Tag::ChromaSubsampling)? != Some(1);
    let are_several = first(Tag::SamplesPerPixel)? > Some(1);
    let is_planar = are_several && first(Tag::PlanarConfiguration)? == Some(2);
    let (rows, of_tile) = (first(Tag::ImageLength)?, first(Tag::TileLength)?);
    let is_cut = rows.unwrap_or(0) % of_tile.unwrap_or(1).max(1) > 0;
    let (found, remedy) = match (compression, first(Tag::PhotometricInterpretation)?) {
        (Some(50_000), _) if cfg!(not(feature = "zstd")) => ("is compressed by ZSTD", DEFLATE),
        (Some(34_887), _) => ("is compressed by LERC", DEFLATE),
        (Some(34_925), _) => ("is compressed by LZMA", DEFLATE),
        (Some(34_712 | 33_003 | 33_005), _) => ("is compressed by JPEG 2000", DEFLATE),
        (Some(50_002 | 52_546), _) => ("is compressed by JPEG XL", DEFLATE),
        (_, Some(3)) => ("has a palette", RGB),
        (_, Some(6)) if is_subsampled => ("is in subsampled YCbCr", RGB),
        (_, Some(8..=10)) => ("is in CIE L*a*b*", RGB),
        _ if is_planar && is_cut => ("has its channels apart in tiles", TOGETHER),
        _ => {
            let is_float = first(Tag::SampleFormat)? == Some(3);
            return Ok(is_planar || (!is_float && first(Tag::BitsPerSample)? == Some(32)));
        }
    };
    Err(Error::Unsupported {
        path: path.to_path_buf(),
        found: format!("{found}, which is not read"),
        remedy: remedy.into(),
    })
}

/// The first of a tag's numbers: one for each channel, or one for all.
fn first_of(decoder: &mut Decoder<BufReader<File>>, tag: Tag) -> tiff::TiffResult<Option<u32>> {
    let values = decoder.find_tag_unsigned_vec(tag)?;
    Ok(values.and_then(|values| values.first().copied()))
}

fn tiff_error(path: &Path) -> impl Fn(tiff::TiffError) -> Error {
    move |error| match error {
        tiff::TiffError::UnsupportedError(found) => {
            unsupported(path, &format!("cannot be read ({found})"))
        }
        error => damaged(path, &error),
    }
}

/// The colour of these codes of 8 bits, as in JPEG (BT.601, over all 256 codes).
fn rgb_of([y, blue, red]: [f32; 3]) -> [f32; 3] {
    let [blue, red] = [blue - 128.0, red - 128.0];
    let green = y - 0.344_136 * blue - 0.714_136 * red;
    [y + 1.402 * red, green, y + 1.772 * blue].map(f32::round)
}

/// So many bytes, or those that there are: room is made as they come, not as a header claims.
fn bytes_of(file: &mut dyn Read, count: usize) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(count as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;
    use crate::io::photo::Photo;
    use half::f16;
    use std::collections::BTreeMap;
    use std::io::Cursor;
    use tiff::encoder::{TiffEncoder, colortype};

    const SIZE: [usize; 2] = [3, 2];

    fn npy(
        descr: &str,
        is_fortran: bool,
        shape: &str,
        numbers: impl Fn(usize) -> Vec<u8>,
        count: usize,
    ) -> Vec<u8> {
        let is_fortran = if is_fortran { "True" } else { "False" };
        let header =
            format!("{{'descr': '{descr}', 'fortran_order': {is_fortran}, 'shape': {shape}, }}\n");
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.bytes());
        file.extend((0..count).flat_map(numbers));
        file
    }

    fn read(bytes: &[u8]) -> Result<Photo> {
        let desk = tempfile::tempdir().unwrap();
        let path = desk.path().join("numbers");
        std::fs::write(&path, bytes).unwrap();
        Photo::read(&path)
    }

    /// Of two rows of three pixels the last holds 5 in either order, less 2.5; the second of the first row 1 by rows, and 2
    /// by columns. Channel c of pixel p holds 3 p + c where channels are last.
    #[test]
    fn arrays_are_read_in_any_order() {
        let [width, height] = SIZE;
        let float = |i: usize| (i as f32 - 2.5).to_le_bytes().to_vec();
        let at = |bytes: &[u8], channel: usize| {
            let photo = read(bytes).unwrap();
            assert_eq!(
                (photo.width, photo.height, photo.is_float),
                (width, height, true)
            );
            (
                photo.channels[channel].at(2, 1),
                photo.channels[channel].at(1, 0),
            )
        };
        assert_eq!(at(&npy("<f4", false, "(2, 3)", float, 6), 1), (2.5, -1.5));
        assert_eq!(at(&npy("<f4", true, "(2, 3)", float, 6), 0), (2.5, -0.5));
        assert_eq!(
            at(&npy("<f4", false, "(1, 2, 3, 3)", float, 18), 2),
            (14.5, 2.5)
        );
        assert_eq!(
            at(&npy("<f4", false, "(1, 1, 2, 3)", float, 6), 0),
            (2.5, -1.5)
        );
        // Channels first: c of pixel p holds p + 12 c.
        let first = read(&npy("<f4", false, "(4, 2, 6)", float, 48)).unwrap();
        assert_eq!([first.width, first.height], [6, 2]);
        assert_eq!(
            (first.channels[1].at(2, 1), first.alpha.unwrap().at(1, 0)),
            (17.5, 34.5)
        );
        let big = |i: usize| (-(i as f64)).to_be_bytes().to_vec();
        assert_eq!(at(&npy(">f8", false, "(2, 3)", big, 6), 0), (-5.0, -1.0));
        let signed = |i: usize| (-300 * i as i16).to_le_bytes().to_vec();
        assert_eq!(
            at(&npy("<i2", false, "(2, 3)", signed, 6), 0),
            (-1500.0, -300.0)
        );
        let half = |i: usize| f16::from_f32(i as f32 / 4.0).to_le_bytes().to_vec();
        assert_eq!(at(&npy("<f2", false, "(2, 3)", half, 6), 0), (1.25, 0.25));
    }

    #[test]
    fn rows_of_a_pfm_are_from_the_bottom_and_tiff_has_all_kinds() {
        let mut pfm = b"Pf\n3 2\n-1.0\n".to_vec();
        pfm.extend((0..6).flat_map(|i| (i as f32).to_le_bytes()));
        let photo = read(&pfm).unwrap();
        assert_eq!(photo.channels[0].samples(), [3.0, 4.0, 5.0, 0.0, 1.0, 2.0]);
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap();
        let numbers = [-7.5_f32, 0.0, 1e6, f32::NAN, 2.0, 3.0];
        encoder
            .write_image::<colortype::Gray32Float>(3, 2, &numbers)
            .unwrap();
        let photo = read(&file.into_inner()).unwrap();
        assert_eq!(photo.channels[0].at(0, 0), -7.5);
        assert!(photo.channels[2].at(0, 1).is_nan());
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new_big(&mut file).unwrap();
        encoder
            .write_image::<colortype::GrayI16>(3, 2, &[-9, 1, 2, 3, 4, 5])
            .unwrap();
        assert_eq!(read(&file.into_inner()).unwrap().channels[1].at(0, 0), -9.0);
    }

    type TagOf<'a> = (u16, &'a [u16]);

    /// A TIFF of 3 x 2 pixels with these samples, of three channels of 8 bits but for these tags; those without a number are
    /// left out.
    fn tiff(tags: &[TagOf], samples: &[u8]) -> Vec<u8> {
        let mut all: BTreeMap<u16, &[u16]> = BTreeMap::from([
            (256, &[3][..]),
            (257, &[2]),
            (258, &[8, 8, 8]),
            (259, &[1]),
            (262, &[2]),
            (273, &[8]),
            (277, &[3]),
            (279, &[18]),
        ]);
        all.extend(tags.iter().copied());
        all.retain(|_, numbers| !numbers.is_empty());
        let mut file = b"II*\0\0\0\0\0".to_vec();
        file.extend(samples);
        let mut directory = (all.len() as u16).to_le_bytes().to_vec();
        for (tag, numbers) in all {
            let mut value: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            if value.len() > 4 {
                let at = file.len() as u32;
                file.append(&mut value);
                value.extend(at.to_le_bytes());
            }
            value.resize(4, 0);
            // Numbers of 16 bits.
            directory.extend(
                [tag, 3, numbers.len() as u16, 0]
                    .map(u16::to_le_bytes)
                    .as_flattened(),
            );
            directory.extend(value);
        }
        let at = file.len() as u32;
        file[4..8].copy_from_slice(&at.to_le_bytes());
        file.extend([directory, vec![0; 4]].concat());
        file
    }

    /// Sample i is code 10 i: the last pixel of three channels holds 150, 160 and 170, and 50, 110 and 170 in planes.
    #[test]
    fn several_channels_of_unsigned_integers_are_codes() {
        let codes: Vec<u8> = (0..18).map(|i| 10 * i).collect();
        let last = |bytes: &[u8]| {
            let photo = read(bytes).unwrap();
            assert_eq!((photo.bits, photo.is_float), (8, false));
            let at = |plane: &Plane| (255.0 * plane.at(2, 1)).round() as u8;
            let color: Vec<u8> = photo.channels.iter().map(at).collect();
            (color, photo.alpha.as_ref().map(at))
        };
        let opaque = |color: [u8; 3]| (color.to_vec(), None);
        let code = |i: usize| vec![10 * i as u8];
        let array = npy("|u1", false, "(2, 3, 3)", code, 18);
        assert_eq!(last(&array), opaque([150, 160, 170]));
        let planes: [(u16, &[u16]); 3] = [(273, &[8, 14, 20]), (279, &[6; 3]), (284, &[2])];
        assert_eq!(last(&tiff(&planes, &codes)), opaque([50, 110, 170]));
        // Grey and two that are none of colour.
        let others: [(u16, &[u16]); 2] = [(262, &[1]), (338, &[0, 0])];
        assert_eq!(last(&tiff(&others, &codes)), opaque([150, 160, 170]));
        // Grey and coverage.
        let covered: [(u16, &[u16]); 5] = [
            (262, &[1]),
            (258, &[8; 2]),
            (277, &[2]),
            (279, &[12]),
            (338, &[2]),
        ];
        assert_eq!(
            last(&tiff(&covered, &codes[..12])),
            (vec![100; 3], Some(110))
        );
        // Y 150, Cb 160, Cr 170: 150 + 1.402 * 42, 150 - .344 * 32 - .714 * 42, 150 + 1.772 * 32.
        let ycbcr: [(u16, &[u16]); 2] = [(262, &[6]), (530, &[1, 1])];
        assert_eq!(last(&tiff(&ycbcr, &codes)), opaque([209, 109, 207]));
    }

    #[test]
    fn long_integers_of_a_tiff_are_numbers_and_other_kinds_name_a_converter() {
        let long: Vec<u8> = (0..6_u32).flat_map(|i| (1000 * i).to_le_bytes()).collect();
        let grey: [(u16, &[u16]); 4] = [(262, &[1]), (258, &[32]), (277, &[1]), (279, &[24])];
        let photo = read(&tiff(&grey, &long)).unwrap();
        assert_eq!((photo.is_float, photo.channels[0].at(2, 1)), (true, 5000.0));
        let refused: [(&[TagOf], &str); 4] = [
            (
                &[(262, &[3]), (258, &[8]), (277, &[1]), (279, &[6])],
                "a palette",
            ),
            (&[(262, &[9])], "CIE L*a*b*"),
            (&[(262, &[6]), (530, &[2, 2])], "subsampled YCbCr"),
            (
                &[
                    (273, &[]),
                    (279, &[]),
                    (284, &[2]),
                    (322, &[16]),
                    (323, &[16]),
                    (324, &[8; 3]),
                    (325, &[256; 3]),
                ],
                "apart in tiles",
            ),
        ];
        for (tags, kind) in refused {
            let said = read(&tiff(tags, &[0; 18])).unwrap_err().to_string();
            assert!(
                said.contains(kind) && said.contains("IN.tif"),
                "{kind}: {said}"
            );
        }
    }

    #[test]
    fn what_is_no_picture_of_numbers_is_refused_in_one_line() {
        let none = |_: usize| vec![0; 4];
        let files = [
            npy("<f4", false, "(2, 3)", none, 5),
            npy("<f4", false, "(0, 3)", none, 0),
            npy("<f4", false, "(7, 8, 9)", none, 1),
            npy("<c8", false, "(2, 3)", none, 12),
            npy("<f4", false, "(99999999, 99999999)", none, 1),
            npy("<f4", false, "(2, -3)", none, 6),
            b"\x93NUMPY\x01\x00".to_vec(),
            b"Pf\n3 x\n-1\n".to_vec(),
            b"PF\n3 2\n1\n".to_vec(),
        ];
        for (i, file) in files.iter().enumerate() {
            let refused = read(file).map(drop).unwrap_err().to_string();
            assert!(!refused.contains('\n'), "{i}: {refused}");
        }
    }
}
