//! Displayed pictures: in rotated light, before and after, layer by layer, pixel by pixel.

use super::{Window, fixture};
use eframe::egui::{Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;

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
