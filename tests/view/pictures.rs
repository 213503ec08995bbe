//! Displayed pictures: in rotated light, before and after, layer by layer, pixel by pixel.

use super::{Window, fixture};
use crate::common::program::run;
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use std::path::PathBuf;

#[test]
fn the_light_is_dragged_on_its_ball_and_no_shape_is_made_anew() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    assert_eq!(window.view().command(), "relight");
    let (before, counts) = (window.pixels(), window.view().counts());
    let (middle, half) = window.place_of("Light ball");
    // To the right of the middle, by a third of the way to the rim of the square.
    window.drag(middle, middle + vec2(0.33 * half.x, 0.0));
    let light = window.value("light").unwrap();
    let angles: Vec<f32> = light.split(',').map(|n| n.parse().unwrap()).collect();
    assert_eq!(angles[0], 0.0);
    assert!((60.0..80.0).contains(&angles[1]), "{light}");
    assert_ne!(window.pixels(), before);
    let after = window.view().counts();
    for (pass, count) in &after {
        let made_anew = *count > counts[pass];
        assert_eq!(made_anew, *pass == "relight", "{pass}");
    }
    // Undone, it is as it was, and so again when redone.
    let turned = window.pixels();
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.pixels(), before);
    window.press(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
    assert_eq!(window.pixels(), turned);
}

#[test]
fn layers_are_shown_one_by_one() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let mut seen = vec![window.pixels()];
    for _ in 0..7 {
        window.press(Modifiers::NONE, Key::L);
        assert_eq!(window.view().said(), None);
        let pixels = window.pixels();
        assert!(!seen.contains(&pixels), "a layer looks like another");
        seen.push(pixels);
    }
    window.press(Modifiers::NONE, Key::L);
    assert_eq!(window.pixels(), seen[0]);
    // All of one shape, computed once.
    let counts = window.view().counts();
    assert_eq!(counts["edges-and-gradient"], 1);
    assert_eq!(counts["diffusion"], 1);
}

#[test]
fn values_under_the_pointer_are_those_of_the_layers() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    window.click("Probe");
    let (middle, _) = window.place_of("Picture");
    window.point_at(middle);
    let lines = window.view().probed();
    let of = |name: &str| -> Vec<f32> {
        let line = lines.iter().find(|line| line.starts_with(name));
        let line = line.unwrap_or_else(|| panic!("no {name} in {lines:?}"));
        let numbers = line[20..].replace(',', " ");
        numbers
            .split_whitespace()
            .map(|n| n.parse().unwrap())
            .collect()
    };
    let [width, height] = [480, 360];
    let at = of("pixel");
    assert!((at[0] - width as f32 / 2.0).abs() <= 1.0, "{at:?}");
    assert!((at[1] - height as f32 / 2.0).abs() <= 1.0, "{at:?}");
    let normal = of("normal");
    let length: f32 = normal.iter().map(|n| n * n).sum();
    assert!((length - 1.0).abs() < 1e-3, "{normal:?}");
    assert!(of("depth")[0] > 0.0);
    assert_eq!(of("result").len(), 3);
}

#[test]
fn the_divider_shows_light_without_shape_brought_out() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    window.press(Modifiers::NONE, Key::S);
    let (middle, half) = window.place_of("Picture");
    let split = window.view().split();
    window.drag(middle, middle - vec2(0.25 * half.x, 0.0));
    assert!(window.view().split() < split - 0.05);
    assert_eq!(window.view().said(), None);
}

#[test]
fn a_file_that_is_no_picture_says_so_and_the_next_one_is_shown() {
    let mut window = Window::on(None);
    assert!(window.view().pixels().is_none());
    let place = tempfile::tempdir().unwrap();
    let broken = place.path().join("broken.exr");
    std::fs::write(&broken, b"v/1\x01 and then nothing").unwrap();
    window.view().open(&broken);
    window.settle();
    let said = window.view().said().unwrap().to_string();
    assert!(said.contains("broken.exr"), "{said}");
    assert!(window.harness.query_by_label(&said).is_some());
    window.view().open(&fixture("bust.exr"));
    window.settle();
    assert!(window.view().pixels().is_some());
    assert_eq!(window.view().said(), None);
}

#[test]
fn the_picture_before_is_a_key_away() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let (middle, half) = window.place_of("Picture");
    // Around the middle, where only the bust is.
    let seen = |window: &mut Window| {
        let corner = (middle - vec2(0.1 * half.x, 0.1 * half.x)).to_vec2();
        let [x, y, side] = [corner.x, corner.y, 0.2 * half.x].map(|v| v as u32);
        let whole = window.rendered()?;
        Some(image::imageops::crop_imm(&whole, x, y, side, side).to_image())
    };
    let Some(shown) = seen(&mut window) else {
        return;
    };
    window.press(Modifiers::NONE, Key::B);
    let before = seen(&mut window).unwrap();
    assert!(before != shown);
    // The same light without shape: what the other method makes.
    window.press(Modifiers::NONE, Key::B);
    assert!(seen(&mut window).unwrap() == shown);
    let place = tempfile::tempdir().unwrap();
    let plain = place.path().join("plain.toml");
    let recipe = "version = 1\ncommand = \"relight\"\nlight = \"135,40\"\nmethod = \"plain\"\n";
    std::fs::write(&plain, recipe).unwrap();
    window.view().open(&plain);
    window.settle();
    assert!(seen(&mut window).unwrap() == before);
}

#[test]
fn lines_of_a_drawing_are_shown_alone() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    // New light has none.
    window.press(Modifiers::NONE, Key::D);
    assert_eq!(window.view().layer(), "Picture");
    assert!(window.view().said().unwrap().contains("hatch"));
    window.click("Hatch");
    let drawing = window.pixels();
    let mut seen = vec![drawing.clone()];
    for layer in ["Strokes", "Contours", "Interior lines"] {
        window.press(Modifiers::NONE, Key::D);
        assert_eq!(window.view().layer(), layer);
        let pixels = window.pixels();
        assert!(!seen.contains(&pixels), "{layer} look like another layer");
        // Ink is where the whole drawing has some: nowhere is it darker, rounding aside.
        let darker = pixels
            .iter()
            .zip(&drawing)
            .filter(|(one, all)| one[0].saturating_add(1) < all[0]);
        assert_eq!(darker.count(), 0, "{layer}");
        seen.push(pixels);
    }
    window.press(Modifiers::NONE, Key::D);
    assert!(window.pixels() == drawing);
    // A layer that the next command has not gives way to its picture.
    window.press(Modifiers::NONE, Key::D);
    window.click("Relight");
    assert_eq!(window.view().layer(), "Picture");
}

#[test]
fn warnings_stand_beside_the_picture_in_the_words_of_the_command_line() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let (_, without) = window.place_of("Picture");
    window.slide("scaling", 0.7);
    let scaling = format!("--scaling={}", window.value("scaling").unwrap());
    let place = tempfile::tempdir().unwrap();
    let input = fixture("bust.exr");
    let arguments = ["relight", "--light=135,40", &scaling, "-o", "lit.png", "--"];
    let arguments = arguments.iter().map(|word| (*word).into()).chain([input]);
    let ran = run(place.path(), arguments.collect::<Vec<PathBuf>>()).done();
    // With the feature for GPUs, the program also says where there is none.
    let printed = ran
        .stderr
        .lines()
        .filter_map(|line| line.strip_prefix("warning: "));
    let printed: Vec<_> = printed
        .filter(|warning| !warning.starts_with("no GPU"))
        .collect();
    assert_eq!(printed.len(), 1, "{printed:?}");
    assert!(window.shows(printed[0]), "{}", printed[0]);
    let (_, beside) = window.place_of("Picture");
    assert!(beside.y < without.y);
    window.click("close warnings");
    assert!(!window.shows(printed[0]));
    // The count stays, and opens them again; so does the key.
    window.click("1 warning");
    assert!(window.shows(printed[0]));
    window.press(Modifiers::NONE, Key::W);
    assert!(!window.shows(printed[0]));
    // Others are shown although these were closed.
    window.slide("scaling", 0.6);
    assert!(window.shows("close warnings"));
}
