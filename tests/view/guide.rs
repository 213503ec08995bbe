//! The pictures of the guide are those of the window as it is. `RELIEVO_RENEW=1` writes them anew.

use super::{Window, fixture};
use eframe::egui::{Key, Modifiers, Vec2, pos2, vec2};
use image::RgbImage;
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, crop_imm, resize};
use std::path::Path;

/// What the tests' own panel leaves around the viewer, in points.
const MARGIN: u32 = 8;

/// Columns and rows of a picture made small: 20 x 20 points each.
const SMALL: [u32; 2] = [64, 40];

/// Largest mean difference of the small pictures in grey levels. Their JPEG, another driver's rounding and the time in
/// the status line make less than a tenth of that; a row more in the panel moves all below it.
const MEAN: f64 = 1.0;

impl Window {
    /// As large as the viewer opens. Tests run in the root of the repository: the status line names the file as a user
    /// would, on any machine.
    fn for_the_guide() -> Self {
        let around = Vec2::splat(2.0 * MARGIN as f32);
        let input = Path::new("fixtures/bust.exr");
        Self::sized(Some(input), vec2(1280.0, 800.0) + around)
    }

    /// Compares the window with a picture of the guide, or writes it.
    fn is_as_in_the_guide(&mut self, name: &str) {
        self.settle_small();
        let Some(rendered) = self.rendered() else {
            return;
        };
        let [width, height] = [rendered.width(), rendered.height()].map(|side| side - 2 * MARGIN);
        let shown = crop_imm(&rendered, MARGIN, MARGIN, width, height).to_image();
        let path = fixture(name);
        if std::env::var_os("RELIEVO_RENEW").is_some() {
            let file = std::fs::File::create(&path).unwrap();
            JpegEncoder::new_with_quality(file, 90)
                .encode_image(&shown)
                .unwrap();
        }
        let kept = image::open(&path).unwrap().into_rgb8();
        assert_eq!(shown.dimensions(), kept.dimensions(), "{name}");
        let small = |picture: &RgbImage| resize(picture, SMALL[0], SMALL[1], FilterType::Triangle);
        let (shown, kept) = (small(&shown), small(&kept));
        let apart = shown.iter().zip(kept.iter());
        let sum: f64 = apart.map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
        let mean = sum / shown.len() as f64;
        eprintln!("{name}: {mean:.3} grey levels");
        assert!(
            mean <= MEAN,
            "{name} shows an older window, by {mean:.2} grey levels: renew it with RELIEVO_RENEW=1"
        );
    }
}

#[test]
fn a_light_on_its_ball_with_the_divider_and_values() {
    let mut window = Window::for_the_guide();
    let (middle, half) = window.place_of("Light ball");
    window.drag(middle, middle + vec2(-0.6 * half.x, 0.15 * half.y));
    window.press(Modifiers::NONE, Key::S);
    window.press(Modifiers::NONE, Key::P);
    window.point_at(pos2(690.0, 250.0));
    window.is_as_in_the_guide("view.jpg");
}

#[test]
fn a_drawing_with_its_styles() {
    let mut window = Window::for_the_guide();
    window.click("Hatch");
    let (middle, half) = window.place_of("Light ball");
    window.drag(middle, middle + vec2(0.33 * half.x, -0.36 * half.y));
    window.is_as_in_the_guide("view.hatch.jpg");
}

#[test]
fn lights_dragged_in_the_picture_and_a_warning() {
    let mut window = Window::for_the_guide();
    window.click("Add an area light");
    window.click("remove light 1");
    window.click("Add a point light");
    let (at, _) = window.place_of("Point light 2");
    window.drag(at, at + vec2(-60.0, -40.0));
    window.slide("scaling", 0.15);
    let (at, _) = window.place_of("Point light 2");
    window.point_at(at);
    window.is_as_in_the_guide("view.light.jpg");
}

#[test]
fn the_gallery_of_presets() {
    let mut window = Window::for_the_guide();
    window.press(Modifiers::NONE, Key::G);
    window.is_as_in_the_guide("view.presets.jpg");
}
