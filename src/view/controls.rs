//! Controls of all settings of a command, made from the tables of its flags.

use super::light_rows::light_rows;
use super::lights::LIGHTS;
use super::look::{INPUTS, Look, Setting, SettingKind};
use super::picks::{Picks, leads, picks};
use super::setting_row::{Changes, help_of, name_of, reset};
use crate::params::Useful;
use eframe::egui::{
    self, CollapsingHeader, ComboBox, Response, RichText, Slider, SliderClamping, TextEdit, Ui,
};
use std::collections::BTreeMap;

/// Families listed last.
const LAST: [&str; 3] = ["Mirrors and lenses", INPUTS, "Output"];

/// Families that start unfolded.
const OPEN: [&str; 5] = [
    "Strokes",
    "Light",
    "Light warping",
    "Radiance scaling",
    "Shape",
];

/// The controls of one command.
#[derive(Default)]
pub(super) struct Controls {
    command: String,
    families: Vec<(String, Vec<Setting>)>,
    /// Text fields being edited.
    typed: BTreeMap<String, String>,
    sought: String,
    /// Whether settings are shown that few need.
    shows_all: bool,
}

impl Controls {
    /// Shows the controls of `look`. `chosen` are the automatic choices, by setting; some are picked among `pictures`.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        look: &mut Look,
        chosen: &[(String, String)],
        mut pictures: Picks,
    ) -> Changes {
        if self.command != look.command() {
            self.command = look.command().into();
            self.families = families(&self.command);
            self.typed.clear();
        }
        let mut changes = Changes::default();
        let families = std::mem::take(&mut self.families);
        let has_lights = families.iter().flat_map(|(_, all)| all).any(is_light);
        if has_lights {
            light_rows(ui, look, &mut changes);
        }
        ui.horizontal(|ui| {
            let hint = "Find a setting";
            let edit = TextEdit::singleline(&mut self.sought).hint_text(hint);
            ui.add(edit.desired_width(ui.available_width() - 8.0))
                .on_hover_text(hint);
        });
        for (family, settings) in &families {
            let is_usual = |s: &Setting| s.is_common || !look.values(&s.name).is_empty();
            let matches = |s: &&Setting| match self.sought.is_empty() {
                true => self.shows_all || is_usual(s),
                false => is_sought(s, &self.sought),
            };
            let shown = settings.iter().filter(|s| !is_light(s)).filter(matches);
            let shown: Vec<&Setting> = shown.collect();
            if shown.is_empty() {
                continue;
            }
            let is_open = (!self.sought.is_empty()).then_some(true);
            CollapsingHeader::new(RichText::new(family).strong())
                .default_open(OPEN.contains(&family.as_str()))
                .open(is_open)
                .show(ui, |ui| {
                    for setting in shown {
                        let chosen = chosen.iter().find(|(name, _)| *name == setting.name);
                        let chosen = chosen.map(|(_, value)| value.as_str());
                        let before = look.values(&setting.name).to_vec();
                        let is_picked = pictures.shows(&setting.name);
                        if !is_picked || self.shows_all || !self.sought.is_empty() {
                            self.control(ui, look, setting, chosen);
                        }
                        if is_picked {
                            picks(ui, look, setting, &mut pictures, &mut changes);
                        }
                        if look.values(&setting.name) != before {
                            changes.changed = Some(setting.name.clone());
                        }
                    }
                });
        }
        self.families = families;
        let label = match self.shows_all {
            true => "Fewer settings",
            false => "More settings",
        };
        if self.sought.is_empty() && ui.button(label).clicked() {
            self.shows_all = !self.shows_all;
        }
        changes
    }

    /// One control.
    fn control(&mut self, ui: &mut Ui, look: &mut Look, setting: &Setting, chosen: Option<&str>) {
        let value = look.value(&setting.name).map(String::from);
        let current = value.clone().or_else(|| setting.default.clone());
        ui.horizontal(|ui| {
            let label = name_of(ui, look, setting);
            let made = match &setting.kind {
                SettingKind::Switch => {
                    let mut is_on = value.is_some();
                    let switch = ui.checkbox(&mut is_on, "");
                    if switch.changed() {
                        look.set(&setting.name, is_on.then(|| "true".into()));
                    }
                    switch
                }
                SettingKind::Choice(words) => choice(ui, look, setting, words, current.as_deref()),
                SettingKind::Number {
                    range,
                    is_whole,
                    word,
                } => number(
                    ui,
                    look,
                    setting,
                    (range, *is_whole, word.as_deref()),
                    current.as_deref(),
                    chosen,
                ),
                SettingKind::Text {
                    form,
                    is_repeatable,
                } => self.text(ui, look, setting, form, *is_repeatable),
            };
            made.labelled_by(label.id).on_hover_text(help_of(setting));
            if reset(ui, look, setting) {
                self.typed.remove(&setting.name);
            }
        });
    }

    /// A text field, applied when editing ends.
    fn text(
        &mut self,
        ui: &mut Ui,
        look: &mut Look,
        setting: &Setting,
        form: &str,
        is_repeatable: bool,
    ) -> Response {
        let values = look.values(&setting.name);
        let current = match values {
            [] => setting.default.clone().unwrap_or_default(),
            values => values.join("; "),
        };
        let mut text = self
            .typed
            .get(&setting.name)
            .cloned()
            .unwrap_or(current.clone());
        let width = (ui.available_width() - 50.0).max(60.0);
        let edit = TextEdit::singleline(&mut text)
            .hint_text(form)
            .desired_width(width);
        let edit = ui.add(edit);
        if edit.changed() {
            self.typed.insert(setting.name.clone(), text.clone());
        }
        if edit.lost_focus() {
            self.typed.remove(&setting.name);
            let text = text.trim();
            if text != current {
                let values: Vec<String> = match is_repeatable {
                    true => text.split(';').map(|v| v.trim().to_string()).collect(),
                    false => vec![text.into()],
                };
                let is_default = setting.default.as_deref() == Some(text);
                let values = values.into_iter().filter(|v| !v.is_empty() && !is_default);
                look.set_all(&setting.name, values.collect());
            }
        }
        edit
    }
}

fn is_light(setting: &Setting) -> bool {
    LIGHTS.contains(&setting.name.as_str())
}

/// The settings of a command by family, those most used first.
fn families(command: &str) -> Vec<(String, Vec<Setting>)> {
    let mut families: Vec<(String, Vec<Setting>)> = Vec::new();
    for setting in super::look::settings_of(command) {
        match families
            .iter_mut()
            .find(|(name, _)| *name == setting.family)
        {
            Some((_, settings)) => settings.push(setting),
            None => families.push((setting.family.clone(), vec![setting])),
        }
    }
    let rank = |name: &str| {
        let last = LAST.iter().position(|last| *last == name);
        let first = OPEN.iter().position(|open| *open == name);
        match (first, last) {
            (Some(first), _) => first,
            (_, Some(last)) => 200 + last,
            _ => 100,
        }
    };
    families.retain(|(name, _)| !name.is_empty() && name != "Run" && name != "Sequence");
    families.sort_by_key(|(name, _)| rank(name));
    for (_, settings) in &mut families {
        // Text fields come after sliders and choices.
        settings.sort_by_key(|setting| match setting.kind {
            _ if leads(&setting.name) => 0,
            SettingKind::Text { .. } => 2,
            _ => 1,
        });
    }
    families
}

fn is_sought(setting: &Setting, sought: &str) -> bool {
    let sought = sought.trim().to_lowercase();
    let words = || sought.split_whitespace();
    let text = format!("{} {}", setting.name.replace('-', " "), setting.help).to_lowercase();
    words().all(|word| text.contains(word))
}

fn choice(
    ui: &mut Ui,
    look: &mut Look,
    setting: &Setting,
    words: &[String],
    current: Option<&str>,
) -> Response {
    let shown = current.unwrap_or("-");
    let combo = ComboBox::from_id_salt(&setting.name)
        .selected_text(shown)
        .show_ui(ui, |ui| {
            for word in words {
                let is_current = current == Some(word.as_str());
                if ui.selectable_label(is_current, word).clicked() {
                    let is_default = setting.default.as_ref() == Some(word);
                    look.set(&setting.name, (!is_default).then(|| word.clone()));
                }
            }
        });
    combo.response
}

/// A slider; a check box in front of it switches to a word or to no value.
fn number(
    ui: &mut Ui,
    look: &mut Look,
    setting: &Setting,
    (range, is_whole, word): (&Useful, bool, Option<&str>),
    current: Option<&str>,
    chosen: Option<&str>,
) -> Response {
    let given: Option<f64> = current.and_then(|text| text.split(',').next()?.parse().ok());
    let middle = match range.logarithmic {
        true => (range.from * range.to).sqrt(),
        false => 0.5 * (range.from + range.to),
    };
    let stand_in = || chosen.and_then(|text| text.parse().ok()).unwrap_or(middle);
    let may_be_absent = word.is_some() || setting.default.is_none();
    let text_of = |value: f64| match is_whole {
        true => (value.round() as i64).to_string(),
        // Digits of single precision only, as the slider shows them.
        false => (value as f32).to_string(),
    };
    let set = |look: &mut Look, text: String| {
        let is_default = setting.default.as_ref() == Some(&text);
        look.set(&setting.name, (!is_default).then_some(text));
    };
    if may_be_absent {
        let mut is_absent = given.is_none();
        let name = word.unwrap_or("none");
        let check = ui.checkbox(&mut is_absent, name);
        let about = format!("{} {name}", setting.name.replace('-', " "));
        check.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_absent, &about)
        });
        if check.changed() {
            match (is_absent, word) {
                (true, Some(word)) => set(look, word.into()),
                (true, None) => look.set(&setting.name, None),
                (false, _) => set(look, text_of(stand_in())),
            }
        }
        if given.is_none() {
            let text = chosen.map(|text| match text.parse::<f32>() {
                Ok(number) => format!("{number:.3}"),
                Err(_) => text.into(),
            });
            return ui.weak(text.unwrap_or_default());
        }
    }
    let mut value = given.unwrap_or(middle);
    let shown = value;
    // Leaves room for the value and the reset button.
    ui.spacing_mut().slider_width = (ui.available_width() - 112.0).clamp(40.0, 240.0);
    let slider = Slider::new(&mut value, range.from..=range.to)
        .logarithmic(range.logarithmic)
        .clamping(SliderClamping::Never)
        .suffix(setting.unit)
        .max_decimals(if is_whole { 0 } else { 4 });
    let slider = match is_whole {
        true => slider.step_by(1.0),
        false => slider,
    };
    let slider = ui.add(slider);
    if slider.changed() && value != shown {
        set(look, text_of(value));
    }
    slider
}
