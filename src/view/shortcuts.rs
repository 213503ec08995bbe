//! Keyboard shortcuts, and the window that lists them.

use eframe::egui::{Context, Grid, Key, KeyboardShortcut, Modifiers, Ui, Window};

/// Actions of the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Action {
    Open,
    SavePicture,
    SaveRecipe,
    CopyCommand,
    Undo,
    Redo,
    Split,
    Before,
    Lines,
    Presets,
    Handles,
    Notices,
    Fit,
    ActualSize,
    Probe,
    NextFrame,
    PreviousFrame,
    NextLayer,
    PreviousLayer,
    Help,
}

struct Shortcut {
    action: Action,
    keys: KeyboardShortcut,
    does: &'static str,
}

const fn shortcut(action: Action, modifiers: Modifiers, key: Key, does: &'static str) -> Shortcut {
    Shortcut {
        action,
        keys: KeyboardShortcut::new(modifiers, key),
        does,
    }
}

/// All shortcuts. Those with more modifiers come first, since fewer modifiers match too.
const SHORTCUTS: [Shortcut; 22] = [
    shortcut(
        Action::Open,
        Modifiers::COMMAND,
        Key::O,
        "open a picture or a recipe",
    ),
    shortcut(
        Action::SavePicture,
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        Key::S,
        "save the picture",
    ),
    shortcut(
        Action::SaveRecipe,
        Modifiers::COMMAND,
        Key::S,
        "save the recipe",
    ),
    shortcut(
        Action::CopyCommand,
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        Key::C,
        "copy the command line that makes the same",
    ),
    shortcut(
        Action::Redo,
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        Key::Z,
        "redo",
    ),
    shortcut(Action::Redo, Modifiers::COMMAND, Key::Y, "redo"),
    shortcut(Action::Undo, Modifiers::COMMAND, Key::Z, "undo"),
    shortcut(
        Action::Split,
        Modifiers::NONE,
        Key::S,
        "compare with before; drag the divider",
    ),
    shortcut(
        Action::Before,
        Modifiers::NONE,
        Key::B,
        "the picture before, in place of the other",
    ),
    shortcut(
        Action::Lines,
        Modifiers::NONE,
        Key::D,
        "of a drawing: strokes, contours or interior lines alone",
    ),
    shortcut(Action::Presets, Modifiers::NONE, Key::G, "the presets"),
    shortcut(
        Action::Handles,
        Modifiers::NONE,
        Key::H,
        "hide the handles of lights, or show them",
    ),
    shortcut(
        Action::Notices,
        Modifiers::NONE,
        Key::W,
        "close the warnings, or open them",
    ),
    shortcut(
        Action::Fit,
        Modifiers::NONE,
        Key::F,
        "fit the picture in (or double-click)",
    ),
    shortcut(
        Action::ActualSize,
        Modifiers::NONE,
        Key::Num1,
        "one point for each pixel",
    ),
    shortcut(
        Action::Probe,
        Modifiers::NONE,
        Key::P,
        "values under the pointer",
    ),
    shortcut(
        Action::PreviousLayer,
        Modifiers::SHIFT,
        Key::L,
        "layer before",
    ),
    shortcut(Action::NextLayer, Modifiers::NONE, Key::L, "next layer"),
    shortcut(
        Action::NextFrame,
        Modifiers::NONE,
        Key::ArrowRight,
        "next frame",
    ),
    shortcut(
        Action::PreviousFrame,
        Modifiers::NONE,
        Key::ArrowLeft,
        "frame before",
    ),
    shortcut(Action::Help, Modifiers::NONE, Key::F1, "this list"),
    shortcut(
        Action::Help,
        Modifiers::SHIFT,
        Key::Questionmark,
        "this list",
    ),
];

/// Actions of the keys pressed; while a text is being typed, only those of Ctrl and F1.
pub(super) fn asked(context: &Context) -> Vec<Action> {
    let is_typing = context.egui_wants_keyboard_input();
    let asked = SHORTCUTS.iter().filter(|shortcut| {
        let is_plain = !shortcut.keys.modifiers.command && shortcut.keys.logical_key != Key::F1;
        let may_be_typed = is_typing && is_plain;
        !may_be_typed && context.input_mut(|input| input.consume_shortcut(&shortcut.keys))
    });
    asked.map(|shortcut| shortcut.action).collect()
}

/// The keys of `action` as text; empty if it has none.
pub(super) fn keys_of(context: &Context, action: Action) -> String {
    let shortcut = SHORTCUTS.iter().find(|shortcut| shortcut.action == action);
    shortcut.map_or(String::new(), |s| text_of(context, &s.keys))
}

fn text_of(context: &Context, keys: &KeyboardShortcut) -> String {
    plainly(&context.format_shortcut(keys))
}

/// Spells the question mark as on the key.
fn plainly(keys: &str) -> String {
    keys.replace("Questionmark", "?")
}

/// The list of shortcuts, in its own window.
pub(super) fn help(context: &Context, is_open: &mut bool) {
    Window::new("Keys and mouse")
        .open(is_open)
        .resizable(false)
        .collapsible(false)
        .show(context, list);
}

fn list(ui: &mut Ui) {
    Grid::new("keys")
        .num_columns(2)
        .spacing([24.0, 4.0])
        .show(ui, |ui| {
            for shortcut in &SHORTCUTS {
                ui.monospace(text_of(ui.ctx(), &shortcut.keys));
                ui.label(shortcut.does);
                ui.end_row();
            }
            let mouse = [
                ("wheel", "zoom about the pointer"),
                ("drag", "move the picture"),
                ("drag the ball", "turn the light"),
                ("drag a handle", "move the light; Shift: nearer or farther"),
                (
                    "wheel on a handle",
                    "a light nearer or farther, larger or smaller",
                ),
                ("drop a file", "open a picture or a recipe"),
            ];
            for (does, what) in mouse {
                ui.monospace(does);
                ui.label(what);
                ui.end_row();
            }
        });
}

#[cfg(test)]
mod tests {
    use super::*;
    use eframe::egui::ModifierNames;

    #[test]
    fn the_guide_lists_all_keys() {
        let chapter = include_str!("../../docs/guide/window.md");
        for Shortcut { keys, does, .. } in &SHORTCUTS {
            let keys = plainly(&keys.format(&ModifierNames::NAMES, false));
            let row = format!("| `{keys}` | {does} |");
            assert!(chapter.contains(&row), "the guide has no row {row}");
        }
    }
}
