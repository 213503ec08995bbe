//! Controls: they have the names of their flags, change them, and return to their defaults.

use super::{Window, fixture};
use eframe::egui::{accesskit::Role, vec2};
use egui_kittest::kittest::Queryable;

impl Window {
    /// The slider called `label`, dragged by a share of its length.
    pub(crate) fn slide(&mut self, label: &str, by: f32) {
        let slider = self.harness.get_by_role_and_label(Role::Slider, label);
        let rect = slider.rect();
        let from = rect.left_center() + vec2(0.2 * rect.width(), 0.0);
        self.drag(from, from + vec2(by * rect.width(), 0.0));
    }
}

#[test]
fn a_slider_changes_its_setting_and_its_reset_takes_that_back() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let before = window.pixels();
    assert_eq!(window.value("scaling"), None);
    window.slide("scaling", 0.3);
    let scaling: f32 = window.value("scaling").unwrap().parse().unwrap();
    assert!(scaling > 0.0);
    assert_ne!(window.pixels(), before);
    assert!(window.view().command_line().unwrap().contains("--scaling="));
    window.click("reset scaling");
    assert_eq!(window.value("scaling"), None);
    assert_eq!(window.pixels(), before);
}

#[test]
fn a_number_that_is_chosen_can_be_told() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let before = window.pixels();
    // Few need it, so it is behind a button.
    assert!(!window.shows("curvature gain auto"));
    window.click("More settings");
    window.click("curvature gain auto");
    let told: f32 = window.value("curvature-gain").unwrap().parse().unwrap();
    assert!(told > 0.0);
    // It begins at the chosen value: nothing changes.
    assert_eq!(window.pixels(), before);
    // What is set is shown, even so.
    window.click("Fewer settings");
    window.click("curvature gain auto");
    assert_eq!(window.value("curvature-gain"), None);
}

#[test]
fn every_command_shows_its_picture() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let mut seen = vec![window.pixels()];
    for command in ["Shape", "Enhance", "Hatch"] {
        window.click(command);
        assert_eq!(window.view().said(), None, "{command}");
        let pixels = window.pixels();
        assert!(!seen.contains(&pixels), "{command}");
        seen.push(pixels);
    }
    window.click("Relight");
    assert_eq!(window.pixels(), seen[0]);
}

#[test]
fn lights_are_added_and_removed() {
    let mut window = Window::on(Some(&fixture("bust.exr")));
    let before = window.pixels();
    window.click("Add a light");
    assert!(
        window
            .view()
            .command_line()
            .unwrap()
            .matches("--light=")
            .count()
            == 2
    );
    assert_ne!(window.pixels(), before);
    window.click("remove light 2");
    assert_eq!(window.pixels(), before);
    // Without any the lamp of the command line shines, from where the first light was.
    window.click("remove light 1");
    assert_eq!(window.view().said(), None);
    assert_eq!(window.pixels(), before);
    assert!(window.shows("1 warning"));
    // Where ambient light is asked for there is no lamp; of none the picture would be black.
    window.click("More settings");
    window.slide("ambient", -1.0);
    let said = window.view().said().unwrap().to_string();
    assert!(said.contains("--light"), "{said}");
}
