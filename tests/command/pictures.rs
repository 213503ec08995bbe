//! Pictures of every kind, and how inputs are interpreted for them.

use crate::common::program::Desk;
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::scenes::{ExactScene, Surface};

/// The largest difference of two pictures, in codes of 8 bits, and the share of samples that differ.
fn difference(a: &Photo, b: &Photo) -> (f32, f64) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    assert_eq!(a.channels.len(), b.channels.len());
    let samples = |photo: &Photo| -> Vec<f32> {
        let planes = photo.channels.iter().flat_map(|p| p.samples());
        planes.copied().collect()
    };
    let (a, b) = (samples(a), samples(b));
    let apart: Vec<f32> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
    let differ = apart.iter().filter(|&&d| d > 0.0).count();
    let most = apart.iter().copied().fold(0.0, f32::max);
    (most * 255.0, differ as f64 / apart.len() as f64)
}

#[test]
fn every_kind_of_picture_is_written_and_shows_more_shape() {
    let desk = Desk::new();
    let starts: [(&str, &[u8]); 7] = [
        ("png", b"\x89PNG"),
        ("jpg", b"\xff\xd8\xff"),
        ("jpeg", b"\xff\xd8\xff"),
        ("tif", b"II*\0"),
        ("tiff", b"II*\0"),
        ("hdr", b"#?RADIANCE"),
        ("EXR", b"\x76\x2f\x31\x01"),
    ];
    for (extension, start) in starts {
        let [on, off] = ["on", "off"].map(|name| format!("{name}.{extension}"));
        desk.make(format!("enhance fixtures/gears.exr -o {on}"));
        desk.make(format!("enhance fixtures/gears.exr -o {off} --scaling 0"));
        let bytes = desk.bytes(&on);
        assert!(bytes.starts_with(start), "{extension}");
        assert_ne!(bytes, desk.bytes(&off), "{extension} shows no more shape");
        if extension != "EXR" {
            let read = desk.photo(&on);
            assert_eq!((read.width, read.height), (320, 240), "{extension}");
            assert_eq!(read.channels.len(), 3, "{extension}");
            let bits = if extension == "hdr" { 32 } else { 8 };
            assert_eq!(read.bits, bits, "{extension}");
        }
    }
    assert_eq!(desk.names("").len(), 2 * starts.len());
}

/// Both scales of a picture are one, and so is what is said of it and written.
#[test]
fn two_scales_of_a_picture_are_mixed() {
    let desk = Desk::new();
    for verb in ["enhance", "relight"] {
        let picture = |scale| {
            let made = desk.picture(format!("{verb} fixtures/gears.exr --scale {scale}"));
            made.channels
        };
        let mixed = picture("2,8");
        for scale in ["2", "8"] {
            assert!(mixed != picture(scale), "{verb} {scale}");
        }
        assert!(mixed == picture("8,2"), "{verb}");
    }
    let rows = "
        2,8 --explain => 0: scale 2.00 and 8.00 px
        2,-8 => 2: --scale is -8
        2,nan => 2: NaN
        2,5000 => 2: --scale is 5000
        2,8 --solver explicit => 2: explicit steps
    ";
    desk.check("enhance fixtures/gears.exr -o a.png --scale {}", rows);
}

#[test]
#[cfg(not(feature = "gpu"))]
fn a_gpu_is_refused_where_the_program_has_none() {
    // An unrequested GPU is not missed.
    Desk::new().check(
        "enhance fixtures/gears.exr -o a.exr --backend {}",
        "
        gpu => 1: --features gpu
        auto => 0: !GPU
    ",
    );
}

#[test]
fn a_picture_that_is_not_scaled_keeps_every_code() {
    let desk = Desk::new();
    // Every code of 8 bits, and codes of 16 bits from end to end.
    let (width, height) = (48, 40);
    let code = |x: u32, y: u32, c: u32| (x + width * y) * 7 + 85 * c;
    let of_8 = |x, y| [0, 1, 2].map(|c| (code(x, y, c) % 256) as u8);
    let of_16 = |x, y| [0, 1, 2].map(|c| (code(x, y, c) * 4099 % 65536) as u16);
    let rgb8 = image::RgbImage::from_fn(width, height, |x, y| image::Rgb(of_8(x, y)));
    let rgb16 = image::ImageBuffer::from_fn(width, height, |x, y| image::Rgb(of_16(x, y)));
    let rgba8 = image::RgbaImage::from_fn(width, height, |x, y| {
        let [r, g, b] = of_8(x, y);
        image::Rgba([r, g, b, (64 + (5 * x + 3 * y) % 192) as u8])
    });
    let rgba16 = image::ImageBuffer::from_fn(width, height, |x, y| {
        let [r, g, b] = of_16(x, y);
        image::Rgba([r, g, b, (20_000 + (997 * x + 331 * y) % 45_000) as u16])
    });
    let normal = image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([100 + x as u8, 110 + y as u8, 250])
    });
    let pictures: [(&str, image::DynamicImage); 5] = [
        ("rgb8", rgb8.into()),
        ("rgb16", rgb16.into()),
        ("rgba8", rgba8.into()),
        ("rgba16", rgba16.into()),
        ("normal", normal.into()),
    ];
    for (name, picture) in &pictures {
        picture.save(desk.at(&format!("{name}.png"))).unwrap();
    }
    for (name, _) in &pictures[..4] {
        for output in ["out.png", "out.tif"] {
            desk.make(format!(
                "enhance {name}.png --normal normal.png --scaling 0 -o {output}"
            ));
            let is_kept = desk.photo(output) == desk.photo(&format!("{name}.png"));
            assert!(is_kept, "{name} to {output}");
        }
    }
}

#[test]
fn threads_change_no_byte() {
    let desk = Desk::new();
    for (verb, name) in [("enhance", "a.exr"), ("shape", "b.exr"), ("shape", "c.png")] {
        let bytes = [1, 8].map(|threads| {
            desk.make(format!(
                "{verb} fixtures/bust.exr -o {name} --threads {threads}"
            ));
            desk.bytes(name)
        });
        assert!(bytes[0] == bytes[1], "{verb} {name}");
    }
}

#[test]
fn a_camera_file_gives_the_picture_of_the_recovered_camera() {
    let desk = Desk::new();
    for (name, other) in [("bust", "gears"), ("gears", "bust")] {
        let enhanced = |flags: &str| desk.picture(format!("enhance fixtures/{name}.exr {flags}"));
        let recovered = enhanced("");
        let given = enhanced(&format!("--camera fixtures/{name}.camera.json"));
        let (most, differ) = difference(&recovered, &given);
        assert!(most < 1.5 && differ < 0.01, "{name}: {most}, {differ}");
        // Another camera is another picture, so the file is not simply left aside.
        let [own, mut json] =
            [name, other].map(|name| desk.json(&format!("fixtures/{name}.camera.json")));
        for key in ["resolution", "intrinsics_px", "camera_type"] {
            json[key] = own[key].clone();
        }
        desk.write("other.json", json.to_string());
        let wrong = enhanced("--camera other.json --normal-space world");
        let (most, differ) = difference(&recovered, &wrong);
        assert!(most > 3.0 && differ > 0.1, "{name}: {most}, {differ}");
    }
}

#[test]
fn flipping_an_axis_undoes_a_flipped_map() {
    let desk = Desk::new();
    let right = "fixtures/tablet.normal.png";
    let mut map = image::open(desk.at(right)).unwrap().to_rgb8();
    map.pixels_mut()
        .for_each(|pixel| pixel.0[1] = 255 - pixel.0[1]);
    map.save(desk.at("flipped.png")).unwrap();
    let tablet = |normal: &str| {
        desk.picture(format!(
            "enhance fixtures/tablet.color.jpg --normal {normal}"
        ))
    };
    let plain = tablet(right);
    let wrong = tablet(&format!("{right} --normal-flip y"));
    let undone = tablet("flipped.png --normal-flip y");
    let (most, differ) = difference(&plain, &wrong);
    assert!(most > 20.0 && differ > 0.1, "{most}, {differ}");
    // Without the flag the slopes decide: their curl is a thirtieth of that with y reversed. A flag overrides them.
    assert!(difference(&plain, &tablet("flipped.png")).0 < 1.5);
    assert!(difference(&wrong, &tablet("flipped.png --normal-flip none")).0 < 1.5);
    let (most, differ) = difference(&plain, &undone);
    assert!(most < 1.5 && differ < 0.001, "{most}, {differ}");
}

#[test]
fn a_normal_map_of_16_bits_is_finer_than_one_of_8() {
    let desk = Desk::new();
    let frame = ExactScene::orthographic(Surface::ball(60.0), 64.3, 63.8).frame(128, 128);
    let n = &frame.normal;
    desk.write_exr("n.exr", &[("N.x", &n.x), ("N.y", &n.y), ("N.z", &n.z)]);
    let codes = || [&n.x, &n.y, &n.z].map(|plane| plane.map(|v| 0.5 * v + 0.5));
    desk.write_codes("n8.png", codes(), 8);
    desk.write_codes("n16.png", codes(), 16);
    let photo = [150.0, 140.0, 120.0].map(|code| Plane::filled(128, 128, code / 255.0));
    desk.write_codes("photo.png", photo, 8);
    let enhanced = |normal: &str| {
        let flags = "--normal-space view --iterations 0 --curvature-gain 30";
        desk.picture(format!("enhance photo.png --normal {normal} {flags}"))
    };
    let exact = enhanced("n.exr");
    let (most_16, _) = difference(&exact, &enhanced("n16.png"));
    let (most_8, differ_8) = difference(&exact, &enhanced("n8.png"));
    assert!(most_16 < 1.5, "16 bits differ by {most_16}");
    assert!(most_8 > 4.0 && differ_8 > 0.1, "{most_8}, {differ_8}");
}
