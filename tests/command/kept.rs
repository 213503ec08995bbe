//! Metadata that pictures keep of their photo, and metadata about themselves.

use super::inputs::grey;
use crate::common::program::Desk;
use image::{ImageDecoder, ImageReader};
use relievo::frame::Plane;
use std::fs;
use std::io::Cursor;

/// Stored columns and rows of the photo.
const STORED: [usize; 2] = [64, 48];

/// A JPEG, dark except for its upper left quarter, with segments of these names and contents after its first two bytes.
fn write_photo(desk: &Desk, name: &str, segments: &[(u8, Vec<u8>)]) {
    let [width, height] = STORED;
    let is_light = |x, y| x < width / 2 && y < height / 2;
    let light = |x, y| if is_light(x, y) { 0.8 } else { 0.1 };
    desk.write_light(name, grey(Plane::from_fn(width, height, light)));
    let plain = desk.bytes(name);
    let mut file = plain[..2].to_vec();
    for (name, content) in segments {
        // 0xff, the name, and the length with its own two bytes.
        file.extend([0xff, *name]);
        file.extend((content.len() as u16 + 2).to_be_bytes());
        file.extend(content);
    }
    file.extend(&plain[2..]);
    desk.write(name, file);
}

/// An EXIF segment (APP1): its name; `MM`, big-endian, 42, the directory at 8; three entries of a tag, a kind, a count and a
/// value: orientation (0x112, a short), artist (0x13b, a text of 6 bytes at 50), resolution unit (0x128, centimetres);
/// no next directory; the text.
fn exif(orientation: u8) -> (u8, Vec<u8>) {
    let mut block = b"Exif\0\0MM\0*\0\0\0\x08\0\x03".to_vec();
    block.extend([1, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0]);
    block.extend([1, 0x28, 0, 3, 0, 0, 0, 1, 0, 3, 0, 0]);
    block.extend([1, 0x3b, 0, 2, 0, 0, 0, 6, 0, 0, 0, 50]);
    block.extend(b"\0\0\0\0Marie\0");
    (0xe1, block)
}

/// An ICC segment (APP2), part 1 of 1: of the profile only the space of its colours, 16 bytes in, is of interest here.
fn icc(space: &[u8; 4]) -> (u8, Vec<u8>) {
    let mut profile = vec![7; 128];
    profile[16..20].copy_from_slice(space);
    let name = b"ICC_PROFILE\0\x01\x01";
    (0xe2, [&name[..], &profile].concat())
}

/// A JFIF segment (APP0): its name, version 1.2, a resolution in pixels per inch, no thumbnail.
fn jfif(dpi: u16) -> (u8, Vec<u8>) {
    let [high, low] = dpi.to_be_bytes();
    let numbers = [1, 2, 1, high, low, high, low, 0, 0];
    (0xe0, [&b"JFIF\0"[..], &numbers].concat())
}

/// Normals that face the viewer.
fn write_normals(desk: &Desk, name: &str, [width, height]: [usize; 2]) {
    desk.write_codes(
        name,
        [0.5, 0.5, 1.0].map(|v| Plane::filled(width, height, v)),
        8,
    );
}

fn decoder(desk: &Desk, name: &str) -> impl ImageDecoder + use<> {
    let reader = ImageReader::new(Cursor::new(desk.bytes(name)));
    let reader = reader.with_guessed_format().unwrap();
    reader.into_decoder().unwrap()
}

#[test]
fn photos_stand_as_their_orientation_has_them() {
    let desk = Desk::new();
    write_normals(&desk, "n.png", [48, 64]);
    write_normals(&desk, "lying.png", STORED);
    // The stored upper left corner moves to: for 6, a quarter turn clockwise, the upper right; for 8, the other way,
    // the lower left; for 5, columns for rows, where it is.
    for (orientation, corner) in [(6, [40, 8]), (8, [8, 56]), (5, [8, 8])] {
        write_photo(&desk, "in.jpg", &[exif(orientation)]);
        let made = desk.picture("enhance in.jpg --normal n.png");
        assert_eq!((made.width, made.height), (48, 64));
        for at in [[8, 8], [40, 8], [8, 56], [40, 56]] {
            let light = made.channels[0].at(at[0], at[1]);
            assert_eq!(light > 0.6, at == corner, "{orientation} {at:?} {light}");
        }
        let row = format!(
            "=> 1: lying.png: is 64x48 and has no orientation, but in.jpg is stored as 64x48 with orientation {orientation}, upright 48x64"
        );
        desk.check("enhance in.jpg --normal lying.png -o out.png", &row);
    }
    // Rows of a rotated photo cannot be read without the whole of it.
    let sparing = "relight n.png --normal n.png --environment in.jpg -o out.png --max-memory 8K";
    desk.check(sparing, "=> 1: in.jpg ... orientation");
}

#[test]
fn pictures_keep_profile_and_resolution_and_what_the_camera_said() {
    let desk = Desk::new();
    write_normals(&desk, "n.png", [48, 64]);
    write_photo(&desk, "in.jpg", &[jfif(240), exif(6), icc(b"RGB ")]);
    for name in ["out.png", "out.jpg", "out.tif"] {
        let words = format!("enhance in.jpg --normal n.png --scaling 2 -q -o {name}");
        desk.make(&words);
        let mut made = decoder(&desk, name);
        let profile = made.icc_profile().unwrap();
        assert_eq!(profile, Some(icc(b"RGB ").1[14..].to_vec()), "{name}");
        assert_eq!(made.dimensions(), (48, 64), "{name}");
        let upright = image::metadata::Orientation::NoTransforms;
        assert_eq!(made.orientation().unwrap(), upright, "{name}");
        let file = desk.bytes(name);
        let holds = |text: &str| file.windows(text.len()).any(|part| part == text.as_bytes());
        assert_eq!(holds("Marie"), name != "out.tif", "{name}");
        let version = env!("CARGO_PKG_VERSION");
        for text in [version, "command = \"enhance\"", "scaling = 2"] {
            assert!(holds(text), "{name}: {text}");
        }
        // The same command makes the same file.
        desk.make(&words);
        assert!(file == desk.bytes(name), "{name}");
        // The result is read like a photo: 240 pixels per inch are 9449 per metre, 240.005 again.
        desk.make(format!("enhance {name} --normal n.png -q -o again.png"));
        let png = png::Decoder::new(Cursor::new(desk.bytes("again.png")));
        let dims = png.read_info().unwrap().info().pixel_dims.unwrap();
        assert_eq!((dims.xppu, dims.yppu), (9449, 9449), "{name}");
    }
    // Flags override the photo's data: after its version and unit, 300 in two bytes.
    for command in ["enhance", "relight", "shape"] {
        desk.make(format!(
            "{command} in.jpg --normal n.png --dpi 300 -q -o out.jpg"
        ));
        let head = b"JFIF\0\x01\x02\x01\x01\x2c\x01\x2c";
        assert_eq!(desk.bytes("out.jpg")[6..18], *head);
    }
    // A display of curvature has colours of its own, and a profile of grey does not fit colours.
    desk.make("shape in.jpg --normal n.png -q -o out.png");
    assert_eq!(decoder(&desk, "out.png").icc_profile().unwrap(), None);
    write_photo(&desk, "in.jpg", &[exif(6), icc(b"GRAY")]);
    desk.make("enhance in.jpg --normal n.png -q -o out.png");
    assert_eq!(decoder(&desk, "out.png").icc_profile().unwrap(), None);
}

#[test]
fn quality_is_of_jpegs_alone() {
    let desk = Desk::new();
    write_normals(&desk, "n.png", STORED);
    write_photo(&desk, "in.jpg", &[]);
    let made = |flags: &str| {
        desk.make(format!(
            "enhance in.jpg --normal n.png -q -o out.jpg {flags}"
        ));
        // The first table of quantisation, after its name, length and number.
        let file = desk.bytes("out.jpg");
        let mut pairs = file.windows(2);
        let at = pairs.position(|part| part == [0xff, 0xdb]).unwrap();
        file[at + 5]
    };
    // The table's first number is 16; from a quality of 50 on it is multiplied by (200 - 2 * quality) / 100: 1.6 at
    // 95; below by 50 / quality: 80 at 10.
    assert_eq!(["", "--quality 95", "--quality 10"].map(made), [2, 2, 80]);
    let rows = "
        out.png --quality 80 => 2: --quality ... out.png
        out.jpg --quality 0 => 2: --quality
    ";
    desk.check("enhance in.jpg --normal n.png -o {}", rows);
}

#[test]
fn several_pictures_are_each_made_on_their_own() {
    let desk = Desk::new();
    // One is landscape, the next portrait, and the third has no normals.
    for (name, orientation) in [("a.jpg", 1), ("b.jpg", 6), ("c.jpg", 1)] {
        write_photo(&desk, name, &[exif(orientation)]);
    }
    write_normals(&desk, "a_n.png", STORED);
    write_normals(&desk, "b_n.png", [48, 64]);
    let all = "enhance a.jpg c.jpg b.jpg --normal {name}_n.png -q -o made/new";
    let said = desk.run(all).error(3);
    assert!(said.contains("c_n.png"), "{said}");
    let one = desk.picture("enhance b.jpg --normal b_n.png");
    let made = fs::read_dir(desk.at("made/new")).unwrap();
    let mut made: Vec<_> = made.map(|file| file.unwrap().file_name()).collect();
    made.sort();
    assert_eq!(made, ["a.png", "b.png"]);
    assert_eq!(desk.photo("made/new/b.png"), one);
    // User-defined names; one file for all; one written by two. All fail.
    desk.make("enhance a.jpg --normal {name}_n.png -q -o {name}_e.jpg");
    assert!(desk.has("a_e.jpg"));
    let rows = "
        enhance a.jpg b.jpg --normal {name}_n.png -o x.png => 2: {name}
        enhance a.jpg ./a.jpg --normal {name}_n.png -o made => 2: of another
        enhance a.jpg b.jpg --normal {name}_n.png -o {name}_n.png => 2: is the input
    ";
    desk.check("{}", rows);
    desk.run("enhance c.jpg d.jpg --normal {name}_n.png -q -o made")
        .ended(1);
}
