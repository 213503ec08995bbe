//! Handles in the picture: point lights are dragged over the surface, area lights about a ball that fills the picture.

use super::ball::{knob, rim_of_light};
use super::lights::{FarLight, Lights, NearLight};
use super::overlay;
use super::space::Space;
use eframe::egui::{
    CursorIcon, Id, Pos2, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo, pos2, vec2,
};

/// Side of a handle in points.
const GRIP: f32 = 22.0;

/// Radius of the ball of area lights, as a share of the shorter side of the picture.
const BALL: f32 = 0.45;

/// Points of dragging or scrolling by which a depth or a radius doubles.
const DOUBLING: f32 = 240.0;

/// Where the picture is in the window, and the pixels it has.
#[derive(Debug, Clone, Copy)]
pub(super) struct PicturePlace {
    pub(super) area: Rect,
    pub(super) picture: Rect,
    pub(super) size: [usize; 2],
}

impl PicturePlace {
    fn scale(&self) -> Vec2 {
        let [width, height] = self.size.map(|side| side.max(1) as f32);
        self.picture.size() / vec2(width, height)
    }
}

/// Shows the handles; `lights` move with them.
pub(super) fn handles(ui: &Ui, place: &PicturePlace, space: &Space, lights: &mut Lights) {
    let far_count = lights.far.len();
    for (index, light) in lights.far.iter_mut().enumerate() {
        if light.radius.is_some() {
            round(ui, place, light, index + 1);
        }
    }
    for (index, light) in lights.near.iter_mut().enumerate() {
        near(ui, place, space, light, far_count + index + 1);
    }
}

fn round(ui: &Ui, place: &PicturePlace, light: &mut FarLight, number: usize) {
    let middle = place.picture.center();
    let ball = BALL * place.picture.size().min_elem();
    let handle = Handle::at(
        ui,
        place,
        middle + ball * light.on_ball(),
        "Area light",
        number,
    );
    if let Some(to) = handle.dragged_to(ui) {
        *light = light.moved_to((to - middle) / ball);
    }
    let turned = handle.turned(ui);
    if let Some(radius) = light.radius.as_mut().filter(|_| turned != 0.0) {
        let grown = radius.max(1.0) * (turned / DOUBLING).exp2();
        *radius = (10.0 * grown).round().clamp(0.0, 1800.0) / 10.0;
    }
    let at = middle + ball * light.on_ball();
    let painter = ui.painter_at(place.area);
    rim_of_light(&painter, at, ball, light.radius.unwrap_or(0.0));
    handle.paint(ui, place, at, light.color, "scroll: larger or smaller");
}

fn near(ui: &Ui, place: &PicturePlace, space: &Space, light: &mut NearLight, number: usize) {
    let scale = place.scale();
    let seen = |light: &NearLight| {
        let pixel = space.pixel_of(light.position)?;
        Some(place.picture.min + pixel * scale)
    };
    // A light behind the eye has its numbers in the panel.
    let Some(at) = seen(light) else { return };
    let handle = Handle::at(ui, place, at, "Point light", number);
    if handle.goes_deep(ui) {
        let by = handle.response.drag_delta().y;
        light.position = space.deeper(light.position, (-by / DOUBLING).exp2() - 1.0);
    } else if let Some(to) = handle.dragged_to(ui) {
        let pixel = (to - place.picture.min) / scale;
        light.position = space.moved(light.position, pixel);
    }
    let turned = handle.turned(ui);
    if turned != 0.0 {
        light.position = space.deeper(light.position, (turned / DOUBLING).exp2() - 1.0);
    }
    let at = seen(light).unwrap_or(at);
    handle.paint(
        ui,
        place,
        at,
        light.color,
        "scroll or Shift: nearer or farther",
    );
}

struct Handle {
    response: Response,
    /// Remembers where it was grabbed.
    grip: Id,
    at: Pos2,
}

impl Handle {
    /// The handle of a light at `at`, moved to the border if that is out of sight.
    fn at(ui: &Ui, place: &PicturePlace, at: Pos2, kind: &str, number: usize) -> Self {
        let within = place.area.shrink(0.5 * GRIP);
        let at = pos2(
            at.x.clamp(within.left(), within.right()),
            at.y.clamp(within.top(), within.bottom()),
        );
        let id = ui.scope_id().with("light").with(number);
        let rect = Rect::from_center_size(at, Vec2::splat(GRIP));
        let response = ui.interact(rect, id, Sense::drag());
        let name = format!("{kind} {number}");
        response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, &name));
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::Grab);
        }
        let grip = id.with("grip");
        if response.drag_started() {
            let origin = ui.input(|i| i.pointer.press_origin());
            let held = at - origin.unwrap_or(at);
            ui.data_mut(|data| data.insert_temp(grip, held));
        }
        Self { response, grip, at }
    }

    fn goes_deep(&self, ui: &Ui) -> bool {
        self.response.dragged() && ui.input(|i| i.modifiers.shift)
    }

    /// Where it is dragged to.
    fn dragged_to(&self, ui: &Ui) -> Option<Pos2> {
        let pointer = self.response.interact_pointer_pos()?;
        let held = ui.data(|data| data.get_temp::<Vec2>(self.grip));
        let to = pointer + held.unwrap_or_default();
        (self.response.dragged() && to != self.at).then_some(to)
    }

    /// How far the wheel was turned over it.
    fn turned(&self, ui: &Ui) -> f32 {
        match self.response.hovered() {
            true => ui.input(|i| i.smooth_scroll_delta().y),
            false => 0.0,
        }
    }

    fn paint(&self, ui: &Ui, place: &PicturePlace, at: Pos2, color: Option<[f32; 3]>, hint: &str) {
        let painter = ui.painter_at(place.area);
        knob(&painter, at, color);
        if self.response.hovered() || self.response.dragged() {
            overlay::caption(&painter, at + vec2(22.0, 0.0), hint);
        }
    }
}
