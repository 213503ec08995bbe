//! Files in and out: round trips, copies with a part added, and files with false claims.

use crate::common::bits;
use crate::common::real_files::real;
use glam::DVec3;
use relievo::frame::{Plane, Window};
use relievo::io::Needs;
use relievo::io::exr::{
    ChannelId, ExrFile, Limits, OutputChannel, OutputPart, OutputType, PartWriter, write_results,
};
use relievo::io::inputs::Inputs as Files;
use std::io::Cursor;
use std::path::Path;

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
    OutputPart {
        name: name.into(),
        data_window: window,
        display_window: Window::from_size(40, 30),
        pixel_aspect: 1.5,
        channels: planes
            .iter()
            .map(|&(name, plane, sample_type)| OutputChannel {
                name: name.into(),
                plane,
                sample_type,
            })
            .collect(),
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
    float.samples_mut()[..5].copy_from_slice(&[
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -0.0,
        f32::MIN_POSITIVE / 8.0,
    ]);
    let half = float.map(|v| half::f16::from_f32(v.clamp(-60000.0, 60000.0)).to_f32());
    let long = "a name that is a good deal longer than thirty-one bytes.Ünïcode";
    let bytes = written(&part(
        "awkward",
        Window::at(-11, -7, 37, 35),
        &[
            ("zebra.Z", &float, OutputType::Float),
            (long, &float, OutputType::Float),
            ("N.Y", &half, OutputType::Half),
        ],
    ));
    (float, half, bytes)
}

#[test]
fn what_is_written_is_read() {
    let (float, half, bytes) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("awkward.exr");
    std::fs::write(&path, &bytes).unwrap();
    let file = open(&path);
    assert_eq!(file.parts.len(), 1);
    assert_eq!(file.parts[0].window, Window::at(-11, -7, 37, 35));
    assert_eq!(file.display_window, Window::from_size(40, 30));
    assert_eq!(file.pixel_aspect, 1.5);
    assert_eq!(file.parts[0].compression, "zip");
    assert_eq!(file.attributes["software"], "relievo test");

    let names: Vec<&str> = file.parts[0]
        .channels
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    assert_eq!(names[0], "N.Y");
    assert!(names[1].ends_with("Ünïcode"));
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
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.exr");
    std::fs::write(&path, &bytes).unwrap();
    let ids = [2, 0, 2].map(|channel| ChannelId { part: 0, channel });
    let planes = open(&path).read_channels(&ids).unwrap();
    assert_eq!(bits(&planes[0]), bits(&float));
    assert_eq!(bits(&planes[1]), bits(&half));
    assert_eq!(bits(&planes[2]), bits(&float));
}

#[test]
fn a_limit_refuses_before_anything_is_read() {
    let (_, _, bytes) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.exr");
    std::fs::write(&path, &bytes).unwrap();
    let limits = Limits {
        max_pixels: 1000,
        ..Limits::default()
    };
    let few_bytes = Limits {
        max_bytes: 1000,
        ..Limits::default()
    };
    for limits in [limits, few_bytes] {
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
    let bytes = appended(
        &input,
        &part(&name, window, &[("new.Z", &plane, OutputType::Float)]),
    );
    let directory = tempfile::tempdir().unwrap();
    let copy = directory.path().join("copy.exr");
    std::fs::write(&copy, bytes).unwrap();
    let output = open(&copy);

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
        let plane = Plane::filled(4, 4, 1.0);
        let window = Window::from_size(4, 4);
        let part = part("x", window, &[("Z", &plane, OutputType::Half)]);
        let (mut copy, description) = (Cursor::new(Vec::new()), part.description());
        PartWriter::append(&file, &mut copy, path, &description)?.write(&part)?;
        let window = file.parts[0].window;
        let plane = Plane::filled(window.width(), window.height(), 1.0);
        let part = self::part("x", window, &[("Z", &plane, OutputType::Half)]);
        let (mut copy, description) = (Cursor::new(Vec::new()), part.description());
        let (writer, _) = PartWriter::add_channels(&file, 0, &mut copy, path, &description)?;
        writer.write(&part)?;
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

#[test]
fn damaged_files_are_errors() {
    let Some(folder) = real("conformance/damaged") else {
        return;
    };
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        println!("{:?}", survive(&path));
    }
}

#[test]
fn every_conformance_file_is_read_or_refused() {
    let Some(folder) = real("conformance") else {
        return;
    };
    for folder in [
        "compression/f16",
        "compression/f32",
        "structure",
        "dwa_csc",
        "multires",
        "testimages",
        "chromaticities",
        "displaywindow",
    ]
    .map(|f| folder.join(f))
    {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            println!("{} {:?}", path.display(), survive(&path));
        }
    }
}

#[test]
fn a_truncated_file_is_damaged_wherever_it_ends() {
    let (_, _, bytes) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("cut.exr");
    for end in (0..bytes.len()).step_by(13).chain([bytes.len() - 1]) {
        std::fs::write(&path, &bytes[..end]).unwrap();
        let message = survive(&path).unwrap_err();
        assert!(
            message.contains("write or copy the file again"),
            "{message}"
        );
    }
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(survive(&path), Ok(()));
}

/// Replaces the value of the first `name`d attribute of `kind`.
fn patched(bytes: &[u8], name: &str, kind: &str, value: &[u8]) -> Vec<u8> {
    let key = format!("{name}\0{kind}\0");
    let at = bytes
        .windows(key.len())
        .position(|w| w == key.as_bytes())
        .unwrap();
    let mut bytes = bytes.to_vec();
    let start = at + key.len() + 4;
    bytes[start..start + value.len()].copy_from_slice(value);
    bytes
}

/// The bytes with the first text attribute `attribute` stripped of its type, which joins its value.
fn without_type(bytes: &[u8], attribute: &str) -> Vec<u8> {
    let key = format!("{attribute}\0string\0");
    let at = bytes
        .windows(key.len())
        .position(|w| w == key.as_bytes())
        .unwrap();
    let mut bytes = bytes.to_vec();
    let kind = at + attribute.len() + 1;
    let size = u32::from_le_bytes(bytes[kind + 7..kind + 11].try_into().unwrap());
    bytes[kind] = 0;
    bytes[kind + 1..kind + 5].copy_from_slice(&(size + 6).to_le_bytes());
    bytes
}

#[test]
fn an_attribute_without_a_type_is_refused() {
    let (_, _, one) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("untyped.exr");
    std::fs::write(&path, &one).unwrap();
    let plane = Plane::filled(4, 3, 1.0);
    let planes = [("more.Z", &plane, OutputType::Float)];
    let more = part("more", Window::from_size(4, 3), &planes);
    let two = appended(&open(&path), &more);
    for bytes in [one, two] {
        std::fs::write(&path, without_type(&bytes, "software")).unwrap();
        let message = survive(&path).unwrap_err();
        assert!(message.contains("\"software\" has no type"), "{message}");
    }
}

#[test]
fn a_small_file_that_claims_to_be_huge_is_refused() {
    let (_, _, bytes) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("huge.exr");
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
        std::fs::write(&path, bytes).unwrap();
        let message = survive(&path).unwrap_err();
        println!("{message}");
    }
}

#[test]
fn compressions_that_cannot_be_read_name_the_remedy() {
    let (_, _, bytes) = awkward();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("new.exr");
    for (number, name) in [(10, "HTJ2K"), (11, "HTJ2K"), (12, "ZSTD"), (99, "unknown")] {
        let bytes = patched(&bytes, "compression", "compression", &[number]);
        std::fs::write(&path, bytes).unwrap();
        let message = survive(&path).unwrap_err();
        assert!(
            message.contains(name) && message.contains("oiiotool"),
            "{message}"
        );
    }
}

#[test]
fn dwa_counters_are_not_believed() {
    let Some(path) = real("conformance/compression/f16/dwaa.exr") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("dwa.exr");
    // The first chunk starts with its row and its size; the counters follow.
    let version = [2u64.to_le_bytes(), 0u64.to_le_bytes()].concat();
    let chunk = bytes.windows(8).position(|w| w == &version[..8]).unwrap();
    for counter in 1..11 {
        for value in [1 << 34, i64::MAX as u64, u64::MAX, 1 << 24] {
            let mut bytes = bytes.clone();
            let at = chunk + 8 * counter;
            bytes[at..at + 8].copy_from_slice(&u64::to_le_bytes(value));
            std::fs::write(&path, bytes).unwrap();
            assert!(survive(&path).is_err(), "counter {counter} = {value}");
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
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("fuzz.exr");
    let mut dice = Dice(seed);
    let mut read = 0;
    for round in 0..rounds {
        let mut bytes = bytes.to_vec();
        // Headers are small but matter most: every other round stays in there.
        let range = if round % 2 == 0 {
            bytes.len().min(700)
        } else {
            bytes.len()
        };
        for _ in 0..1 + dice.below(4) {
            let at = dice.below(range);
            bytes[at] = match dice.below(3) {
                0 => bytes[at] ^ (1 << dice.below(8)),
                1 => [0, 1, 0x7f, 0x80, 0xff][dice.below(5)],
                _ => dice.below(256) as u8,
            };
        }
        std::fs::write(&path, &bytes).unwrap();
        read += usize::from(survive(&path).is_ok());
    }
    println!("{read} of {rounds} still readable");
}

#[test]
fn flipped_bytes_never_panic() {
    let (_, _, bytes) = awkward();
    fuzz(&bytes, 2000, 0x9e3779b97f4a7c15);
    for (i, name) in [
        "f16/b44",
        "f16/dwaa",
        "f16/piz",
        "f32/pxr24",
        "f16/rle",
        "f16/zips",
        "f32/uncompressed",
    ]
    .into_iter()
    .enumerate()
    {
        let Some(path) = real(&format!("conformance/compression/{name}.exr")) else {
            return;
        };
        fuzz(&std::fs::read(path).unwrap(), 300, 77 + i as u64);
    }
    for name in [
        "structure/parts.exr",
        "structure/tiled_with_scanlineimage_type.exr",
    ] {
        let Some(path) = real(&format!("conformance/{name}")) else {
            return;
        };
        fuzz(&std::fs::read(path).unwrap(), 500, 99);
    }
}

#[test]
fn tiles_larger_than_the_picture_are_harmless() {
    let Some(path) = real("conformance/structure/tiled_with_scanlineimage_type.exr") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("tiles.exr");
    for size in [
        [0, 20],
        [1, 1],
        [1 << 15, 1 << 15],
        [i32::MAX as u32; 2],
        [u32::MAX; 2],
    ] {
        let size = size.map(u32::to_le_bytes).concat();
        std::fs::write(&path, patched(&bytes, "tiles", "tiledesc", &size)).unwrap();
        println!("{}", survive(&path).unwrap_err());
    }
}

/// JPEG moves the samples of gentle forms by a code or two, in blocks: the smoothest normals that near bend as the form does.
#[test]
fn gentle_forms_are_read_from_jpeg_without_its_blocks() {
    const SIDE: u32 = 320;
    let folder = tempfile::tempdir().unwrap();
    // The slopes of 3 sin(x / 40) sin(y / 55).
    let exact = |x: u32, y: u32| {
        let ((sx, cx), (sy, cy)) = (
            (f64::from(x) / 40.0).sin_cos(),
            (f64::from(y) / 55.0).sin_cos(),
        );
        DVec3::new(-cx * sy * 3.0 / 40.0, sx * cy * 3.0 / 55.0, 1.0).normalize()
    };
    let in_codes = |x, y| {
        image::Rgb(
            exact(x, y)
                .to_array()
                .map(|v| ((0.5 * v + 0.5) * 255.0).round() as u8),
        )
    };
    let map = image::RgbImage::from_fn(SIDE, SIDE, in_codes);
    // Root mean square error of the change of x over 8 pixels, where blocks show.
    let error = |x_of: &dyn Fn(u32, u32) -> f64| {
        let bend = |of: &dyn Fn(u32, u32) -> f64, x, y| of(x + 8, y) - of(x, y);
        let places = (16..SIDE - 24).flat_map(|y| (16..SIDE - 24).map(move |x| (x, y)));
        let squares: Vec<f64> = places
            .map(|(x, y)| (bend(x_of, x, y) - bend(&|x, y| exact(x, y).x, x, y)).powi(2))
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    for quality in [95, 75] {
        let path = folder.path().join(format!("{quality}.jpg"));
        let file = std::fs::File::create(&path).unwrap();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(file, quality);
        map.write_with_encoder(encoder).unwrap();
        let stored = image::open(&path).unwrap().to_rgb8();
        let before = error(&|x, y| f64::from(stored.get_pixel(x, y).0[0]) / 127.5 - 1.0);
        let files = Files {
            picture: path,
            ..Files::default()
        };
        let normal = relievo::io::load(&files, Needs::default())
            .unwrap()
            .frame
            .normal;
        let after = error(&|x, y| normal.at(x as usize, y as usize).x);
        assert!(
            after < before / 3.0,
            "{quality}: {before:.1e} to {after:.1e}"
        );
    }
}
