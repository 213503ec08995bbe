//! A bar of a round length on pictures, and the resolution that goes with it.

use super::inputs::grey;
use crate::common::program::Desk;
use relievo::frame::Plane;
use relievo::io::photo::Photo;

const SIZE: [usize; 2] = [240, 160];

/// A photo of grey with a pattern, and normals that face the viewer.
fn desk_of([width, height]: [usize; 2]) -> Desk {
    let desk = Desk::new();
    let pattern = |x: usize, y: usize| 0.3 + 0.2 * ((x / 3 + y / 3) % 2) as f32;
    desk.write_light("in.png", grey(Plane::from_fn(width, height, pattern)));
    let normal = [0.22, 0.22, 1.0].map(|value| Plane::filled(width, height, value));
    desk.write_light("n.png", normal);
    desk
}

/// The longest run of black in any row from `from` on.
fn longest(photo: &Photo, from: usize) -> usize {
    let plane = &photo.channels[0];
    let of_row = |y: usize| {
        let runs = plane.row(y).split(|&v| v > 0.0);
        runs.map(<[f32]>::len).max().unwrap_or(0)
    };
    (from..plane.height()).map(of_row).max().unwrap_or(0)
}

#[test]
fn pictures_have_a_bar_as_long_as_it_says() {
    let desk = desk_of(SIZE);
    let made = |words: &str, name: &str| {
        desk.make(format!("{words} -q -o {name}"));
        desk.photo(name)
    };
    let enhance = "enhance in.png --normal n.png";
    let plain = made(enhance, "plain.png");
    // Three tenths of 240 pixels of 0.05 mm are 3.6 mm: 2 mm are 40 pixels.
    for (words, name) in [
        (enhance, "enhance.tif"),
        (enhance, "enhance.png"),
        (
            "relight in.png --normal n.png --light 135,40",
            "relight.png",
        ),
        ("shape in.png --normal n.png", "shape.png"),
        ("hatch in.png --normal n.png", "hatch.png"),
    ] {
        let words = format!("{words} --pixel-size 0.05mm --scale-bar");
        let on = made(&format!("{words} on"), name);
        assert_eq!([on.width, on.height], SIZE, "{name}");
        assert_eq!(longest(&on, 0), 40, "{name}");
        let outside = made(&format!("{words} outside"), name);
        assert!(outside.height > SIZE[1], "{name}");
        assert_eq!(longest(&outside, SIZE[1]), 40, "{name}");
    }
    let outside = format!("{enhance} --pixel-size 50um --scale-bar outside");
    let outside = made(&outside, "outside.png");
    for y in 0..SIZE[1] {
        assert_eq!(outside.channels[0].row(y), plain.channels[0].row(y));
    }
    // Twice as large, a pixel is half as wide: 2 mm are 80 pixels.
    let twice = "hatch in.png --normal n.png --enlarge 2 --pixel-size 0.05mm --scale-bar outside";
    assert_eq!(longest(&made(twice, "twice.png"), 2 * SIZE[1]), 80);
}

#[test]
fn the_resolution_is_that_of_the_pixels_unless_it_is_given() {
    let desk = desk_of(SIZE);
    let per_metre = |flags: &str| {
        desk.make(format!(
            "enhance in.png --normal n.png -q -o out.png {flags}"
        ));
        let file = std::io::Cursor::new(desk.bytes("out.png"));
        let reader = png::Decoder::new(file).read_info().unwrap();
        reader.info().pixel_dims.map(|dims| dims.xppu)
    };
    assert_eq!(per_metre(""), None);
    // Pixels of 0.05 mm: 20,000 in a metre. 300 in an inch are 11,811 in a metre.
    assert_eq!(per_metre("--pixel-size 0.05mm"), Some(20_000));
    assert_eq!(per_metre("--pixel-size 0.05mm --dpi 300"), Some(11_811));
    // Nobody prints a field in its own size.
    assert_eq!(per_metre("--pixel-size 2m"), None);
    // Of an EXR in its standard attribute, in each way that layers may be written.
    for (flags, density) in [
        ("--pixel-size 0.05mm --layers results", 508.0f32),
        ("--pixel-size 0.05mm --dpi 300 --layers channels", 300.0),
    ] {
        desk.make(format!("enhance fixtures/gears.exr -q -o out.exr {flags}"));
        let attribute = [b"xDensity\0float\0\x04\0\0\0", &density.to_le_bytes()[..]].concat();
        let bytes = desk.bytes("out.exr");
        let is_there = bytes.windows(attribute.len()).any(|w| w == attribute);
        assert!(is_there, "{flags}");
    }
    let rows = "
        --scale-bar on => 2: --pixel-size
        --pixel-size 1mm --scale-bar on => 2: no room
    ";
    desk_of([40, 30]).check("enhance in.png --normal n.png -o out.png {}", rows);
}
