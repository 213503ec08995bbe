//! Keyboard shortcuts, and the window that lists them.

use eframe::egui::{Context, Grid, Key, KeyboardShortcut, Modifiers, Ui, Window};

/// One of the keys of an action.
struct Shortcut {
    action: Action,
    keys: KeyboardShortcut,
    does: &'static str,
}

/// Defines the actions of the keyboard: the keys of each, several with a stroke between, and what it does.
macro_rules! actions {
    ($($action:ident: $($modifiers:ident $key:ident)|+, $does:literal;)*) => {
        /// Actions of the keyboard.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Action {
            $($action,)*
        }

        const SHORTCUTS: &[Shortcut] = &[$($(Shortcut {
            action: Action::$action,
            keys: KeyboardShortcut::new($modifiers, Key::$key),
            does: $does,
        },)+)*];
    };
}

const PLAIN: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND: Modifiers = Modifiers::COMMAND;
const COMMAND_SHIFT: Modifiers = COMMAND.plus(SHIFT);

// Those with more modifiers come first, since fewer modifiers match too.
actions! {
    Open: COMMAND O, "open a picture or a recipe";
    SavePicture: COMMAND_SHIFT S, "save the picture";
    SaveRecipe: COMMAND S, "save the recipe";
    CopyCommand: COMMAND_SHIFT C, "copy the command line that makes the same";
    Redo: COMMAND_SHIFT Z | COMMAND Y, "redo";
    Undo: COMMAND Z, "undo";
    Split: PLAIN S, "compare with before; drag the divider";
    Before: PLAIN B, "the picture before, in place of the other";
    Lines: PLAIN D, "of a drawing: strokes, contours or interior lines alone";
    Presets: PLAIN G, "the presets";
    Handles: PLAIN H, "hide the handles of lights, or show them";
    Notices: PLAIN W, "close the warnings, or open them";
    Fit: PLAIN F, "fit the picture in (or double-click)";
    ActualSize: PLAIN Num1, "one point for each pixel";
    Probe: PLAIN P, "values under the pointer";
    PreviousLayer: SHIFT L, "layer before";
    NextLayer: PLAIN L, "next layer";
    NextFrame: PLAIN ArrowRight, "next frame";
    PreviousFrame: PLAIN ArrowLeft, "frame before";
    Help: PLAIN F1 | SHIFT Questionmark, "this list";
}

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
            for shortcut in SHORTCUTS {
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
        for Shortcut { keys, does, .. } in SHORTCUTS {
            let keys = plainly(&keys.format(&ModifierNames::NAMES, false));
            let row = format!("| `{keys}` | {does} |");
            assert!(chapter.contains(&row), "the guide has no row {row}");
        }
    }
}
