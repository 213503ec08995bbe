//! What the rows of all settings have in common: a name, a way back to the default, and the changes they report.

use super::look::{Look, Setting};
use eframe::egui::{self, Response, RichText, Ui};

/// Changes made in one frame of the window.
#[derive(Debug, Default)]
pub(super) struct Changes {
    /// The setting that was changed.
    pub(super) changed: Option<String>,
    /// Whether a light near the surface is to be added.
    pub(super) adds_near: bool,
    /// The setting whose file is to be chosen in a dialog.
    pub(super) browses: Option<&'static str>,
}

/// The name of a setting, stronger where it is set.
pub(super) fn name_of(ui: &mut Ui, look: &Look, setting: &Setting) -> Response {
    let label = RichText::new(setting.name.replace('-', " "));
    let label = match look.values(&setting.name).is_empty() {
        true => label,
        false => label.color(ui.visuals().strong_text_color()),
    };
    let width = 118.0;
    let at = ui.cursor().min;
    let size = egui::vec2(width, ui.spacing().interact_size.y);
    let place = egui::Rect::from_min_size(at, size);
    let label = ui.scope_builder(egui::UiBuilder::new().max_rect(place), |ui| {
        ui.add(egui::Label::new(label).truncate())
    });
    ui.advance_cursor_after_rect(place);
    label.inner.on_hover_text(help_of(setting))
}

/// A button that restores the default of a setting, where it is set; returns whether it did.
pub(super) fn reset(ui: &mut Ui, look: &mut Look, setting: &Setting) -> bool {
    if look.values(&setting.name).is_empty() {
        return false;
    }
    let reset = ui.small_button("reset");
    let name = format!("reset {}", setting.name.replace('-', " "));
    named_button(&reset, &name);
    let hint = match &setting.default {
        Some(default) => format!("back to {default}"),
        None => "back to none".into(),
    };
    let is_reset = reset.on_hover_text(hint).clicked();
    if is_reset {
        look.set(&setting.name, None);
    }
    is_reset
}

/// What a setting does, its flag, and its default.
pub(super) fn help_of(setting: &Setting) -> String {
    let default = match &setting.default {
        Some(default) => format!("\nDefault: {default}"),
        None => String::new(),
    };
    format!("{}\n--{}{default}", setting.help, setting.name)
}

/// Gives a button its name for screen readers.
pub(super) fn named_button(response: &Response, name: &str) {
    let info = || egui::WidgetInfo::labeled(egui::Role::Button, true, name);
    response.widget_info(info);
}
