//! Metadata that pictures keep of their photo, and metadata about themselves.

use super::inputs::write_planes;
use crate::common::program::relievo;
use image::{ImageDecoder, ImageReader};
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::io::picture::ViewTransform;
use std::fs::{self, File};
use std::path::Path;

/// Stored columns and rows of the photo.
const STORED: [usize; 2] = [64, 48];

/// A JPEG, dark except for its upper left quarter, with segments of these names and contents after its first two bytes.
fn write_photo(path: &Path, segments: &[(u8, Vec<u8>)]) {
    let [width, height] = STORED;
    let is_light = |x, y| x < width / 2 && y < height / 2;
    let light = |x, y| if is_light(x, y) { 0.8 } else { 0.1 };
    let plane = Plane::from_fn(width, height, light);
    write_planes(
        path,
        [plane.clone(), plane.clone(), plane],
        None,
        8,
        ViewTransform::Srgb,
    );
    let plain = fs::read(path).unwrap();
    let mut file = plain[..2].to_vec();
    for (name, content) in segments {
        // 0xff, the name, and the length with its own two bytes.
        file.extend([0xff, *name]);
        file.extend((content.len() as u16 + 2).to_be_bytes());
        file.extend(content);
    }
    file.extend(&plain[2..]);
    fs::write(path, file).unwrap();
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
fn write_normals(path: &Path, [width, height]: [usize; 2]) {
    let planes = [0.5, 0.5, 1.0].map(|v| Plane::filled(width, height, v));
    write_planes(path, planes, None, 8, ViewTransform::None);
}

/// All bytes of a file.
fn bytes(here: &Path, name: &str) -> Vec<u8> {
    fs::read(here.join(name)).unwrap()
}

fn decoder(path: &Path) -> impl ImageDecoder + use<> {
    let reader = ImageReader::open(path).unwrap().with_guessed_format();
    reader.unwrap().into_decoder().unwrap()
}

#[test]
fn photos_stand_as_their_orientation_has_them() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_normals(&here.join("n.png"), [48, 64]);
    write_normals(&here.join("lying.png"), STORED);
    // The stored upper left corner moves to: for 6, a quarter turn clockwise, the upper right; for 8, the other way,
    // the lower left; for 5, columns for rows, where it is.
    for (orientation, corner) in [(6, [40, 8]), (8, [8, 56]), (5, [8, 8])] {
        write_photo(&here.join("in.jpg"), &[exif(orientation)]);
        let words = "enhance in.jpg --normal n.png -o out.png -q";
        relievo(here, words).done();
        let made = Photo::read(&here.join("out.png")).unwrap();
        assert_eq!((made.width, made.height), (48, 64));
        for at in [[8, 8], [40, 8], [8, 56], [40, 56]] {
            let light = made.channels[0].at(at[0], at[1]);
            assert_eq!(light > 0.6, at == corner, "{orientation} {at:?} {light}");
        }
        let said = relievo(here, "enhance in.jpg --normal lying.png -o out.png").error(1);
        let expected = format!(
            "lying.png: is 64x48 and has no orientation, but in.jpg is stored as 64x48 with orientation {orientation}, upright 48x64"
        );
        assert!(said.contains(&expected), "{said}");
    }
    // Rows of a rotated photo cannot be read without the whole of it.
    let sparing = "relight n.png --normal n.png --environment in.jpg -o out.png --max-memory 8K";
    let said = relievo(here, sparing).error(1);
    assert!(
        said.contains("in.jpg") && said.contains("orientation"),
        "{said}"
    );
}

#[test]
fn pictures_keep_profile_and_resolution_and_what_the_camera_said() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_normals(&here.join("n.png"), [48, 64]);
    write_photo(&here.join("in.jpg"), &[jfif(240), exif(6), icc(b"RGB ")]);
    for name in ["out.png", "out.jpg", "out.tif"] {
        let words = format!("enhance in.jpg --normal n.png --scaling 2 -q -o {name}");
        relievo(here, &words).done();
        let mut made = decoder(&here.join(name));
        let profile = made.icc_profile().unwrap();
        assert_eq!(profile, Some(icc(b"RGB ").1[14..].to_vec()), "{name}");
        assert_eq!(made.dimensions(), (48, 64), "{name}");
        let upright = image::metadata::Orientation::NoTransforms;
        assert_eq!(made.orientation().unwrap(), upright, "{name}");
        let file = bytes(here, name);
        let holds = |text: &str| file.windows(text.len()).any(|part| part == text.as_bytes());
        assert_eq!(holds("Marie"), name != "out.tif", "{name}");
        for text in [
            env!("CARGO_PKG_VERSION"),
            "command = \"enhance\"",
            "scaling = 2",
        ] {
            assert!(holds(text), "{name}: {text}");
        }
        // The same command makes the same file.
        relievo(here, &words).done();
        assert!(file == bytes(here, name), "{name}");
        // The result is read like a photo: 240 pixels per inch are 9449 per metre, 240.005 again.
        let again = format!("enhance {name} --normal n.png -q -o again.png");
        relievo(here, &again).done();
        let png = png::Decoder::new(std::io::BufReader::new(
            File::open(here.join("again.png")).unwrap(),
        ));
        let dims = png.read_info().unwrap().info().pixel_dims.unwrap();
        assert_eq!((dims.xppu, dims.yppu), (9449, 9449), "{name}");
    }
    // Flags override the photo's data: after its version and unit, 300 in two bytes.
    for command in ["enhance", "relight", "shape"] {
        let words = format!("{command} in.jpg --normal n.png --dpi 300 -q -o out.jpg");
        relievo(here, &words).done();
        assert_eq!(
            bytes(here, "out.jpg")[6..18],
            *b"JFIF\0\x01\x02\x01\x01\x2c\x01\x2c"
        );
    }
    // A display of curvature has colours of its own, and a profile of grey does not fit colours.
    relievo(here, "shape in.jpg --normal n.png -q -o out.png").done();
    assert_eq!(decoder(&here.join("out.png")).icc_profile().unwrap(), None);
    write_photo(&here.join("in.jpg"), &[exif(6), icc(b"GRAY")]);
    relievo(here, "enhance in.jpg --normal n.png -q -o out.png").done();
    assert_eq!(decoder(&here.join("out.png")).icc_profile().unwrap(), None);
}

#[test]
fn quality_is_of_jpegs_alone() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_normals(&here.join("n.png"), STORED);
    write_photo(&here.join("in.jpg"), &[]);
    let made = |flags: &str| {
        let words = format!("enhance in.jpg --normal n.png -q -o out.jpg {flags}");
        relievo(here, &words).done();
        // The first table of quantisation, after its name, length and number.
        let file = bytes(here, "out.jpg");
        let at = file
            .windows(2)
            .position(|part| part == [0xff, 0xdb])
            .unwrap();
        file[at + 5]
    };
    // The table's first number is 16; from a quality of 50 on it is multiplied by (200 - 2 * quality) / 100: 1.6 at
    // 95; below by 50 / quality: 80 at 10.
    assert_eq!(["", "--quality 95", "--quality 10"].map(made), [2, 2, 80]);
    let words = "enhance in.jpg --normal n.png -o out.png --quality 80";
    let said = relievo(here, words).refused(2);
    assert!(
        said.contains("--quality") && said.contains("out.png"),
        "{said}"
    );
    relievo(here, "enhance in.jpg --normal n.png -o out.jpg --quality 0").refused(2);
}

#[test]
fn several_pictures_are_each_made_on_their_own() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    // One is landscape, the next portrait, and the third has no normals.
    for (name, orientation) in [("a", 1), ("b", 6), ("c", 1)] {
        write_photo(&here.join(format!("{name}.jpg")), &[exif(orientation)]);
    }
    write_normals(&here.join("a_n.png"), STORED);
    write_normals(&here.join("b_n.png"), [48, 64]);
    let all = "enhance a.jpg c.jpg b.jpg --normal {name}_n.png -q";
    let said = relievo(here, &format!("{all} -o made/new")).error(3);
    assert!(said.contains("c_n.png"), "{said}");
    relievo(here, "enhance b.jpg --normal b_n.png -q -o b.png").done();
    let made = fs::read_dir(here.join("made/new")).unwrap();
    let mut made: Vec<_> = made.map(|file| file.unwrap().file_name()).collect();
    made.sort();
    assert_eq!(made, ["a.png", "b.png"]);
    let one = Photo::read(&here.join("b.png")).unwrap();
    assert_eq!(Photo::read(&here.join("made/new/b.png")).unwrap(), one);
    // User-defined names; one file for all; one written by two.
    relievo(
        here,
        "enhance a.jpg --normal {name}_n.png -q -o {name}_e.jpg",
    )
    .done();
    assert!(here.join("a_e.jpg").exists());
    for (words, expected) in [
        (
            "enhance a.jpg b.jpg --normal {name}_n.png -o x.png",
            "{name}",
        ),
        (
            "enhance a.jpg ./a.jpg --normal {name}_n.png -o made",
            "of another",
        ),
        (
            "enhance a.jpg b.jpg --normal {name}_n.png -o {name}_n.png",
            "is the input",
        ),
    ] {
        let said = relievo(here, words).refused(2);
        assert!(said.contains(expected), "{said}");
    }
    assert!(!here.join("x.png").exists());
    // All fail.
    relievo(here, "enhance c.jpg d.jpg --normal {name}_n.png -q -o made").ended(1);
}
