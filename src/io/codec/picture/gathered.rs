//! Samples in the layout of picture files, gathered by rows and encoded at once.

use super::codes::code;
use super::encoding::Encoding;
use super::format::{Picture, PictureFormat, ViewTransform};
use super::scale_bar::Bar;
use super::stored::{Storable, unwritten};
use super::straight::{rows_of, straight};
use crate::error::{Error, Result};
use crate::frame::{MOST_ROWS_PER_TASK, Plane};
use crate::io::photo::max_code;
use crate::params::ScaleBar;
use image::ImageResult;
use rayon::prelude::*;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;

/// A picture whose stored samples are gathered, some rows at a time, before it is written.
#[derive(Debug, Clone)]
pub(crate) struct Gathered {
    format: PictureFormat,
    size: [usize; 2],
    /// Samples of each pixel: 1, 3, or 4 with alpha.
    channels: usize,
    /// Bits per stored sample, 32 of a float.
    bits: u8,
    dpi: Option<[f32; 2]>,
    grey: bool,
    /// Whether its colours are photographic or light, so that a colour profile applies.
    is_photo: bool,
    /// Whether alpha was 1 everywhere so far.
    is_opaque: bool,
    /// Samples in the layout of files, those of a pixel interleaved, in native byte order; of 1 bit a byte each.
    samples: Vec<u8>,
}

#[cfg(feature = "cli")]
impl Gathered {
    /// Bytes of its samples.
    pub(crate) fn bytes(&self) -> u64 {
        let pixels = self.size[0] as u64 * self.size[1] as u64;
        pixels * (self.channels * self.sample_bytes()) as u64
    }

    /// Additional bytes for encoding: compressed data, and samples of 16 bits in another byte order.
    pub(crate) fn encoding_bytes(&self) -> u64 {
        match self.bits {
            16 => 2 * self.bytes(),
            _ => self.bytes(),
        }
    }
}

impl Gathered {
    /// A picture of `size`, columns and rows, for parts like `part` in grey or colour, alpha, and bits.
    ///
    /// # Panics
    /// If its `bits` are none of 1, 8 and 16, or 1 of colour or alpha.
    pub(crate) fn new(format: PictureFormat, size: [usize; 2], part: &Picture) -> Self {
        assert!([1, 8, 16].contains(&part.bits), "bits must be 1, 8 or 16");
        let bits = format.bits(part.bits);
        let channels = match part.alpha {
            _ if bits == 32 => 3,
            Some(_) if format.holds_alpha() => 4,
            _ if part.grey => 1,
            _ => 3,
        };
        assert!(bits > 1 || channels == 1, "one bit holds one grey sample");
        Self {
            format,
            size,
            channels,
            bits,
            dpi: part.dpi,
            grey: part.grey,
            is_photo: !part.grey && part.transform == ViewTransform::Srgb,
            is_opaque: true,
            samples: Vec::with_capacity(
                size[0] * size[1] * channels * usize::from(bits).div_ceil(8),
            ),
        }
    }

    fn sample_bytes(&self) -> usize {
        usize::from(self.bits).div_ceil(8)
    }

    /// Adds the rows `rows` of `part`, below those added before.
    ///
    /// # Panics
    /// If planes differ in size, or `part` is not as wide as the picture.
    pub(crate) fn push(&mut self, part: &Picture, rows: Range<usize>) {
        let planes = part.primaries();
        let size = (self.size[0], part.color.r.height());
        for plane in planes.into_iter().chain(part.alpha) {
            let own = (plane.width(), plane.height());
            assert_eq!(own, size, "planes differ in size");
        }
        let channels = self.channels;
        let alpha = part.alpha.filter(|_| channels == 4);
        if let Some(alpha) = alpha {
            let shows = |&a: &f32| a < 1.0 || a.is_nan();
            let mut rows = rows.clone();
            self.is_opaque &= !rows.any(|y| alpha.row(y).iter().any(shows));
        }
        if self.bits == 32 {
            for y in rows {
                let [r, g, b] = planes.map(|plane| plane.row(y));
                let pixels = r.iter().zip(g).zip(b);
                let pixels =
                    pixels.map(|((&r, &g), &b)| [r, g, b].map(|v| finite(v).to_ne_bytes()));
                self.samples.extend(pixels.flatten().flatten());
            }
            return;
        }
        let part = CodedRows {
            picture: part,
            alpha,
            rows,
            max: max_code(self.bits),
        };
        match self.bits {
            16 => part.add_to(&mut self.samples, channels, u16::to_ne_bytes),
            _ => part.add_to(&mut self.samples, channels, |code| [code as u8]),
        }
    }

    /// Writes the picture; `target` is only named in errors.
    ///
    /// # Errors
    /// Any [`Error`] of writing.
    ///
    /// # Panics
    /// If rows are missing.
    pub(crate) fn write(
        mut self,
        w: &mut (impl Write + Seek),
        target: &Path,
        encoding: &Encoding,
    ) -> Result<()> {
        if self.channels == 4 && self.is_opaque {
            self.drop_alpha();
        }
        self.draw_scale_bar(target, encoding)?;
        self.encode(w, encoding).map_err(unwritten(target))
    }

    /// Drops alpha, and in a grey picture all but one sample.
    fn drop_alpha(&mut self) {
        let kept = if self.grey { 1 } else { 3 };
        let bytes = self.sample_bytes();
        keep_first(&mut self.samples, kept * bytes, 4 * bytes);
        self.channels = kept;
    }

    /// Draws the requested scale bar.
    ///
    /// # Errors
    /// [`Error::BadParameter`] where the picture is too small for it.
    fn draw_scale_bar(&mut self, target: &Path, encoding: &Encoding) -> Result<()> {
        let (place, Some(pixel_mm)) = (encoding.scale_bar, encoding.pixel_mm) else {
            return Ok(());
        };
        if place == ScaleBar::Off {
            return Ok(());
        }
        let size = self.size;
        let bar = Bar::new(size, pixel_mm);
        let (channels, white) = match self.bits {
            // Floats of a pixel are looked at together.
            32 => (1, [1.0_f32.to_ne_bytes(); 3].concat()),
            16 => (self.channels, vec![u8::MAX; 2]),
            bits => (self.channels, vec![max_code(bits) as u8]),
        };
        let drawn = bar.draw(&mut self.samples, size, channels, &white, place);
        self.size = drawn.ok_or_else(|| Error::BadParameter {
            name: "--scale-bar",
            found: format!(
                "has no room on {}x{} pixels of {}",
                size[0],
                size[1],
                target.display()
            ),
            remedy: "leave it out, or make a larger picture".into(),
        })?;
        Ok(())
    }

    fn encode(&self, w: &mut (impl Write + Seek), encoding: &Encoding) -> ImageResult<()> {
        let [width, height] = self.size;
        let stored = Storable {
            size: [width as u32, height as u32],
            channels: self.channels,
            bits: self.bits,
            dpi: self.dpi.or_else(|| encoding.dpi(width)),
            profile: encoding.profile().filter(|_| self.is_photo),
            samples: &self.samples,
        };
        self.format.write(w, &stored, encoding)
    }
}

/// Keeps the first `kept` of every `count` bytes.
fn keep_first(samples: &mut Vec<u8>, kept: usize, count: usize) {
    let pixels = samples.len() / count;
    for pixel in 0..pixels {
        samples.copy_within(count * pixel..count * pixel + kept, kept * pixel);
    }
    samples.truncate(kept * pixels);
}

fn finite(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e30) }
}

/// Rows of a picture to be stored as codes up to `max`.
pub(super) struct CodedRows<'a> {
    pub(super) picture: &'a Picture<'a>,
    pub(super) alpha: Option<&'a Plane>,
    pub(super) rows: Range<usize>,
    pub(super) max: u32,
}

impl CodedRows<'_> {
    /// Adds the codes, `channels` of each pixel.
    pub(super) fn add_to<const BYTES: usize>(
        &self,
        samples: &mut Vec<u8>,
        channels: usize,
        stored: impl Fn(u16) -> [u8; BYTES] + Sync,
    ) {
        let row_bytes = self.picture.color.r.width() * channels * BYTES;
        let before = samples.len();
        samples.resize(before + row_bytes * self.rows.len(), 0);
        let rows = samples[before..].par_chunks_mut(row_bytes.max(1));
        rows.with_max_len(MOST_ROWS_PER_TASK)
            .zip(self.rows.clone())
            .map(|(row, y)| (row.as_chunks_mut::<BYTES>().0, y))
            .for_each(|(row, y)| match channels {
                1 => {
                    let samples = self.picture.color.r.row(y);
                    for (to, &v) in row.iter_mut().zip(samples) {
                        *to = stored(code(v.into(), self.picture.transform, self.max));
                    }
                }
                4 => self.interleave::<4, _>(row, y, &stored),
                _ => self.interleave::<3, _>(row, y, &stored),
            });
    }

    /// The first `N` of red, green, blue and alpha of each pixel of a row, as codes.
    fn interleave<const N: usize, T: Copy>(
        &self,
        row: &mut [T],
        y: usize,
        stored: impl Fn(u16) -> T,
    ) {
        let (transform, max) = (self.picture.transform, self.max);
        let (mapping, alphas) = (self.picture.mapping(), self.alpha.map(|plane| plane.row(y)));
        let rows = self.picture.primaries().map(|plane| plane.row(y));
        for (x, pixel) in row.as_chunks_mut::<N>().0.iter_mut().enumerate() {
            let of = |rows: [&[f32]; 3]| straight(rows, alphas, x, max);
            let (mut color, alpha) = of(rows);
            if let Some(mapping) = mapping {
                color = mapping.shown(color, |before| of(rows_of(before, y)).0);
            }
            let coded = |v: f64| code(v, transform, max);
            let [r, g, b] = color;
            let alpha = code(alpha, ViewTransform::None, max);
            let codes = [coded(r), coded(g), coded(b), alpha];
            for (sample, code) in pixel.iter_mut().zip(codes) {
                *sample = stored(code);
            }
        }
    }
}
