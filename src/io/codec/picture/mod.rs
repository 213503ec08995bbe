//! Writing pictures of the everyday kinds: PNG, JPEG, TIFF and Radiance HDR.

mod agx;
#[cfg(feature = "cli")]
mod arrays;
mod codes;
mod display;
mod encoding;
mod exposure;
mod filmic;
mod format;
mod gathered;
mod scale_bar;
#[cfg(feature = "cli")]
mod small;
mod stored;
mod straight;
#[cfg(feature = "cli")]
mod whites;

#[cfg(feature = "cli")]
pub(crate) use arrays::{Array, ArrayFormat};
pub use display::{Bright, Display};
pub use encoding::Encoding;
pub(crate) use exposure::Brightness;
pub(crate) use format::is_picture_name;
pub use format::{Picture, PictureFormat, ViewTransform};
pub(crate) use gathered::Gathered;
#[cfg(feature = "view")]
pub(crate) use small::small;
#[cfg(feature = "cli")]
pub(crate) use small::small_png;
#[cfg(feature = "cli")]
pub(crate) use whites::Whites;

use crate::error::Result;
use crate::io::photo::max_code;
use gathered::CodedRows;
use std::io::{Seek, Write};
use std::path::Path;

/// Writes a picture without metadata. Values are clipped to 0..1 and NaN becomes 0; `target` is only named in errors.
///
/// # Errors
/// Any [`Error`] of writing.
///
/// # Panics
/// If planes differ in size, `bits` is none of 1, 8 and 16, or it is 1 of a picture in colour or with alpha.
pub fn write_picture(
    w: &mut (impl Write + Seek),
    target: &Path,
    format: PictureFormat,
    picture: &Picture,
) -> Result<()> {
    write_picture_as(w, target, format, picture, &Encoding::default())
}

/// Writes a picture. Values are clipped to 0..1 and NaN becomes 0; `target` is only named in errors.
///
/// Where alpha is stored, colour is divided by it. A coloured pixel whose alpha would be stored as 0 (a glow over
/// nothing) gets the smallest alpha that holds that colour. An alpha of 1 everywhere is left out.
///
/// # Errors
/// Any [`Error`] of writing.
///
/// # Panics
/// If planes differ in size, `bits` is none of 1, 8 and 16, or it is 1 of a picture in colour or with alpha.
pub(crate) fn write_picture_as(
    w: &mut (impl Write + Seek),
    target: &Path,
    format: PictureFormat,
    picture: &Picture,
    encoding: &Encoding,
) -> Result<()> {
    let size = [picture.color.r.width(), picture.color.r.height()];
    let mut gathered = Gathered::new(format, size, picture);
    gathered.push(picture, 0..size[1]);
    gathered.write(w, target, encoding)
}

/// The same as [`pixels`], in 16 bits.
#[cfg(feature = "cli")]
pub(crate) fn pixels_16(picture: &Picture) -> Vec<[u16; 4]> {
    let samples = codes(picture, 16, u16::to_ne_bytes);
    let codes: Vec<u16> = samples
        .as_chunks()
        .0
        .iter()
        .map(|&code| u16::from_ne_bytes(code))
        .collect();
    codes.as_chunks().0.to_vec()
}

/// Red, green, blue and alpha of each pixel in 8 bits, as in a PNG of the picture; opaque without alpha.
///
/// # Panics
/// If planes differ in size.
pub fn pixels(picture: &Picture) -> Vec<[u8; 4]> {
    codes(picture, 8, |code| [code as u8])
        .as_chunks()
        .0
        .to_vec()
}

fn codes<const BYTES: usize>(
    picture: &Picture,
    bits: u8,
    code: impl Fn(u16) -> [u8; BYTES] + Sync,
) -> Vec<u8> {
    let part = CodedRows {
        picture,
        alpha: picture.alpha,
        rows: 0..picture.color.r.height(),
        max: max_code(bits),
    };
    let mut samples = Vec::new();
    part.add_to(&mut samples, 4, code);
    samples
}

#[cfg(test)]
mod tests {
    use super::codes::{SRGB_8, computed_code};
    use super::*;
    use crate::frame::{ColorPlanes, Plane};
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
                    grey,
                    bits,
                    ..Picture::of(&color, ViewTransform::Srgb)
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
        for &least in &SRGB_8.least[..255] {
            for v in [least.next_down(), least, least.next_up()] {
                assert_eq!(u16::from(SRGB_8.code(v)), computed(v), "{v:e}");
            }
        }
        // A step that hits no part and no code evenly.
        for step in 0..200_000 {
            let v = f64::from(step) * 5.17e-6;
            assert_eq!(u16::from(SRGB_8.code(v)), computed(v), "{v}");
        }
        for odd in [f64::NAN, -1.0, -0.0, 1.0, 2.0, f64::INFINITY, 1e-310] {
            assert_eq!(u16::from(SRGB_8.code(odd)), computed(odd), "{odd}");
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
                bits,
                ..Picture::of(&color, ViewTransform::Srgb)
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
            bits: 16,
            ..Picture::of(&color, ViewTransform::None)
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
            alpha: Some(&alpha),
            bits: 16,
            ..Picture::of(&color, ViewTransform::None)
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
    fn pixels_that_are_stored_together_are_as_if_alone() {
        // Empty; opaque and dark; beside one that is not opaque; up to beyond white; and numbers without a meaning.
        let odd = [f32::NAN, f32::INFINITY, -1.0, -0.0];
        let sample = |i: usize| match i {
            0..16 => 0.0,
            16..48 => 0.024 * (i - 16) as f32,
            48..96 => 0.03 * (i - 48) as f32,
            _ => odd[i % 4],
        };
        let color = grey(100, 1, (0..100).map(sample).collect());
        let before = grey(100, 1, (0..100).map(|i| sample(99 - i)).collect());
        let alpha = (0..100).map(|i| match i {
            0..16 => 0.0,
            40 => 0.5,
            _ => 1.0,
        });
        let alpha = Plane::from_samples(100, 1, alpha.collect());
        let single = |plane: &Plane, x: usize| Plane::filled(1, 1, plane.at(x, 0));
        let brights = [
            Bright::Clipped,
            Bright::Compressed,
            Bright::ChangedFrom(&before),
        ];
        for (bright, exposure) in brights.into_iter().flat_map(|b| [(b, 0.0), (b, 0.5)]) {
            for alpha in [None, Some(&alpha)] {
                let picture = Picture {
                    alpha,
                    display: Display { exposure, bright },
                    ..Picture::of(&color, ViewTransform::Srgb)
                };
                let together = pixels(&picture);
                for (x, together) in together.into_iter().enumerate() {
                    let color = grey(1, 1, vec![color.r.at(x, 0)]);
                    let before = grey(1, 1, vec![before.r.at(x, 0)]);
                    let alpha = alpha.map(|alpha| single(alpha, x));
                    let bright = match bright {
                        Bright::ChangedFrom(_) => Bright::ChangedFrom(&before),
                        other => other,
                    };
                    let alone = pixels(&Picture {
                        color: &color,
                        alpha: alpha.as_ref(),
                        display: Display { exposure, bright },
                        ..picture
                    });
                    assert_eq!(alone, [together], "{x} {bright:?}");
                }
            }
        }
    }

    #[test]
    fn full_alpha_is_left_out() {
        let color = grey(2, 1, vec![0.0, 1.0]);
        let alpha = Plane::filled(2, 1, 1.0);
        let picture = Picture {
            alpha: Some(&alpha),
            ..Picture::of(&color, ViewTransform::Srgb)
        };
        assert!(round_trip(PictureFormat::Png, &picture).alpha.is_none());
    }

    #[test]
    fn jpeg_and_hdr_are_readable() {
        let color = grey(16, 16, vec![0.25; 256]);
        let picture = Picture {
            bits: 16,
            ..Picture::of(&color, ViewTransform::Srgb)
        };
        let jpeg = round_trip(PictureFormat::Jpeg, &picture);
        assert_eq!((jpeg.bits, jpeg.is_float), (8, false));
        assert!((jpeg.to_linear()[0].at(3, 3) - 0.25).abs() < 0.01);
        let hdr = round_trip(PictureFormat::Hdr, &picture);
        assert!(hdr.is_float);
        assert!((hdr.to_linear()[0].at(3, 3) - 0.25).abs() < 0.01);
    }
}
