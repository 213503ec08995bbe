//! Settings picked among small pictures: styles and materials on the open frame, and light from files beside it.

use super::lights::make_way;
use super::look::{ENVIRONMENT, LIT_SPHERE, LightFile, Look, Setting, ShownFile};
use super::setting_row::{Changes, name_of, named_button, reset};
use super::thumbnails::{Motif, Thumbnails, tile};
use crate::params::{self, Kind, Param};
use eframe::egui::{Ui, Vec2, vec2};

/// Settings whose words, those of their table, are shown on the frame.
const WORDS: [&str; 2] = ["style", "material"];

/// Settings that take a file.
const FILES: [&str; 2] = [ENVIRONMENT, LIT_SPHERE];

/// Box of a choice, in points: five fit side by side.
const TILE: Vec2 = vec2(58.0, 44.0);

/// Whether a setting comes first in its family.
pub(super) fn leads(name: &str) -> bool {
    WORDS.contains(&name)
}

/// What small pictures are made of.
pub(super) struct Picks<'a> {
    pub(super) thumbnails: &'a mut Thumbnails,
    pub(super) reading: Option<&'a ShownFile>,
    pub(super) light_files: &'a [LightFile],
}

impl Picks<'_> {
    /// Whether a setting is picked among pictures.
    pub(super) fn shows(&self, name: &str) -> bool {
        self.reading.is_some() && WORDS.iter().chain(&FILES).any(|known| *known == name)
    }
}

/// A choice of a setting.
struct SettingChoice {
    value: String,
    name: String,
    help: String,
    motif: Motif,
    /// Whether it is a file, left out where it turns out to be no light.
    is_file: bool,
}

/// The choices of a setting; a click on the chosen one restores the default.
pub(super) fn picks(
    ui: &mut Ui,
    look: &mut Look,
    setting: &Setting,
    pictures: &mut Picks,
    changes: &mut Changes,
) {
    let Some(reading) = pictures.reading else {
        return;
    };
    let name = setting.name.as_str();
    let current = look.value(name).or(setting.default.as_deref());
    let current = current.map(String::from);
    let choices: Vec<SettingChoice> = match FILES.iter().find(|file| **file == name) {
        Some(_) => of_files(name, pictures.light_files),
        None => of_words(name, look, reading),
    };
    ui.horizontal(|ui| {
        name_of(ui, look, setting);
        if let Some(&name) = FILES.iter().find(|file| **file == name) {
            let browse = ui.small_button("File\u{2026}");
            named_button(&browse, &format!("{} file", name.replace('-', " ")));
            if browse.clicked() {
                changes.browses = Some(name);
            }
        }
        // A value that is none of the choices.
        if let Some(other) = current.as_ref()
            && choices.iter().all(|choice| choice.value != *other)
        {
            ui.weak(other.rsplit('/').next().unwrap_or(other))
                .on_hover_text(other);
        }
        reset(ui, look, setting);
    });
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(6.0, 4.0);
        for choice in &choices {
            let label = format!("{} {}", name.replace('-', " "), choice.name);
            if choice.is_file && pictures.thumbnails.has_failed(&label) {
                continue;
            }
            let picture = pictures.thumbnails.get(&label, choice.motif.clone());
            let is_chosen = current.as_ref() == Some(&choice.value);
            let shown = choice.name.rsplit_once('.');
            let shown = shown.map_or(choice.name.as_str(), |(stem, _)| stem);
            let made = tile(ui, TILE, picture, (shown, &label), is_chosen);
            if made.on_hover_text(&choice.help).clicked() {
                let is_default = setting.default.as_ref() == Some(&choice.value);
                make_way(look, name);
                look.set(
                    name,
                    (!is_default && !is_chosen).then(|| choice.value.clone()),
                );
            }
        }
    });
}

/// The words of a setting, each as the frame looks with it.
fn of_words(name: &str, look: &Look, reading: &ShownFile) -> Vec<SettingChoice> {
    let words: &[params::Choice] = match Param::named(name).map(|row| row.kind) {
        Some(Kind::Choice(words) | Kind::ChoiceOrFolder(words)) => words,
        _ => &[],
    };
    let choice = |word: &params::Choice| SettingChoice {
        value: word.name.into(),
        name: word.name.into(),
        help: word.doc.join("\n").trim().into(),
        motif: Motif::Look(look.with(name, word.name), reading.clone()),
        is_file: false,
    };
    words.iter().map(choice).collect()
}

/// The files that a setting may take.
fn of_files(name: &str, files: &[LightFile]) -> Vec<SettingChoice> {
    let files = files.iter().filter(|file| file.setting == name);
    let choice = |file: &LightFile| SettingChoice {
        value: file.path.display().to_string(),
        name: file
            .path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into(),
        help: file.path.display().to_string(),
        motif: Motif::Light(file.clone()),
        is_file: true,
    };
    files.map(choice).collect()
}
