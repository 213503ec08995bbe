//! Pictures of numbers, that decoders of pictures refuse: TIFF of further sample types, NumPy arrays and PFM. Their samples
//! are the numbers as stored; grey is repeated, since there is no grey of floats.

use super::faults::{MAX_BYTES, damaged, unsupported};
use super::npy::{NpyHeader, Number};
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
enum Source {
    Tiff(Box<Decoder<BufReader<File>>>),
    /// Numbers one after another, by rows from the bottom or from the top.
    Raw {
        file: Box<dyn Read>,
        number: Number,
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
    source: Source,
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
        let failed = |error: tiff::TiffError| damaged(path, &error);
        let mut limits = Limits::default();
        limits.decoding_buffer_size = MAX_BYTES as usize;
        let mut decoder = Decoder::new(file).map_err(failed)?.with_limits(limits);
        let (width, height) = decoder.dimensions().map_err(failed)?;
        let channels = decoder.colortype().map_err(failed)?.num_samples().into();
        let planar = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration);
        let is_planar = planar.map_err(failed)? == Some(2);
        let (width, height) = (width as usize, height as usize);
        let extra = decoder.find_tag_unsigned::<u16>(Tag::ExtraSamples);
        let is_alpha = matches!(extra.map_err(failed)?, Some(1 | 2));
        let found = Self {
            size: [width, height],
            channels,
            is_pair: channels == 2 && !is_alpha,
            strides: match is_planar {
                true => [1, width, width.saturating_mul(height)],
                false => [channels, channels * width, 1],
            },
            source: Source::Tiff(Box::new(decoder)),
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
            source: Source::Raw {
                file,
                number: header.number,
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
            source: Source::Raw {
                file: Box::new(file),
                number: Number {
                    kind: 'f',
                    bytes: 4,
                    is_little: scale < 0.0,
                },
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
        let samples = match &mut self.source {
            Source::Tiff(decoder) => {
                let mut read = DecodingResult::U8(Vec::new());
                decoder
                    .read_image_to_buffer(&mut read)
                    .map_err(|e| said(&e))?;
                floats(read)
            }
            Source::Raw {
                file,
                number,
                is_upward,
            } => {
                let stored = bytes_of(file, count * number.bytes).map_err(|e| said(&e))?;
                let numbers = |row: &[u8]| -> Vec<f32> {
                    let numbers = row.chunks_exact(number.bytes);
                    numbers.map(|bytes| number.read(bytes)).collect()
                };
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
        match self.channels {
            1 | 3 => ColorType::Rgb32F,
            2 if self.is_pair => ColorType::Rgb32F,
            _ => ColorType::Rgba32F,
        }
    }

    fn original_color_type(&self) -> ExtendedColorType {
        match self.is_pair {
            true => PAIR,
            false => self.color_type().into(),
        }
    }

    fn read_image(mut self, buffer: &mut [u8]) -> ImageResult<()> {
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
        for (bytes, at) in buffer.chunks_exact_mut(4).zip(numbers) {
            let sample = at.map_or(0.0, |at| samples[at]);
            bytes.copy_from_slice(&sample.to_ne_bytes());
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, buffer: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(buffer)
    }
}

/// Refuses a TIFF of a compression that is not read, by its name. Decoders come to it with the samples alone.
pub(super) fn refuse_compression(path: &Path) -> Result<()> {
    let file = open_buffered(path)?;
    let failed = |error: tiff::TiffError| damaged(path, &error);
    let mut decoder = Decoder::new(file).map_err(failed)?;
    let stored = decoder.find_tag_unsigned::<u16>(Tag::Compression);
    let name = match stored.map_err(failed)? {
        Some(50_000) if cfg!(not(feature = "zstd")) => "ZSTD",
        Some(34_887) => "LERC",
        Some(34_925) => "LZMA",
        Some(34_712 | 33_003 | 33_005) => "JPEG 2000",
        Some(50_002 | 52_546) => "JPEG XL",
        _ => return Ok(()),
    };
    Err(Error::Unsupported {
        path: path.to_path_buf(),
        found: format!("is compressed by {name}, which is not read"),
        remedy: "save it with Deflate, as with gdal_translate -co COMPRESS=DEFLATE IN.tif OUT.tif, or tiffcp -c zip"
            .into(),
    })
}

/// So many bytes, or those that there are: room is made as they come, not as a header claims.
fn bytes_of(file: &mut dyn Read, count: usize) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(count as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn floats(read: DecodingResult) -> Vec<f32> {
    fn all<T>(numbers: Vec<T>, float: impl Fn(T) -> f32) -> Vec<f32> {
        numbers.into_iter().map(float).collect()
    }
    match read {
        DecodingResult::U8(numbers) => all(numbers, f32::from),
        DecodingResult::U16(numbers) => all(numbers, f32::from),
        DecodingResult::U32(numbers) => all(numbers, |number| number as f32),
        DecodingResult::U64(numbers) => all(numbers, |number| number as f32),
        DecodingResult::F16(numbers) => all(numbers, f32::from),
        DecodingResult::F32(numbers) => numbers,
        DecodingResult::F64(numbers) => all(numbers, |number| number as f32),
        DecodingResult::I8(numbers) => all(numbers, f32::from),
        DecodingResult::I16(numbers) => all(numbers, f32::from),
        DecodingResult::I32(numbers) => all(numbers, |number| number as f32),
        DecodingResult::I64(numbers) => all(numbers, |number| number as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::photo::Photo;
    use half::f16;
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
