//! Overlays: values under the pointer, and a hint while there is no picture.

use super::probe::ProbedValue;
use eframe::egui::{
    Align2, Color32, CornerRadius, FontId, Painter, Pos2, Rect, RichText, Ui, Vec2, pos2, vec2,
};

/// The values at a pixel, in the lower left corner of `area`.
pub(super) fn values(ui: &Ui, area: Rect, pixel: [usize; 2], values: &[ProbedValue]) {
    let lines = lines_of(pixel, values);
    let font = FontId::monospace(12.0);
    let painter = ui.painter_at(area);
    let color = Color32::from_gray(235);
    let text = painter.layout_no_wrap(lines.join("\n"), font, color);
    let margin = Vec2::splat(8.0);
    let size = text.size() + 2.0 * margin;
    let corner = pos2(area.left() + 10.0, area.bottom() - 10.0 - size.y);
    let rect = Rect::from_min_size(corner, size);
    painter.rect_filled(rect, CornerRadius::same(4), Color32::from_black_alpha(190));
    painter.galley(corner + margin, text, color);
}

/// The values as lines of text.
pub(super) fn lines_of([x, y]: [usize; 2], values: &[ProbedValue]) -> Vec<String> {
    let position = format!("{:<20} {x}, {y}", "pixel");
    let lines = values.iter().map(|ProbedValue { name, numbers }| {
        let numbers: Vec<_> = numbers.iter().map(|n| format!("{n:9.4}")).collect();
        format!("{name:<20}{}", numbers.join(" "))
    });
    std::iter::once(position).chain(lines).collect()
}

/// A hint for getting started.
pub(super) fn welcome(ui: &mut Ui) {
    ui.centered_and_justified(|ui| {
        ui.label(
            RichText::new("Drop a render with normals (EXR) here, or open one with Ctrl+O.\n\nA photo goes with its normals: relievo view photo.jpg --normal normals.png")
                .size(16.0)
                .weak(),
        );
    });
}

/// A line of text whose left end is at `at`, readable on any picture.
pub(super) fn caption(painter: &Painter, at: Pos2, text: &str) {
    let font = FontId::proportional(13.0);
    let text = painter.layout_no_wrap(text.into(), font, Color32::from_gray(235));
    let rect = Align2::LEFT_CENTER.anchor_size(at, text.size());
    let around = rect.expand2(vec2(8.0, 4.0));
    painter.rect_filled(
        around,
        CornerRadius::same(4),
        Color32::from_black_alpha(190),
    );
    painter.galley(rect.min, text, Color32::WHITE);
}

/// A busy indicator.
pub(super) fn busy(ui: &Ui, area: Rect) {
    let painter = ui.painter_at(area);
    let at = area.right_top() + vec2(-12.0, 10.0);
    let font = FontId::proportional(13.0);
    painter.text(
        at,
        Align2::RIGHT_TOP,
        "\u{2026}",
        font,
        Color32::from_gray(200),
    );
}
