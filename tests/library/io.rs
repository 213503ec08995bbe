//! Files in and out: round trips, copies with a part added, and files with false claims.

use crate::common::real_files::real;
use crate::common::{bits, default_but, files, places};
use glam::DVec3;
use relievo::frame::{Plane, Window};
use relievo::io::exr::{
    ChannelId, ExrFile, Limits, OutputChannel, OutputPart, OutputType, PartWriter, write_results,
};
use std::io::Cursor;
use std::path::{Path, PathBuf};

fn open(path: &Path) -> ExrFile {
    ExrFile::open(path, &Limits::default()).unwrap()
}

fn read_all(file: &ExrFile) -> Vec<Plane> {
    let ids: Vec<ChannelId> = file.channel_ids().collect();
    file.read_channels(&ids).unwrap()
}

fn part<'a>(
    name: &str,
    window: Window,
    planes: &[(&str, &'a Plane, OutputType)],
) -> OutputPart<'a> {
    let channel = |&(name, plane, sample_type): &(&str, &'a Plane, OutputType)| OutputChannel {
        name: name.into(),
        plane,
        sample_type,
    };
    OutputPart {
        name: name.into(),
        data_window: window,
        display_window: Window::from_size(40, 30),
        pixel_aspect: 1.5,
        channels: planes.iter().map(channel).collect(),
        attributes: vec![("software".into(), "relievo test".into())],
        chromaticities: Some([0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]),
        compression: Default::default(),
    }
}

fn written(part: &OutputPart) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    write_results(&mut file, Path::new("test"), part).unwrap();
    file.into_inner()
}

fn appended(input: &ExrFile, part: &OutputPart) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let writer = PartWriter::append(input, &mut file, Path::new("test"), &part.description());
    writer.unwrap().write(part).unwrap();
    file.into_inner()
}

/// A small file with awkward content: overscan, odd names, NaN samples.
fn awkward() -> (Plane, Plane, Vec<u8>) {
    let mut float = Plane::from_fn(37, 35, |x, y| (x as f32 - 7.3) * y as f32);
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0];
    float.samples_mut()[..4].copy_from_slice(&wild);
    float.samples_mut()[4] = f32::MIN_POSITIVE / 8.0;
    let half = float.map(|v| half::f16::from_f32(v.clamp(-60000.0, 60000.0)).to_f32());
    let long = "a name that is a good deal longer than thirty-one bytes.Ünïcode";
    let channels = [
        ("zebra.Z", &float, OutputType::Float),
        (long, &float, OutputType::Float),
        ("N.Y", &half, OutputType::Half),
    ];
    let bytes = written(&part("awkward", Window::at(-11, -7, 37, 35), &channels));
    (float, half, bytes)
}

/// A folder for bytes, to be read as a file.
struct Saved(tempfile::TempDir);

impl Saved {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn of(&self, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join("saved.exr");
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

#[test]
fn what_is_written_is_read() {
    let (float, half, bytes) = awkward();
    let saved = Saved::new();
    let file = open(&saved.of(&bytes));
    assert_eq!(file.parts.len(), 1);
    assert_eq!(file.parts[0].window, Window::at(-11, -7, 37, 35));
    assert_eq!(file.display_window, Window::from_size(40, 30));
    assert_eq!(file.pixel_aspect, 1.5);
    assert_eq!(file.parts[0].compression, "zip");
    assert_eq!(file.attributes["software"], "relievo test");

    let channels = &file.parts[0].channels;
    assert_eq!(channels[0].name, "N.Y");
    assert!(channels[1].name.ends_with("Ünïcode"));
    let planes = read_all(&file);
    assert_eq!(bits(&planes[0]), bits(&half));
    assert_eq!(bits(&planes[1]), bits(&float));
    assert_eq!(bits(&planes[2]), bits(&float));
    // Writing is deterministic.
    assert_eq!(bytes, awkward().2);
}

#[test]
fn channels_come_in_the_order_asked_for() {
    let (float, half, bytes) = awkward();
    let ids = [2, 0, 2].map(|channel| ChannelId { part: 0, channel });
    let saved = Saved::new();
    let planes = open(&saved.of(&bytes)).read_channels(&ids).unwrap();
    assert_eq!(bits(&planes[0]), bits(&float));
    assert_eq!(bits(&planes[1]), bits(&half));
    assert_eq!(bits(&planes[2]), bits(&float));
}

#[test]
fn a_limit_refuses_before_anything_is_read() {
    let (_, _, bytes) = awkward();
    let saved = Saved::new();
    let path = saved.of(&bytes);
    let few_pixels = default_but(|limits: &mut Limits| limits.max_pixels = 1000);
    let few_bytes = default_but(|limits: &mut Limits| limits.max_bytes = 1000);
    for limits in [few_pixels, few_bytes] {
        let file = ExrFile::open(&path, &limits).unwrap();
        let ids: Vec<ChannelId> = file.channel_ids().collect();
        assert!(file.read_channels(&ids).is_err());
    }
}

#[test]
fn a_part_added_leaves_the_rest_as_it_was() {
    for name in [
        "renders/suzanne_640_half_dwaa.exr",
        "renders/cloth_640_mixed_piz.exr",
        "renders/tiny_bunny_64_multipart.exr",
        "renders/suzanne_480_allpasses_b50_multipart_dwaa.exr",
        "conformance/multires/ColorCodedLevels.exr",
        "conformance/multires/MirrorPattern.exr",
        "conformance/structure/lineOrder_decreasing.exr",
        "conformance/structure/cryptoasset.exr",
        "conformance/structure/parts.exr",
        "conformance/structure/tiny-az.exr",
        "conformance/structure/tiled_with_scanlineimage_type.exr",
        "conformance/testimages/BrightRingsNanInf.exr",
        "conformance/displaywindow/t16.exr",
    ] {
        let Some(path) = real(name) else { return };
        check_append(&path);
    }
}

fn check_append(path: &Path) {
    let input = open(path);
    let window = Window::at(-3, 5, 21, 33);
    let plane = Plane::from_fn(21, 33, |x, y| x as f32 - 0.25 * y as f32);
    // A name that is taken has to be changed.
    let name = input.parts[0].name.clone().unwrap_or("main".into());
    let new = part(&name, window, &[("new.Z", &plane, OutputType::Float)]);
    let saved = Saved::new();
    let output = open(&saved.of(appended(&input, &new)));

    let old = input.parts.len();
    assert_eq!(output.parts.len(), old + 1);
    for (before, after) in input.parts.iter().zip(&output.parts) {
        assert_eq!(before.channels, after.channels);
        assert_eq!(before.window, after.window);
        assert_eq!(before.compression, after.compression);
        assert_eq!(before.tiled, after.tiled);
        assert!(before.name.is_none() || before.name == after.name);
    }
    for (name, value) in &input.attributes {
        assert_eq!(output.attributes.get(name), Some(value), "{name}");
    }
    assert_eq!(output.display_window, input.display_window);
    assert_eq!(output.parts[old].window, window);
    assert_eq!(output.parts[old].name, Some(format!("{name}.2")));
    let (before, after) = (read_all(&input), read_all(&output));
    for (before, after) in before.iter().zip(&after) {
        assert_eq!(bits(before), bits(after), "{}", path.display());
    }
    assert_eq!(bits(&after[before.len()]), bits(&plane));
}

/// Opens and reads any content of `path`; an error must be one line and name the file.
fn survive(path: &Path) -> Result<(), String> {
    let attempt = || -> relievo::Result<()> {
        let file = ExrFile::open(path, &Limits::default())?;
        let ids: Vec<ChannelId> = file.channel_ids().collect();
        file.read_channels(&ids)?;
        for is_part in [true, false] {
            let window = if is_part {
                Window::from_size(4, 4)
            } else {
                file.parts[0].window
            };
            let plane = Plane::filled(window.width(), window.height(), 1.0);
            let part = part("x", window, &[("Z", &plane, OutputType::Half)]);
            let (mut copy, description) = (Cursor::new(Vec::new()), part.description());
            let writer = match is_part {
                true => PartWriter::append(&file, &mut copy, path, &description)?,
                false => PartWriter::add_channels(&file, 0, &mut copy, path, &description)?.0,
            };
            writer.write(&part)?;
        }
        Ok(())
    };
    attempt().map_err(|error| {
        let message = error.to_string();
        // Long names are cut in their middle.
        let name = path.file_name().unwrap().to_string_lossy();
        let end = name.char_indices().rev().nth(39).map_or(0, |(at, _)| at);
        assert!(message.contains(&name[end..]), "{message}");
        assert!(!message.contains(char::is_control), "{message:?}");
        message
    })
}

/// All that is read or refused in these folders of the collection.
fn survive_all(folders: &[&str]) {
    for folder in folders
        .iter()
        .filter_map(|name| real(&format!("conformance/{name}")))
    {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            println!("{} {:?}", path.display(), survive(&path));
        }
    }
}

#[test]
fn damaged_files_are_errors() {
    survive_all(&["damaged"]);
}

#[test]
fn every_conformance_file_is_read_or_refused() {
    survive_all(&[
        "compression/f16",
        "compression/f32",
        "structure",
        "dwa_csc",
        "multires",
    ]);
    survive_all(&["testimages", "chromaticities", "displaywindow"]);
}

#[test]
fn a_truncated_file_is_damaged_wherever_it_ends() {
    let (_, _, bytes) = awkward();
    let saved = Saved::new();
    for end in (0..bytes.len()).step_by(13).chain([bytes.len() - 1]) {
        let message = survive(&saved.of(&bytes[..end])).unwrap_err();
        let remedy = "write or copy the file again";
        assert!(message.contains(remedy), "{message}");
    }
    assert_eq!(survive(&saved.of(&bytes)), Ok(()));
}

/// Where the bytes after the first `key` begin.
fn after(bytes: &[u8], key: &str) -> usize {
    let mut windows = bytes.windows(key.len());
    windows.position(|w| w == key.as_bytes()).unwrap() + key.len()
}

/// Replaces the value of the first `name`d attribute of `kind`.
fn patched(bytes: &[u8], name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let start = after(bytes, &format!("{name}\0{kind}\0")) + 4;
    let mut bytes = bytes.to_vec();
    bytes[start..start + value.len()].copy_from_slice(value);
    bytes
}

/// The bytes with the first text attribute `attribute` stripped of its type, which joins its value.
fn without_type(bytes: &[u8], attribute: &str) -> Vec<u8> {
    let end = after(bytes, &format!("{attribute}\0string\0"));
    let kind = end - "string\0".len();
    let mut bytes = bytes.to_vec();
    let size = u32::from_le_bytes(bytes[end..end + 4].try_into().unwrap());
    bytes[kind] = 0;
    bytes[kind + 1..kind + 5].copy_from_slice(&(size + 6).to_le_bytes());
    bytes
}

#[test]
fn an_attribute_without_a_type_is_refused() {
    let (_, _, one) = awkward();
    let saved = Saved::new();
    let plane = Plane::filled(4, 3, 1.0);
    let planes = [("more.Z", &plane, OutputType::Float)];
    let more = part("more", Window::from_size(4, 3), &planes);
    let two = appended(&open(&saved.of(&one)), &more);
    for bytes in [one, two] {
        let message = survive(&saved.of(without_type(&bytes, "software"))).unwrap_err();
        assert!(message.contains("\"software\" has no type"), "{message}");
    }
}

#[test]
fn a_small_file_that_claims_to_be_huge_is_refused() {
    let (_, _, bytes) = awkward();
    let saved = Saved::new();
    let corners = |c: [i32; 4]| c.map(i32::to_le_bytes).concat();
    for window in [
        [0, 0, 32767, 32767],
        [0, 0, 16383, 16383],
        [0, 0, 1 << 29, 0],
        [0, 0, i32::MAX, i32::MAX],
        [i32::MIN, i32::MIN, i32::MAX, i32::MAX],
        [10, 10, 0, 0],
    ] {
        let bytes = patched(&bytes, "dataWindow", "box2i", &corners(window));
        println!("{}", survive(&saved.of(bytes)).unwrap_err());
    }
}

#[test]
fn compressions_that_cannot_be_read_name_the_remedy() {
    let (_, _, bytes) = awkward();
    let saved = Saved::new();
    for (number, name) in [(10, "HTJ2K"), (11, "HTJ2K"), (12, "ZSTD"), (99, "unknown")] {
        let bytes = patched(&bytes, "compression", "compression", &[number]);
        let message = survive(&saved.of(bytes)).unwrap_err();
        let names_both = message.contains(name) && message.contains("oiiotool");
        assert!(names_both, "{message}");
    }
}

#[test]
fn dwa_counters_are_not_believed() {
    let Some(path) = real("conformance/compression/f16/dwaa.exr") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let saved = Saved::new();
    // The first chunk starts with its row and its size; the counters follow.
    let version = [2u64.to_le_bytes(), 0u64.to_le_bytes()].concat();
    let chunk = bytes.windows(8).position(|w| w == &version[..8]).unwrap();
    for counter in 1..11 {
        for value in [1 << 34, i64::MAX as u64, u64::MAX, 1 << 24] {
            let mut bytes = bytes.clone();
            let at = chunk + 8 * counter;
            bytes[at..at + 8].copy_from_slice(&u64::to_le_bytes(value));
            let is_refused = survive(&saved.of(bytes)).is_err();
            assert!(is_refused, "counter {counter} = {value}");
        }
    }
}

/// A small pseudo-random generator (xorshift), the same in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

fn fuzz(bytes: &[u8], rounds: usize, seed: u64) {
    let (saved, mut dice, mut read) = (Saved::new(), Dice(seed), 0);
    for round in 0..rounds {
        let mut bytes = bytes.to_vec();
        // Headers are small but matter most: every other round stays in there.
        let range = bytes
            .len()
            .min(if round % 2 == 0 { 700 } else { usize::MAX });
        for _ in 0..1 + dice.below(4) {
            let at = dice.below(range);
            bytes[at] = match dice.below(3) {
                0 => bytes[at] ^ (1 << dice.below(8)),
                1 => [0, 1, 0x7f, 0x80, 0xff][dice.below(5)],
                _ => dice.below(256) as u8,
            };
        }
        read += usize::from(survive(&saved.of(bytes)).is_ok());
    }
    println!("{read} of {rounds} still readable");
}

#[test]
fn flipped_bytes_never_panic() {
    let (_, _, bytes) = awkward();
    fuzz(&bytes, 2000, 0x9e3779b97f4a7c15);
    for (name, rounds, seed) in [
        ("compression/f16/b44", 300, 77),
        ("compression/f16/dwaa", 300, 78),
        ("compression/f16/piz", 300, 79),
        ("compression/f32/pxr24", 300, 80),
        ("compression/f16/rle", 300, 81),
        ("compression/f16/zips", 300, 82),
        ("compression/f32/uncompressed", 300, 83),
        ("structure/parts", 500, 99),
        ("structure/tiled_with_scanlineimage_type", 500, 99),
    ] {
        let Some(path) = real(&format!("conformance/{name}.exr")) else {
            return;
        };
        fuzz(&std::fs::read(path).unwrap(), rounds, seed);
    }
}

#[test]
fn tiles_larger_than_the_picture_are_harmless() {
    let Some(path) = real("conformance/structure/tiled_with_scanlineimage_type.exr") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let saved = Saved::new();
    let large = [1 << 15, i32::MAX as u32, u32::MAX].map(|side| [side; 2]);
    for size in [[0, 20], [1, 1]].into_iter().chain(large) {
        let size = size.map(u32::to_le_bytes).concat();
        let bytes = patched(&bytes, "tiles", "tiledesc", &size);
        println!("{}", survive(&saved.of(bytes)).unwrap_err());
    }
}

/// JPEG moves the samples of gentle forms by a code or two, in blocks: the smoothest normals that near bend as the form does.
#[test]
fn gentle_forms_are_read_from_jpeg_without_its_blocks() {
    const SIDE: u32 = 320;
    let folder = tempfile::tempdir().unwrap();
    // The slopes of 3 sin(x / 40) sin(y / 55).
    let exact = |x: u32, y: u32| {
        let (sx, cx) = (f64::from(x) / 40.0).sin_cos();
        let (sy, cy) = (f64::from(y) / 55.0).sin_cos();
        DVec3::new(-cx * sy * 3.0 / 40.0, sx * cy * 3.0 / 55.0, 1.0).normalize()
    };
    let code = |v: f64| ((0.5 * v + 0.5) * 255.0).round() as u8;
    let in_codes = |x, y| image::Rgb(exact(x, y).to_array().map(code));
    let map = image::RgbImage::from_fn(SIDE, SIDE, in_codes);
    // Root mean square error of the change of x over 8 pixels, where blocks show.
    let error = |x_of: &dyn Fn(u32, u32) -> f64| {
        let bend = |of: &dyn Fn(u32, u32) -> f64, x, y| of(x + 8, y) - of(x, y);
        let side = SIDE as usize - 40;
        let squares = places(side, side).map(|(x, y)| {
            let [x, y] = [x as u32 + 16, y as u32 + 16];
            (bend(x_of, x, y) - bend(&|x, y| exact(x, y).x, x, y)).powi(2)
        });
        let squares: Vec<f64> = squares.collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    for quality in [95, 75] {
        let path = folder.path().join(format!("{quality}.jpg"));
        let file = std::fs::File::create(&path).unwrap();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(file, quality);
        map.write_with_encoder(encoder).unwrap();
        let stored = image::open(&path).unwrap().to_rgb8();
        let before = error(&|x, y| f64::from(stored.get_pixel(x, y).0[0]) / 127.5 - 1.0);
        let normal = files::load(path, |_, _| ()).frame.normal;
        let after = error(&|x, y| normal.at(x as usize, y as usize).x);
        assert!(
            3.0 * after < before,
            "{quality}: {before:.1e} to {after:.1e}"
        );
    }
}
