//! Round trips, and files whose claims are false: read, or refused in one line.

use super::*;
use crate::common::damage::Dice;

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
    let bytes = whole(&part_of("awkward", Window::at(-11, -7, 37, 35), &channels));
    (float, half, bytes)
}

#[test]
fn what_is_written_is_read() {
    let (float, half, bytes) = awkward();
    let (_saved, file) = saved(&bytes, &Limits::default());
    assert_eq!(file.parts.len(), 1);
    assert_eq!(file.parts[0].window, Window::at(-11, -7, 37, 35));
    assert_eq!(file.display_window, Window::from_size(40, 30));
    assert_eq!(file.pixel_aspect, 1.5);
    assert_eq!(file.parts[0].compression, "zip");
    assert_eq!(file.attributes["software"], "relievo test");
    let channels = &file.parts[0].channels;
    assert_eq!(channels[0].name, "N.Y");
    assert!(channels[1].name.ends_with("Ünïcode"));
    // In the order asked for, also twice.
    let ids = [2, 0, 1, 2].map(|channel| ChannelId { part: 0, channel });
    let planes = file.read_channels(&ids).unwrap();
    for (plane, expected) in planes.iter().zip([&float, &half, &float, &float]) {
        assert_eq!(bits(plane), bits(expected));
    }
    // Writing is deterministic.
    assert_eq!(bytes, awkward().2);
}

#[test]
fn what_is_added_leaves_the_rest_as_it_was() {
    for path in files(
        "renders/suzanne_640_half_dwaa renders/cloth_640_mixed_piz renders/tiny_bunny_64_multipart
        renders/suzanne_480_allpasses_b50_multipart_dwaa conformance/multires/ColorCodedLevels
        conformance/multires/MirrorPattern conformance/structure/lineOrder_decreasing
        conformance/structure/cryptoasset conformance/structure/parts conformance/structure/tiny-az
        conformance/structure/tiled_with_scanlineimage_type
        conformance/testimages/BrightRingsNanInf conformance/displaywindow/t16",
    ) {
        check_append(&path);
        check_merge(&path);
    }
}

fn check_append(path: &Path) {
    let input = open(path);
    let window = Window::at(-3, 5, 21, 33);
    let plane = Plane::from_fn(21, 33, |x, y| x as f32 - 0.25 * y as f32);
    // A name that is taken has to be changed.
    let name = input.parts[0].name.clone().unwrap_or("main".into());
    let new = part_of(&name, window, &[("new.Z", &plane, OutputType::Float)]);
    let (_saved, output) = saved(&appended(&input, &new), &Limits::default());
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

fn check_merge(path: &Path) {
    let input = open(path);
    let window = input.parts[0].window;
    let plane = Plane::from_fn(window.width(), window.height(), |x, y| (x * y) as f32);
    let new = part_of("new", window, &[("new.Z", &plane, OutputType::Float)]);
    let (_saved, output) = saved(&merged(&input, 0, &new).0, &Limits::default());
    let read = |file: &ExrFile| -> Vec<(String, Vec<u32>)> {
        let names = file.parts.iter().flat_map(|part| &part.channels);
        let names = names.map(|channel| channel.name.clone());
        let all = names.zip(read_all(file).into_iter().map(|plane| bits(&plane)));
        all.filter(|(name, _)| name != "new.Z").collect()
    };
    let name = path.display();
    assert!(read(&input) == read(&output), "{name}");
    assert_eq!(output.parts.len(), input.parts.len(), "{name}");
    let of_storage = "channels chunkCount compression lineOrder tiles type software";
    for (key, value) in &input.attributes {
        let is_same = output.attributes.get(key) == Some(value);
        assert!(is_same || of_storage.contains(key.as_str()), "{name} {key}");
    }
}

/// Opens and reads any content of `path`, and adds to it; an error must be one line and name the file.
fn survive(path: &Path) -> Result<(), String> {
    let attempt = || -> relievo::Result<()> {
        let file = ExrFile::open(path, &Limits::default())?;
        file.read_channels(&ids(&file))?;
        for is_part in [true, false] {
            let own = file.parts[0].window;
            let window = if is_part {
                Window::from_size(4, 4)
            } else {
                own
            };
            let plane = Plane::filled(window.width(), window.height(), 1.0);
            let part = part_of("x", window, &[("Z", &plane, OutputType::Half)]);
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

#[test]
fn every_conformance_file_is_read_or_refused() {
    let folders = "damaged compression/f16 compression/f32 structure dwa_csc multires testimages chromaticities displaywindow";
    let folders = folders
        .split(' ')
        .filter_map(|name| real(&format!("conformance/{name}")));
    for folder in folders {
        for entry in std::fs::read_dir(folder).unwrap() {
            let _ = survive(&entry.unwrap().path());
        }
    }
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
fn false_claims_are_refused() {
    let (_, _, one) = awkward();
    let plane = Plane::filled(4, 3, 1.0);
    let more = [("more.Z", &plane, OutputType::Float)];
    let more = part_of("more", Window::from_size(4, 3), &more);
    let two = appended(&saved(&one, &Limits::default()).1, &more);
    let saved = Saved::new();
    let refused = |bytes: Vec<u8>, parts: &str| {
        let message = survive(&saved.of(bytes)).expect_err(parts);
        assert!(
            parts.split(" ... ").all(|part| message.contains(part)),
            "{message}"
        );
    };
    for bytes in [&one, &two] {
        refused(without_type(bytes, "software"), "\"software\" has no type");
    }
    // A small file that claims to be huge.
    for window in [
        [0, 0, 32767, 32767],
        [0, 0, 16383, 16383],
        [0, 0, 1 << 29, 0],
        [0, 0, i32::MAX, i32::MAX],
        [i32::MIN, i32::MIN, i32::MAX, i32::MAX],
        [10, 10, 0, 0],
    ] {
        let corners = window.map(i32::to_le_bytes).concat();
        refused(patched(&one, "dataWindow", "box2i", &corners), "");
    }
    for (number, name) in [(10, "HTJ2K"), (11, "HTJ2K"), (12, "ZSTD"), (99, "unknown")] {
        let bytes = patched(&one, "compression", "compression", &[number]);
        refused(bytes, &format!("{name} ... oiiotool"));
    }
    // Tiles larger than the picture.
    for path in files("conformance/structure/tiled_with_scanlineimage_type") {
        let bytes = std::fs::read(path).unwrap();
        let large = [1 << 15, i32::MAX as u32, u32::MAX].map(|side| [side; 2]);
        for size in [[0, 20], [1, 1]].into_iter().chain(large) {
            let size = size.map(u32::to_le_bytes).concat();
            refused(patched(&bytes, "tiles", "tiledesc", &size), "");
        }
    }
    // Counters of DWA: the first chunk starts with its row and its size; they follow.
    for path in files("conformance/compression/f16/dwaa") {
        let bytes = std::fs::read(path).unwrap();
        let version = 2u64.to_le_bytes();
        let chunk = bytes.windows(8).position(|w| w == version).unwrap();
        for counter in 1..11 {
            for value in [1 << 34, i64::MAX as u64, u64::MAX, 1 << 24] {
                let mut bytes = bytes.clone();
                let at = chunk + 8 * counter;
                bytes[at..at + 8].copy_from_slice(&u64::to_le_bytes(value));
                refused(bytes, "");
            }
        }
    }
}

fn fuzz(bytes: &[u8], rounds: usize, seed: u64) {
    let (saved, mut dice) = (Saved::new(), Dice(seed));
    for round in 0..rounds {
        let mut bytes = bytes.to_vec();
        // Headers are small but matter most: every other round stays in there.
        let most = if round % 2 == 0 { 700 } else { usize::MAX };
        let range = bytes.len().min(most);
        for _ in 0..1 + dice.below(4) {
            let at = dice.below(range);
            bytes[at] = match dice.below(3) {
                0 => bytes[at] ^ (1 << dice.below(8)),
                1 => [0, 1, 0x7f, 0x80, 0xff][dice.below(5)],
                _ => dice.below(256) as u8,
            };
        }
        let _ = survive(&saved.of(bytes));
    }
}

#[test]
fn flipped_bytes_never_panic() {
    let (_, _, bytes) = awkward();
    fuzz(&bytes, 2000, 0x9e3779b97f4a7c15);
    let compressions = "f16/b44 f16/dwaa f16/piz f32/pxr24 f16/rle f16/zips f32/uncompressed";
    let compressions = compressions
        .split(' ')
        .map(|name| (format!("compression/{name}"), 300));
    let structures = ["parts", "tiled_with_scanlineimage_type"];
    let structures = structures.map(|name| (format!("structure/{name}"), 500));
    for (i, (name, rounds)) in compressions.chain(structures).enumerate() {
        for path in files(&format!("conformance/{name}")) {
            fuzz(&std::fs::read(path).unwrap(), rounds, 77 + i as u64);
        }
    }
}
