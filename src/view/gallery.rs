//! The presets, each applied to the open frame.

use super::look::{Look, ShownFile};
use super::thumbnails::{Motif, Thumbnails, tile};
use eframe::egui::{Context, Grid, Vec2, Window, vec2};

/// Presets side by side.
const COLUMNS: usize = 4;

/// Box of a preset, in points.
const TILE: Vec2 = vec2(192.0, 144.0);

/// Shows the gallery, while it is open; a click sets `look` to a preset.
pub(super) fn gallery(
    context: &Context,
    is_open: &mut bool,
    look: &mut Look,
    reading: &ShownFile,
    thumbnails: &mut Thumbnails,
) {
    Window::new("Presets")
        .open(is_open)
        // Below the toolbar.
        .default_pos([16.0, 48.0])
        .resizable(false)
        .collapsible(false)
        .show(context, |ui| {
            Grid::new("presets").spacing([10.0, 8.0]).show(ui, |ui| {
                for (index, name) in Look::presets().enumerate() {
                    let preset = look.preset(name);
                    let label = format!("preset {name}");
                    let motif = Motif::Look(preset.clone(), reading.clone());
                    let picture = thumbnails.get(&label, motif);
                    if tile(ui, TILE, picture, (name, &label), preset == *look).clicked() {
                        *look = preset;
                    }
                    if index % COLUMNS == COLUMNS - 1 {
                        ui.end_row();
                    }
                }
            });
            ui.weak("As small pictures: strokes are as large as in a picture of that size.");
        });
}
