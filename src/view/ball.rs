//! A ball on which lights are dragged.

use super::lights::FarLight;
use eframe::egui::{
    self, Color32, Mesh, Painter, Pos2, Response, Role, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo,
    pos2, vec2,
};

/// Diameter of the ball in points.
const SIZE: f32 = 148.0;

/// Rings and sectors of its mesh.
const RINGS: usize = 14;
const SECTORS: usize = 48;

/// Colour of what lights are dragged by.
const MARK: Color32 = Color32::from_rgb(240, 150, 30);

/// Ambient light, so that the dark side stays visible.
const EVEN: f32 = 0.12;

/// The ball, lit by `lights`; dragging moves the nearest one. The response is marked as changed if a light moved.
pub(super) fn ball(ui: &mut Ui, lights: &mut [FarLight]) -> Response {
    let (rect, mut response) = ui.allocate_exact_size(Vec2::splat(SIZE), Sense::click_and_drag());
    let radius = 0.5 * SIZE - 6.0;
    let middle = rect.center();
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Light ball"));
    let held = response.id.with("held light");
    if let Some(pointer) = response.interact_pointer_pos() {
        let place = (pointer - middle) / radius;
        let nearest = || {
            let far = |light: &FarLight| (light.on_ball() - place).length();
            let nearest =
                (0..lights.len()).min_by(|&a, &b| far(&lights[a]).total_cmp(&far(&lights[b])));
            nearest.unwrap_or(0)
        };
        let begins = response.drag_started() || response.clicked();
        let kept = ui.data(|data| data.get_temp::<usize>(held));
        let index = match kept {
            Some(index) if !begins && index < lights.len() => index,
            _ => nearest(),
        };
        ui.data_mut(|data| data.insert_temp(held, index));
        if let Some(light) = lights.get_mut(index)
            && (response.dragged() || response.clicked())
        {
            let moved = light.moved_to(place);
            if moved != *light {
                *light = moved;
                response.mark_changed();
            }
        }
    }
    if ui.is_rect_visible(rect) {
        paint(ui, middle, radius, lights);
    }
    response.on_hover_text("Drag: where the light comes from.\nIn the middle it shines from the viewer, at the rim from the side.")
}

fn paint(ui: &Ui, middle: Pos2, radius: f32, lights: &[FarLight]) {
    let painter = ui.painter();
    let toward: Vec<_> = lights
        .iter()
        .map(|light| (light, to_light(light)))
        .collect();
    let shade = |place: Vec2| {
        let z = (1.0 - place.length_sq()).max(0.0).sqrt();
        let mut color = [EVEN; 3];
        for (light, direction) in &toward {
            let cosine = place.x * direction[0] - place.y * direction[1] + z * direction[2];
            for (sum, c) in color.iter_mut().zip(light.color.unwrap_or([1.0; 3])) {
                *sum += 0.85 * c * cosine.max(0.0);
            }
        }
        let [r, g, b] = color.map(|c| c.min(1.0));
        Color32::from(egui::Rgba::from_rgb(r, g, b))
    };
    let mut mesh = Mesh::default();
    let mut add = |place: Vec2| mesh.colored_vertex(middle + radius * place, shade(place));
    add(Vec2::ZERO);
    for ring in 1..=RINGS {
        // Rings are denser toward the rim, where the ball turns away.
        let r = (ring as f32 / RINGS as f32 * std::f32::consts::FRAC_PI_2).sin();
        for sector in 0..SECTORS {
            let angle = sector as f32 / SECTORS as f32 * std::f32::consts::TAU;
            add(r * Vec2::angled(angle));
        }
    }
    let at = |ring: usize, sector: usize| match ring {
        0 => 0,
        _ => (1 + (ring - 1) * SECTORS + sector % SECTORS) as u32,
    };
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let corners = [
                at(ring, sector),
                at(ring + 1, sector),
                at(ring + 1, sector + 1),
                at(ring, sector + 1),
            ];
            mesh.add_triangle(corners[0], corners[1], corners[2]);
            mesh.add_triangle(corners[0], corners[2], corners[3]);
        }
    }
    painter.add(Shape::mesh(mesh));
    let rim = ui.visuals().widgets.noninteractive.bg_stroke.color;
    painter.circle_stroke(middle, radius, Stroke::new(1.0, rim));
    for light in lights {
        let at = middle + radius * light.on_ball();
        knob(painter, at, light.color);
        if let Some(degrees) = light.radius {
            rim_of_light(painter, at, radius, degrees);
        }
    }
    if lights.is_empty() {
        let color = ui.visuals().weak_text_color();
        let font = egui::TextStyle::Small.resolve(ui.style());
        let at = pos2(middle.x, middle.y) + vec2(0.0, 0.0);
        painter.text(
            at,
            egui::Align2::CENTER_CENTER,
            "no light from afar",
            font,
            color,
        );
    }
}

/// A mark to drag a light by, in its colour.
pub(super) fn knob(painter: &Painter, at: Pos2, color: Option<[f32; 3]>) {
    let color = color.unwrap_or([1.0; 3]);
    let most = color.into_iter().fold(1.0, f32::max);
    let [r, g, b] = color.map(|c| c / most);
    let color = Color32::from(egui::Rgba::from_rgb(r, g, b));
    painter.circle(at, 6.0, color, Stroke::new(2.0, MARK));
}

/// The rim of a light of `degrees` around its middle, on a ball of `radius`.
pub(super) fn rim_of_light(painter: &Painter, at: Pos2, radius: f32, degrees: f32) {
    let rim = radius * degrees.clamp(0.0, 90.0).to_radians().sin();
    painter.circle_stroke(at, rim.max(8.0), Stroke::new(1.0, MARK));
}

/// Unit direction to a light, x right, y up, z toward the viewer.
fn to_light(light: &FarLight) -> [f32; 3] {
    crate::light::lights::direction_of(light.azimuth, light.elevation).to_array()
}
