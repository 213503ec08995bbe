//! The window: its state and layout.

use super::canvas::{Canvas, Painted};
use super::controls::Controls;
use super::files::{self, Files, Purpose};
use super::history::History;
use super::layer::Layer;
use super::overlay;
use super::probe::Value;
use super::shortcuts::{self, Action};
use super::texture::Texture;
use super::worker::{Order, Reply, Save, Shown, Worker};
use crate::command::frames_there::frames_on_disk;
use crate::command::look::{Look, Opening, Reading};
use eframe::egui::{CentralPanel, Color32, Context, Frame, Margin, Panel, ScrollArea, Theme, Ui};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Surround of the picture: neutral grey, so that its tones are seen without bias.
const SURROUND: Color32 = Color32::from_gray(38);

/// A one-line message for the user.
#[derive(Debug, Clone)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
}

/// The result that the canvas should show.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    look: Look,
    reading: Reading,
    layer: Layer,
    before: bool,
}

/// A request sent to the worker.
struct Ordered {
    wanted: Wanted,
    number: u64,
    is_quick: bool,
    is_met: bool,
}

/// The viewer.
pub struct View {
    pub(super) look: Look,
    pub(super) history: History,
    pub(super) layer: Layer,
    pub(super) is_split: bool,
    pub(super) is_probing: bool,
    pub(super) is_helping: bool,
    pub(super) frames: Option<Vec<i32>>,
    pub(super) frame_index: usize,
    pub(super) shown: Option<Box<Shown>>,
    pub(super) said: Option<Notice>,
    pub(super) zoom: f32,
    input: Option<PathBuf>,
    controls: Controls,
    canvas: Canvas,
    textures: [Option<Texture>; 2],
    worker: Worker,
    files: Files,
    ordered: Option<Ordered>,
    saving: usize,
    changed: Option<String>,
    /// The pixel probed last, and its values once they arrive.
    probed: Option<([usize; 2], Option<Vec<Value>>)>,
}

impl View {
    /// A viewer that starts with the input and look in `opening`.
    pub(crate) fn of(opening: Opening, context: &Context) -> Self {
        context.set_theme(Theme::Dark);
        context.all_styles_mut(|style| {
            style.spacing.item_spacing.y = 5.0;
            style.interaction.tooltip_delay = 0.4;
        });
        let waker = context.clone();
        let mut view = Self {
            history: History::new(opening.look.clone()),
            look: opening.look,
            layer: Layer::default(),
            is_split: false,
            is_probing: false,
            is_helping: false,
            frames: None,
            frame_index: 0,
            shown: None,
            said: None,
            zoom: 1.0,
            input: None,
            controls: Controls::new(),
            canvas: Canvas::default(),
            textures: [None, None],
            worker: Worker::start(opening.engine, opening.save, move || {
                waker.request_repaint()
            }),
            files: Files::new(),
            ordered: None,
            saving: 0,
            changed: None,
            probed: None,
        };
        if let Some(input) = &opening.input {
            view.open(input);
        }
        if opening.frames.is_some() {
            view.frames = opening.frames;
        }
        view
    }

    /// Opens a picture, all frames of a sequence (`name.####.exr`), or a recipe.
    pub fn open(&mut self, path: &Path) {
        self.said = None;
        if files::is_recipe(path) {
            match Look::of_recipe(path) {
                Ok(look) => self.look = look,
                Err(error) => self.say(error.to_string(), true),
            }
            return;
        }
        self.frames = frames_on_disk(path);
        if self.frames.as_ref().is_some_and(Vec::is_empty) {
            self.say(format!("{}: no frame is there", path.display()), true);
            self.frames = None;
            return;
        }
        self.frame_index = 0;
        self.input = Some(path.to_path_buf());
        self.canvas.fit();
        self.probed = None;
    }

    /// Shows the window's content, and requests what is missing.
    pub fn show(&mut self, ui: &mut Ui) {
        let context = ui.ctx().clone();
        self.on_message(&context);
        self.take_files(&context);
        for action in shortcuts::asked(&context) {
            self.act(&context, action);
        }
        Panel::top("toolbar").show(ui, |ui| self.toolbar(ui));
        Panel::bottom("status").show(ui, |ui| self.status(ui));
        Panel::right("controls")
            .default_size(360.0)
            .size_range(280.0..=520.0)
            .show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    let chosen = self.shown.as_ref().map_or(&[][..], |s| &s.chosen);
                    let changes = self.controls.show(ui, &mut self.look, chosen);
                    if changes.changed.is_some() {
                        self.changed = changes.changed;
                        self.said = None;
                    }
                });
            });
        let central = Frame::new().fill(SURROUND).inner_margin(Margin::ZERO);
        CentralPanel::default()
            .frame(central)
            .show(ui, |ui| self.picture(ui));
        shortcuts::help(&context, &mut self.is_helping);
        let is_changing = context.input(|input| input.pointer.any_down());
        if !is_changing {
            self.history.rest_at(&self.look);
        }
        self.ask(is_changing);
    }

    fn picture(&mut self, ui: &mut Ui) {
        let area = ui.max_rect();
        let [Some(picture), before] = &self.textures else {
            overlay::welcome(ui);
            return;
        };
        let Some(shown) = &self.shown else { return };
        let painted = Painted {
            picture,
            before: before.as_ref().filter(|_| self.is_split),
            arrows: &shown.arrows,
            size: shown.size,
            pixel_aspect: shown.pixel_aspect,
        };
        let seen = self.canvas.show(ui, &painted);
        self.zoom = seen.zoom;
        if self.is_busy() {
            overlay::busy(ui, area);
        }
        if !self.is_probing {
            return;
        }
        if let Some(pixel) = seen.pixel
            && self.probed.as_ref().is_none_or(|(at, _)| *at != pixel)
        {
            let last = self.probed.take().and_then(|(_, values)| values);
            self.probed = Some((pixel, last));
            self.worker.probe(pixel);
        }
        if let Some((pixel, Some(values))) = &self.probed {
            overlay::values(ui, area, *pixel, values);
        }
    }

    /// Requests the wanted picture, unless it is already on its way.
    fn ask(&mut self, is_changing: bool) {
        let Some(reading) = self.reading() else {
            return;
        };
        let wanted = Wanted {
            look: self.look.clone(),
            reading,
            layer: self.layer,
            before: self.is_split,
        };
        if let Some(ordered) = &self.ordered
            && ordered.wanted == wanted
        {
            let was_coarse = self.shown.as_ref().is_some_and(|shown| shown.step > 1);
            let is_good = !ordered.is_quick || !ordered.is_met || !was_coarse;
            if is_good || is_changing {
                return;
            }
        }
        let number = self
            .ordered
            .as_ref()
            .map_or(0, |ordered| ordered.number + 1);
        self.worker.order(Order {
            number,
            look: wanted.look.clone(),
            reading: wanted.reading.clone(),
            layer: wanted.layer,
            before: wanted.before,
            changed: self.changed.clone(),
            is_quick: is_changing,
        });
        self.ordered = Some(Ordered {
            wanted,
            number,
            is_quick: is_changing,
            is_met: false,
        });
    }

    /// Takes in the worker's replies.
    fn on_message(&mut self, context: &Context) {
        let replies: Vec<Reply> = self.worker.replies().collect();
        for reply in replies {
            match reply {
                Reply::Shown(shown) => {
                    self.meet(shown.number);
                    let [picture, before] = &mut self.textures;
                    *picture = Some(Texture::of(context, &shown.pixels, picture.take()));
                    *before = shown
                        .before
                        .as_ref()
                        .map(|pixels| Texture::of(context, pixels, before.take()));
                    if self.said.as_ref().is_some_and(|said| said.is_error) {
                        self.said = None;
                    }
                    self.shown = Some(shown);
                    // Values at the probed pixel may have changed.
                    if let Some((pixel, _)) = &self.probed {
                        self.worker.probe(*pixel);
                    }
                }
                Reply::Failed(number, said) => {
                    self.meet(number);
                    self.say(said, true);
                }
                Reply::Probed(pixel, values) => {
                    if self.probed.as_ref().is_some_and(|(at, _)| *at == pixel) {
                        self.probed = Some((pixel, Some(values)));
                    }
                }
                Reply::Saved(saved) => {
                    self.saving -= 1;
                    match saved {
                        Ok(path) => self.say(format!("{} is written", path.display()), false),
                        Err(said) => self.say(said, true),
                    }
                }
            }
        }
    }

    fn meet(&mut self, number: u64) {
        if let Some(ordered) = self.ordered.as_mut().filter(|o| o.number == number) {
            ordered.is_met = true;
        }
    }

    /// Takes in files that were dropped or chosen in a dialog.
    fn take_files(&mut self, context: &Context) {
        let dropped = context.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            self.open(file.path());
        }
        for (purpose, path) in self.files.chosen() {
            match purpose {
                Purpose::Open => self.open(&path),
                Purpose::SaveRecipe => self.save_recipe(&path),
                Purpose::SavePicture => self.save_picture(&path),
            }
        }
    }

    pub(super) fn act(&mut self, context: &Context, action: Action) {
        let ask = |purpose| {
            let waker = context.clone();
            let wake = move || waker.request_repaint();
            self.files.ask(purpose, self.input.as_deref(), wake);
        };
        match action {
            Action::Open => ask(Purpose::Open),
            Action::SavePicture => ask(Purpose::SavePicture),
            Action::SaveRecipe => ask(Purpose::SaveRecipe),
            Action::CopyCommand => {
                if let Some(line) = self.command_line() {
                    context.copy_text(line);
                    self.say("the command line is copied".into(), false);
                }
            }
            Action::Undo => self.look = self.history.undo().unwrap_or(self.look.clone()),
            Action::Redo => self.look = self.history.redo().unwrap_or(self.look.clone()),
            Action::Split => self.is_split = !self.is_split,
            Action::Fit => self.canvas.fit(),
            Action::ActualSize => self.canvas.zoom_to(context.pixels_per_point().recip()),
            Action::Probe => self.is_probing = !self.is_probing,
            Action::NextFrame => self.step_frame(1),
            Action::PreviousFrame => self.step_frame(-1),
            Action::NextLayer => self.step_layer(1),
            Action::PreviousLayer => self.step_layer(Layer::all().count() - 1),
            Action::Help => self.is_helping = !self.is_helping,
        }
    }

    fn step_frame(&mut self, by: isize) {
        let last = self.frames.as_ref().map_or(0, |frames| frames.len() - 1);
        self.frame_index = self.frame_index.saturating_add_signed(by).min(last);
    }

    fn step_layer(&mut self, by: usize) {
        let layers: Vec<_> = Layer::all().collect();
        let index = layers.iter().position(|&layer| layer == self.layer);
        let index = index.expect("all layers are among all") + by;
        self.layer = layers[index % layers.len()];
    }

    pub(super) fn say(&mut self, text: String, is_error: bool) {
        let text = text.replace('\n', " ");
        self.said = Some(Notice { text, is_error });
    }

    pub(super) fn input(&self) -> Option<&Path> {
        self.input.as_deref()
    }

    /// One line describing the open input.
    pub(super) fn about(&self) -> String {
        let input = self.input.as_ref();
        input.map_or(String::new(), |path| path.display().to_string())
    }

    fn reading(&self) -> Option<Reading> {
        let frames = self.frames.as_ref();
        Some(Reading {
            input: self.input.clone()?,
            frame: frames.and_then(|frames| frames.get(self.frame_index).copied()),
        })
    }

    /// Whether a picture or file is being made, or values are looked up.
    pub fn is_busy(&self) -> bool {
        let ordered = self.ordered.as_ref();
        let probes = matches!(self.probed, Some((_, None)));
        ordered.is_some_and(|ordered| !ordered.is_met) || self.saving > 0 || probes
    }

    /// Writes the recipe of the shown picture.
    pub fn save_recipe(&mut self, path: &Path) {
        self.save(Save::Recipe, path);
    }

    /// Writes the picture of the look, as the command line writes it.
    pub fn save_picture(&mut self, path: &Path) {
        self.save(Save::Picture, path);
    }

    fn save(&mut self, save: Save, path: &Path) {
        if let Some(reading) = self.reading() {
            self.saving += 1;
            self.worker
                .save(save, self.look.clone(), reading, path.to_path_buf());
        }
    }

    /// The command line that reproduces the picture.
    pub fn command_line(&self) -> Option<String> {
        let frames = self.frames.as_deref();
        Some(self.look.command_line(self.input.as_ref()?, frames))
    }

    /// The value of a setting that is not at its default; the first, if it has several.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.look.value(name)
    }

    /// The command whose picture is shown.
    pub fn command(&self) -> &str {
        self.look.command()
    }

    /// Width, height and pixels of the shown picture: red, green, blue and alpha, as in a PNG.
    pub fn pixels(&self) -> Option<(usize, usize, &[[u8; 4]])> {
        let pixels = &self.shown.as_ref()?.pixels;
        Some((pixels.width, pixels.height, &pixels.rgba))
    }

    /// How often each pass has run on the open frame, named as in
    /// [`Outcome::timings`](crate::engine::outcome::Outcome::timings).
    pub fn counts(&self) -> BTreeMap<&'static str, u32> {
        self.shown
            .as_ref()
            .map_or(BTreeMap::new(), |shown| shown.counts.clone())
    }

    /// Position of the divider between before and after, as a share of the width.
    pub fn split(&self) -> f32 {
        self.canvas.split
    }

    /// The values under the pointer, as lines of text.
    pub fn probed(&self) -> Vec<String> {
        match &self.probed {
            Some((pixel, Some(values))) => overlay::lines_of(*pixel, values),
            _ => Vec::new(),
        }
    }

    /// The last message to the user.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().map(|said| said.text.as_str())
    }
}
