//! The ball, and a row of numbers for each light.

use super::ball::ball;
use super::lights::{FarLight, Lights, NearLight};
use super::look::Look;
use super::setting_row::{Changes, named_button};
use crate::params::MAX_LIGHTS;
use eframe::egui::{Align, DragValue, Layout, Response, Ui, WidgetInfo};

/// Radius in degrees of a new round light.
const RADIUS_DEG: f32 = 15.0;

/// The lights of `look`; nothing is shown of lights that are not in the form of their flags.
pub(super) fn light_rows(ui: &mut Ui, look: &mut Look, changes: &mut Changes) {
    let Some(before) = Lights::of(look) else {
        return;
    };
    let mut lights = before.clone();
    ui.vertical_centered(|ui| ball(ui, &mut lights.far));
    let near_from = 1 + lights.far.len();
    lights.far = rows(ui, &lights.far, 1, far_row);
    lights.near = rows(ui, &lights.near, near_from, near_row);
    let has_room = lights.count() < MAX_LIGHTS as usize;
    ui.add_enabled_ui(has_room, |ui| {
        ui.horizontal(|ui| {
            if ui.small_button("Add a light").clicked() {
                lights.far.push(FarLight {
                    radius: None,
                    ..another(&lights.far)
                });
            }
            let area = ui.small_button("Add an area light");
            if area
                .on_hover_text("A round light: softer shadows")
                .clicked()
            {
                lights.far.push(FarLight {
                    radius: Some(RADIUS_DEG),
                    ..another(&lights.far)
                });
            }
            let point = ui.small_button("Add a point light");
            let hint = "A light near the surface, dragged in the picture; it takes depth";
            changes.adds_near |= point.on_hover_text(hint).clicked();
        });
    });
    ui.separator();
    if let Some(changed) = lights.write(&before, look) {
        changes.changed = Some(changed.into());
    }
}

/// A quarter of a turn from the last one; the lamp, if there is none.
fn another(lights: &[FarLight]) -> FarLight {
    match lights.last() {
        Some(last) => FarLight {
            azimuth: last.azimuth - 90.0,
            ..*last
        },
        None => FarLight::lamp(),
    }
}

/// A row for each light, numbered from `first` on; returns those that are not removed.
fn rows<L: Copy>(
    ui: &mut Ui,
    lights: &[L],
    first: usize,
    row: impl Fn(&mut Ui, &str, &mut L),
) -> Vec<L> {
    let kept = lights.iter().zip(first..).filter_map(|(light, number)| {
        let mut light = *light;
        let name = format!("light {number}");
        let is_kept = ui.horizontal(|ui| {
            row(ui, &name, &mut light);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let remove = ui.small_button("\u{d7}");
                named_button(&remove, &format!("remove {name}"));
                !remove.on_hover_text("Remove this light").clicked()
            })
            .inner
        });
        is_kept.inner.then_some(light)
    });
    kept.collect()
}

fn far_row(ui: &mut Ui, name: &str, light: &mut FarLight) {
    let azimuth = ui.add(degrees(&mut light.azimuth).range(-180.0..=360.0));
    named_number(&azimuth, &format!("{name} azimuth"), light.azimuth);
    azimuth.on_hover_text("Azimuth: counterclockwise from the right");
    let elevation = ui.add(degrees(&mut light.elevation).range(-90.0..=90.0));
    named_number(&elevation, &format!("{name} elevation"), light.elevation);
    elevation.on_hover_text("Elevation: from the picture toward the viewer");
    if let Some(radius) = &mut light.radius {
        let edit = ui.add(degrees(radius).range(0.0..=180.0));
        named_number(&edit, &format!("{name} radius"), *radius);
        edit.on_hover_text("Radius of the round light");
    }
    let mut color = light.color.unwrap_or([1.0; 3]);
    let edit = ui.color_edit_button_rgb(&mut color);
    named_button(&edit, &format!("{name} colour"));
    if edit.changed() {
        light.color = (color != [1.0; 3]).then_some(color);
    }
}

/// Numbers of a light near the surface: its place, and its strength apart from its colour.
fn near_row(ui: &mut Ui, name: &str, light: &mut NearLight) {
    let step = 0.005 * light.position[2].abs().max(1e-6);
    for (axis, value) in ["x", "y", "z"].into_iter().zip(&mut light.position) {
        let edit = ui.add(DragValue::new(value).speed(step).max_decimals(4));
        named_number(&edit, &format!("{name} {axis}"), *value);
        edit.on_hover_text(format!("{axis}, in view space and the units of depth"));
    }
    let color = light.color.unwrap_or([1.0; 3]);
    let mut strength = color.into_iter().fold(0.0, f32::max);
    let mut hue = match strength > 0.0 {
        true => color.map(|c| c / strength),
        false => [1.0; 3],
    };
    let last = (strength, hue);
    let drag = DragValue::new(&mut strength).range(0.0..=1e12);
    let edit = ui.add(drag.speed(0.01 * last.0.max(1e-3)).max_decimals(4));
    named_number(&edit, &format!("{name} strength"), strength);
    edit.on_hover_text("What a white surface shows that faces it at a distance of 1");
    let edit = ui.color_edit_button_rgb(&mut hue);
    named_button(&edit, &format!("{name} colour"));
    if (strength, hue) != last {
        light.color = Some(hue.map(|c| strength * c));
    }
}

fn degrees(value: &mut f32) -> DragValue<'_> {
    DragValue::new(value).suffix("\u{b0}").max_decimals(1)
}

fn named_number(response: &Response, name: &str, value: f32) {
    let info = || {
        let mut info = WidgetInfo::drag_value(true, f64::from(value));
        info.label = Some(name.into());
        info
    };
    response.widget_info(info);
}
