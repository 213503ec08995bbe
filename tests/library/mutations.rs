//! Small files of pictures and numbers, whole and damaged: an answer or one line, soon, in little memory.

use crate::common::damage::Dice;
use crate::common::program::fixture;
use image::{DynamicImage, ImageFormat, RgbImage};
use relievo::io::photo::Photo;
use std::io::{Cursor, Write};
use std::time::{Duration, Instant};
use tiff::encoder::{TiffEncoder, colortype};
use zip::write::SimpleFileOptions;

const SIZE: [usize; 2] = [7, 5];

/// Longest time for one of these files.
const MOST_TIME: Duration = Duration::from_secs(5);
fn npy(descr: &str, shape: &str, bytes: usize) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.bytes());
    file.extend((0..bytes).map(|i| (i * 37) as u8));
    file
}

/// A TIFF of 7 x 5 pixels of three channels, of 8 bits, stored one after another or together; signed by format 2.
fn planar_tiff(is_planar: bool, format: u16, compression: u16) -> Vec<u8> {
    let [width, height] = SIZE.map(|side| side as u32);
    let (count, plane) = (if is_planar { 3 } else { 1 }, width * height);
    // Samples, then offsets and lengths of strips and bits of channels, then the directory.
    let mut file = b"II\x2a\0".to_vec();
    let lists = 8 + 3 * plane + 1;
    let directory = lists + 8 * count + 6;
    file.extend(directory.to_le_bytes());
    file.extend((0..3 * plane + 1).map(|i| i as u8));
    let strip = 3 * plane / count;
    file.extend((0..count).flat_map(|i| (8 + i * strip).to_le_bytes()));
    file.extend((0..count).flat_map(|_| strip.to_le_bytes()));
    file.extend([8, 0, 8, 0, 8, 0]);
    let list = |at: u32, one: u32| if count == 1 { one } else { at };
    let entries: [(u16, u16, u32, u32); 11] = [
        (256, 4, 1, width),
        (257, 4, 1, height),
        (258, 3, 3, lists + 8 * count),
        (259, 3, 1, compression.into()),
        (262, 3, 1, 2),
        (273, 4, count, list(lists, 8)),
        (277, 3, 1, 3),
        (278, 4, 1, height),
        (279, 4, count, list(lists + 4 * count, strip)),
        (284, 3, 1, if is_planar { 2 } else { 1 }),
        (339, 3, 1, format.into()),
    ];
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend([tag, kind].map(u16::to_le_bytes).as_flattened());
        file.extend([count, value].map(u32::to_le_bytes).as_flattened());
    }
    file.extend([0; 4]);
    file
}

/// An archive of an array as it is.
fn npz(name: &str, array: &[u8]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    archive.start_file(name, stored).unwrap();
    archive.write_all(array).unwrap();
    archive.finish().unwrap().into_inner()
}

/// Files of all kinds by their names, each of which is read.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let [width, height] = SIZE.map(|side| side as u32);
    let pixel = |x: u32, y: u32| image::Rgb([(30 * x) as u8, (40 * y) as u8, 200]);
    let picture = DynamicImage::ImageRgb8(RgbImage::from_fn(width, height, pixel));
    let encoded = |format: ImageFormat| {
        let mut file = Cursor::new(Vec::new());
        picture.write_to(&mut file, format).unwrap();
        file.into_inner()
    };
    let mut pfm = b"PF\n7 5\n-1.0\n".to_vec();
    pfm.extend((0..3 * 35).flat_map(|i| (i as f32).to_le_bytes()));
    let mut floats = Cursor::new(Vec::new());
    let numbers: Vec<f32> = (0..35).map(|i| i as f32).collect();
    let mut encoder = TiffEncoder::new_big(&mut floats).unwrap();
    type Floats = colortype::Gray32Float;
    encoder
        .write_image::<Floats>(width, height, &numbers)
        .unwrap();
    let mut signed = Cursor::new(Vec::new());
    let numbers: Vec<i16> = (0..35).map(|i| 100 - 20 * i).collect();
    let encoder = TiffEncoder::new(&mut signed).unwrap();
    let mut encoder = encoder.with_compression(tiff::encoder::Compression::Lzw);
    type Signed = colortype::GrayI16;
    encoder
        .write_image::<Signed>(width, height, &numbers)
        .unwrap();
    let estimated = std::fs::read(fixture("estimated.npz")).unwrap();
    vec![
        ("a.npy", npy("<f4", "(5, 7, 3)", 420)),
        ("b.npy", npy(">i2", "(1, 5, 7)", 70)),
        ("c.npz", npz("depth.npy", &npy("<f8", "(5, 7)", 280))),
        ("d.npz/depth", estimated),
        ("e.pfm", pfm),
        ("f.tif", floats.into_inner()),
        ("g.tif", signed.into_inner()),
        ("h.tif", planar_tiff(true, 2, 1)),
        ("i.tif", encoded(ImageFormat::Tiff)),
        ("j.tga", encoded(ImageFormat::Tga)),
        ("k.webp", encoded(ImageFormat::WebP)),
        ("l.bmp", encoded(ImageFormat::Bmp)),
        ("m.ppm", encoded(ImageFormat::Pnm)),
    ]
}

/// One to four changes: bytes, extreme numbers, a piece left out or repeated, an early end. Most hit the first bytes, where
/// headers are, or the last.
fn mutate(file: &mut Vec<u8>, noise: &mut Dice) {
    for _ in 0..=noise.below(4) {
        let end = file.len();
        let at = match noise.below(4) {
            0 => noise.below(end),
            1 => end.saturating_sub(1 + noise.below(100)),
            _ => noise.below(end.min(160)),
        };
        #[rustfmt::skip]
        let extremes: [&[u8]; 6] = [
            &[0xff; 4], &[0; 4], &[0xff, 0xff, 0xff, 0x7f], &[0x7f, 0xff], &[1, 0], b"9999999",
        ];
        let to = (at + noise.below(16)).min(end);
        let piece = at.min(to)..to;
        match noise.below(8) {
            0 => file.truncate(at),
            1 => drop(file.drain(piece)),
            2 => {
                let piece = file[piece].to_vec();
                file.splice(at..at, piece);
            }
            3 | 4 => {
                let extreme = extremes[noise.below(extremes.len())];
                let own = file.iter_mut().skip(at).zip(extreme);
                own.for_each(|(byte, extreme)| *byte = *extreme);
            }
            _ => {
                if let Some(byte) = file.get_mut(at) {
                    *byte = noise.below(256) as u8;
                }
            }
        }
    }
}

#[test]
fn damaged_pictures_and_numbers_are_errors_of_one_line() {
    let (files, mut noise) = (files(), Dice(0x9e37_79b9_7f4a_7c15));
    let desk = tempfile::tempdir().unwrap();
    for round in 0..520 {
        let (name, whole) = &files[round % files.len()];
        let path = desk.path().join(name);
        let file = desk.path().join(name.split('/').next().unwrap());
        let mut bytes = whole.clone();
        if round >= files.len() {
            mutate(&mut bytes, &mut noise);
        }
        std::fs::write(&file, &bytes).unwrap();
        let began = Instant::now();
        let read = Photo::read(&path);
        assert!(began.elapsed() < MOST_TIME, "{round}: {name}");
        let is_whole = round < files.len();
        match read {
            Ok(photo) => assert!(!is_whole || photo.width >= SIZE[0]),
            Err(error) => {
                let said = error.to_string();
                assert!(!is_whole && !said.contains('\n'), "{round}: {said}");
                let is_ours = ["npy", "npz", "pfm"].iter().any(|own| name.contains(own));
                let contradicts = said.contains("contradicts itself");
                assert!(!(is_ours && contradicts), "{round}: {said}");
            }
        }
    }
}

#[test]
fn channels_that_are_stored_apart_are_read_together() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("in.tif");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        Photo::read(&path)
    };
    // Sample i is i / 255, or i where signed: 35 c + 7 y + x of channels that are apart, 3 (7 y + x) + c of others.
    for (is_planar, format, expected) in [
        (true, 1, [34, 69, 104]),
        (true, 2, [34, 69, 104]),
        (false, 1, [102, 103, 104]),
        (false, 2, [102, 103, 104]),
    ] {
        let photo = read(&planar_tiff(is_planar, format, 1)).unwrap();
        let scale = if format == 1 { 255.0 } else { 1.0 };
        let last = photo.channels.iter().map(|plane| scale * plane.at(6, 4));
        let last: Vec<_> = last.map(|v| v.round() as i32).collect();
        assert_eq!(last, expected);
    }
    let refused = read(&planar_tiff(false, 1, 34_925)).unwrap_err();
    let said = refused.to_string();
    let is_told = said.contains("LZMA") && said.contains("COMPRESS=DEFLATE");
    assert!(is_told, "{said}");
}

#[test]
fn textures_of_graphics_devices_are_named_with_a_converter() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("in.png");
    for (mark, converter) in [
        (&b"DDS \x7c\0\0\0"[..], "texconv"),
        (b"\xabKTX 20\xbb\r\n\x1a\n", "ktx extract"),
        (b"\xabKTX 11\xbb\r\n\x1a\n", "ktx2ktx2"),
    ] {
        std::fs::write(&path, mark).unwrap();
        let said = Photo::read(&path).unwrap_err().to_string();
        assert!(said.contains(converter) && !said.contains('\n'), "{said}");
    }
}
