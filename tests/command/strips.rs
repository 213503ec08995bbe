//! Pictures larger than the memory allowed: the same bits, strip by strip.

use crate::common::program::{Desk, Ran, program};
use relievo::frame::Plane;
use relievo::io::picture::ViewTransform;

/// 256 x 3200 pixels take about 80 MiB, of 100 bytes each; in 62 MiB a strip has some 500 rows.
const SIZE: [usize; 2] = [256, 3200];

/// Expects the file that a command writes to be the same, whole and in strips.
fn same_in_strips(desk: &Desk, words: &str, least: &str) {
    let (_, output) = words.rsplit_once(' ').unwrap();
    let [whole, strips] = ["8G", least].map(|memory| {
        desk.make(format!("{words} --max-memory {memory}"));
        // The recipe in an EXR does not mention memory.
        desk.shown(output)
    });
    assert!(whole == strips, "{words}");
}

#[test]
fn strips_are_the_whole_bit_for_bit() {
    let desk = Desk::new();
    // Directions on the planes come from the bumps above and below.
    desk.write_bumps("in.exr", 1, SIZE, 0.7, |y| y / 100 % 3 == 0);
    let grain = "--method scale --anisotropy 0.5 --albedo-from picture --material ashikhmin-shirley --coat 10,200 \
                 --tangent curvature";
    for work in [
        "enhance --solver explicit --layers results",
        "enhance --scale 3 --foreshortening 0.5",
        "enhance --scale 2,4",
        "enhance --layers channels --compression zips",
        "enhance --curvature-gain 3 --white-level 0.5 --depth-of-output half",
        "enhance --scaling 0",
        "shape --layers results --write kappa,normal",
        "shape --scale 2,3 --layers results --depth-of-output half",
        "relight --light 30,40 --method both --albedo-from white",
        "relight --light 30,40 --method scale",
        &format!("relight --light 30,40 {grain}"),
    ] {
        same_in_strips(&desk, &format!("{work} in.exr -o out.exr"), "62M");
    }
}

#[test]
fn what_needs_the_picture_whole_is_refused() {
    let desk = Desk::new();
    desk.write_bumps("in.exr", 1, SIZE, 0.7, |_| false);
    let rows = "
        hatch in.exr -o out.png --max-memory 62M => 1: draws the picture whole ... --max-memory
        enhance in.exr -o out.exr --max-memory 30M => 1: even in strips ... --max-memory
    ";
    desk.check("{}", rows);
}

/// A photo and its normal map, in 8 and 16 bits, with alpha in the latter, and a map of noise alone.
fn write_photos(desk: &Desk, [width, height]: [usize; 2]) {
    let wave = |x: usize| (x as f32 * std::f32::consts::TAU / 24.0).sin();
    let normal = |x: usize, y: usize| {
        let n = glam::Vec3::new(0.5 * wave(x), 0.5 * wave(y + 3), 1.0).normalize();
        n * 0.5 + 0.5
    };
    let normals = [0, 1, 2].map(|c| Plane::from_fn(width, height, |x, y| normal(x, y)[c]));
    let color = [0.9, 0.6, 0.3].map(|hue| {
        let light = |x, y| hue * normal(x, y).z * (0.6 + 0.4 * wave(x / 7 + y / 5));
        Plane::from_fn(width, height, light)
    });
    // Empty in the first rows, then a rim, then full.
    let alpha = Plane::from_fn(width, height, |_, y| {
        (y as f32 / 20.0 - 1.0).clamp(0.0, 1.0)
    });
    desk.write_codes("in8.jpg", color.clone(), 8);
    desk.write_codes("n8.png", normals.clone(), 8);
    desk.write_planes("in16.png", color, Some(&alpha), 16, ViewTransform::None);
    desk.write_codes("n16.tif", normals, 16);
    // Slopes spread evenly over .06.
    let noise = |x: usize, y: usize, c: u32| {
        let place = (x * SIZE[1] + y) as u32 * 3 + c;
        let mixed = (place ^ (place >> 15)).wrapping_mul(668_265_263);
        let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(1_274_126_177);
        0.06 * ((mixed ^ (mixed >> 16)) as u8 as f32 / 255.0 - 0.5)
    };
    let normal = |x, y| glam::Vec3::new(noise(x, y, 0), noise(x, y, 1), 1.0).normalize();
    let noisy =
        [0, 1, 2].map(|c| Plane::from_fn(width, height, |x, y| normal(x, y)[c] * 0.5 + 0.5));
    desk.write_codes("noisy.png", noisy, 8);
}

#[test]
fn photos_in_strips_are_the_whole_bit_for_bit() {
    let desk = Desk::new();
    write_photos(&desk, SIZE);
    for words in [
        "enhance in8.jpg --normal n8.png -o a.png",
        "enhance in16.png --normal n16.tif --scale 3 -o a.png",
        "relight in16.png --normal n16.tif --light 30,40 --shadows off -o a.tif",
        "relight in8.jpg --normal n8.png --light 30,40 --method scale --shadows off -o a.jpg",
        "enhance in8.jpg --normal n16.tif --curvature-gain 3 -o a.hdr",
        "shape in8.jpg --normal n8.png -o a.png",
        // Burning light is dimmed by the exposure of the whole.
        "relight in8.jpg --normal n8.png --light 30,40,9,9,9 --method plain --shadows off -o a.png",
        "enhance in8.jpg --normal noisy.png --curvature-gain 3 -o a.png",
    ] {
        same_in_strips(&desk, words, "62M");
    }
    // Less than the 80 MiB of the whole: writing an EXR needs more besides.
    same_in_strips(&desk, "enhance in16.png --normal n8.png -o a.exr", "72M");
}

/// The number of MiB that a refusal names.
fn named(said: &str) -> u64 {
    let (_, rest) = said.split_once("--max-memory ").expect("names the flag");
    let (number, _) = rest.split_once('M').expect("in MiB");
    number.parse().unwrap()
}

/// The least memory that a refusal names is enough, no more than that is taken, and less is refused.
#[test]
fn the_least_memory_that_is_named_is_enough() {
    let desk = Desk::new();
    // Two thirds of the height: whole, that is still more than the least memory of each.
    let size = [SIZE[0], 2 * SIZE[1] / 3];
    write_photos(&desk, size);
    desk.write_bumps("in.exr", 1, size, 0.7, |_| false);
    let sky = image::Rgb32FImage::from_fn(1024, 512, |x, y| image::Rgb([x as f32, y as f32, 9.0]));
    sky.save(desk.at("sky.hdr")).unwrap();
    for work in [
        "enhance in.exr -o out.exr",
        "enhance in.exr -o out.exr --scale 6",
        "shape in8.jpg --normal n8.png --normal-flip none -o out.png",
        "relight in.exr --environment sky.hdr --method warp -o out.exr",
        "relight in8.jpg --normal n8.png --normal-flip none --light 135,40 --shadows off -o out.png",
        "hatch in8.jpg --normal n8.png --normal-flip none -o out.png",
        "hatch in.exr --style engraving -o out.svg",
        "hatch in.exr --style lines --tone relight --environment sky.hdr -o out.exr",
        "hatch in.exr --style stipple --wrap xy -o out.png",
        "shape in.exr --wrap xy -o out.exr",
        "map n8.png --map height,occlusion --wrap xy -o out.exr",
    ] {
        let within = |mib: u64| {
            // Drivers of devices take memory of their own.
            let words = format!("{work} --backend cpu --max-memory {mib}M");
            Ran::measured(program(desk.path()).args(words.split(' ')))
        };
        let (refused, program) = within(32);
        let said = refused.ended(1);
        assert_eq!(said.lines().count(), 1, "{said}");
        // A release refuses in 20 MiB. What this build takes beyond that is its code.
        let larger = program.saturating_sub(20 << 20);
        let least = named(&said);
        let (ran, peak) = within(least);
        ran.ended(0);
        assert!(
            peak <= (least << 20) + larger,
            "{work}: {peak} of {least} MiB + {larger}"
        );
        assert_eq!(named(&within(least - 1).0.ended(1)), least, "{work}");
    }
}
