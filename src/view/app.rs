//! The window: its state and layout.

use super::canvas::{Painted, ViewCanvas};
use super::controls::Controls;
use super::files::{self, FileDialogs, FilePurpose};
use super::gallery::gallery;
use super::handles::{PicturePlace, handles};
use super::history::History;
use super::layer::ShownLayer;
use super::lights::Lights;
use super::look::{LightFile, Look, Opening, ShownFile};
use super::notices::Notices;
use super::overlay;
use super::picks::Picks;
use super::probe::ProbedValue;
use super::shortcuts;
use super::texture::ViewTexture;
use super::thumbnails::Thumbnails;
use super::worker::{Order, Reply, Save, ShownPicture, ToShow, ViewTask, Worker};
use crate::command::frames_there::frames_on_disk;
use eframe::egui::{
    CentralPanel, Color32, Context, Frame, Margin, Panel, ScrollArea, Theme, Ui, Vec2, vec2,
};
use std::path::{Path, PathBuf};

/// Surround of the picture: neutral grey, so that its tones are seen without bias.
const SURROUND: Color32 = Color32::from_gray(38);

/// A one-line message for the user.
#[derive(Debug, Clone)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
}

/// A request sent to the worker.
struct Ordered {
    wanted: ToShow,
    number: u64,
    is_quick: bool,
    is_met: bool,
}

/// The viewer.
pub struct View {
    pub(super) look: Look,
    pub(super) history: History,
    pub(super) layer: ShownLayer,
    pub(super) is_split: bool,
    /// Whether the picture before stands in place of the other.
    pub(super) is_before: bool,
    /// Whether the gallery of presets is open.
    pub(super) is_choosing: bool,
    pub(super) is_probing: bool,
    pub(super) is_helping: bool,
    pub(super) frames: Option<Vec<i32>>,
    pub(super) frame_index: usize,
    pub(super) shown: Option<Box<ShownPicture>>,
    pub(super) said: Option<Notice>,
    pub(super) notices: Notices,
    pub(super) zoom: f32,
    pub(super) hides_handles: bool,
    input: Option<PathBuf>,
    controls: Controls,
    pub(super) canvas: ViewCanvas,
    textures: [Option<ViewTexture>; 2],
    worker: Worker,
    pub(super) files: FileDialogs,
    ordered: Option<Ordered>,
    saving: usize,
    /// Whether a place is looked for, for a new light near the surface.
    is_placing: bool,
    pub(super) thumbnails: Thumbnails,
    light_files: Vec<LightFile>,
    changed: Option<String>,
    /// The pixel probed last, and its values once they arrive.
    pub(super) probed: Option<([usize; 2], Option<Vec<ProbedValue>>)>,
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
            layer: ShownLayer::default(),
            is_split: false,
            is_before: false,
            is_choosing: false,
            is_probing: false,
            is_helping: false,
            frames: None,
            frame_index: 0,
            shown: None,
            said: None,
            notices: Notices::default(),
            zoom: 1.0,
            hides_handles: false,
            input: None,
            controls: Controls::default(),
            canvas: ViewCanvas::default(),
            textures: [None, None],
            worker: Worker::start(opening.engine, opening.save, move || {
                waker.request_repaint()
            }),
            files: FileDialogs::new(),
            ordered: None,
            saving: 0,
            is_placing: false,
            thumbnails: Thumbnails::default(),
            light_files: Vec::new(),
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
        self.light_files.clear();
        self.worker.ask(ViewTask::Search(path.to_path_buf()));
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
                    self.settings(ui);
                });
            });
        if let Some(shown) = &self.shown {
            self.notices.show(ui, &shown.warnings);
        }
        let central = Frame::new().fill(SURROUND).inner_margin(Margin::ZERO);
        CentralPanel::default()
            .frame(central)
            .show(ui, |ui| self.picture(ui));
        shortcuts::help(&context, &mut self.is_helping);
        if let Some(reading) = self.reading() {
            let (is_open, look) = (&mut self.is_choosing, &mut self.look);
            gallery(&context, is_open, look, &reading, &mut self.thumbnails);
        }
        if !ShownLayer::all(self.look.command()).any(|layer| layer == self.layer) {
            self.layer = ShownLayer::Picture;
        }
        let (is_held, is_scrolling) = context.input(|input| {
            let is_scrolling = input.smooth_scroll_delta() != Vec2::ZERO;
            (input.pointer.any_down(), is_scrolling)
        });
        if is_scrolling {
            // Once more when the wheel rests.
            context.request_repaint();
        }
        let is_changing = is_held || is_scrolling;
        if !is_changing {
            self.history.rest_at(&self.look);
        }
        self.ask(is_changing);
        if let Some(wanted) = self.thumbnails.order(is_changing) {
            self.worker
                .ask_all(wanted.into_iter().map(ViewTask::Small).collect());
        }
    }

    fn settings(&mut self, ui: &mut Ui) {
        let reading = self.reading();
        let pictures = Picks {
            thumbnails: &mut self.thumbnails,
            reading: reading.as_ref(),
            light_files: &self.light_files,
        };
        let chosen = self.shown.as_ref().map_or(&[][..], |s| &s.chosen);
        let changes = self.controls.show(ui, &mut self.look, chosen, pictures);
        if changes.changed.is_some() {
            self.changed = changes.changed;
            self.said = None;
        }
        if let Some(reading) = reading.filter(|_| changes.adds_near) {
            self.is_placing = true;
            self.worker.ask(ViewTask::Place(self.look.clone(), reading));
        }
        if let Some(setting) = changes.browses {
            self.browse(ui.ctx(), FilePurpose::Setting(setting));
        }
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
            before: before.as_ref().filter(|_| self.is_split || self.is_before),
            is_split: !self.is_before,
            arrows: &shown.arrows,
            size: shown.size,
            pixel_aspect: shown.pixel_aspect,
        };
        let seen = self.canvas.show(ui, &painted);
        self.zoom = seen.zoom;
        if self.is_before && before.is_some() {
            let at = area.left_top() + vec2(20.0, 20.0);
            overlay::caption(&ui.painter_at(area), at, "before");
        } else if self.layer == ShownLayer::Picture && !self.hides_handles {
            let place = PicturePlace {
                area,
                picture: seen.rect,
                size: shown.size,
            };
            if let Some(before) = Lights::of(&self.look) {
                let mut lights = before.clone();
                handles(ui, &place, &shown.space, &mut lights);
                if let Some(changed) = lights.write(&before, &mut self.look) {
                    self.changed = Some(changed.into());
                }
            }
        }
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
            self.worker.ask(ViewTask::Probe(pixel));
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
        let wanted = ToShow {
            look: self.look.clone(),
            reading,
            layer: self.layer,
            before: self.is_split || self.is_before,
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
        self.worker.ask(ViewTask::Show(Order {
            number,
            wanted: wanted.clone(),
            changed: self.changed.clone(),
            is_quick: is_changing,
        }));
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
                    *picture = Some(ViewTexture::of(context, &shown.pixels, picture.take()));
                    *before = shown
                        .before
                        .as_ref()
                        .map(|pixels| ViewTexture::of(context, pixels, before.take()));
                    if self.said.as_ref().is_some_and(|said| said.is_error) {
                        self.said = None;
                    }
                    self.shown = Some(shown);
                    // Values at the probed pixel may have changed.
                    if let Some((pixel, _)) = &self.probed {
                        self.worker.ask(ViewTask::Probe(*pixel));
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
                Reply::Placed(placed) => {
                    self.is_placing = false;
                    match placed {
                        Ok(light) => Lights::add_near(&mut self.look, light),
                        Err(said) => self.say(said, true),
                    }
                }
                Reply::Found(files) => self.light_files = files,
                Reply::Small(choice, pixels) => self.thumbnails.take(context, choice, pixels),
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

    fn reading(&self) -> Option<ShownFile> {
        let frames = self.frames.as_ref();
        Some(ShownFile {
            input: self.input.clone()?,
            frame: frames.and_then(|frames| frames.get(self.frame_index).copied()),
        })
    }

    /// Whether a picture or file is being made, or values are looked up.
    pub fn is_busy(&self) -> bool {
        let ordered = self.ordered.as_ref();
        let probes = matches!(self.probed, Some((_, None)));
        let is_ordered = ordered.is_some_and(|ordered| !ordered.is_met);
        is_ordered || self.saving > 0 || self.is_placing || probes
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
            let task = ViewTask::Save(save, self.look.clone(), reading, path.to_path_buf());
            self.worker.ask(task);
        }
    }
}
