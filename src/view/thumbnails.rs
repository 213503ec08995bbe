//! Small pictures of choices, made by the worker while it has nothing else to do.

use super::look::{LightFile, Look, ShownFile, ViewPixels};
use super::texture::ViewTexture;
use eframe::egui::{
    Color32, Context, CornerRadius, FontId, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui,
    Vec2, WidgetInfo, pos2, vec2,
};
use std::collections::BTreeMap;

/// Longest side of a small picture in pixels.
pub(super) const LONGEST: usize = 240;

/// Height of the name below a small picture, in points.
const NAME: f32 = 15.0;

/// What a small picture shows.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Motif {
    /// The frame with a look. It is reduced, and lengths are in pixels of what it is reduced to: strokes are as large as
    /// in a picture of that size.
    Look(Look, ShownFile),
    /// A picture that light comes from.
    Light(LightFile),
}

/// A small picture: whole and at half its size, which boxes of the panel show without aliasing.
pub(super) struct Small([ViewTexture; 2]);

impl Small {
    fn of(context: &Context, pixels: &ViewPixels, last: Option<Self>) -> Self {
        let [whole, half] = last.map_or([None, None], |Self(last)| last.map(Some));
        Self([
            ViewTexture::of(context, pixels, whole),
            ViewTexture::of(context, &halved(pixels), half),
        ])
    }

    /// The texture for a box with sides of at most `longest` pixels.
    fn for_box(&self, longest: f32) -> &ViewTexture {
        let [whole, half] = &self.0;
        let [width, height] = half.size;
        match width.max(height) as f32 >= longest {
            true => half,
            false => whole,
        }
    }
}

/// The small picture made last for a choice.
struct MadeThumbnail {
    motif: Motif,
    /// `None` if that failed.
    picture: Option<Small>,
}

/// The small pictures of all choices, by name.
#[derive(Default)]
pub(super) struct Thumbnails {
    made: BTreeMap<String, MadeThumbnail>,
    /// Those shown in this frame of the window that are not made yet.
    wanted: Vec<(String, Motif)>,
    ordered: Vec<(String, Motif)>,
}

impl Thumbnails {
    /// The picture of a choice: the one before it until it is made. Asking for it orders it.
    pub(super) fn get(&mut self, name: &str, motif: Motif) -> Option<&Small> {
        let made = self.made.get(name);
        if made.is_none_or(|made| made.motif != motif) {
            self.wanted.push((name.into(), motif));
        }
        made?.picture.as_ref()
    }

    /// Whether the picture of a choice could not be made.
    pub(super) fn has_failed(&self, name: &str) -> bool {
        let made = self.made.get(name);
        made.is_some_and(|made| made.picture.is_none())
    }

    /// Takes in what the worker made.
    pub(super) fn take(
        &mut self,
        context: &Context,
        choice: (String, Motif),
        pixels: Option<ViewPixels>,
    ) {
        // One of before the last order leaves that on its way.
        self.ordered.retain(|ordered| *ordered != choice);
        let (name, motif) = choice;
        let last = self.made.remove(&name).and_then(|made| made.picture);
        let picture = pixels.map(|pixels| Small::of(context, &pixels, last));
        self.made.insert(name, MadeThumbnail { motif, picture });
    }

    /// What was asked for since the last call, to be made; `None` if it is on its way, or the look `is_changing`.
    pub(super) fn order(&mut self, is_changing: bool) -> Option<Vec<(String, Motif)>> {
        let wanted = std::mem::take(&mut self.wanted);
        let is_new = wanted.iter().any(|wanted| !self.ordered.contains(wanted));
        if is_changing || !is_new {
            return None;
        }
        self.ordered.clone_from(&wanted);
        Some(wanted)
    }

    /// Whether any is on its way.
    pub(super) fn is_pending(&self) -> bool {
        !self.ordered.is_empty()
    }
}

/// A picture with half as many rows and columns: of each square of four pixels the mean, weighted by alpha.
fn halved(pixels: &ViewPixels) -> ViewPixels {
    let [width, height] = [pixels.width, pixels.height].map(|side| (side / 2).max(1));
    let square = |x: usize, y: usize| {
        let [columns, rows] =
            [(x, pixels.width), (y, pixels.height)].map(|(at, end)| 2 * at..(2 * at + 2).min(end));
        rows.flat_map(move |y| {
            columns
                .clone()
                .map(move |x| pixels.rgba[y * pixels.width + x])
        })
    };
    let mean = |at: usize| {
        let (mut sum, mut count) = ([0_u32; 4], 0);
        for [r, g, b, a] in square(at % width, at / width) {
            let a = u32::from(a);
            let weighted = [r, g, b].map(|c| u32::from(c) * a);
            for (sum, c) in sum.iter_mut().zip(weighted.into_iter().chain([a])) {
                *sum += c;
            }
            count += 1;
        }
        let [r, g, b, a] = sum;
        let [r, g, b] = [r, g, b].map(|c| ((c + a / 2) / a.max(1)) as u8);
        [r, g, b, (a / count) as u8]
    };
    ViewPixels {
        width,
        height,
        rgba: (0..width * height).map(mean).collect(),
    }
}

/// A small picture in a box of `size` with its name below, to be clicked; `label` names it for screen readers.
pub(super) fn tile(
    ui: &mut Ui,
    size: Vec2,
    picture: Option<&Small>,
    (name, label): (&str, &str),
    is_chosen: bool,
) -> Response {
    let (rect, response) = ui.allocate_exact_size(size + vec2(0.0, NAME), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, label));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let frame = Rect::from_min_size(rect.min, size);
    let painter = ui.painter_at(rect.expand(2.0));
    painter.rect_filled(frame, CornerRadius::same(3), Color32::from_gray(20));
    if let Some(picture) = picture {
        let texture = picture.for_box(size.max_elem() * ui.ctx().pixels_per_point());
        let [width, height] = texture.size.map(|side| side.max(1) as f32);
        let scale = (size.x / width).min(size.y / height);
        let shown = Rect::from_center_size(frame.center(), scale * vec2(width, height));
        texture.paint(&painter, shown);
    }
    let visuals = ui.visuals();
    let stroke = match (is_chosen, response.hovered()) {
        (true, _) => Stroke::new(2.0, visuals.selection.bg_fill),
        (false, true) => Stroke::new(1.0, visuals.strong_text_color()),
        (false, false) => visuals.widgets.noninteractive.bg_stroke,
    };
    painter.rect_stroke(frame, CornerRadius::same(3), stroke, StrokeKind::Outside);
    let color = match is_chosen {
        true => visuals.strong_text_color(),
        false => visuals.text_color(),
    };
    // Names of files may be longer than their picture is wide.
    let font = FontId::proportional(11.0);
    let name = painter.layout_no_wrap(name.into(), font, color);
    let left = (frame.center().x - 0.5 * name.size().x).max(frame.left());
    painter.galley(pos2(left, frame.bottom() + 1.0), name, color);
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_hold_the_mean_of_what_covers() {
        let [red, clear, dark] = [[200, 0, 0, 255], [0, 90, 0, 0], [100, 0, 0, 255]];
        let pixels = ViewPixels {
            width: 3,
            height: 2,
            rgba: vec![red, clear, dark, dark, clear, dark],
        };
        // (200 + 100) / 2, covered by half; the column too many is left out.
        assert_eq!(
            halved(&pixels),
            ViewPixels {
                width: 1,
                height: 1,
                rgba: vec![[150, 0, 0, 127]],
            }
        );
    }
}
