//! Recipes and pictures that the viewer writes, against the command line's.

use super::Window;
use crate::common::program::{fixture, run};
use eframe::egui::vec2;
use std::path::Path;

/// The pixels of a PNG, opaque where it has no alpha, grey as three equals.
fn pixels_of(path: &Path) -> Vec<[u8; 4]> {
    let picture = image::open(path).unwrap().into_rgba8();
    picture.pixels().map(|pixel| pixel.0).collect()
}

#[test]
fn a_recipe_makes_the_same_picture_from_the_command_line_bit_for_bit() {
    let place = tempfile::tempdir().unwrap();
    let input = fixture("bust.exr");
    let mut window = Window::on(Some(&input));
    let (middle, half) = window.place_of("Light ball");
    window.drag(middle, middle + vec2(-0.4 * half.x, -0.3 * half.y));
    for command in ["Relight", "Enhance", "Hatch", "Shape"] {
        window.click(command);
        if command == "Hatch" {
            // Unless its style is named, a drawing is written larger than it is shown.
            window.settle_small();
            window.click("style engraving");
        }
        let shown = window.pixels();
        let recipe = place.path().join(format!("{command}.toml"));
        let picture = place.path().join(format!("{command}.png"));
        window.view().save_recipe(&recipe);
        window.settle();
        let arguments = ["run".as_ref(), &*recipe, &*input, "-o".as_ref(), &*picture];
        run(place.path(), arguments).done();
        assert!(pixels_of(&picture) == shown, "{command} differs");
        // The viewer's own file is the same.
        let own = place.path().join(format!("{command}.own.png"));
        window.view().save_picture(&own);
        window.settle();
        let [a, b] = [&own, &picture].map(|path| std::fs::read(path).unwrap());
        assert!(a == b, "{command} is written otherwise");
        // And the recipe opens to the same.
        window.view().open(&recipe);
        window.settle();
        assert!(
            window.pixels() == shown,
            "the recipe of {command} opens otherwise"
        );
    }
}

/// A folder as estimators write one is a picture, in the window too.
#[test]
fn a_folder_of_image_and_normals_is_a_picture() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("estimated");
    std::fs::create_dir(&folder).unwrap();
    for (name, to) in [
        ("tablet.color.jpg", "image.jpg"),
        ("tablet.normal.png", "normal.png"),
    ] {
        std::fs::copy(fixture(name), folder.join(to)).unwrap();
    }
    let mut window = Window::on(Some(&folder));
    window.click("Enhance");
    let picture = place.path().join("enhanced.png");
    let arguments = ["enhance".as_ref(), &*folder, "-o".as_ref(), &*picture];
    run(place.path(), arguments).done();
    assert!(pixels_of(&picture) == window.pixels());
}

#[test]
fn the_frames_of_a_sequence_are_gone_through() {
    use eframe::egui::{Key, Modifiers};
    let place = tempfile::tempdir().unwrap();
    for (number, name) in [(7, "bust.exr"), (9, "gears.exr")] {
        let to = place.path().join(format!("shot.{number:04}.exr"));
        std::fs::copy(fixture(name), to).unwrap();
    }
    let mut window = Window::on(Some(&place.path().join("shot.####.exr")));
    let first = window.pixels();
    window.press(Modifiers::NONE, Key::ArrowRight);
    assert_eq!(window.view().said(), None);
    let second = window.pixels();
    assert!(first != second);
    window.press(Modifiers::NONE, Key::ArrowLeft);
    assert!(window.pixels() == first);
    let line = window.view().command_line().unwrap();
    assert!(line.contains("--frames=7,9"), "{line}");
}
