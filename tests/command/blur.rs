//! A render out of focus and in motion, and a map of 8 bits.

use crate::common::program::Desk;
use image::{Rgb, RgbImage};
use relievo::frame::Plane;

/// A channel of a command's result.
fn made(desk: &Desk, command: &str, layer: &str) -> Plane {
    let output = "--layers results --depth-of-output float -q -o out.exr";
    desk.make(format!("{command} {output}"));
    desk.channel("out.exr", layer)
}

#[test]
fn what_blur_mixes_fades_to_the_picture_as_it_was() {
    let desk = Desk::new();
    let confidence = made(&desk, "shape fixtures/blur.exr", "weights.confidence");
    // The rim of the wheel below its hub, which rolls before the floor, and the head's brow, which is in focus.
    assert!(confidence.at(165, 134) < 0.2, "{}", confidence.at(165, 134));
    assert_eq!(confidence.at(75, 70), 1.0);
    let mixed = confidence.samples().iter().filter(|c| **c < 1.0).count();
    let share = mixed as f64 / confidence.samples().len() as f64;
    assert!((0.05..0.2).contains(&share), "{share}");

    let before = desk.channel("fixtures/blur.exr", "ViewLayer.Combined.R");
    for command in ["enhance", "relight --light 135,40"] {
        let red = |fade| made(&desk, &format!("{command} fixtures/blur.exr {fade}"), "R");
        let faded = red("");
        let full = red("--blur-fade 0");
        let half = red("--blur-fade 0.5");
        for (i, &was) in before.samples().iter().enumerate() {
            let [full, faded, half] = [&full, &faded, &half].map(|plane| plane.samples()[i]);
            let lost = 1.0 - confidence.samples()[i];
            let bound = 1e-5 * (full + was).abs() + 1e-6;
            for (taken, made) in [(1.0 - lost, faded), (1.0 - 0.5 * lost, half)] {
                let error = made - was - taken * (full - was);
                let is_near = error.abs() <= bound;
                assert!(is_near, "{command} pixel {i}: {error} of {bound}");
            }
        }
    }
}

#[test]
fn sharp_frames_keep_their_samples() {
    let desk = Desk::new();
    for name in [
        "fixtures/bust.exr",
        "fixtures/gears.exr",
        "fixtures/street.exr",
    ] {
        let confidence = made(&desk, &format!("shape {name}"), "weights.confidence");
        assert!(confidence.samples().iter().all(|c| *c == 1.0), "{name}");
        let [faded, full] =
            ["", "--blur-fade 0"].map(|fade| made(&desk, &format!("enhance {name} {fade}"), "G"));
        assert_eq!(faded.samples(), full.samples(), "{name}");
    }
}

#[test]
fn a_soft_form_in_8_bits_has_no_rings() {
    let desk = Desk::new();
    // A dome of radius 3000 px, whose normals change by a code in 24 pixels: its curvature is constant.
    let (size, radius) = (480, 3000.0);
    let mut map = RgbImage::new(size, size);
    for (x, y, pixel) in map.enumerate_pixels_mut() {
        let [nx, ny] = [x, y].map(|i| (f64::from(i) + 0.5 - f64::from(size) / 2.0) / radius);
        let nz = (1.0 - nx * nx - ny * ny).sqrt();
        *pixel = Rgb([nx, -ny, nz].map(|n| ((0.5 * n + 0.5) * 255.0).round() as u8));
    }
    map.save(desk.at("map.png")).unwrap();
    let photo = RgbImage::from_pixel(size, size, Rgb([128; 3]));
    photo.save(desk.at("photo.png")).unwrap();
    // Such a flat shape needs a gain of more than 200. At the finest scale the possible remainder of a step would show
    // at 153.
    let rows = "
        --scale 0.5 => 0: held at 153 ... 8 bits
        => 0: !held
    ";
    let shape =
        "shape photo.png --normal map.png --normal-flip none --layers results -o out.exr {}";
    desk.check(shape, rows);
    let mean = desk.channel("out.exr", "curvature.mean");
    // Convex is negative. A step of 2/255 every 24 pixels is a ridge 5 times as curved as the dome is, and nothing between.
    let exact = -1.0 / radius as f32;
    let inner = mean.rows_within(40..440, 40..440).flatten();
    let square = inner.map(|mean| (mean / exact - 1.0).powi(2)).sum::<f32>() / 400f32.powi(2);
    assert!(square.sqrt() < 0.1, "{}", square.sqrt());
}
