//! Samples in the layout of picture files, gathered by rows and encoded at once.

use super::codes::{SRGB_8, SrgbCodes, code};
use super::display::Shown;
use super::encoding::Encoding;
use super::format::{Picture, PictureFormat, ViewTransform};
use super::group::{GROUP, straight};
use super::scale_bar::Bar;
use super::stored::{self, Stored};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, MOST_ROWS_PER_TASK, Plane};
use crate::io::photo::{max_code, one_line, unsupported};
use crate::params::ScaleBar;
use image::codecs::jpeg::{JpegEncoder, PixelDensity, PixelDensityUnit};
use image::{ExtendedColorType, ImageEncoder, ImageError, ImageResult};
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
    /// Bits per stored sample.
    bits: u8,
    dpi: Option<[f32; 2]>,
    grey: bool,
    /// Whether its colours are photographic or light, so that a colour profile applies.
    is_photo: bool,
    /// Whether alpha was 1 everywhere so far.
    is_opaque: bool,
    samples: Samples,
}

/// Samples in the layout of files, those of a pixel interleaved.
#[derive(Debug, Clone)]
enum Samples {
    /// 8-bit or 1-bit samples.
    Narrow(Vec<u8>),
    /// 16-bit samples, in native byte order.
    Wide(Vec<[u8; 2]>),
    Float(Vec<image::Rgb<f32>>),
}

#[cfg(feature = "cli")]
impl Gathered {
    /// Bytes of its samples.
    pub(crate) fn bytes(&self) -> u64 {
        let pixels = self.size[0] as u64 * self.size[1] as u64;
        pixels
            * self.channels as u64
            * match self.samples {
                Samples::Narrow(_) => 1,
                Samples::Wide(_) => 2,
                // Always three floats.
                Samples::Float(_) => return pixels * 12,
            }
    }

    /// Additional bytes for encoding: compressed data, and 16-bit samples in another byte order.
    pub(crate) fn encoding_bytes(&self) -> u64 {
        match self.samples {
            Samples::Wide(_) => 2 * self.bytes(),
            Samples::Narrow(_) => self.bytes(),
            Samples::Float(_) => 0,
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
        let channels = match part.alpha {
            Some(_) if format.holds_alpha() => 4,
            _ if part.grey => 1,
            _ => 3,
        };
        let bits = match format {
            PictureFormat::Jpeg => 8,
            _ => part.bits,
        };
        assert!(bits > 1 || channels == 1, "one bit holds one grey sample");
        let pixels = size[0] * size[1];
        let samples = match (format, bits) {
            (PictureFormat::Hdr, _) => Samples::Float(Vec::with_capacity(pixels)),
            (_, 16) => Samples::Wide(Vec::with_capacity(pixels * channels)),
            _ => Samples::Narrow(Vec::with_capacity(pixels * channels)),
        };
        Self {
            format,
            size,
            channels,
            bits,
            dpi: part.dpi,
            grey: part.grey,
            is_photo: !part.grey && part.transform == ViewTransform::Srgb,
            is_opaque: true,
            samples,
        }
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
        match &mut self.samples {
            Samples::Narrow(samples) => {
                let part = Part {
                    picture: part,
                    alpha,
                    rows,
                    max: max_code(self.bits),
                };
                part.add_to(samples, channels, |code| code as u8);
            }
            Samples::Wide(samples) => {
                let part = Part {
                    picture: part,
                    alpha,
                    rows,
                    max: max_code(16),
                };
                part.add_to(samples, channels, u16::to_ne_bytes);
            }
            Samples::Float(samples) => rows.for_each(|y| {
                let [r, g, b] = planes.map(|plane| plane.row(y));
                let pixel = |((&r, &g), &b)| image::Rgb([r, g, b].map(finite));
                samples.extend(r.iter().zip(g).zip(b).map(pixel));
            }),
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
        self.encode(w, encoding).map_err(|error| match error {
            ImageError::IoError(source) => Error::io(target, "write")(source),
            other => unsupported(
                target,
                &format!("cannot be written ({})", one_line(&other.to_string())),
            ),
        })
    }

    /// Drops alpha, and in a grey picture all but one sample.
    fn drop_alpha(&mut self) {
        let kept = if self.grey { 1 } else { 3 };
        match &mut self.samples {
            Samples::Narrow(samples) => keep_first(samples, kept),
            Samples::Wide(samples) => keep_first(samples, kept),
            Samples::Float(_) => return,
        }
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
        let (size, channels) = (self.size, self.channels);
        let bar = Bar::new(size, pixel_mm);
        let white = max_code(self.bits);
        let drawn = match &mut self.samples {
            Samples::Narrow(samples) => bar.draw(samples, size, channels, [0, white as u8], place),
            Samples::Wide(samples) => {
                let codes = [0, white as u16].map(u16::to_ne_bytes);
                bar.draw(samples, size, channels, codes, place)
            }
            Samples::Float(samples) => {
                let codes = [0.0, 1.0].map(|v| image::Rgb([v; 3]));
                bar.draw(samples, size, 1, codes, place)
            }
        };
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
        let (bytes, kind) = match (&self.samples, self.channels) {
            (Samples::Float(pixels), _) => {
                return image::codecs::hdr::HdrEncoder::new(w).encode(pixels, width, height);
            }
            (Samples::Narrow(samples), 1) => (&samples[..], ExtendedColorType::L8),
            (Samples::Narrow(samples), 4) => (&samples[..], ExtendedColorType::Rgba8),
            (Samples::Narrow(samples), _) => (&samples[..], ExtendedColorType::Rgb8),
            (Samples::Wide(samples), 1) => (samples.as_flattened(), ExtendedColorType::L16),
            (Samples::Wide(samples), 4) => (samples.as_flattened(), ExtendedColorType::Rgba16),
            (Samples::Wide(samples), _) => (samples.as_flattened(), ExtendedColorType::Rgb16),
        };
        let stored = Stored {
            size: [width as u32, height as u32],
            channels: self.channels,
            bits: self.bits,
            dpi: self.dpi.or_else(|| encoding.dpi(width)),
            profile: encoding.profile().filter(|_| self.is_photo),
            samples: bytes,
        };
        match self.format {
            PictureFormat::Tiff => stored::write_tiff(w, &stored, encoding),
            PictureFormat::Jpeg => write_jpeg(w, &stored, kind, encoding),
            _ => stored::write_png(w, &stored, encoding),
        }
    }
}

fn write_jpeg(
    w: &mut impl Write,
    picture: &Stored,
    kind: ExtendedColorType,
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

/// Keeps the first few of every four samples.
fn keep_first<T: Copy>(samples: &mut Vec<T>, kept: usize) {
    let pixels = samples.len() / 4;
    for pixel in 0..pixels {
        samples.copy_within(4 * pixel..4 * pixel + kept, kept * pixel);
    }
    samples.truncate(kept * pixels);
}

fn finite(v: f32) -> f32 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1e30) }
}

/// Rows of a picture to be stored as codes up to `max`.
pub(super) struct Part<'a> {
    pub(super) picture: &'a Picture<'a>,
    pub(super) alpha: Option<&'a Plane>,
    pub(super) rows: Range<usize>,
    pub(super) max: u32,
}

impl Part<'_> {
    /// Adds the codes, `channels` of each pixel.
    pub(super) fn add_to<T: Copy + Default + Send>(
        &self,
        samples: &mut Vec<T>,
        channels: usize,
        stored: impl Fn(u16) -> T + Sync,
    ) {
        let (width, before) = (self.picture.color.r.width(), samples.len());
        samples.resize(before + width * channels * self.rows.len(), T::default());
        let rows = samples[before..].par_chunks_mut((width * channels).max(1));
        rows.with_max_len(MOST_ROWS_PER_TASK)
            .zip(self.rows.clone())
            .for_each(|(row, y)| match channels {
                1 => {
                    let samples = self.picture.color.r.row(y);
                    for (to, &v) in row.iter_mut().zip(samples) {
                        *to = stored(code(v.into(), self.picture.transform, self.max));
                    }
                }
                4 => self.interleave::<4, T>(row, y, &stored),
                _ => self.interleave::<3, T>(row, y, &stored),
            });
    }

    /// The first `N` of red, green, blue and alpha of each pixel of a row, as codes.
    fn interleave<const N: usize, T: Copy>(
        &self,
        row: &mut [T],
        y: usize,
        stored: impl Fn(u16) -> T,
    ) {
        let color = self.picture.primaries().map(|plane| plane.row(y));
        let (shown, looked_up) = (self.picture.shown(), self.looked_up());
        let (pixels, _) = row.as_chunks_mut::<N>();
        for (group, pixels) in pixels.chunks_mut(GROUP).enumerate() {
            let columns = group * GROUP..group * GROUP + pixels.len();
            let group = color.map(|row| &row[columns.clone()]);
            if self.are_empty(group, y, columns.clone()) {
                pixels.as_flattened_mut().fill(stored(0));
            } else if let Some(codes) = looked_up
                && self.are_plain(group, shown, y, columns.clone())
            {
                for (x, pixel) in pixels.iter_mut().enumerate() {
                    let [r, g, b] = group.map(|row| codes.code_of_single(row[x]).into());
                    let codes = [r, g, b, self.max as u16];
                    *pixel = std::array::from_fn(|i| stored(codes[i]));
                }
            } else {
                let codes = self.codes(shown, y, columns);
                for (x, pixel) in pixels.iter_mut().enumerate() {
                    for (sample, codes) in pixel.iter_mut().zip(&codes) {
                        *sample = stored(codes[x]);
                    }
                }
            }
        }
    }

    /// The codes of samples that are opaque and shown as they are, if there is a table of them.
    fn looked_up(&self) -> Option<&'static SrgbCodes> {
        let has_table = self.picture.transform == ViewTransform::Srgb && self.max == max_code(8);
        has_table.then(|| &*SRGB_8)
    }

    /// Whether these columns of a row have neither colour nor alpha.
    fn are_empty(&self, color: [&[f32]; 3], y: usize, columns: Range<usize>) -> bool {
        let alpha = self.alpha.map(|alpha| &alpha.row(y)[columns]);
        let are_zero = |row: &[f32]| row.iter().fold(true, |all, &v| all & (v == 0.0));
        alpha.is_some_and(are_zero) && color.into_iter().all(are_zero)
    }

    /// Whether these columns of a row surely are opaque and shown as they are.
    fn are_plain(
        &self,
        color: [&[f32]; 3],
        shown: Option<Shown>,
        y: usize,
        columns: Range<usize>,
    ) -> bool {
        let alpha = self.alpha.map(|alpha| &alpha.row(y)[columns.clone()]);
        let is_opaque = alpha.is_none_or(|row| row.iter().fold(true, |all, &a| all & (a == 1.0)));
        is_opaque && shown.is_none_or(|shown| shown.leaves(color, y, columns))
    }

    /// Red, green, blue and alpha of these columns of a row, as codes.
    fn codes(&self, shown: Option<Shown>, y: usize, columns: Range<usize>) -> [[u16; GROUP]; 4] {
        let (transform, max) = (self.picture.transform, self.max);
        let of = |color: [&Plane; 3]| straight(color, self.alpha, y, columns.clone(), max);
        let (mut color, alpha) = of(self.picture.primaries());
        if let Some(shown) = shown {
            color = shown.group(&color, |ColorPlanes { r, g, b }| of([r, g, b]).0);
        }
        let mut codes = [[max as u16; GROUP]; 4];
        let of_color = color.iter().map(|channel| (channel, transform));
        let of_alpha = self.alpha.map(|_| (&alpha, ViewTransform::None));
        for (codes, (numbers, transform)) in codes.iter_mut().zip(of_color.chain(of_alpha)) {
            for (stored, &v) in codes.iter_mut().zip(numbers) {
                *stored = code(v, transform, max);
            }
        }
        codes
    }
}
