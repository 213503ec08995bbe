//! The viewer, clicked and dragged without a window.

#[path = "../common/mod.rs"]
mod common;

mod choices;
mod controls;
mod files;
mod guide;
mod lights;
mod pictures;

use common::program::fixture;
use eframe::egui;
use eframe::egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::{DynamicImage, RgbImage};
use relievo::view::View;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

/// Time limit for anything here.
const PATIENCE: Duration = Duration::from_secs(60);

/// A viewer that is open on `input`, when it shows it.
struct Window {
    harness: Harness<'static, Option<View>>,
}

impl Window {
    fn on(input: Option<&Path>) -> Self {
        // So high that all controls are in sight.
        Self::sized(input, vec2(1200.0, 2000.0))
    }

    fn sized(input: Option<&Path>, size: Vec2) -> Self {
        let input = input.map(Path::to_path_buf);
        let show = move |ui: &mut egui::Ui, view: &mut Option<View>| {
            let context = ui.ctx().clone();
            let view = view.get_or_insert_with(|| View::new(&context, input.as_deref()));
            view.show(ui);
        };
        let harness = Harness::builder()
            .with_size(size)
            .with_max_steps(64)
            .build_ui_state(show, None);
        let mut window = Self { harness };
        window.settle();
        window
    }

    fn view(&mut self) -> &mut View {
        self.harness.state_mut().as_mut().unwrap()
    }

    /// Continues until all pending results are there.
    fn settle(&mut self) {
        self.until(|view| !view.is_busy());
    }

    /// The same with the small pictures of choices.
    fn settle_small(&mut self) {
        self.until(|view| !view.is_busy() && !view.is_drawing_small());
    }

    fn until(&mut self, is_done: impl Fn(&View) -> bool) {
        let start = Instant::now();
        loop {
            self.harness.run_steps(3);
            if is_done(self.view()) {
                self.harness.run_steps(2);
                if is_done(self.view()) {
                    return;
                }
            }
            assert!(start.elapsed() < PATIENCE, "nothing comes of it");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn click(&mut self, label: &str) {
        // Families have the names of commands; those come first.
        let first = self.harness.get_all_by_label(label).next();
        first
            .unwrap_or_else(|| panic!("nothing is called {label}"))
            .click();
        self.settle();
    }

    /// Whether anything is called `label`.
    fn shows(&self, label: &str) -> bool {
        self.harness.query_all_by_label(label).next().is_some()
    }

    fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.settle();
    }

    fn point_at(&mut self, at: Pos2) {
        self.harness.hover_at(at);
        self.settle();
    }

    /// Drags from one place to another, by way of the middle between them.
    fn drag(&mut self, from: Pos2, to: Pos2) {
        self.harness.hover_at(from);
        self.harness.step();
        self.button(from, true);
        for at in [from + 0.5 * (to - from), to] {
            self.harness.event(Event::PointerMoved(at));
            self.harness.step();
        }
        self.button(to, false);
        self.harness.event(Event::PointerGone);
        self.settle();
    }

    fn button(&mut self, pos: Pos2, pressed: bool) {
        self.harness.event(Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
        self.harness.step();
    }

    /// The centre of the element with this label, and half its size.
    fn place_of(&self, label: &str) -> (Pos2, Vec2) {
        let rect = self.harness.get_by_label(label).rect();
        (rect.center(), 0.5 * rect.size())
    }

    /// The window as it is seen; `None`, said aloud, on a machine without a graphics device.
    fn rendered(&mut self) -> Option<RgbImage> {
        let rendered = catch_unwind(AssertUnwindSafe(|| self.harness.render()));
        if rendered.is_err() {
            assert!(std::env::var_os("RELIEVO_NEEDS_GPU").is_none());
            eprintln!("SKIPPED: nothing is rendered without a graphics device");
        }
        let rendered = rendered.ok()?.unwrap();
        Some(DynamicImage::from(rendered).into_rgb8())
    }

    fn value(&mut self, name: &str) -> Option<String> {
        self.view().value(name).map(String::from)
    }

    fn pixels(&mut self) -> Vec<[u8; 4]> {
        self.view().pixels().unwrap().2.to_vec()
    }
}
