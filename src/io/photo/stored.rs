//! A picture whose header has been read, and its samples as they are stored.

use super::decoder::{image_error, max_code, unsupported, with_decoder};
use super::rows::{each_row, has_changed};
use crate::error::{Error, Result};
use crate::frame::Plane;
use crate::io::srgb;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat};
use rayon::prelude::*;
use std::cell::{Ref, RefCell};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What the integers of a picture stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Meaning {
    /// A share of the largest: normals, masks and other data.
    Stored,
    /// Light, encoded by the sRGB curve.
    Linear,
}

/// A picture whose header has been read. Its samples are decoded when first asked for.
pub(in crate::io) struct StoredPhoto {
    pub(in crate::io) path: PathBuf,
    pub(in crate::io) width: usize,
    pub(in crate::io) height: usize,
    /// Bits per sample: 8, 16 or 32.
    pub(in crate::io) bits: u8,
    /// Whether samples are floating point, and linear.
    pub(in crate::io) is_float: bool,
    pub(super) format: ImageFormat,
    pub(super) color: ColorType,
    /// Most bytes of samples that may be held.
    most_bytes: u64,
    /// All samples, while they are held.
    image: RefCell<Option<DynamicImage>>,
}

/// Samples of whole pixels, side by side.
#[derive(Clone, Copy)]
pub(super) enum Samples<'a> {
    Narrow(&'a [u8]),
    Wide(&'a [u16]),
    Float(&'a [f32]),
}

impl StoredPhoto {
    /// Reads the header of the picture at `path`; its kind is recognised by content, not by name. Of samples that take
    /// more than `most_bytes` only rows are read.
    pub(in crate::io) fn open(path: &Path, most_bytes: u64) -> Result<Self> {
        with_decoder(path, |decoder, format| {
            let color = decoder.color_type();
            let (width, height) = decoder.dimensions();
            let bits = 8 * (color.bytes_per_pixel() / color.channel_count());
            if ![8, 16, 32].contains(&bits) {
                return Err(unsupported(path, "has samples of an unknown kind"));
            }
            Ok(Self {
                path: path.to_path_buf(),
                width: width as usize,
                height: height as usize,
                bits,
                is_float: bits == 32,
                format,
                color,
                most_bytes,
                image: RefCell::default(),
            })
        })
    }

    pub(in crate::io) fn has_alpha(&self) -> bool {
        self.color.has_alpha()
    }

    /// Channels without alpha: 1 or 3.
    pub(in crate::io) fn color_channels(&self) -> usize {
        self.channels() - usize::from(self.has_alpha())
    }

    pub(super) fn channels(&self) -> usize {
        usize::from(self.color.channel_count())
    }

    /// Bytes that all its samples take.
    pub(in crate::io) fn bytes(&self) -> u64 {
        let pixels = self.width as u64 * self.height as u64;
        pixels.saturating_mul(self.color.bytes_per_pixel().into())
    }

    /// Planes of the rows `rows`: grey or colour, then alpha where it has one, which is never encoded.
    ///
    /// # Errors
    /// As for any picture; [`Error::Unsupported`] for one that takes more than it may and is of a kind that can only be
    /// decoded whole.
    ///
    /// # Panics
    /// If it has fewer rows.
    pub(in crate::io) fn planes(&self, rows: Range<usize>, meaning: Meaning) -> Result<Vec<Plane>> {
        let size = [self.width, rows.len()];
        if self.bytes() <= self.most_bytes {
            let image = self.image()?;
            let samples = self
                .samples_of(&image)
                .within(self.channels() * self.width, &rows);
            return Ok(self.planes_of(size, samples, meaning));
        }
        let mut planes = vec![Plane::filled(size[0], size[1], 0.0); self.channels()];
        each_row(self, rows.clone(), &mut |y, samples| {
            let row = self.planes_of([self.width, 1], samples, meaning);
            for (plane, row) in planes.iter_mut().zip(row) {
                plane.row_mut(y - rows.start).copy_from_slice(row.samples());
            }
        })?;
        Ok(planes)
    }

    /// Hands planes of each of the rows `rows` to `take`, one row after the other.
    ///
    /// # Errors
    /// As [`StoredPhoto::planes`].
    pub(in crate::io) fn each_row(
        &self,
        rows: Range<usize>,
        meaning: Meaning,
        take: &mut dyn FnMut(usize, Vec<Plane>),
    ) -> Result<()> {
        let mut take = |y, samples: Samples| {
            take(y, self.planes_of([self.width, 1], samples, meaning));
        };
        if self.bytes() > self.most_bytes {
            return each_row(self, rows, &mut take);
        }
        let image = self.image()?;
        let samples = self.samples_of(&image);
        for y in rows {
            take(y, samples.within(self.channels() * self.width, &(y..y + 1)));
        }
        Ok(())
    }

    /// Lets go of the samples; they are decoded anew where they are asked for again.
    pub(in crate::io) fn release(&self) {
        self.image.take();
    }

    /// The refusal of a picture whose samples can only be decoded whole.
    pub(super) fn too_large(&self) -> Error {
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        Error::Unsupported {
            path: self.path.clone(),
            found: format!(
                "is {}x{} and takes {} MiB, of which {} may be held; a picture of this kind is decoded whole",
                self.width,
                self.height,
                mib(self.bytes()),
                self.most_bytes >> 20,
            ),
            remedy: "allow more memory, make it smaller, or save it as PNG without interlacing or OpenEXR"
                .into(),
        }
    }

    /// All samples, decoded where they are not held.
    fn image(&self) -> Result<Ref<'_, DynamicImage>> {
        if self.image.borrow().is_none() {
            let image = with_decoder(&self.path, |decoder, _| {
                // The file may have been written anew since its header was read.
                let size = (self.width as u32, self.height as u32);
                if (decoder.dimensions(), decoder.color_type()) != (size, self.color) {
                    return Err(has_changed(self));
                }
                DynamicImage::from_decoder(decoder).map_err(image_error(&self.path))
            })?;
            self.image.replace(Some(image));
        }
        Ok(Ref::map(self.image.borrow(), |image| {
            image.as_ref().expect("decoded above")
        }))
    }

    fn samples_of<'i>(&self, image: &'i DynamicImage) -> Samples<'i> {
        match image {
            DynamicImage::ImageLuma8(i) => Samples::Narrow(i),
            DynamicImage::ImageLumaA8(i) => Samples::Narrow(i),
            DynamicImage::ImageRgb8(i) => Samples::Narrow(i),
            DynamicImage::ImageRgba8(i) => Samples::Narrow(i),
            DynamicImage::ImageLuma16(i) => Samples::Wide(i),
            DynamicImage::ImageLumaA16(i) => Samples::Wide(i),
            DynamicImage::ImageRgb16(i) => Samples::Wide(i),
            DynamicImage::ImageRgba16(i) => Samples::Wide(i),
            DynamicImage::ImageRgb32F(i) => Samples::Float(i),
            DynamicImage::ImageRgba32F(i) => Samples::Float(i),
            _ => unreachable!("opening refuses other kinds"),
        }
    }

    fn planes_of(&self, size: [usize; 2], samples: Samples, meaning: Meaning) -> Vec<Plane> {
        let count = self.channels();
        let plane = |channel: usize| {
            let is_alpha = self.has_alpha() && channel + 1 == count;
            let meaning = if is_alpha { Meaning::Stored } else { meaning };
            let samples = match samples {
                Samples::Narrow(samples) => {
                    let values = values(8, meaning);
                    channel_of(samples, count, channel, |v| values[usize::from(v)])
                }
                Samples::Wide(samples) => {
                    let values = values(16, meaning);
                    channel_of(samples, count, channel, |v| values[usize::from(v)])
                }
                Samples::Float(samples) => channel_of(samples, count, channel, |v| v),
            };
            Plane::from_samples(size[0], size[1], samples)
        };
        (0..count).map(plane).collect()
    }
}

impl<'a> Samples<'a> {
    /// Those of some rows, with so many samples to a row.
    fn within(self, row: usize, rows: &Range<usize>) -> Self {
        let range = rows.start * row..rows.end * row;
        match self {
            Self::Narrow(samples) => Self::Narrow(&samples[range]),
            Self::Wide(samples) => Self::Wide(&samples[range]),
            Self::Float(samples) => Self::Float(&samples[range]),
        }
    }
}

/// The value of each code of `bits` bits.
pub(super) fn values(bits: u8, meaning: Meaning) -> &'static [f32] {
    use std::sync::LazyLock;
    type Values = LazyLock<Vec<f32>>;
    static STORED: [Values; 2] = [
        LazyLock::new(|| stored_values(8)),
        LazyLock::new(|| stored_values(16)),
    ];
    static LINEAR: [Values; 2] = [
        LazyLock::new(|| linear_values(8)),
        LazyLock::new(|| linear_values(16)),
    ];
    let tables = match meaning {
        Meaning::Stored => &STORED,
        Meaning::Linear => &LINEAR,
    };
    &tables[usize::from(bits == 16)]
}

fn stored_values(bits: u8) -> Vec<f32> {
    let max = max_code(bits);
    (0..=max).map(|code| code as f32 / max as f32).collect()
}

fn linear_values(bits: u8) -> Vec<f32> {
    let max = max_code(bits);
    let linear = |code| srgb::decoded(f64::from(code) / f64::from(max)) as f32;
    (0..=max).map(linear).collect()
}

/// The values of one of `count` channels that lie side by side.
fn channel_of<T: Copy + Sync>(
    samples: &[T],
    count: usize,
    channel: usize,
    value: impl Fn(T) -> f32 + Sync,
) -> Vec<f32> {
    let pixels = samples.par_chunks_exact(count).with_min_len(1 << 14);
    pixels.map(|pixel| value(pixel[channel])).collect()
}
