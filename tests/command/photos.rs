//! Photos and companion files: headers first, pixels when needed, within memory.

use super::inputs::write_planes;
use crate::common::program::{Ran, relievo};
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::io::picture::ViewTransform;
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;

/// A PNG of 8-bit grey: `value(x, y)` is its code.
fn write_grey(path: &Path, [width, height]: [u32; 2], value: impl Fn(u32, u32) -> u8) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let codes = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let codes: Vec<u8> = codes.map(|(x, y)| value(x, y)).collect();
    writer.write_image_data(&codes).unwrap();
}

/// A PNG that claims these pixels, and contains none of them.
fn write_header(path: &Path, [width, height]: [u32; 2]) {
    let encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    let mut writer = encoder.write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, b"nothing").unwrap();
}

/// A colour picture by the extension of its name, of light from 0 to 1.
fn write_color(path: &Path, [width, height]: [usize; 2], light: impl Fn(usize, usize) -> [f32; 3]) {
    let planes = [0, 1, 2].map(|c| Plane::from_fn(width, height, |x, y| light(x, y)[c]));
    write_planes(path, planes, None, 8, ViewTransform::Srgb);
}

/// A small picture and its normal map: a plane that faces the viewer.
fn write_small(here: &Path) {
    write_color(&here.join("in.png"), [64, 64], |x, y| {
        [x, y, 32].map(|v| v as f32 / 64.0)
    });
    write_color(&here.join("n.png"), [64, 64], |_, _| [0.22, 0.22, 1.0]);
}

#[test]
fn inspect_reads_the_header_of_a_photo_alone() {
    let desk = tempfile::tempdir().unwrap();
    write_header(&desk.path().join("huge.png"), [18000, 18000]);
    let stdout = relievo(desk.path(), "inspect huge.png").done().stdout;
    assert!(
        stdout.contains("18000x18000") && stdout.contains("u8"),
        "{stdout}"
    );
}

#[test]
fn files_of_other_sizes_are_refused_before_they_are_decoded() {
    let desk = tempfile::tempdir().unwrap();
    write_small(desk.path());
    write_header(&desk.path().join("huge.png"), [18000, 18000]);
    let said = relievo(desk.path(), "enhance in.png --normal huge.png -o out.png").ended(1);
    assert!(said.contains("inputs of one size"), "{said}");
}

#[test]
fn inspect_looks_at_the_middle_of_what_is_too_large() {
    let desk = tempfile::tempdir().unwrap();
    // 100 bytes for each of 11 million pixels are more than 1 GiB.
    for name in ["in.png", "n.png"] {
        write_grey(&desk.path().join(name), [4096, 2700], |x, y| (x + y) as u8);
    }
    let words = "inspect in.png --normal n.png --normal-space view";
    let stdout = relievo(desk.path(), words).done().stdout;
    let said: Vec<&str> = stdout
        .lines()
        .filter(|l| l.contains("rows in the middle"))
        .collect();
    assert_eq!(said.len(), 1, "{stdout}");
    assert!(
        said[0].contains("of 2700") && stdout.contains("normal encoding"),
        "{stdout}"
    );
}

#[test]
fn pictures_of_no_pixels_are_refused_in_one_line_in_every_role() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_small(here);
    fs::write(
        here.join("none.hdr"),
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n",
    )
    .unwrap();
    for words in [
        "inspect none.hdr",
        "enhance none.hdr --normal n.png -o out.png",
        "enhance in.png --normal none.hdr -o out.png",
        "enhance in.png --normal n.png --occlusion none.hdr -o out.png",
        "relight in.png --normal n.png --environment none.hdr -o out.png",
        "relight in.png --normal n.png --lit-sphere none.hdr -o out.png",
    ] {
        let said = relievo(here, words).ended(1);
        assert!(
            said.contains("none.hdr: is 0x0 and holds no pixels"),
            "{words}: {said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn environments_are_reduced_to_what_may_be_used() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_small(here);
    // Brighter to the right and upward, in steps far finer than the reduction.
    let sky = |x: usize, y: usize| [x as f32 / 512.0, 0.3, 1.0 - y as f32 / 256.0];
    for name in ["sky.png", "sky.jpg", "sky.hdr"] {
        write_color(&here.join(name), [512, 256], sky);
    }
    let lit = |sky: &str, memory: &str, code: i32| {
        let words = format!(
            "relight in.png --normal n.png --environment {sky} -o out.png --max-memory {memory}"
        );
        relievo(here, &words).ended(code)
    };
    for sky in ["sky.png", "sky.jpg", "sky.hdr"] {
        lit(sky, "1G", 0);
        let whole = Photo::read(&here.join("out.png")).unwrap();
        // Half of 4 MiB holds a third of 512 x 256 pixels at 48 bytes.
        lit(sky, "4M", 0);
        let reduced = Photo::read(&here.join("out.png")).unwrap();
        for (whole, reduced) in whole.channels.iter().zip(&reduced.channels) {
            let pairs = whole.samples().iter().zip(reduced.samples());
            // Two codes of 8 bits.
            assert!(
                pairs.into_iter().all(|(a, b)| (a - b).abs() < 2.5 / 255.0),
                "{sky}"
            );
        }
    }
    // Half of 500 KiB is less than the 384 KiB of its samples.
    let said = lit("sky.jpg", "500K", 1);
    assert!(
        said.contains("sky.jpg") && said.contains("decoded whole"),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
    lit("sky.png", "500K", 0);
}

/// A stream of zlib that inflates to one zero and `258 * matches` more.
fn zeros(matches: usize) -> Vec<u8> {
    // A last block with fixed codes: 3 bits, from the lowest on; the literal 0, eight bits that begin with its highest;
    // for each match the eight of length 258 and five of distance 1; and seven zeros at the end.
    let (zero, longest) = (
        [0, 0, 1, 1, 0, 0, 0, 0],
        [1, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0],
    );
    let bits = [1, 1, 0].into_iter().chain(zero);
    let bits = bits.chain(std::iter::repeat_n(longest, matches).flatten());
    let bits: Vec<u8> = bits.chain([0; 7]).collect();
    let bytes = bits
        .chunks(8)
        .map(|bits| bits.iter().rev().fold(0, |byte, bit| byte << 1 | bit));
    [0x78, 1].into_iter().chain(bytes).collect()
}

/// A colour profile of a gigabyte takes neither its memory nor its time, whatever the picture with it is read for.
#[cfg(target_os = "linux")]
#[test]
fn a_profile_is_inflated_within_a_limit() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_small(here);
    let mut encoder = png::Encoder::new(File::create(here.join("bomb.png")).unwrap(), 64, 64);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    // 2^30 bytes, after a name and the number of the method.
    let profile = [&b"icc\0\0"[..], &zeros((1 << 30) / 258)].concat();
    writer.write_chunk(png::chunk::iCCP, &profile).unwrap();
    writer.write_image_data(&[128; 64 * 64 * 3]).unwrap();
    writer.finish().unwrap();
    for words in [
        "inspect bomb.png",
        "enhance bomb.png --normal n.png -o o.png -q",
        "enhance bomb.png --normal n.png -o o.jpg -q",
        "enhance in.png --normal bomb.png --normal-space view -o o.png -q",
        "enhance in.png --normal n.png --mask bomb.png -o o.png -q",
        "relight in.png --normal n.png --environment bomb.png -o o.png -q",
        "relight in.png --normal n.png --lit-sphere bomb.png -o o.png -q",
        "hatch bomb.png --normal n.png -o o.png -q",
        "shape bomb.png -o o.png -q",
        "report bomb.png -q",
    ] {
        // 600 MB of addresses, of which stacks and code take the most.
        let script = format!("ulimit -v 600000; exec \"$0\" {words}");
        let mut shell = Command::new("sh");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_relievo")]);
        let ran = Ran::of(shell.current_dir(here));
        assert!(
            [Some(0), Some(1)].contains(&ran.code),
            "{words}: {}",
            ran.stderr
        );
        assert!(ran.stderr.lines().count() <= 1, "{words}: {}", ran.stderr);
    }
    assert_eq!(Photo::read(&here.join("bomb.png")).unwrap().width, 64);
}

/// A resolution of nothing is not handed on: the EXIF block of a photo, as a big-endian TIFF whose directory at 8 has two
/// resolutions (0x11a and 0x11b, fractions at 50) and their unit (0x128), inches.
#[test]
fn an_unsound_resolution_is_left_out_of_the_copy() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_small(here);
    write_color(&here.join("in.jpg"), [64, 64], |x, y| {
        [x, y, 9].map(|v| v as f32 / 64.0)
    });
    let plain = fs::read(here.join("in.jpg")).unwrap();
    for (fraction, kept) in [
        ([0, 1], None),
        ([1, 0], None),
        ([0, 0], None),
        ([72, 1], Some([72, 1])),
    ] {
        let mut block = b"Exif\0\0MM\0*\0\0\0\x08\0\x03".to_vec();
        for tag in [0x1a, 0x1b] {
            block.extend([1, tag, 0, 5, 0, 0, 0, 1, 0, 0, 0, 50]);
        }
        block.extend([1, 0x28, 0, 3, 0, 0, 0, 1, 0, 2, 0, 0, 0, 0, 0, 0]);
        block.extend(fraction.map(u32::to_be_bytes).concat());
        let length = (block.len() as u16 + 2).to_be_bytes();
        let segment = [&[0xff, 0xd8, 0xff, 0xe1], &length[..], &block].concat();
        // In place of the first segment, of JFIF, whose own length comes after its marker.
        let own = usize::from(u16::from_be_bytes([plain[4], plain[5]]));
        fs::write(
            here.join("exif.jpg"),
            [&segment, &plain[4 + own..]].concat(),
        )
        .unwrap();
        for output in ["o.jpg", "o.png"] {
            relievo(
                here,
                &format!("enhance exif.jpg --normal n.png -o {output}"),
            )
            .done();
            let written = fs::read(here.join(output)).unwrap();
            let long = |at: usize| u32::from_be_bytes(written[at..at + 4].try_into().unwrap());
            let block = written.windows(4).position(|bytes| bytes == b"MM\0*");
            let block = block.unwrap();
            // The directory is new; the old one stands before it.
            let directory = block + long(block + 4) as usize;
            for tag in [0x1a, 0x1b] {
                let entry = [1, tag, 0, 5, 0, 0, 0, 1];
                let mut entries = written[directory + 2..].chunks(12);
                let found = entries
                    .find(|bytes| bytes.starts_with(&entry))
                    .map(|bytes| {
                        let value = u32::from_be_bytes(bytes[8..].try_into().unwrap());
                        let value = block + value as usize;
                        [long(value), long(value + 4)]
                    });
                let kept = kept.map(|[n, d]| [1000 * n, 1000 * d]);
                assert_eq!(found, kept, "{fraction:?} in {output}");
            }
        }
    }
}
