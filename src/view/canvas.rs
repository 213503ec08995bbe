//! The picture: zoomed about the pointer, dragged about, split by a divider.

use super::arrows::Arrow;
use super::texture::ViewTexture;
use eframe::egui::{
    Color32, CursorIcon, Pos2, Rect, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, pos2,
    vec2,
};

/// Limits of the zoom, in points per pixel of the picture.
const LARGEST: f32 = 64.0;
const SMALLEST: f32 = 0.02;

/// Distance in points within which the divider is grabbed.
const GRIP: f32 = 7.0;

/// Zoom, pan and divider of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ViewCanvas {
    /// Points per pixel; `None` fits the whole picture.
    zoom: Option<f32>,
    /// The point of the picture at the centre of the canvas, in shares of its size.
    middle: Vec2,
    /// Position of the divider, as a share of the width.
    pub(super) split: f32,
    holds_divider: bool,
}

impl Default for ViewCanvas {
    fn default() -> Self {
        Self {
            zoom: None,
            middle: Vec2::splat(0.5),
            split: 0.5,
            holds_divider: false,
        }
    }
}

/// The content of the canvas.
pub(super) struct Painted<'a> {
    pub(super) picture: &'a ViewTexture,
    /// The picture shown left of the divider, or in place of the other.
    pub(super) before: Option<&'a ViewTexture>,
    pub(super) is_split: bool,
    pub(super) arrows: &'a [Arrow],
    /// Size of the whole picture; `picture` may hold fewer pixels.
    pub(super) size: [usize; 2],
    pub(super) pixel_aspect: f32,
}

/// Pointer and zoom after a frame of the window.
pub(super) struct CanvasFrame {
    /// The pixel under the pointer.
    pub(super) pixel: Option<[usize; 2]>,
    /// Points per pixel.
    pub(super) zoom: f32,
    /// The rectangle of the whole picture, perhaps beyond the canvas.
    pub(super) rect: Rect,
}

impl ViewCanvas {
    /// Fits the whole picture.
    pub(super) fn fit(&mut self) {
        self.zoom = None;
        self.middle = Vec2::splat(0.5);
    }

    /// Zooms to `zoom` points per pixel.
    pub(super) fn zoom_to(&mut self, zoom: f32) {
        self.zoom = Some(zoom);
    }

    pub(super) fn show(&mut self, ui: &mut Ui, painted: &Painted) -> CanvasFrame {
        let (area, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Picture"));
        let size = vec2(
            painted.size[0] as f32 * painted.pixel_aspect,
            painted.size[1] as f32,
        );
        let fitting = (area.width() / size.x.max(1.0)).min(area.height() / size.y.max(1.0));
        if response.double_clicked() {
            self.fit();
        }
        let rect = self.rect(area, size, fitting);
        self.wheel(ui, &response, area, rect, size, fitting);
        self.drag(
            ui,
            &response,
            rect,
            fitting,
            painted.before.is_some() && painted.is_split,
        );
        let rect = self.rect(area, size, fitting);
        let painter = ui.painter_at(area);
        match painted.before.filter(|_| !painted.is_split) {
            Some(before) => before.paint(&painter, rect),
            None => painted.picture.paint(&painter, rect),
        }
        if let Some(before) = painted.before.filter(|_| painted.is_split) {
            let x = rect.left() + self.split * rect.width();
            let left = Rect::from_min_max(area.min, pos2(x, area.bottom()));
            before.paint(&painter.with_clip_rect(left.intersect(area)), rect);
            divider(&painter, x, area.intersect(rect));
        }
        let scale = vec2(
            rect.width() / painted.picture.size[0].max(1) as f32,
            rect.height() / painted.picture.size[1].max(1) as f32,
        );
        for Arrow { middle, half } in painted.arrows {
            let middle = rect.min + vec2(middle[0], middle[1]) * scale;
            let half = vec2(half[0], half[1]) * scale;
            let stroke = Stroke::new(1.2, Color32::from_rgb(25, 70, 150));
            painter.line_segment([middle - half, middle + half], stroke);
        }
        let pixel = response.hover_pos().and_then(|pointer| {
            let place = (pointer - rect.min) / rect.size();
            let inside = rect.contains(pointer) && place.x < 1.0 && place.y < 1.0;
            let index = |share: f32, count: usize| (share * count as f32) as usize;
            inside.then(|| {
                [
                    index(place.x, painted.size[0]),
                    index(place.y, painted.size[1]),
                ]
            })
        });
        CanvasFrame {
            pixel,
            zoom: self.zoom.unwrap_or(fitting),
            rect,
        }
    }

    /// The rectangle of the picture in `area`.
    fn rect(&self, area: Rect, size: Vec2, fitting: f32) -> Rect {
        let shown = size * self.zoom.unwrap_or(fitting);
        Rect::from_min_size(area.center() - self.middle * shown, shown)
    }

    /// Zooms about the pointer: the point under it stays in place.
    fn wheel(
        &mut self,
        ui: &Ui,
        response: &Response,
        area: Rect,
        rect: Rect,
        size: Vec2,
        fitting: f32,
    ) {
        let Some(pointer) = response.hover_pos() else {
            return;
        };
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        let factor = pinch * (scroll / 240.0).exp2();
        if factor == 1.0 {
            return;
        }
        let zoom = (self.zoom.unwrap_or(fitting) * factor).clamp(SMALLEST, LARGEST);
        let place = (pointer - rect.min) / rect.size();
        self.zoom = Some(zoom);
        self.middle = place + (area.center() - pointer) / (size * zoom);
    }

    fn drag(&mut self, ui: &Ui, response: &Response, rect: Rect, fitting: f32, is_split: bool) {
        let x = rect.left() + self.split * rect.width();
        let is_near = |at: Pos2| is_split && (at.x - x).abs() < GRIP;
        if response.hover_pos().is_some_and(is_near) || self.holds_divider {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        if response.drag_started() {
            let origin = ui.input(|i| i.pointer.press_origin());
            self.holds_divider = origin.is_some_and(is_near);
        }
        if response.dragged() {
            let moved = response.drag_delta();
            match (self.holds_divider, response.interact_pointer_pos()) {
                (true, Some(at)) => {
                    self.split = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
                }
                _ => {
                    self.zoom.get_or_insert(fitting);
                    self.middle -= moved / rect.size();
                }
            }
        } else {
            self.holds_divider = false;
        }
    }
}

fn divider(painter: &eframe::egui::Painter, x: f32, within: Rect) {
    let (top, bottom) = (pos2(x, within.top()), pos2(x, within.bottom()));
    painter.line_segment(
        [top, bottom],
        Stroke::new(3.0, Color32::from_black_alpha(120)),
    );
    painter.line_segment([top, bottom], Stroke::new(1.0, Color32::WHITE));
    let grip = pos2(x, within.center().y);
    painter.circle(
        grip,
        7.0,
        Color32::WHITE,
        Stroke::new(1.0, Color32::from_gray(60)),
    );
    for side in [-1.0, 1.0] {
        let tip = grip + vec2(4.5 * side, 0.0);
        let back = grip + vec2(1.5 * side, 0.0);
        let stroke = Stroke::new(1.2, Color32::from_gray(60));
        painter.line_segment([tip, back + vec2(0.0, 2.5)], stroke);
        painter.line_segment([tip, back - vec2(0.0, 2.5)], stroke);
    }
}
