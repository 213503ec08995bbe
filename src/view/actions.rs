//! What keys and buttons do, and files that are dropped or chosen.

use super::app::View;
use super::files::FilePurpose;
use super::layer::ShownLayer;
use super::lights::make_way;
use super::shortcuts::Action;
use eframe::egui::Context;

impl View {
    /// Takes in files that were dropped or chosen in a dialog.
    pub(super) fn take_files(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            self.open(file.path());
        }
        for (purpose, path) in self.files.chosen() {
            match purpose {
                FilePurpose::Open => self.open(&path),
                FilePurpose::SaveRecipe => self.save_recipe(&path),
                FilePurpose::SavePicture => self.save_picture(&path),
                FilePurpose::Setting(name) => {
                    make_way(&mut self.look, name);
                    self.look.set(name, Some(path.display().to_string()));
                }
            }
        }
    }

    pub(super) fn act(&mut self, context: &Context, action: Action) {
        match action {
            Action::Open => self.browse(context, FilePurpose::Open),
            Action::SavePicture => self.browse(context, FilePurpose::SavePicture),
            Action::SaveRecipe => self.browse(context, FilePurpose::SaveRecipe),
            Action::CopyCommand => {
                if let Some(line) = self.command_line() {
                    context.copy_text(line);
                    self.say("the command line is copied".into(), false);
                }
            }
            Action::Undo => self.look = self.history.undo().unwrap_or(self.look.clone()),
            Action::Redo => self.look = self.history.redo().unwrap_or(self.look.clone()),
            Action::Split => self.is_split = !self.is_split,
            Action::Before => self.is_before = !self.is_before,
            Action::Lines => match ShownLayer::all(self.look.command()).any(ShownLayer::is_drawn) {
                true => self.layer = self.layer.next_lines(),
                false => self.say("lines alone are layers of hatch".into(), false),
            },
            Action::Presets => self.is_choosing = !self.is_choosing,
            Action::Handles => self.hides_handles = !self.hides_handles,
            Action::Notices => {
                if let Some(shown) = &self.shown {
                    self.notices.toggle(&shown.warnings);
                }
            }
            Action::Fit => self.canvas.fit(),
            Action::ActualSize => self.canvas.zoom_to(context.pixels_per_point().recip()),
            Action::Probe => self.is_probing = !self.is_probing,
            Action::NextFrame => self.step_frame(1),
            Action::PreviousFrame => self.step_frame(-1),
            Action::NextLayer => self.step_layer(1),
            Action::PreviousLayer => self.step_layer(-1),
            Action::Help => self.is_helping = !self.is_helping,
        }
    }

    /// Opens a dialog for a file.
    pub(super) fn browse(&self, context: &Context, purpose: FilePurpose) {
        let waker = context.clone();
        let wake = move || waker.request_repaint();
        self.files.ask(purpose, self.input(), wake);
    }

    fn step_frame(&mut self, by: isize) {
        let last = self.frames.as_ref().map_or(0, |frames| frames.len() - 1);
        self.frame_index = self.frame_index.saturating_add_signed(by).min(last);
    }

    fn step_layer(&mut self, by: isize) {
        let layers: Vec<_> = ShownLayer::all(self.look.command()).collect();
        let index = layers.iter().position(|&layer| layer == self.layer);
        let index = index.unwrap_or(0) as isize + by;
        self.layer = layers[index.rem_euclid(layers.len() as isize) as usize];
    }
}
