//! Warnings beside the picture: what the command line prints.

use super::setting_row::named_button;
use eframe::egui::{Align, Label, Layout, Panel, RichText, ScrollArea, Ui};

/// Height of the list in points, beyond which it scrolls.
const HIGHEST: f32 = 120.0;

/// The list of warnings, closed until there are others.
#[derive(Debug, Default)]
pub(super) struct Notices {
    closed: Vec<String>,
}

impl Notices {
    /// How many there are, in words.
    pub(super) fn count(warnings: &[String]) -> String {
        match warnings.len() {
            1 => "1 warning".into(),
            count => format!("{count} warnings"),
        }
    }

    pub(super) fn is_open(&self, warnings: &[String]) -> bool {
        !warnings.is_empty() && self.closed != warnings
    }

    /// Closes the list, or opens it again.
    pub(super) fn toggle(&mut self, warnings: &[String]) {
        self.closed = match self.is_open(warnings) {
            true => warnings.to_vec(),
            false => Vec::new(),
        };
    }

    /// Shows the list, if it is open.
    pub(super) fn show(&mut self, ui: &mut Ui, warnings: &[String]) {
        if !self.is_open(warnings) {
            return;
        }
        let mut is_closed = false;
        Panel::bottom("warnings").show(ui, |ui| {
            let color = ui.visuals().warn_fg_color;
            ui.horizontal(|ui| {
                ui.label(RichText::new(Self::count(warnings)).color(color));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let close = ui.small_button("\u{d7}");
                    named_button(&close, "close warnings");
                    is_closed = close
                        .on_hover_text("Close until there are others")
                        .clicked();
                });
            });
            ScrollArea::vertical().max_height(HIGHEST).show(ui, |ui| {
                for warning in warnings {
                    ui.add(Label::new(warning).wrap());
                }
            });
        });
        if is_closed {
            self.toggle(warnings);
        }
    }
}
