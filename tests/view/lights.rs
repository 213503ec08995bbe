//! Lights dragged in the picture.

use super::{Window, fixture};
use eframe::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, Pos2, TouchPhase, vec2,
};

impl Window {
    /// The numbers of the first light of a setting.
    fn numbers(&mut self, setting: &str) -> Vec<f32> {
        let text = self.value(setting).unwrap();
        text.split(',').map(|n| n.parse().unwrap()).collect()
    }

    /// Turns the wheel at a place, by some points.
    fn scroll(&mut self, at: Pos2, by: f32) {
        self.point_at(at);
        self.harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, by),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Unknown,
            modifiers: Modifiers::NONE,
        });
        // The wheel turns smoothly.
        self.harness.run_steps(30);
        self.settle();
    }
}

#[test]
fn a_point_light_is_dragged_over_the_surface_and_into_it() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let lamp = window.pixels();
    window.click("Add a point light");
    assert_eq!(window.view().said(), None);
    let placed = window.numbers("point-light");
    let lit = window.pixels();
    assert_ne!(lit, lamp);
    // Before the middle of the picture, where it is dragged by a fifth of the way to its border.
    let (middle, half) = window.place_of("Picture");
    let (at, _) = window.place_of("Point light 2");
    assert!((at - middle).length() < 2.0, "{at} is not {middle}");
    let to = at + vec2(0.2 * half.x, 0.0);
    window.drag(at, to);
    let moved = window.numbers("point-light");
    assert!(moved[0] > placed[0] + 0.01, "{moved:?}");
    assert_eq!(moved[1..], placed[1..]);
    assert_ne!(window.pixels(), lit);
    let (at, _) = window.place_of("Point light 2");
    assert!((at - to).length() < 1.0, "{at} is not {to}");
    // The wheel moves it away along its sight line: 240 points double its depth.
    window.scroll(at, 120.0);
    let deeper = window.numbers("point-light");
    let factor = deeper[2] / moved[2];
    assert!((factor - 2.0_f32.sqrt()).abs() < 0.01, "{factor}");
    // However many steps a turn of the wheel takes, it is undone at once.
    window.press(Modifiers::COMMAND, Key::Z);
    assert_eq!(window.numbers("point-light"), moved);
    window.press(Modifiers::COMMAND, Key::Y);
    assert_eq!(window.numbers("point-light"), deeper);
    let (seen, _) = window.place_of("Point light 2");
    assert!((seen - at).length() < 1.0, "{seen} is not {at}");
    // With Shift it is dragged there: down brings it nearer.
    let shift = Event::ModifiersChanged(Modifiers::SHIFT);
    window.harness.event(shift);
    window.drag(at, at + vec2(0.0, 120.0));
    let none = Event::ModifiersChanged(Modifiers::NONE);
    window.harness.event(none);
    let back = window.numbers("point-light");
    assert!((back[2] - moved[2]).abs() < 0.01, "{back:?}");
    // The picture is not zoomed by that.
    assert_eq!(window.place_of("Picture").0, middle);
    let line = window.view().command_line().unwrap();
    assert!(line.contains("--point-light="), "{line}");
    // Hidden, it is not to be dragged.
    window.press(Modifiers::NONE, Key::H);
    assert!(!window.shows("Point light 2"));
}

#[test]
fn an_area_light_is_dragged_about_the_picture_and_grows() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    window.click("Add an area light");
    let placed = window.numbers("area-light");
    let (middle, _) = window.place_of("Picture");
    let (at, _) = window.place_of("Area light 2");
    // To the right of the middle, as far from it as before.
    let away = (at - middle).length();
    window.drag(at, middle + vec2(away, 0.0));
    let moved = window.numbers("area-light");
    assert_eq!(moved[0], 0.0);
    assert!((moved[1] - placed[1]).abs() <= 1.0, "{moved:?}");
    assert_eq!(window.view().said(), None);
    let (at, _) = window.place_of("Area light 2");
    window.scroll(at, 240.0);
    let grown = window.numbers("area-light");
    assert!((grown[2] - 2.0 * moved[2]).abs() < 0.5, "{grown:?}");
}
