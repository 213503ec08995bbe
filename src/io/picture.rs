//! Writing pictures of the everyday kinds: PNG, JPEG, TIFF and Radiance HDR.

use super::photo::{max_code, one_line, unsupported};
use super::srgb;
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane};
use image::{ExtendedColorType, ImageEncoder, ImageError};
use rayon::prelude::*;
use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;
use std::sync::LazyLock;

/// Quality of written JPEG files, of 100.
const JPEG_QUALITY: u8 = 95;

/// The kinds of pictures that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// PNG, 8 or 16 bits, with alpha.
    Png,
    /// JPEG, 8 bits, over black.
    Jpeg,
    /// TIFF, 8 or 16 bits, with alpha.
    Tiff,
    /// Radiance HDR, linear, over black.
    Hdr,
}

impl PictureFormat {
    /// The format that the extension of `path` stands for.
    pub fn of_path(path: &Path) -> Option<PictureFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(PictureFormat::Png),
            "jpg" | "jpeg" => Some(PictureFormat::Jpeg),
            "tif" | "tiff" => Some(PictureFormat::Tiff),
            "hdr" => Some(PictureFormat::Hdr),
            _ => None,
        }
    }

    fn holds_alpha(self) -> bool {
        matches!(self, PictureFormat::Png | PictureFormat::Tiff)
    }
}

/// How linear values become stored ones in integer formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ViewTransform {
    /// The sRGB curve: for pictures to be looked at.
    Srgb,
    /// None: for normals, masks and other data.
    None,
}

/// A picture to be written.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Linear colour, multiplied by alpha.
    pub color: &'a ColorPlanes,
    /// Coverage, 0..1.
    pub alpha: Option<&'a Plane>,
    /// Whether it is grey, its planes alike: without alpha PNG, JPEG and TIFF then hold one sample per pixel.
    pub grey: bool,
    /// Bits per sample, 8 or 16; JPEG always has 8, HDR its own.
    pub bits: u8,
    /// How values are encoded; HDR is always linear.
    pub transform: ViewTransform,
}

impl<'a> Picture<'a> {
    /// Its planes: three of colour, and alpha where it has one.
    pub(crate) fn planes(&self) -> Vec<&'a Plane> {
        let ColorPlanes { r, g, b } = self.color;
        [r, g, b].into_iter().chain(self.alpha).collect()
    }
}

/// Writes a picture. Values are clipped to 0..1 and NaN becomes 0; `target` is only named in errors.
///
/// Where alpha is stored, colour is divided by it. A pixel whose alpha would be stored as 0 although
/// it has colour (a glow over nothing) gets the alpha that just holds that colour. An alpha of 1
/// everywhere is left out.
///
/// # Errors
/// Any [`Error`] of writing.
///
/// # Panics
/// If planes differ in size, or `bits` is neither 8 nor 16.
pub fn write_picture(
    w: &mut (impl Write + Seek),
    target: &Path,
    format: PictureFormat,
    picture: &Picture,
) -> Result<()> {
    let size = [picture.color.r.width(), picture.color.r.height()];
    let mut gathered = Gathered::new(format, size, picture);
    gathered.push(picture, 0..size[1]);
    gathered.write(w, target)
}

/// A picture of which the stored samples are gathered, some rows at a time, before it is written.
#[derive(Debug, Clone)]
pub struct Gathered {
    format: PictureFormat,
    size: [usize; 2],
    /// Samples of each pixel: 1, 3, or 4 with alpha.
    channels: usize,
    grey: bool,
    /// Whether alpha was 1 everywhere so far.
    is_opaque: bool,
    samples: Samples,
}

/// Samples as files hold them, those of a pixel side by side.
#[derive(Debug, Clone)]
enum Samples {
    Narrow(Vec<u8>),
    /// Of 16 bits, in this machine's order of bytes.
    Wide(Vec<[u8; 2]>),
    Float(Vec<image::Rgb<f32>>),
}

impl Gathered {
    /// A picture of `size`, columns and rows, of which all parts are like `part`: grey or not, with alpha or without, of
    /// as many bits.
    ///
    /// # Panics
    /// If its `bits` are neither 8 nor 16.
    pub fn new(format: PictureFormat, size: [usize; 2], part: &Picture) -> Self {
        assert!([8, 16].contains(&part.bits), "bits must be 8 or 16");
        let channels = match part.alpha {
            Some(_) if format.holds_alpha() => 4,
            _ if part.grey => 1,
            _ => 3,
        };
        let pixels = size[0] * size[1];
        let samples = match (format, part.bits) {
            (PictureFormat::Hdr, _) => Samples::Float(Vec::with_capacity(pixels)),
            (PictureFormat::Jpeg, _) | (_, 8) => {
                Samples::Narrow(Vec::with_capacity(pixels * channels))
            }
            _ => Samples::Wide(Vec::with_capacity(pixels * channels)),
        };
        Self {
            format,
            size,
            channels,
            grey: part.grey,
            is_opaque: true,
            samples,
        }
    }

    /// Bytes that its samples take.
    pub fn bytes(&self) -> u64 {
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

    /// Bytes that encoding takes besides: what is compressed, and samples of 16 bits in another order of bytes.
    pub fn encoding_bytes(&self) -> u64 {
        match self.samples {
            Samples::Wide(_) => 2 * self.bytes(),
            Samples::Narrow(_) => self.bytes(),
            Samples::Float(_) => 0,
        }
    }

    /// Adds the rows `rows` of `part`, below those that were added before.
    ///
    /// # Panics
    /// If planes differ in size, or `part` is not as wide as the picture.
    pub fn push(&mut self, part: &Picture, rows: Range<usize>) {
        let planes = [&part.color.r, &part.color.g, &part.color.b];
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
                    max: max_code(8),
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
    pub fn write(mut self, w: &mut (impl Write + Seek), target: &Path) -> Result<()> {
        if self.channels == 4 && self.is_opaque {
            self.drop_alpha();
        }
        self.encode(w).map_err(|error| match error {
            ImageError::IoError(source) => Error::io(target, "write")(source),
            other => unsupported(
                target,
                &format!("cannot be written ({})", one_line(&other.to_string())),
            ),
        })
    }

    /// Leaves alpha out; of a grey picture all but one sample.
    fn drop_alpha(&mut self) {
        let kept = if self.grey { 1 } else { 3 };
        match &mut self.samples {
            Samples::Narrow(samples) => keep_first(samples, kept),
            Samples::Wide(samples) => keep_first(samples, kept),
            Samples::Float(_) => return,
        }
        self.channels = kept;
    }

    fn encode(&self, w: &mut (impl Write + Seek)) -> image::ImageResult<()> {
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
        let (width, height) = (width as u32, height as u32);
        match self.format {
            PictureFormat::Jpeg => {
                image::codecs::jpeg::JpegEncoder::new_with_quality(w, JPEG_QUALITY)
                    .write_image(bytes, width, height, kind)
            }
            PictureFormat::Tiff => {
                image::codecs::tiff::TiffEncoder::new(w).write_image(bytes, width, height, kind)
            }
            _ => image::codecs::png::PngEncoder::new(w).write_image(bytes, width, height, kind),
        }
    }
}

/// Of every four samples the first few.
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
struct Part<'a> {
    picture: &'a Picture<'a>,
    alpha: Option<&'a Plane>,
    rows: Range<usize>,
    max: u32,
}

impl Part<'_> {
    /// Adds the codes, `channels` of each pixel.
    fn add_to<T: Copy + Default + Send>(
        &self,
        samples: &mut Vec<T>,
        channels: usize,
        stored: impl Fn(u16) -> T + Sync,
    ) {
        let (width, before) = (self.picture.color.r.width(), samples.len());
        samples.resize(before + width * channels * self.rows.len(), T::default());
        let rows = samples[before..].par_chunks_mut((width * channels).max(1));
        rows.zip(self.rows.clone())
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
        let (ColorPlanes { r, g, b }, max) = (self.picture.color, self.max);
        let transform = self.picture.transform;
        let color = r.row(y).iter().zip(g.row(y)).zip(b.row(y));
        let (pixels, _) = row.as_chunks_mut::<N>();
        for (x, (pixel, ((&r, &g), &b))) in pixels.iter_mut().zip(color).enumerate() {
            let color = [r, g, b].map(f64::from);
            let alpha = self.alpha.map(|a| f64::from(a.at(x, y)));
            let (color, alpha) = straight(color, alpha, max);
            let [r, g, b] = color.map(|v| code(v, transform, max));
            let alpha = alpha.map_or(max as u16, |a| code(a, ViewTransform::None, max));
            for (to, code) in pixel.iter_mut().zip([r, g, b, alpha]) {
                *to = stored(code);
            }
        }
    }
}

/// Red, green, blue and alpha of each pixel in 8 bits: what a PNG of them would hold, opaque where there is no alpha.
///
/// # Panics
/// If planes differ in size.
pub fn pixels(picture: &Picture) -> Vec<[u8; 4]> {
    if picture.alpha.is_none() && picture.transform == ViewTransform::Srgb {
        return opaque_pixels(picture.color);
    }
    let part = Part {
        picture,
        alpha: picture.alpha,
        rows: 0..picture.color.r.height(),
        max: max_code(8),
    };
    let mut samples = Vec::new();
    part.add_to(&mut samples, 4, |code| code as u8);
    samples.as_chunks::<4>().0.to_vec()
}

/// The most frequent case, which a window asks for many times a second.
fn opaque_pixels(color: &ColorPlanes) -> Vec<[u8; 4]> {
    let width = color.r.width();
    let mut pixels = vec![[0; 4]; color.r.samples().len()];
    let rows = pixels.par_chunks_mut(width.max(1)).with_min_len(8);
    let codes = &*SRGB_8;
    rows.enumerate().for_each(|(y, row)| {
        let [r, g, b] = [&color.r, &color.g, &color.b].map(|plane| &plane.row(y)[..row.len()]);
        for (x, pixel) in row.iter_mut().enumerate() {
            let [r, g, b] = [r[x], g[x], b[x]].map(|v| codes.code_of_single(v));
            *pixel = [r, g, b, 255];
        }
    });
    pixels
}

/// Colour divided by alpha, and the alpha to be stored.
fn straight(color: [f64; 3], alpha: Option<f64>, max: u32) -> ([f64; 3], Option<f64>) {
    let Some(alpha) = alpha else {
        return (color, None);
    };
    let alpha = clipped(alpha);
    let least = 0.5 / f64::from(max);
    let strongest = color.iter().fold(0.0, |most: f64, &v| most.max(v)).min(1.0);
    let alpha = if alpha < least { strongest } else { alpha };
    match alpha < least {
        true => ([0.0; 3], Some(0.0)),
        false => (color.map(|v| v / alpha), Some(alpha)),
    }
}

fn clipped(v: f64) -> f64 {
    if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }
}

fn code(v: f64, transform: ViewTransform, max: u32) -> u16 {
    match (transform, max) {
        (ViewTransform::Srgb, 255) => SRGB_8.code(v),
        _ => computed_code(v, transform, max),
    }
}

/// The codes of the sRGB curve in 8 bits, looked up: a power for each sample takes longer than all else.
struct SrgbCodes {
    /// The least value of each code above 0.
    least: [f64; 255],
    /// The least single number of each code above 0, and what none reaches.
    least_single: [f32; 256],
    /// The code at the beginning of each of so many equal parts of 0..1, and of those beyond.
    at: [u8; 2 * SRGB_PARTS],
}

/// Many enough that a part holds no more than two codes.
const SRGB_PARTS: usize = 4096;

static SRGB_8: LazyLock<SrgbCodes> = LazyLock::new(SrgbCodes::new);

impl SrgbCodes {
    fn new() -> Self {
        let computed = |v| computed_code(v, ViewTransform::Srgb, 255);
        let least = std::array::from_fn(|below| {
            // Numbers above 0 are in the order of their bits.
            let (mut lower, mut upper) = (0, 1.0_f64.to_bits());
            while lower < upper {
                let middle = lower.midpoint(upper);
                match usize::from(computed(f64::from_bits(middle))) > below {
                    true => upper = middle,
                    false => lower = middle + 1,
                }
            }
            f64::from_bits(lower)
        });
        let at = std::array::from_fn(|part| computed(part as f64 / SRGB_PARTS as f64) as u8);
        let least_single = std::array::from_fn(|below| match least.get(below) {
            Some(&least) => {
                let single = least as f32;
                let is_below = f64::from(single) < least;
                if is_below { single.next_up() } else { single }
            }
            None => f32::INFINITY,
        });
        Self {
            least,
            least_single,
            at,
        }
    }

    /// The code of a single number. Codes are farther apart than parts: one step is enough.
    #[inline]
    fn code_of_single(&self, v: f32) -> u8 {
        // As an index NaN is 0, and it reaches no code; the mask only spares a check.
        let v = v.clamp(0.0, 1.0);
        let code = self.at[(v * SRGB_PARTS as f32) as usize & (2 * SRGB_PARTS - 1)];
        code + u8::from(v >= self.least_single[usize::from(code)])
    }

    fn code(&self, v: f64) -> u16 {
        let v = clipped(v);
        let mut code = self.at[(v * SRGB_PARTS as f64) as usize];
        while let Some(&least) = self.least.get(usize::from(code))
            && v >= least
        {
            code += 1;
        }
        code.into()
    }
}

fn computed_code(v: f64, transform: ViewTransform, max: u32) -> u16 {
    let encoded = match transform {
        ViewTransform::Srgb => srgb::encoded(clipped(v)),
        ViewTransform::None => clipped(v),
    };
    (encoded * f64::from(max)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::photo::Photo;
    use std::io::Cursor;

    fn grey(width: usize, height: usize, samples: Vec<f32>) -> ColorPlanes {
        let plane = Plane::from_samples(width, height, samples);
        ColorPlanes {
            r: plane.clone(),
            g: plane.clone(),
            b: plane,
        }
    }

    fn round_trip(format: PictureFormat, picture: &Picture) -> Photo {
        let mut file = Cursor::new(Vec::new());
        let name = Path::new("test");
        write_picture(&mut file, name, format, picture).unwrap();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("picture");
        std::fs::write(&path, file.into_inner()).unwrap();
        Photo::read(&path).unwrap()
    }

    #[test]
    fn a_grey_picture_holds_one_sample_per_pixel_and_looks_the_same() {
        let color = grey(64, 48, (0..64 * 48).map(|i| i as f32 / 3072.0).collect());
        for format in [PictureFormat::Png, PictureFormat::Tiff] {
            for bits in [8, 16] {
                let of = |grey| Picture {
                    color: &color,
                    alpha: None,
                    grey,
                    bits,
                    transform: ViewTransform::Srgb,
                };
                let size = |picture: &Picture| {
                    let mut file = Cursor::new(Vec::new());
                    write_picture(&mut file, Path::new("test"), format, picture).unwrap();
                    file.into_inner().len()
                };
                assert!(size(&of(true)) < size(&of(false)), "{format:?} {bits}");
                let [one, three] = [true, false].map(|grey| round_trip(format, &of(grey)));
                assert_eq!(
                    one.to_linear()[0],
                    three.to_linear()[0],
                    "{format:?} {bits}"
                );
                // With alpha there are four samples either way.
                let half = Plane::filled(64, 48, 0.5);
                let with_alpha = |grey| Picture {
                    alpha: Some(&half),
                    ..of(grey)
                };
                assert_eq!(size(&with_alpha(true)), size(&with_alpha(false)));
            }
        }
    }

    #[test]
    fn codes_that_are_looked_up_are_those_computed() {
        let computed = |v| computed_code(v, ViewTransform::Srgb, 255);
        for &least in &SRGB_8.least {
            for v in [least.next_down(), least, least.next_up()] {
                assert_eq!(SRGB_8.code(v), computed(v), "{v:e}");
            }
        }
        for &least in &SRGB_8.least_single[..255] {
            for v in [least.next_down(), least, least.next_up()] {
                let expected = computed(f64::from(v));
                assert_eq!(u16::from(SRGB_8.code_of_single(v)), expected, "{v:e}");
            }
        }
        // A step that hits no part and no code evenly.
        for step in 0..200_000 {
            let v = f64::from(step) * 5.17e-6;
            assert_eq!(SRGB_8.code(v), computed(v), "{v}");
            let single = v as f32;
            let expected = computed(f64::from(single));
            assert_eq!(
                u16::from(SRGB_8.code_of_single(single)),
                expected,
                "{single}"
            );
        }
        for odd in [f64::NAN, -1.0, -0.0, 1.0, 2.0, f64::INFINITY, 1e-310] {
            assert_eq!(SRGB_8.code(odd), computed(odd), "{odd}");
            let single = SRGB_8.code_of_single(odd as f32);
            assert_eq!(u16::from(single), computed(f64::from(odd as f32)), "{odd}");
        }
    }

    #[test]
    fn every_code_survives_the_way_to_linear_and_back() {
        for bits in [8, 16] {
            let count = 1usize << bits;
            let codes: Vec<f32> = (0..count)
                .map(|c| (c as f64 / (count - 1) as f64) as f32)
                .collect();
            let photo = Photo {
                width: 256,
                height: count / 256,
                bits,
                is_float: false,
                channels: vec![Plane::from_samples(256, count / 256, codes)],
                alpha: None,
            };
            let linear = photo.to_linear().remove(0);
            let color = grey(256, count / 256, linear.samples().to_vec());
            let picture = Picture {
                color: &color,
                alpha: None,
                grey: false,
                bits,
                transform: ViewTransform::Srgb,
            };
            for format in [PictureFormat::Png, PictureFormat::Tiff] {
                let again = round_trip(format, &picture);
                assert_eq!(again.bits, bits);
                for plane in &again.channels {
                    assert_eq!(plane, &photo.channels[0], "{format:?} {bits}");
                }
            }
        }
    }

    #[test]
    fn raw_codes_survive_without_a_transform() {
        let codes: Vec<f32> = (0..65536).map(|c| f32::from(c as u16) / 65535.0).collect();
        let color = grey(256, 256, codes.clone());
        let picture = Picture {
            color: &color,
            alpha: None,
            grey: false,
            bits: 16,
            transform: ViewTransform::None,
        };
        let again = round_trip(PictureFormat::Png, &picture);
        assert_eq!(again.channels[0].samples(), codes);
    }

    #[test]
    fn alpha_is_stored_straight_and_glow_is_kept() {
        // Half covered white; nothing; glow over nothing; NaN.
        let color = grey(4, 1, vec![0.5, 0.0, 0.25, f32::NAN]);
        let alpha = Plane::from_samples(4, 1, vec![0.5, 0.0, 0.0, 1.0]);
        let picture = Picture {
            color: &color,
            alpha: Some(&alpha),
            grey: false,
            bits: 16,
            transform: ViewTransform::None,
        };
        for format in [PictureFormat::Png, PictureFormat::Tiff] {
            let photo = round_trip(format, &picture);
            let stored = photo.alpha.unwrap();
            assert_eq!(photo.channels[0].samples(), [1.0, 0.0, 1.0, 0.0]);
            for (stored, expected) in stored.samples().iter().zip([0.5, 0.0, 0.25, 1.0]) {
                assert!((stored - expected).abs() < 1e-5, "{stored} {expected}");
            }
        }
    }

    #[test]
    fn full_alpha_is_left_out() {
        let color = grey(2, 1, vec![0.0, 1.0]);
        let alpha = Plane::filled(2, 1, 1.0);
        let picture = Picture {
            color: &color,
            alpha: Some(&alpha),
            grey: false,
            bits: 8,
            transform: ViewTransform::Srgb,
        };
        assert!(round_trip(PictureFormat::Png, &picture).alpha.is_none());
    }

    #[test]
    fn jpeg_and_hdr_are_readable() {
        let color = grey(16, 16, vec![0.25; 256]);
        let picture = Picture {
            color: &color,
            alpha: None,
            grey: false,
            bits: 16,
            transform: ViewTransform::Srgb,
        };
        let jpeg = round_trip(PictureFormat::Jpeg, &picture);
        assert_eq!((jpeg.bits, jpeg.is_float), (8, false));
        assert!((jpeg.to_linear()[0].at(3, 3) - 0.25).abs() < 0.01);
        let hdr = round_trip(PictureFormat::Hdr, &picture);
        assert!(hdr.is_float);
        assert!((hdr.to_linear()[0].at(3, 3) - 0.25).abs() < 0.01);
    }
}
