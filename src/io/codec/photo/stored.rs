//! A picture whose header has been read, and its samples as stored.

use super::decoder::{max_code, with_decoder};
use super::faults::image_error;
use super::header::{PhotoHeader, turned};
use super::metadata::PhotoMetadata;
use super::rows::each_row;
use crate::error::Result;
use crate::frame::{Plane, Window};
use crate::io::srgb;
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat};
use rayon::prelude::*;
use std::cell::{Ref, RefCell};
use std::ops::Range;
use std::path::Path;

/// Meaning of integer samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum CodeMeaning {
    /// A share of the largest: normals, masks and other data.
    Stored,
    /// Light, encoded by the sRGB curve.
    Linear,
}

/// A picture whose header has been read. Its samples are decoded when first asked for.
pub(in crate::io) struct StoredPhoto {
    pub(in crate::io) header: PhotoHeader,
    /// Columns and rows of the cells of a sheet; its own if it is none.
    pub(in crate::io) cell: [usize; 2],
    /// Most bytes of samples that may be held.
    most_bytes: u64,
    /// All samples, while held.
    image: RefCell<Option<DynamicImage>>,
}

impl StoredPhoto {
    /// Reads the header of the picture at `path`. Samples of more than `most_bytes` are only read by rows.
    pub(in crate::io) fn open(path: &Path, most_bytes: u64) -> Result<Self> {
        let header = PhotoHeader::read(path)?;
        Ok(Self {
            cell: [header.width, header.height],
            header,
            most_bytes,
            image: RefCell::default(),
        })
    }

    /// The part `window` of the picture with this header and these upright samples. It holds its own: they are not decoded.
    pub(in crate::io) fn part(whole: &PhotoHeader, samples: &DynamicImage, window: Window) -> Self {
        let (x, y) = (window.x0 as u32, window.y0 as u32);
        let [width, height] = [window.width(), window.height()].map(|side| side as u32);
        Self {
            header: PhotoHeader {
                width: window.width(),
                height: window.height(),
                orientation: Orientation::NoTransforms,
                ..whole.clone()
            },
            cell: [window.width(), window.height()],
            most_bytes: u64::MAX,
            image: RefCell::new(Some(samples.crop_imm(x, y, width, height))),
        }
    }

    /// All samples, upright, which are let go of here.
    #[cfg(feature = "cli")]
    pub(in crate::io) fn take_samples(&self) -> Result<DynamicImage> {
        drop(self.image()?);
        Ok(self.image.take().expect("decoded above"))
    }

    /// Planes of the rows `rows`: grey or colour, then alpha if there is one, which is never encoded.
    ///
    /// # Errors
    /// As for any picture; [`crate::Error::Unsupported`] for one that exceeds its limit and is of a kind that can only
    /// be decoded whole.
    ///
    /// # Panics
    /// If it has fewer rows.
    pub(in crate::io) fn planes(
        &self,
        rows: Range<usize>,
        meaning: CodeMeaning,
    ) -> Result<Vec<Plane>> {
        if self.header.bytes() <= self.most_bytes {
            let image = self.image()?;
            return Ok(self.planes_of(self.rows_of(&image, &rows), meaning));
        }
        let blank = Plane::filled(self.header.width, rows.len(), 0.0);
        let mut planes = vec![blank; self.header.channels()];
        self.each_row(rows.clone(), meaning, &mut |y, row| {
            for (plane, row) in planes.iter_mut().zip(row) {
                plane.row_mut(y - rows.start).copy_from_slice(row.samples());
            }
        })?;
        Ok(planes)
    }

    /// Passes planes of each of the rows `rows` to `take`, one row at a time.
    ///
    /// # Errors
    /// As [`StoredPhoto::planes`].
    pub(in crate::io) fn each_row(
        &self,
        rows: Range<usize>,
        meaning: CodeMeaning,
        take: &mut dyn FnMut(usize, Vec<Plane>),
    ) -> Result<()> {
        let mut take = |y, samples: &[u8]| take(y, self.planes_of(samples, meaning));
        if self.header.bytes() > self.most_bytes {
            return each_row(&self.header, rows, self.most_bytes, &mut take);
        }
        let image = self.image()?;
        for y in rows {
            take(y, self.rows_of(&image, &(y..y + 1)));
        }
        Ok(())
    }

    /// The bits of the codes of integers that its floats are: whole numbers, none negative and one above 1. Those of other
    /// floats are `None`.
    pub(in crate::io) fn bits_of_floats(&self) -> Option<u8> {
        let is_held = self.header.bytes() <= self.most_bytes;
        if !self.header.is_float || self.header.format == ImageFormat::Hdr || !is_held {
            return None;
        }
        let image = self.image().ok()?;
        let (samples, _) = image.as_bytes().as_chunks::<4>();
        let most = samples.iter().try_fold(0.0_f32, |most, bytes| {
            let sample = f32::from_ne_bytes(*bytes);
            (sample >= 0.0 && sample.fract() == 0.0).then(|| most.max(sample))
        });
        let most = most.filter(|most| *most > 1.0)?;
        [8, 16, 32]
            .into_iter()
            .find(|bits| most <= max_code(*bits) as f32)
    }

    /// Metadata that a picture made from it keeps.
    ///
    /// # Errors
    /// Those of opening the file.
    pub(in crate::io) fn metadata(&self) -> Result<PhotoMetadata> {
        PhotoMetadata::of(&self.header)
    }

    /// Releases the samples; they are decoded again on the next use.
    pub(in crate::io) fn release(&self) {
        self.image.take();
    }

    /// All samples, decoded unless held.
    fn image(&self) -> Result<Ref<'_, DynamicImage>> {
        if self.image.borrow().is_none() {
            let image = self.decoded()?;
            self.image.replace(Some(image));
        }
        Ok(Ref::map(self.image.borrow(), |image| {
            image.as_ref().expect("decoded above")
        }))
    }

    fn decoded(&self) -> Result<DynamicImage> {
        with_decoder(&self.header.path, |decoder, _| {
            // The file may have been rewritten since its header was read.
            let orientation = self.header.orientation;
            let (width, height) = turned(orientation, (self.header.width, self.header.height));
            let size = (width as u32, height as u32);
            if (decoder.dimensions(), decoder.color_type()) != (size, self.header.color) {
                return Err(self.header.has_changed());
            }
            let image = DynamicImage::from_decoder(decoder);
            let mut image = image.map_err(image_error(&self.header.path))?;
            image.apply_orientation(orientation);
            Ok(image)
        })
    }

    /// The samples of some rows, in native byte order.
    fn rows_of<'i>(&self, image: &'i DynamicImage, rows: &Range<usize>) -> &'i [u8] {
        let row = self.header.row_bytes();
        &image.as_bytes()[rows.start * row..rows.end * row]
    }

    /// The planes of whole rows.
    fn planes_of(&self, rows: &[u8], meaning: CodeMeaning) -> Vec<Plane> {
        let header = &self.header;
        let (count, height) = (header.channels(), rows.len() / header.row_bytes());
        let plane = |channel: usize| {
            let is_alpha = header.has_alpha() && channel + 1 == count;
            let meaning = if is_alpha {
                CodeMeaning::Stored
            } else {
                meaning
            };
            let place = (count, channel);
            let samples = match header.bits {
                8 => {
                    let values = values(8, meaning);
                    channel_of(rows, place, |[code]| values[usize::from(code)])
                }
                16 => {
                    let values = values(16, meaning);
                    let value = |code| values[usize::from(u16::from_ne_bytes(code))];
                    channel_of(rows, place, value)
                }
                _ => channel_of(rows, place, f32::from_ne_bytes),
            };
            Plane::from_samples(header.width, height, samples)
        };
        (0..count).map(plane).collect()
    }
}

/// The value of each code of `bits` bits.
pub(super) fn values(bits: u8, meaning: CodeMeaning) -> &'static [f32] {
    use std::sync::LazyLock;
    static TABLES: [LazyLock<Vec<f32>>; 4] = [
        LazyLock::new(|| table(8, CodeMeaning::Stored)),
        LazyLock::new(|| table(16, CodeMeaning::Stored)),
        LazyLock::new(|| table(8, CodeMeaning::Linear)),
        LazyLock::new(|| table(16, CodeMeaning::Linear)),
    ];
    &TABLES[2 * usize::from(meaning == CodeMeaning::Linear) + usize::from(bits == 16)]
}

fn table(bits: u8, meaning: CodeMeaning) -> Vec<f32> {
    let max = max_code(bits);
    let value = |code| match meaning {
        CodeMeaning::Stored => code as f32 / max as f32,
        CodeMeaning::Linear => srgb::decoded(f64::from(code) / f64::from(max)) as f32,
    };
    (0..=max).map(value).collect()
}

/// The values of one of `count` interleaved channels.
fn channel_of<const BYTES: usize>(
    samples: &[u8],
    (count, channel): (usize, usize),
    value: impl Fn([u8; BYTES]) -> f32 + Sync,
) -> Vec<f32> {
    let (samples, _) = samples.as_chunks::<BYTES>();
    let pixels = samples.par_chunks_exact(count).with_min_len(1 << 14);
    pixels.map(|pixel| value(pixel[channel])).collect()
}
