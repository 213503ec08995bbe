//! The bars above and below the picture.

use super::app::View;
use super::layer::ShownLayer;
use super::look::Look;
use super::notices::Notices;
use super::shortcuts::{Action, keys_of};
use eframe::egui::{self, Align, Button, ComboBox, Layout, RichText, Slider, Ui};

const RECIPE: &str = "The settings, for relievo run";
const PICTURE: &str = "The picture, as the command line writes it";
const COMMAND: &str = "The command line that makes the same";
const PRESETS: &str = "Drawings and light for kinds of subjects";
const COMPARE: &str = "Left of the divider: without its shape brought out";
const PROBE: &str = "Values under the pointer";

impl View {
    /// Files, command and layer.
    pub(super) fn toolbar(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let has_picture = self.input().is_some();
            let mut asked = None;
            let mut button =
                |ui: &mut Ui, enabled: bool, button: Button, hint: &str, action: Action| {
                    let keys = keys_of(ui.ctx(), action);
                    let made = ui.add_enabled(enabled, button);
                    if made.on_hover_text(format!("{hint}  {keys}")).clicked() {
                        asked = Some(action);
                    }
                };
            for (name, enabled, hint, action) in [
                ("Open", true, "A picture or a recipe", Action::Open),
                ("Save recipe", has_picture, RECIPE, Action::SaveRecipe),
                ("Save picture", has_picture, PICTURE, Action::SavePicture),
                ("Copy command", has_picture, COMMAND, Action::CopyCommand),
            ] {
                button(ui, enabled, Button::new(name), hint, action);
            }
            ui.separator();
            let (undo, redo) = (self.history.can_undo(), self.history.can_redo());
            for (name, enabled, hint, action) in [
                ("Undo", undo, "The last change", Action::Undo),
                ("Redo", redo, "What was undone", Action::Redo),
            ] {
                button(ui, enabled, Button::new(name), hint, action);
            }
            ui.separator();
            for &command in Look::commands() {
                let is_current = self.look.command() == command;
                let text = capitalised(command);
                if ui.selectable_label(is_current, text).clicked() && !is_current {
                    self.look.set_command(command);
                }
            }
            let presets = Button::selectable(self.is_choosing, "Presets");
            button(ui, true, presets, PRESETS, Action::Presets);
            ui.separator();
            self.layer_picker(ui);
            for (name, is_on, hint, action) in [
                ("Compare", self.is_split, COMPARE, Action::Split),
                ("Probe", self.is_probing, PROBE, Action::Probe),
                ("Keys", self.is_helping, "Keys and mouse", Action::Help),
            ] {
                button(ui, true, Button::selectable(is_on, name), hint, action);
            }
            if let Some(action) = asked {
                self.act(ui.ctx(), action);
            }
        });
    }

    fn layer_picker(&mut self, ui: &mut Ui) {
        let picker = ComboBox::from_id_salt("layer")
            .width(132.0)
            .selected_text(self.layer.name())
            .show_ui(ui, |ui| {
                for layer in ShownLayer::all(self.look.command()) {
                    let label = ui.selectable_label(self.layer == layer, layer.name());
                    if label.on_hover_text(layer.help()).clicked() {
                        self.layer = layer;
                    }
                }
            });
        picker.response.on_hover_text("Layer");
    }

    /// The status line: a message, or a description of the picture; and the frames of a sequence.
    pub(super) fn status(&mut self, ui: &mut Ui) {
        if let Some(frames) = self.frames.clone().filter(|frames| frames.len() > 1) {
            ui.horizontal(|ui| {
                ui.spacing_mut().slider_width = (ui.available_width() - 120.0).max(60.0);
                let label = ui.label("Frame");
                let last = frames.len() - 1;
                let slider = Slider::new(&mut self.frame_index, 0..=last).show_value(false);
                ui.add(slider).labelled_by(label.id);
                ui.monospace(frames[self.frame_index.min(last)].to_string());
            });
        }
        ui.horizontal(|ui| {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if let Some(shown) = &self.shown {
                    let [width, height] = shown.size;
                    let zoom = 100.0 * self.zoom * ui.ctx().pixels_per_point();
                    let quick = match shown.step {
                        1 => String::new(),
                        step => format!(", every {step}th pixel"),
                    };
                    let took = 1e3 * shown.took.as_secs_f64();
                    ui.weak(format!(
                        "{width} x {height}   {zoom:.0} %   {took:.0} ms{quick}"
                    ));
                    if !shown.warnings.is_empty() {
                        let is_open = self.notices.is_open(&shown.warnings);
                        let text = RichText::new(Notices::count(&shown.warnings));
                        let text = text.color(ui.visuals().warn_fg_color);
                        let label = Button::selectable(is_open, text).small();
                        if ui.add(label).clicked() {
                            self.notices.toggle(&shown.warnings);
                        }
                    }
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    let (text, is_error) = match &self.said {
                        Some(said) => (said.text.clone(), said.is_error),
                        None => (self.about(), false),
                    };
                    let text = RichText::new(text);
                    let text = match is_error {
                        true => text.color(ui.visuals().error_fg_color),
                        false => text,
                    };
                    ui.add(egui::Label::new(text).truncate());
                });
            });
        });
    }
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters.next().map(|c| c.to_ascii_uppercase());
    first.into_iter().chain(letters).collect()
}
