//! Photos and companion files: headers first, pixels when needed, within memory.

use crate::common::apart;
use crate::common::program::{Desk, relievo_within};
use relievo::frame::Plane;
use std::fs::File;

/// A PNG of 8-bit grey: `value(x, y)` is its code.
fn write_grey(desk: &Desk, name: &str, [width, height]: [u32; 2], value: fn(u32, u32) -> u8) {
    let file = File::create(desk.at(name)).unwrap();
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let codes = (0..height).flat_map(|y| (0..width).map(move |x| value(x, y)));
    let codes: Vec<u8> = codes.collect();
    writer.write_image_data(&codes).unwrap();
}

/// A PNG that claims 18000x18000 pixels, and contains none of them.
fn write_huge_header(desk: &Desk) {
    let file = File::create(desk.at("huge.png")).unwrap();
    let mut writer = png::Encoder::new(file, 18000, 18000)
        .write_header()
        .unwrap();
    writer.write_chunk(png::chunk::IDAT, b"nothing").unwrap();
}

/// A colour picture by the extension of its name, of light from 0 to 1.
fn write_color(
    desk: &Desk,
    name: &str,
    [width, height]: [usize; 2],
    light: impl Fn(usize, usize) -> [f32; 3],
) {
    let planes = [0, 1, 2].map(|c| Plane::from_fn(width, height, |x, y| light(x, y)[c]));
    desk.write_light(name, planes);
}

/// A desk with a small picture and its normal map: a plane that faces the viewer.
fn small() -> Desk {
    let desk = Desk::new();
    write_color(&desk, "in.png", [64, 64], |x, y| {
        [x, y, 32].map(|v| v as f32 / 64.0)
    });
    write_color(&desk, "n.png", [64, 64], |_, _| [0.22, 0.22, 1.0]);
    desk
}

#[test]
fn headers_are_read_before_any_pixel() {
    let desk = small();
    write_huge_header(&desk);
    let rows = "
        inspect huge.png => 0: 18000x18000 ... u8
        enhance in.png --normal huge.png -o out.png => 1: inputs of one size
    ";
    desk.check("{}", rows);
}

#[test]
fn inspect_looks_at_the_middle_of_what_is_too_large() {
    let desk = Desk::new();
    // 100 bytes for each of 11 million pixels are more than 1 GiB.
    for name in ["in.png", "n.png"] {
        write_grey(&desk, name, [4096, 2700], |x, y| (x + y) as u8);
    }
    let stdout = desk
        .make("inspect in.png --normal n.png --normal-space view")
        .stdout;
    let is_told = |l: &&str| l.contains("rows in the middle");
    let said: Vec<&str> = stdout.lines().filter(is_told).collect();
    assert_eq!(said.len(), 1, "{stdout}");
    assert!(said[0].contains("of 2700") && stdout.contains("normal encoding"));
}

#[test]
fn pictures_of_no_pixels_are_refused_in_one_line_in_every_role() {
    let desk = small();
    desk.write(
        "none.hdr",
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n",
    );
    let rows = "
        inspect none.hdr => 1: none.hdr: is 0x0 and holds no pixels
        enhance none.hdr --normal n.png -o out.png => 1: none.hdr: is 0x0 and holds no pixels
        enhance in.png --normal none.hdr -o out.png => 1: none.hdr: is 0x0 and holds no pixels
        enhance in.png --normal n.png --occlusion none.hdr -o out.png => 1: none.hdr: is 0x0 and holds no pixels
        relight in.png --normal n.png --environment none.hdr -o out.png => 1: none.hdr: is 0x0 and holds no pixels
        relight in.png --normal n.png --lit-sphere none.hdr -o out.png => 1: none.hdr: is 0x0 and holds no pixels
    ";
    desk.check("{}", rows);
}

#[test]
fn environments_are_reduced_to_what_may_be_used() {
    let desk = small();
    let relight = "relight in.png --normal n.png --environment";
    for sky in ["sky.png", "sky.jpg", "sky.hdr"] {
        // Brighter to the right and upward, in steps far finer than the reduction.
        write_color(&desk, sky, [512, 256], |x, y| {
            [x as f32 / 512.0, 0.3, 1.0 - y as f32 / 256.0]
        });
        // Half of 4 MiB holds a third of 512 x 256 pixels at 48 bytes.
        let [whole, reduced] = ["1G", "4M"]
            .map(|memory| desk.picture(format!("{relight} {sky} --max-memory {memory}")));
        for (whole, reduced) in whole.channels.iter().zip(&reduced.channels) {
            // Two codes of 8 bits.
            assert!(apart(whole, reduced) < 2.5 / 255.0, "{sky}");
        }
    }
    // Half of 500 KiB is less than the 384 KiB of its samples.
    let rows = "
        sky.jpg => 1: sky.jpg ... decoded whole
        sky.png => 0
    ";
    desk.check(
        &format!("{relight} {{}} -o out.png --max-memory 500K"),
        rows,
    );
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
    let desk = small();
    let mut encoder = png::Encoder::new(File::create(desk.at("bomb.png")).unwrap(), 64, 64);
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
        let ran = relievo_within("ulimit -v 600000", desk.path(), words);
        let is_ended = [Some(0), Some(1)].contains(&ran.code);
        assert!(
            is_ended && ran.stderr.lines().count() <= 1,
            "{words}: {}",
            ran.stderr
        );
    }
    assert_eq!(desk.photo("bomb.png").width, 64);
}

/// A resolution of nothing is not handed on: the EXIF block of a photo, as a big-endian TIFF whose directory at 8 has two
/// resolutions (0x11a and 0x11b, fractions at 50) and their unit (0x128), inches.
#[test]
fn an_unsound_resolution_is_left_out_of_the_copy() {
    let desk = small();
    write_color(&desk, "in.jpg", [64, 64], |x, y| {
        [x, y, 9].map(|v| v as f32 / 64.0)
    });
    let plain = desk.bytes("in.jpg");
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
        desk.write("exif.jpg", [&segment, &plain[4 + own..]].concat());
        for output in ["o.jpg", "o.png"] {
            desk.make(format!("enhance exif.jpg --normal n.png -o {output}"));
            let written = desk.bytes(output);
            let long = |at: usize| u32::from_be_bytes(written[at..at + 4].try_into().unwrap());
            let block = written.windows(4).position(|bytes| bytes == b"MM\0*");
            let block = block.unwrap();
            // The directory is new; the old one stands before it.
            let directory = block + long(block + 4) as usize;
            for tag in [0x1a, 0x1b] {
                let entry = [1, tag, 0, 5, 0, 0, 0, 1];
                let mut entries = written[directory + 2..].chunks(12);
                let found = entries.find(|bytes| bytes.starts_with(&entry));
                let found = found.map(|bytes| {
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
