//! Choices among small pictures: styles, light from files, presets.

use super::{Window, fixture};
use crate::common::program::run;
use eframe::egui::{Key, Modifiers};

#[test]
fn a_style_is_picked_from_what_the_frame_looks_like_in_it() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    window.click("Hatch");
    window.settle_small();
    let before = window.pixels();
    window.click("style pencil");
    assert_eq!(window.value("style").as_deref(), Some("pencil"));
    assert_ne!(window.pixels(), before);
    // Clicked again, it is taken back; and so the default is no setting.
    window.click("style pencil");
    assert_eq!(window.value("style"), None);
    window.click("style auto");
    assert_eq!(window.value("style"), None);
    assert_eq!(window.pixels(), before);
}

#[test]
fn light_is_picked_from_files_beside_the_picture() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    window.settle_small();
    let lamp = window.pixels();
    // Of the square pictures there, two are lit spheres.
    assert!(!window.shows("lit sphere tablet.normal.png"));
    window.click("lit sphere clay.png");
    assert_eq!(window.view().said(), None);
    let sphere = window.value("lit-sphere").unwrap();
    assert!(sphere.ends_with("clay.png"), "{sphere}");
    // It holds all light there is.
    assert_eq!(window.value("light"), None);
    let lit = window.pixels();
    assert_ne!(lit, lamp);
    window.click("environment room.hdr");
    assert_eq!(window.view().said(), None);
    assert_eq!(window.value("lit-sphere"), None);
    assert_ne!(window.pixels(), lit);
    // A light and an environment shine together.
    window.click("Add a light");
    assert!(window.value("environment").is_some() && window.value("light").is_some());
}

#[test]
fn a_preset_of_the_gallery_is_that_of_the_command_line() {
    let place = tempfile::tempdir().unwrap();
    let input = fixture("bust.exr");
    let mut window = Window::on(Some(&input));
    assert!(!window.shows("preset coin"));
    window.press(Modifiers::NONE, Key::G);
    window.settle_small();
    window.click("preset coin");
    assert_eq!(window.view().said(), None);
    assert_eq!(window.view().command(), "hatch");
    let output = place.path().join("coin.png");
    let arguments = [
        "run".as_ref(),
        "coin".as_ref(),
        &*input,
        "-o".as_ref(),
        &*output,
        // As large as it is shown.
        "--style".as_ref(),
        "engraving".as_ref(),
    ];
    run(place.path(), arguments).done();
    let expected = image::open(&output).unwrap().into_rgba8();
    let expected: Vec<_> = expected.pixels().map(|pixel| pixel.0).collect();
    assert!(window.pixels() == expected);
    // Undone, the light is there again.
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.view().command(), "relight");
    window.press(Modifiers::NONE, Key::G);
    assert!(!window.shows("preset coin"));
}
